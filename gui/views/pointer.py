"""What a tool hears of the mouse: plain events in image coordinates, the same in every view."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto


class PointerKind(Enum):
    """What the pointer did."""

    PRESS = auto()
    MOVE = auto()
    """Moved while the left button that was pressed for the tool is held."""
    RELEASE = auto()
    HOVER = auto()
    LEAVE = auto()
    DOUBLE = auto()
    WHEEL = auto()
    """The wheel was turned while Ctrl was held."""


@dataclass(frozen=True)
class PointerEvent:
    """One thing the pointer did over an image view.

    Parameters
    ----------
    kind : PointerKind
        What happened.
    x, y : float
        Where, in image coordinates: the pixel in row r, column c covers x in [c, c + 1), y in [r, r + 1).
        May lie outside the image.
    shift, ctrl, alt : bool
        Modifier keys held.
    pixel : float
        Image pixels per pixel of the screen.
    steps : int
        How far the wheel was turned: above 0 away from the user.
    """

    kind: PointerKind
    x: float
    y: float
    shift: bool = False
    ctrl: bool = False
    alt: bool = False
    pixel: float = 1.0
    steps: int = 0


PointerHandler = Callable[[PointerEvent], "bool | None"]
"""Takes pointer events. False for PRESS: not mine, pan instead. True for DOUBLE: mine, send no PRESS for
it. True for WHEEL: mine, do not zoom."""
