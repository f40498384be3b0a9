"""What every tool has: a hint, a preview, and answers to pointer and keys. State machines without widgets."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QPainterPath

from ilf.segmentation.editing.patches import LabelPatch, Labels

from ..state.inspection import Inspection
from ..state.session import Session
from ..views.interaction import PointerEvent, Preview
from .aid import Aid

# What the user has set for the tools: it holds from tool to tool for as long as the program runs.

BRUSH_RADII = (1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 18.0, 27.0, 40.0, 60.0)
"""Where the steps between brush sizes lead, in pixels."""

LARGEST_LEASH = 20
LARGEST_AMOUNT = 30


@dataclass
class ToolOptions:
    """Options of all tools. A tool names those that it has.

    Attributes
    ----------
    brush_radius : float
        Of the round brush, in pixels.
    leash : int
        How far a drawn line may move to lie on an edge, in pixels of the screen, as it is there that a hand trembles;
        0 leaves it as drawn. Never farther than `LARGEST_LEASH` pixels of the image.
    similar_only : bool
        Whether a stroke keeps to pixels like those where it begins.
    to_no_block : bool
        Whether erased pixels belong to no block afterwards, instead of the neighbour that they fit best.
    amount : int
        By how many pixels blocks grow, shrink or are smoothed.
    """

    brush_radius: float = 8.0
    leash: int = 6
    similar_only: bool = False
    to_no_block: bool = False
    amount: int = 2

    def step_brush(self, steps: int) -> None:
        """A larger or smaller brush, by steps that are larger for large ones."""
        nearest = min(range(len(BRUSH_RADII)), key=lambda k: abs(BRUSH_RADII[k] - self.brush_radius))
        self.brush_radius = BRUSH_RADII[min(max(nearest + steps, 0), len(BRUSH_RADII) - 1)]


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


# Which blocks a line runs through or begins near, and what is too thin to be meant.

_THIN = 3
"""Pixels per pixel of the line that cuts it off up to which a part may be but its trembling."""


def crossed(labels: Labels, points: list[Point]) -> dict[int, int]:
    """How many pixels of a line are in each block that it crosses, the one that it crosses most first."""
    line = np.zeros(labels.shape, np.uint8)
    path = np.floor(np.asarray(points)).astype(np.int32).reshape(-1, 1, 2)
    cv2.polylines(line, [path], False, 1)
    pixels = np.bincount(labels[line > 0], minlength=1)
    most = sorted(np.flatnonzero(pixels[1:]) + 1, key=lambda label: -pixels[label])
    return {int(label): int(pixels[label]) for label in most}


def is_thick(labels: Labels, label: int, patch: LabelPatch, pixels: int) -> bool:
    """Whether a cut by a line with so many pixels in a block leaves more on both of its sides than it trembles."""
    moved = np.count_nonzero(patch.before != patch.after)
    return bool(min(moved, np.count_nonzero(labels == label) - moved) > _THIN * pixels)


def around(labels: Labels, point: Point, reach: float) -> list[int]:
    """The blocks that have pixels within reach of a point, the nearest first."""
    (x, y), (height, width) = point, labels.shape
    top, left = (max(math.floor(at - reach), 0) for at in (y, x))
    seen = labels[top : min(math.ceil(y + reach), height), left : min(math.ceil(x + reach), width)]
    rows, columns = np.nonzero(seen)
    distance = np.hypot(columns + left + 0.5 - x, rows + top + 0.5 - y)
    order = np.argsort(distance, kind="stable")
    return list(dict.fromkeys(seen[rows, columns][order[distance[order] <= reach]].tolist()))
