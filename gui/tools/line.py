"""Base of the tools that draw a line: freely in a drag, or from click to click."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from PySide6.QtGui import QPainterPath

from ilf._runtime.formatting import grouped
from ilf.segmentation.editing.patches import LabelPatch
from ilf.segmentation.editing.snapping import snap

from ..state.document import Document
from ..views.interaction import PointerEvent, Preview
from ..views.mask_paths import boundary_path
from .base import LARGEST_LEASH, Host, Point, Press, Tool, line_path

# A line in progress: free, straight, or from click to click.

Snap = Callable[[list[Point]], list[Point]]
"""Moves a drawn line to nearby edges."""

_MAGNET = math.radians(4)
"""Angle within which a straight line snaps to vertical, horizontal or diagonal."""

_STEP = 0.5
"""Minimum distance between points of a free line [px]."""


@dataclass
class Stretch:
    """A segment of a line: as drawn, and after snapping."""

    drawn: list[Point]
    line: list[Point]
    straight: bool

    @property
    def free(self) -> bool:
        """Whether it was drawn freely, rather than from point to point."""
        return len(self.drawn) > 2


class Pen:
    """A line of segments: each is free and snaps to nearby edges, or straight and does not."""

    def __init__(self) -> None:
        self._start: Point | None = None
        self.stretches: list[Stretch] = []
        """The segments of the line."""
        self._open = False

    @property
    def down(self) -> bool:
        """Whether there is a line."""
        return self._start is not None

    @property
    def line(self) -> list[Point]:
        """The points of the line after snapping."""
        points = self._first
        for stretch in self.stretches:
            points += stretch.line[1:]
        return points

    @property
    def corners(self) -> list[Point]:
        """The start of the line and the ends of its segments."""
        return self._first + [stretch.line[-1] for stretch in self.stretches]

    @property
    def _first(self) -> list[Point]:
        if self._start is None:
            return []
        return self.stretches[0].line[:1] if self.stretches else [self._start]

    def lift(self) -> None:
        """Remove the line."""
        self._start = None
        self.stretches = []
        self._open = False

    def begin(self, point: Point) -> None:
        """Start a line."""
        self.lift()
        self._start = point

    def drag(self, point: Point, straight: bool, snap: Snap) -> None:
        """Draw on to a point; a segment continues while it is drawn in the same way."""
        if not self._open or self.stretches[-1].straight != straight:
            end = self.corners[-1]
            self.stretches.append(Stretch([end], [end], straight))
            self._open = True
        stretch = self.stretches[-1]
        if straight:
            stretch.drawn = stretch.line = [stretch.drawn[0], straightened(stretch.drawn[0], point)]
        elif len(stretch.drawn) == 1 or math.dist(stretch.drawn[-1], point) >= _STEP:
            stretch.drawn.append(point)
            stretch.line = snap(stretch.drawn)

    def rest(self) -> None:
        """End the segment; the next point starts another."""
        self._open = False

    def go(self, point: Point, straight: bool, snap: Snap) -> None:
        """Add one segment to a point, as by a click."""
        self.rest()
        self.drag(point, straight, snap)
        self.rest()

    def reach(self, point: Point, straight: bool, snap: Snap) -> list[Point]:
        """Return the segment that `go` would add."""
        end = self.corners[-1]
        return [end, straightened(end, point)] if straight else snap([end, point])

    def undo_last(self) -> None:
        """Remove the last segment, or the start if there is none."""
        self._open = False
        if self.stretches:
            self.stretches.pop()
        else:
            self._start = None


def straightened(start: Point, end: Point) -> Point:
    """Return the end of a straight line, made vertical, horizontal or diagonal if it is nearly so."""
    along, down = end[0] - start[0], end[1] - start[1]
    angle = math.atan2(down, along)
    nearest = round(angle / (math.pi / 4)) * math.pi / 4
    if abs(angle - nearest) > _MAGNET:
        return end
    length = math.hypot(along, down) * math.cos(angle - nearest)
    return start[0] + length * math.cos(nearest), start[1] + length * math.sin(nearest)


# Points and lines within reach of the pointer.

REACH = 8.0
"""Maximum distance from the pointer at which things are picked [screen pixels]."""


def nearest(points: Sequence[Point], event: PointerEvent) -> int | None:
    """Return the index of the nearest point within reach; None if none is."""
    distances = [math.dist(point, (event.x, event.y)) for point in points]
    closest = min(range(len(points)), key=distances.__getitem__, default=None)
    return closest if closest is not None and distances[closest] <= REACH * event.pixel else None


def touches(start: Point, end: Point, event: PointerEvent) -> bool:
    """Return whether the straight line between two points is within reach."""
    return off_line((event.x, event.y), start, end) <= REACH * event.pixel


def off_line(point: Point, start: Point, end: Point) -> float:
    """Return the distance of a point from the line segment between two others."""
    share = share_along(point, start, end)
    return math.dist(point, (start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])))


def share_along(point: Point, start: Point, end: Point) -> float:
    """Return the position, 0-1, on the line segment between two points that is nearest to a point."""
    x, y = end[0] - start[0], end[1] - start[1]
    square = x * x + y * y
    if square == 0:
        return 0.0
    return min(max(((point[0] - start[0]) * x + (point[1] - start[1]) * y) / square, 0.0), 1.0)


def clamped(point: Point, shape: tuple[int, int]) -> Point:
    """Return the nearest pixel centre on a frame of shape (H, W)."""
    height, width = shape
    x, y = (min(max(math.floor(value), 0), size - 1) + 0.5 for value, size in zip(point, (width, height), strict=True))
    return x, y


# The effect of a line in progress.

_NAMED = 2
"""Maximum number of pairs of blocks that are listed by name; more are counted."""


Effect = tuple[str, QPainterPath]
"""What would change: in words, and its outline, drawn dashed."""


def effect_of(document: Document, patch: LabelPatch | None, apart: int = 0) -> Effect:
    """Return the effect of a change of the label map: the moved pixels and their outline.

    Parameters
    ----------
    document : Document
    patch : LabelPatch or None
        The change; None for none. If a lock forbids it, the text contains only the locked block.
    apart : int
        Number of pixels that would be disconnected from the block that gets them.
    """
    if patch is None:
        return "no pixel changes", QPainterPath()
    changed = patch.before != patch.after
    moves = np.stack([patch.before[changed], patch.after[changed]], axis=1)
    pairs, counts = np.unique(moves, axis=0, return_counts=True)
    locked = sorted(document.locked & set(pairs.ravel().tolist()))
    if locked:
        return f"{document.info(locked[0]).name} is locked", QPainterPath()
    if len(pairs) > _NAMED:
        text = f"{grouped(int(counts.sum()))} px from {len(pairs)} blocks to {_name(document, int(pairs[0, 1]))}"
    else:
        text = ", ".join(
            f"{grouped(count)} px from {_name(document, giver)} to {_name(document, taker)}"
            for count, (giver, taker) in zip(counts.tolist(), pairs.tolist(), strict=True)
        )
    rows, columns = patch.box
    path = boundary_path(changed, columns.start, rows.start)
    if apart:
        text += f", {'' if apart == counts.sum() else f'{grouped(apart)} px of them '}disconnected from the rest of it"
    return text, path


def tell_if_apart(host: Host, label: int, apart: int, remedy: str = "") -> None:
    """Show a message with a remedy if a block has got disconnected pixels."""
    if apart:
        name = host.document.info(label).name
        host.show_message(f"{name} now has {grouped(apart)} px that are disconnected from the rest of it.{remedy}")


def _name(document: Document, label: int) -> str:
    """Return the name of a block, without registering a new one."""
    if label == 0:
        return "no block"
    return document.info(label).name if label in document.blocks.infos or label in document.counts() else "a new block"


# The base of the tools.


class LineTool(Tool):
    """Base of tools with a line in progress. It snaps to edges within the leash; with Shift it is straight."""

    options: tuple[str, ...] = ("leash",)
    guided = True

    def __init__(self) -> None:
        self._pen = Pen()
        self._by_clicks = False
        self._pixel = 1.0
        self._shown: list[Point] = []
        self._effect: Effect | None = None
        """Of the line, or of its shape a moment ago."""

    def look_ahead(self, line: list[Point], host: Host) -> Callable[[], Any]:
        """Return a function that computes the effect of a line, called in the background: the change of the label map
        and the number of disconnected pixels, or what `effect` takes."""
        raise NotImplementedError

    def effect(self, answer: Any, host: Host) -> Effect:
        """Return the effect by the result of the function from `look_ahead`: pixels that change their block."""
        return effect_of(host.document, *answer)

    @property
    def release_hint(self) -> str:
        """Hint: what a release would do; "" as long as that is not known."""
        return f"Release: {self._effect[0]} | Shift: straight | Esc: cancel" if self._effect else ""

    @property
    def busy(self) -> bool:
        """Whether there is a line, or the button is pressed."""
        return super().busy or self._pen.down

    def cancel(self, host: Host) -> None:
        """Cancel the line."""
        self._press = self._effect = None
        self._by_clicks = False
        self._pen.lift()
        host.show_preview(None)

    def undo_last(self, host: Host) -> bool:
        """Remove what the last click added."""
        if not self._by_clicks:
            return False
        self._pen.undo_last()
        if self._pen.down:
            self._show(host)
        else:
            self.cancel(host)
        return True

    def _hover(self, event: PointerEvent, host: Host) -> None:
        """Show where the next click would lead the line."""
        if self._by_clicks:
            self._show(host, event)

    def _drag(self, press: Press, event: PointerEvent, host: Host) -> bool:
        """Draw while the button is down; False while it may still be a click."""
        dragged = press.drags
        if not press.follow(event):
            return False
        self._pixel = event.pixel
        snap = self._snap(host)
        if not self._pen.down:
            self._pen.begin(press.point)
        elif not dragged:
            self._pen.go(press.point, event.shift, snap)
        self._pen.drag((event.x, event.y), event.shift, snap)
        self._show(host)
        return True

    def _click(self, point: Point, straight: bool, host: Host) -> None:
        """Add a point, or start a line there."""
        self._by_clicks = True
        if self._pen.down:
            self._pen.go(point, straight, self._snap(host))
        else:
            self._pen.begin(point)
        self._show(host)

    def _show(self, host: Host, event: PointerEvent | None = None) -> None:
        """Show the line, and with `event` its next segment to the pointer."""
        line = self._pen.line
        if event is not None:
            self._pixel = event.pixel
            line = line + self._pen.reach((event.x, event.y), event.shift, self._snap(host))[1:]
        self._shown = line
        self._draw(host)
        if len(line) > 1:
            host.run_in_background(self.look_ahead(line, host), partial(self._take_effect, host))

    def _take_effect(self, host: Host, answer: Any) -> None:
        if self._pen.down:
            self._effect = self.effect(answer, host)
            self._draw(host)

    def _draw(self, host: Host) -> None:
        corners = self._pen.corners if self._by_clicks else self._shown[:1]
        self._show_path(line_path(self._shown), corners, host)

    def _show_path(self, path: QPainterPath, corners: Sequence[Point], host: Host) -> None:
        """Show a line with its corners and its effect."""
        host.show_preview(Preview(path, corners, line_preview=None if self._effect is None else self._effect[1]))

    @property
    def _near(self) -> float:
        """Distance by which a line may miss its target, in image pixels."""
        return REACH * self._pixel

    def _snap(self, host: Host) -> Snap:
        """Return a function that moves a drawn line to edges within the leash at the current zoom."""
        edge_data, leash = host.edge_data, min(host.options.leash * self._pixel, LARGEST_LEASH)
        return list if edge_data is None else partial(snap, evidence=edge_data.evidence, leash=leash)
