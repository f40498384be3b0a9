"""What every tool has: a hint, a preview, and an answer to pointer events. State machines without widgets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from PySide6.QtGui import QPainterPath

from gui.state.session import Session
from gui.tools.pointer import PointerEvent
from ilf.blocks import Box
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

    def commit(self, patch: LabelPatch | None, text: str, done: bool = False) -> bool:
        """Make a change of the label map one undoable step; False if there was nothing to change."""
        ...

    def show_labels(self, box: Box) -> None:
        """Repaint the label map while a stroke is under way."""
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


def label_at(session: Session, x: float, y: float) -> int:
    """Block under image coordinates; 0 for none or off the frame."""
    row, column = int(y // 1), int(x // 1)
    height, width = session.labels.shape
    return int(session.labels[row, column]) if 0 <= row < height and 0 <= column < width else 0


def line_path(points: Sequence[tuple[float, float]]) -> QPainterPath:
    """A path through points."""
    path = QPainterPath()
    path.moveTo(*points[0])
    for point in points[1:]:
        path.lineTo(*point)
    return path
