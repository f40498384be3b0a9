"""Pointer events for tools, in image coordinates, the same in every view; and what a tool shows."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum, auto

from PySide6.QtCore import Qt
from PySide6.QtGui import QPainterPath

ARROWS: dict[int, tuple[int, int]] = {
    Qt.Key.Key_Left: (-1, 0),
    Qt.Key.Key_Right: (1, 0),
    Qt.Key.Key_Up: (0, -1),
    Qt.Key.Key_Down: (0, 1),
}
"""Arrow keys -> their directions: right and down."""


class PointerKind(Enum):
    """Kind of a pointer event."""

    PRESS = auto()
    MOVE = auto()
    """Moved while the left button, pressed for the tool, is held."""
    RELEASE = auto()
    HOVER = auto()
    LEAVE = auto()
    DOUBLE = auto()
    WHEEL = auto()
    """The wheel was turned while Ctrl was held."""


@dataclass(frozen=True)
class PointerEvent:
    """One pointer event over an image view.

    Parameters
    ----------
    kind : PointerKind
        What happened.
    x, y : float
        Position in image coordinates: the pixel in row r, column c covers x in [c, c + 1), y in [r, r + 1).
        May lie outside the image.
    shift, ctrl, alt : bool
        Modifier keys held.
    pixel : float
        Image pixels per pixel of the screen.
    steps : int
        Wheel steps; positive: away from the user.
    """

    kind: PointerKind
    x: float
    y: float
    shift: bool = False
    ctrl: bool = False
    alt: bool = False
    pixel: float = 1.0
    steps: int = 0

    @property
    def opposite(self) -> bool:
        """Whether a tool's opposite is meant, such as to take away: Ctrl, or Alt where the desktop does not use it."""
        return self.alt or (self.ctrl and self.kind is not PointerKind.WHEEL)


PointerHandler = Callable[[PointerEvent], "bool | None"]
"""Handles pointer events. False for PRESS: rejected, pan instead. True for DOUBLE: handled, send no PRESS for
it. True for WHEEL: handled, do not zoom."""


@dataclass(frozen=True, eq=False)
class Preview:
    """What a tool shows over the views: lines, corners and an area, in image coordinates.

    Attributes
    ----------
    line : QPainterPath
        Drawn bright on dark, visible on any picture.
    corners : sequence of (x, y)
        Drawn as small squares, of one size on the screen unless they would hide the line.
    dashed : bool
        Whether the line is only a suggestion.
    area : QPainterPath, optional
        Shaded and hatched.
    line_preview : QPainterPath, optional
        Predicted result, drawn dashed beside the line.
    """

    line: QPainterPath
    corners: Sequence[tuple[float, float]] = ()
    dashed: bool = False
    area: QPainterPath | None = None
    line_preview: QPainterPath | None = None
