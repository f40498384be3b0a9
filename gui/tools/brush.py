"""Brush tools: paint or erase pixels of the selected block, mark depth as invalid; the base of those that act on
release."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QPainterPath, QPainterPathStroker

from ilf.data.label_map import Box, union
from ilf.segmentation.editing.painting import Stroke, brush_stroke, erase, paint
from ilf.segmentation.editing.snapping import Similar

from ..views.interaction import PointerEvent, PointerKind, Preview
from .base import Host, Point, Tool, edges_ready, line_path, warn_if_any_locked, warn_if_locked

# Pixels that a brush has covered since the button was pressed.


class Swept:
    """Union of the pixels of several short strokes."""

    def __init__(self, shape: tuple[int, int]) -> None:
        self.mask: NDArray[np.bool_] = np.zeros(shape, bool)
        self._box: Box | None = None

    def add(self, stroke: Stroke) -> None:
        """Add a stroke's pixels."""
        self.mask[stroke.box] |= stroke.mask
        self._box = stroke.box if self._box is None else union(self._box, stroke.box)

    @property
    def stroke(self) -> Stroke | None:
        """All pixels as one stroke; None if there are none."""
        return None if self._box is None else Stroke(self._box, self.mask[self._box])


class BrushTool(Tool):
    """The tools Paint and Erase. One stroke, from press to release, is one undo step.

    Painting adds pixels to the selected block, or to the one under the press if none is selected; erasing removes
    pixels from that block only, and assigns them to neighbours on release. Alt swaps the two for one stroke.
    """

    guided = True

    def __init__(self, erases: bool) -> None:
        self.options = ("brush", "similar", "no_block") if erases else ("brush", "similar")
        self._erases = erases
        self._erasing = erases
        self._swept: Swept | None = None
        self._similar: Similar | None = None
        self._last: Point = (0.0, 0.0)
        self._label = 0

    @property
    def hint(self) -> str:
        """Hint: what a drag would do."""
        act = "remove pixels from the block" if self._erases else "add pixels to the block"
        other = "add" if self._erases else "erase"
        return f"Drag: {act} | Alt+drag: {other} | [ ] or Ctrl+wheel: brush size"

    @property
    def busy(self) -> bool:
        """Whether a stroke is in progress."""
        return self._swept is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Paint while the button is down; otherwise show the brush."""
        host.show_preview(None if event.kind is PointerKind.LEAVE else brush_preview(event, host))
        if event.kind is PointerKind.PRESS:
            self._begin(event, host)
        elif self._swept is not None and event.kind is PointerKind.MOVE:
            self._sweep(self._swept, (event.x, event.y), host)
        elif self._swept is not None and event.kind is PointerKind.RELEASE:
            self._end(self._swept, host)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a normal press

    def cancel(self, host: Host) -> bool:
        """Restore the stroke's pixels."""
        pending_work, self._swept = self.busy, None
        host.drop_stroke()
        return pending_work

    def _begin(self, event: PointerEvent, host: Host) -> None:
        document = host.document
        chosen = document.selected
        self._label = chosen[0] if chosen else document.label_at(event.x, event.y)
        self._erasing = self._erases != event.alt
        if self._label == 0:
            host.show_message("Select a block first, or start a new one with Blocks > New block.")
        elif not warn_if_locked(host, self._label) and self._look_around(event, host):
            if chosen != [self._label]:
                host.select([self._label])
            self._swept = Swept(document.labels.shape)
            self._last = event.x, event.y
            self._sweep(self._swept, self._last, host)

    def _look_around(self, event: PointerEvent, host: Host) -> bool:
        """Prepare the limit to similar pixels; False if edges are not computed yet."""
        self._similar = None
        if not host.options.similar_only:
            return True
        edge_data = host.edge_data
        if not edges_ready(host) or edge_data is None:
            return False
        self._similar = Similar(edge_data.frame, edge_data.strength, event.x, event.y)
        return True

    def _sweep(self, swept: Swept, point: Point, host: Host) -> None:
        document = host.document
        stroke: Stroke | None = brush_stroke(document.labels.shape, [self._last, point], host.options.brush_radius)
        self._last = point
        if stroke is not None and self._similar is not None:
            stroke = self._similar.limit(stroke)
        if stroke is None:
            return
        swept.add(stroke)
        change = erase if self._erasing else paint
        host.stroke(change(document.labels, stroke, self._label, document.locked))

    def _end(self, swept: Swept, host: Host) -> None:
        self._swept = None
        document = host.document
        name = document.info(self._label).name
        if not self._erasing:
            if not host.end_stroke(f"Paint {name}", self._label):
                warn_if_any_locked(host, np.unique(document.labels[swept.mask]).tolist())
            return
        text = f"Erase from {name}"
        if host.options.to_no_block:
            host.end_stroke(text, self._label)
            return
        host.drop_stroke()  # the best neighbour can only be found for all pixels together
        if swept.stroke is not None:
            patch = erase(document.labels, swept.stroke, self._label, document.locked, frame=document.frame)
            host.commit(patch, text, self._label)


