"""What every tool has: a hint, a preview, and answers to pointer and keys. State machines without widgets."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QPainterPath

from gui.state.inspection import Inspection
from gui.state.session import Session
from gui.tools.aid import Aid
from gui.tools.options import LARGEST_LEASH, ToolOptions
from gui.views.pointer import PointerEvent
from gui.views.preview import Preview
from ilf.ebs.edit import LabelPatch

Point = tuple[float, float]
Found = TypeVar("Found")

_CLICK = 3
"""Pixels of the screen that the pointer may go during a click."""


class Host(Protocol):
    """What a tool may ask of the editor."""

    options: ToolOptions

    @property
    def inspection(self) -> Inspection:
        """What of the present frame is looked at closely."""
        ...

    @property
    def session(self) -> Session:
        """The present frame's session."""
        ...

    @property
    def aid(self) -> Aid | None:
        """What is known of the frame's edges and regions; None while it is being worked out."""
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

    def distrust(self, mask: NDArray[np.bool_] | None, text: str) -> bool:
        """Make distrusting the depth at these pixels, bool (H, W), and no others one undoable step."""
        ...

    def show_preview(self, preview: Preview | None) -> None:
        """Draw a preview over the views."""
        ...

    def work_out(self, find: Callable[[], Found], take: Callable[[Found], None]) -> None:
        """Work something out off the GUI's thread, then take it; not if the label map has changed, or on `cancel`."""
        ...

    def say(self, message: str) -> None:
        """Tell the user something that needs no answer."""
        ...


class Tool:
    """One way to use the left mouse button. It starts idle, and is idle again after `cancel`.

    Attributes
    ----------
    options : tuple of str
        Names of the `ToolOptions` that it has.
    points_only : bool
        Whether clicks at points are all that it needs: then it can be used on the cloud, too.
    """

    options: tuple[str, ...] = ()
    points_only = False

    @property
    def hint(self) -> str:
        """What a click, a drag or a key would do now."""
        raise NotImplementedError

    @property
    def busy(self) -> bool:
        """Whether something is under way that can be given up."""
        return False

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Answer an event; False for a press that is not the tool's, so that the view pans.

        True for a double click keeps the press that would follow from coming.
        """
        raise NotImplementedError

    def cancel(self, host: Host) -> bool:
        """Give up what is under way, as if it had not begun; False if nothing was."""
        return False

    def remove(self, host: Host) -> bool:
        """Remove what the tool has put over the picture; False if there is nothing."""
        return False

    def finish(self, host: Host) -> bool:
        """Complete what is under way as it stands; False if there is nothing to complete."""
        return False

    def take_back(self, host: Host) -> bool:
        """Take back the last part of what is under way; False if there is none."""
        return False


class Press:
    """Where the button went down, and whether the pointer has gone so far since that it drags."""

    def __init__(self, event: PointerEvent) -> None:
        self.point: Point = event.x, event.y
        self.drags = False

    def follow(self, event: PointerEvent) -> bool:
        """Whether it drags now."""
        self.drags = self.drags or math.dist(self.point, (event.x, event.y)) > _CLICK * event.pixel
        return self.drags


def refuses(host: Host, label: int) -> bool:
    """Whether a block is locked, which is said."""
    session = host.session
    if label in session.locked:
        host.say(f"{session.info(label).name} is locked. Unlock it in the table of blocks.")
    return label in session.locked


def refuses_one(host: Host, labels: Iterable[int]) -> bool:
    """Whether any of these blocks is locked, which is said of the first."""
    return any(refuses(host, label) for label in sorted(labels))


def knows_edges(host: Host) -> bool:
    """Whether the frame's edges are known by now; if not, that is said."""
    if host.aid is None:
        host.say("The edges of the frame are still being looked for. Try again in a moment.")
    return host.aid is not None


def line_path(points: Sequence[Point], closed: bool = False) -> QPainterPath:
    """A path through points."""
    path = QPainterPath()
    if points:
        path.moveTo(*points[0])
    for point in points[1:]:
        path.lineTo(*point)
    if closed and points:
        path.closeSubpath()
    return path


def snapped(host: Host, pixel: float, points: Sequence[Point]) -> list[Point]:
    """A drawn line, moved onto edges nearby as far as the leash allows, where a pixel of the screen is `pixel` ones."""
    aid, leash = host.aid, min(host.options.leash * pixel, LARGEST_LEASH)
    if aid is None or leash <= 0 or len(points) < 2:
        return list(points)
    return aid.snapper.snap(points, leash)
