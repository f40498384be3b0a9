"""Base of the tools: hint, preview, pointer and key events. State machines without widgets."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QRectF
from PySide6.QtGui import QPainterPath

from ilf.data.frame import RGBDFrame
from ilf.errors import InputError
from ilf.segmentation.editing.patches import LabelPatch, Labels
from ilf.segmentation.editing.snapping import border_evidence, similar_pixels

from ..state.document import Document
from ..views.interaction import PointerEvent, PointerKind, Preview

# Options of the tools, shared by all tools while the program runs.

BRUSH_RADII = (1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 18.0, 27.0, 40.0, 60.0)
"""Brush sizes that are set by steps [px]."""

LARGEST_LEASH = 20
LARGEST_AMOUNT = 30


@dataclass
class ToolOptions:
    """Options of all tools. Each tool lists those that it has.

    Attributes
    ----------
    brush_radius : float
        Radius of the round brush, in pixels.
    leash : int
        Maximum distance that a drawn line moves to an edge, in screen pixels; 0 leaves it as drawn. Limited to
        `LARGEST_LEASH` image pixels.
    similar_only : bool
        Whether a stroke is limited to pixels similar to its first ones.
    to_no_block : bool
        Whether erased pixels belong to no block, instead of the best-fitting neighbour.
    amount : int
        Pixels by which blocks grow, shrink or are smoothed.
    hand_depth : float
        Depth [m] that is painted by hand; 0 until one is picked or typed.
    """

    brush_radius: float = 8.0
    leash: int = 6
    similar_only: bool = False
    to_no_block: bool = False
    amount: int = 2
    hand_depth: float = 0.0

    def step_brush(self, steps: int) -> None:
        """Change the brush size by steps, which grow with the size."""
        nearest = min(range(len(BRUSH_RADII)), key=lambda k: abs(BRUSH_RADII[k] - self.brush_radius))
        self.brush_radius = BRUSH_RADII[min(max(nearest + steps, 0), len(BRUSH_RADII) - 1)]


# Data of a frame that the tools need beside its blocks.


@dataclass(frozen=True, eq=False)
class EdgeData:
    """Edges and regions of a frame.

    Attributes
    ----------
    frame : RGBDFrame
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1].
    regions : ndarray of int32, shape (H, W)
        The regions that the extraction merges into blocks.
    evidence : ndarray of float32, shape (H, W)
        Evidence for a border, to which drawn lines snap.
    """

    frame: RGBDFrame
    strength: NDArray[np.float32]
    regions: NDArray[np.int32]
    evidence: NDArray[np.float32]

    @staticmethod
    def of(frame: RGBDFrame, strength: NDArray[np.float32], regions: NDArray[np.int32]) -> EdgeData:
        """Return the data of a frame with known edges and regions."""
        similar_pixels(frame, strength, 0, 0)  # computes and caches what it needs of the whole frame
        return EdgeData(frame, strength, regions, border_evidence(frame, strength))


Point = tuple[float, float]
Result = TypeVar("Result")

_CLICK = 3
"""Maximum pointer movement during a click [screen pixels]."""


class Host(Protocol):
    """The interface of the editor for its tools. It shows the message of an InputError by which a tool refuses a
    pointer event, its end, or a result of `run_in_background`."""

    options: ToolOptions

    @property
    def document(self) -> Document:
        """The current frame's document."""
        ...

    @property
    def edge_data(self) -> EdgeData | None:
        """Edges and regions of the frame; None while they are being computed."""
        ...

    def commit(self, patch: LabelPatch | None, text: str, label: int = 0) -> LabelPatch | None:
        """Make a change of the label map one undo step, with the slivers and rests that it would leave; return the
        whole change, None for none. `label` is the block that is painted or drawn, 0 for none."""
        ...

    def set_option(self, name: str, value: float | bool) -> None:
        """Set one of the options."""
        ...

    def show_preview(self, preview: Preview | None) -> None:
        """Draw a preview over the views."""
        ...

    def run_in_background(self, find: Callable[[], Result], take: Callable[[Result], None]) -> None:
        """Call `find` in the background, then `take` with its result; neither after a label map change or `cancel`."""
        ...

    def show_message(self, message: str) -> None:
        """Show a message to the user."""
        ...


class Press:
    """A press of the button: its position, and whether the pointer has moved far enough to be a drag."""

    def __init__(self, event: PointerEvent) -> None:
        self.point: Point = event.x, event.y
        self.drags = False

    def follow(self, event: PointerEvent) -> bool:
        """Update with an event; return whether it is a drag."""
        self.drags = self.drags or math.dist(self.point, (event.x, event.y)) > _CLICK * event.pixel
        return self.drags

    def box_to(self, event: PointerEvent) -> QRectF:
        """Return the rectangle between the press and an event."""
        x, y = self.point
        return QRectF(x, y, event.x - x, event.y - y).normalized()