def brush_preview(event: PointerEvent, host: Host, area: QPainterPath | None = None) -> Preview:
    """Return the preview of the brush at a position, and of the area that it has covered."""
    path = QPainterPath()
    radius = max(host.options.brush_radius, 0.5)
    path.addEllipse(QPointF(event.x, event.y), radius, radius)
    return Preview(path, area=area)


# Strokes that are collected while the button is down, and applied on release.


class StrokeTool(Tool):
    """Base of brush tools whose strokes have an effect on release only."""

    def __init__(self) -> None:
        self._swept: Swept | None = None
        self._points: list[Point] = []

    @property
    def busy(self) -> bool:
        """Whether a stroke is in progress."""
        return self._swept is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Collect pixels while the button is down; apply them on release."""
        point = event.x, event.y
        if event.kind is PointerKind.PRESS and self.begin(event, host):
            self._swept, self._points = Swept(host.document.frame.shape), [point]
            self._sweep(self._swept, point, host)
        elif event.kind is PointerKind.MOVE and self._swept is not None:
            self._sweep(self._swept, point, host)
        elif event.kind is PointerKind.RELEASE and self._swept is not None:
            swept, self._swept = self._swept, None
            self.apply(swept.mask, host)
        self.show_brush(event, host)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a normal press

    def cancel(self, host: Host) -> bool:
        """Cancel the stroke."""
        pending_work, self._swept = self._swept is not None, None
        host.show_preview(None)
        return pending_work

    def begin(self, event: PointerEvent, host: Host) -> bool:
        """Prepare for a press; return whether it starts a stroke."""
        raise NotImplementedError

    def apply(self, mask: NDArray[np.bool_], host: Host) -> None:
        """Apply a stroke that covered the pixels of a mask, bool (H, W)."""
        raise NotImplementedError

    def show_brush(self, event: PointerEvent, host: Host) -> None:
        area = self._trail(host.options.brush_radius) if self._swept is not None else None
        host.show_preview(None if event.kind is PointerKind.LEAVE else brush_preview(event, host, area))

    def _sweep(self, swept: Swept, point: Point, host: Host) -> None:
        stroke = brush_stroke(host.document.frame.shape, [self._points[-1], point], host.options.brush_radius)
        self._points.append(point)
        if stroke is not None:
            swept.add(stroke)

    def _trail(self, radius: float) -> QPainterPath:
        stroker = QPainterPathStroker()
        stroker.setWidth(2 * max(radius, 0.5))
        stroker.setCapStyle(Qt.PenCapStyle.RoundCap)
        stroker.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        points = self._points
        trail = stroker.createStroke(line_path(points if points[0] != points[-1] else [*points, _beside(points[0])]))
        trail.setFillRule(Qt.FillRule.WindingFill)
        return trail


def _beside(point: Point) -> Point:
    """Return a point so near that a line to it is drawn as a dot; a line of zero length would have no direction."""
    return point[0] + 1e-3, point[1]


class MarkInvalidTool(StrokeTool):
    """The tool that marks measured depth as invalid by strokes: it counts as missing. Alt marks it valid again."""

    options = ("brush",)

    def __init__(self) -> None:
        super().__init__()
        self._marks_valid = False

    @property
    def hint(self) -> str:
        """Hint: what a drag would do."""
        return "Drag: mark depth invalid, as behind glass | Alt+drag: mark valid | [ ] or Ctrl+wheel: brush size"

    def begin(self, event: PointerEvent, host: Host) -> bool:
        """Start a stroke, which marks depth valid with Alt."""
        self._marks_valid = event.alt
        return True

    def apply(self, mask: NDArray[np.bool_], host: Host) -> None:
        """Mark the measured depth under the stroke."""
        frame = host.document.frame
        before = np.zeros(frame.shape, bool) if frame.invalid_mask is None else frame.invalid_mask
        measured = mask & np.isfinite(frame.measured)
        after = before & ~measured if self._marks_valid else before | measured
        text = "Mark depth valid" if self._marks_valid else "Mark depth invalid"
        if not np.array_equal(after, before):
            host.mark_invalid(after, text)
        elif self._marks_valid:
            host.show_message("There is no invalid depth here.")
        else:
            host.show_message("There is no valid measured depth here.")
