"""What every tool has: a hint, a preview, and an answer to pointer events. State machines without widgets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from PySide6.QtGui import QPainterPath

from gui.state.session import Session
from gui.views.pointer import PointerEvent
from ilf.ebs.edit import LabelPatch


class Host(Protocol):
    """What a tool may ask of the editor."""

    brush_radius: float

    @property
    def session(self) -> Session:
        """The present frame's session."""
        ...

    def select(self, labels: list[int]) -> None:
        """Choose blocks."""
        ...

    def commit(self, patch: LabelPatch | None, text: str) -> bool:
        """Make a change of the label map one undoable step; False if there was nothing to change."""
        ...

    def stroke(self, patch: LabelPatch | None) -> None:
        """Change the label map as part of a stroke."""
        ...

    def end_stroke(self, text: str) -> bool:
        """Make the stroke one undoable step; False if it has changed nothing."""
        ...

    def drop_stroke(self) -> bool:
        """Give the stroke up; False if there was none."""
        ...

    def show_preview(self, path: QPainterPath | None) -> None:
        """Draw a preview over the views."""
        ...

    def say(self, message: str) -> None:
        """Tell the user something that needs no answer."""
        ...


class Tool(Protocol):
    """One way to use the left mouse button."""

    hint: str

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Answer an event; False for a press that is not the tool's, so that the view pans."""
        ...

    def cancel(self, host: Host) -> bool:
        """Give up what is under way, as if it had not begun; False if nothing was."""
        ...


def line_path(points: Sequence[tuple[float, float]]) -> QPainterPath:
    """A path through points."""
    path = QPainterPath()
    path.moveTo(*points[0])
    for point in points[1:]:
        path.lineTo(*point)
    return path