class Tool:
    """A tool: one use of the left mouse button. It starts idle, and is idle again after `cancel`.

    `pointer` calls the method that is named after what the hand does: `_begin` at a press, `_drag` and `_release`
    until it ends, `_hover`, `_leave` and `_double`. A tool has those that it needs.

    Attributes
    ----------
    options : tuple of str
        Names of the `ToolOptions` that it has.
    points_only : bool
        Whether it needs only clicks at points: then it also works on the point cloud.
    wheel : bool
        Whether it uses the wheel while Ctrl is held.
    guided : bool
        Whether it uses the edges of the frame, which are computed in advance; if it has the option `similar_only`, only
        with that.
    """

    options: tuple[str, ...] = ()
    points_only = False
    wheel = False
    guided = False
    _press: Press | None = None
    """The press of the button, until it is released."""

    @property
    def hint(self) -> str:
        """Hint: what a click, a drag or a key would do now."""
        raise NotImplementedError

    @property
    def busy(self) -> bool:
        """Whether an action is in progress that can be cancelled."""
        return self._press is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Handle an event; False for a press that the tool does not use, so that the view pans.

        True for a double click suppresses the press that would follow.
        """
        match event.kind:
            case PointerKind.PRESS:
                self._press = None
                self._press = Press(event) if self._begin(event, host) else None
            case PointerKind.MOVE if self._press is not None:
                self._drag(self._press, event, host)
            case PointerKind.RELEASE if self._press is not None:
                press, self._press = self._press, None
                self._release(press, event, host)
            case PointerKind.HOVER:
                self._hover(event, host)
            case PointerKind.LEAVE:
                self._leave(host)
            case PointerKind.DOUBLE:
                return self._double(host)
        return True

    def _begin(self, event: PointerEvent, host: Host) -> bool:
        """Prepare for a click or a drag; False if the press starts none."""
        return True

    def _drag(self, press: Press, event: PointerEvent, host: Host) -> bool:
        """Follow the pointer while the button is down; False while it may still be a click."""
        return press.follow(event)

    def _release(self, press: Press, event: PointerEvent, host: Host) -> None:
        """End the click or the drag."""

    def _hover(self, event: PointerEvent, host: Host) -> None:
        """Show what a click would do."""

    def _leave(self, host: Host) -> None:
        """The pointer has left the views."""

    def _double(self, host: Host) -> bool:
        """Handle a double click; False if the second of two quick clicks is a normal press."""
        return False

    def cancel(self, host: Host) -> None:
        """Cancel the action in progress without any effect."""

    def remove(self, host: Host) -> bool:
        """Remove the tool's mark from the image; False if there is none."""
        return False

    def finish(self, host: Host) -> bool:
        """Complete the action in progress; False if there is none."""
        return False

    def undo_last(self, host: Host) -> bool:
        """Undo the last part of the action in progress; False if there is none."""
        return False


def locked_text(document: Document, labels: Iterable[int]) -> str:
    """Return a sentence about the first of these blocks that is locked; "" if none is."""
    locked = sorted(document.locked.intersection(labels))
    return f"{document.info(locked[0]).name} is locked. Unlock it in the table of blocks." if locked else ""


def check_unlocked(document: Document, labels: Iterable[int]) -> None:
    """Raise InputError if one of these blocks is locked."""
    if text := locked_text(document, labels):
        raise InputError(text)


def edges_of(host: Host) -> EdgeData:
    """Return the frame's edges; raise InputError while they are being computed."""
    edges = host.edge_data
    if edges is None:
        raise InputError("The edges of the frame are still being computed. Try again in a moment.")
    return edges


def line_path(points: Sequence[Point], closed: bool = False) -> QPainterPath:
    """Return a path through points."""
    path = QPainterPath()
    if points:
        path.moveTo(*points[0])
    for point in points[1:]:
        path.lineTo(*point)
    if closed and points:
        path.closeSubpath()
    return path


# Blocks that a line crosses or starts near, and parts too thin to be intended.

_THIN = 3
"""Maximum pixels, per pixel of the cutting line, of a part that may come from hand tremor."""


def crossed(labels: Labels, points: list[Point]) -> dict[int, int]:
    """Return the pixels of a line in each block that it crosses, most pixels first."""
    line = np.zeros(labels.shape, np.uint8)
    path = np.floor(np.asarray(points)).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(line, [path], False, 1)
    pixels = np.bincount(labels[line > 0], minlength=1)
    most = sorted(np.flatnonzero(pixels[1:]) + 1, key=lambda label: -pixels[label])
    return {int(label): int(pixels[label]) for label in most}


def is_thick(labels: Labels, label: int, patch: LabelPatch, pixels: int) -> bool:
    """Return whether a cut by a line with `pixels` pixels in a block leaves more than tremor on both sides."""
    moved = np.count_nonzero(patch.before != patch.after)
    return bool(min(moved, np.count_nonzero(labels == label) - moved) > _THIN * pixels)


def around(labels: Labels, point: Point, reach: float) -> list[int]:
    """Return the blocks with pixels within reach of a point, nearest first."""
    (x, y), (height, width) = point, labels.shape
    top, left = (max(math.floor(at - reach), 0) for at in (y, x))
    seen = labels[top : min(math.ceil(y + reach), height), left : min(math.ceil(x + reach), width)]
    rows, columns = np.nonzero(seen)
    distance = np.hypot(columns + left + 0.5 - x, rows + top + 0.5 - y)
    order = np.argsort(distance, kind="stable")
    return list(dict.fromkeys(seen[rows, columns][order[distance[order] <= reach]].tolist()))
