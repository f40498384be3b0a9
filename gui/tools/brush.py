"""The brushes: their base, and those that paint or erase pixels of a block or mark depth as invalid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, Qt
from PySide6.QtGui import QPainterPath, QPainterPathStroker

from ilf.data.blocks import Region, cropped
from ilf.errors import InputError
from ilf.segmentation.editing.painting import brush_stroke, erase, paint
from ilf.segmentation.editing.snapping import similar_pixels

from ..views.interaction import PointerEvent, PointerKind, Preview
from .base import Host, Point, Tool, check_unlocked, edges_of, line_path

Mask = NDArray[np.bool_]


class StrokeTool(Tool):
    """Base of the brushes. They cover pixels while the button is down; one stroke, to the release, is one undo step."""

    options: tuple[str, ...] = ("brush",)
    leaves_trail = True
    """Whether the covered pixels are shaded until the release."""

    def __init__(self) -> None:
        self._swept: Mask | None = None
        """The pixels that the brush has covered since the button was pressed."""
        self._points: list[Point] = []

    @property
    def busy(self) -> bool:
        """Whether a stroke is in progress."""
        return self._swept is not None

    def pointer(self, event: PointerEvent, host: Host) -> bool:
        """Cover pixels while the button is down; apply the stroke on release."""
        point = event.x, event.y
        try:
            if event.kind is PointerKind.PRESS and self.begin(event, host):
                self._swept, self._points = np.zeros(host.document.frame.shape, bool), [point]
                self._sweep(self._swept, point, host)
            elif event.kind is PointerKind.MOVE and self._swept is not None:
                self._sweep(self._swept, point, host)
            elif event.kind is PointerKind.RELEASE and self._swept is not None:
                swept, self._swept = self._swept, None
                self.apply(swept, host)
        finally:  # also if that was refused
            self.show_brush(event, host)
        return event.kind is not PointerKind.DOUBLE  # the second of two quick clicks is a normal press

    def cancel(self, host: Host) -> None:
        """Cancel the stroke."""
        self._swept = None
        host.show_preview(None)

    def begin(self, event: PointerEvent, host: Host) -> bool:
        """Prepare for a press; return whether it starts a stroke."""
        return True

    def cover(self, stroke: Region, host: Host) -> Region | None:
        """Take the pixels that the brush has just passed; return those that count."""
        return stroke

    def apply(self, swept: Mask, host: Host) -> None:
        """Apply a whole stroke."""
        raise NotImplementedError

    def show_brush(self, event: PointerEvent, host: Host) -> None:
        """Show the brush, and what the stroke has covered."""
        shows_trail = self.leaves_trail and self._swept is not None
        area = self._trail(host.options.brush_radius) if shows_trail else None
        host.show_preview(None if event.kind is PointerKind.LEAVE else brush_preview(event, host, area))

    def _sweep(self, swept: Mask, point: Point, host: Host) -> None:
        stroke = brush_stroke(host.document.frame.shape, [self._points[-1], point], host.options.brush_radius)
        self._points.append(point)
        covered = None if stroke is None else self.cover(stroke, host)
        if covered is not None:
            swept[covered.box] |= covered.mask

    def _trail(self, radius: float) -> QPainterPath:
        stroker = QPainterPathStroker()
        stroker.setWidth(2 * max(radius, 0.5))
        stroker.setCapStyle(Qt.PenCapStyle.RoundCap)
        stroker.setJoinStyle(Qt.PenJoinStyle.RoundJoin)
        points, (x, y) = self._points, self._points[0]
        # a line of zero length would have no direction: a dot is drawn as a line to a point beside it
        trail = stroker.createStroke(line_path(points if points[0] != points[-1] else [*points, (x + 1e-3, y)]))
        trail.setFillRule(Qt.FillRule.WindingFill)
        return trail


def brush_preview(event: PointerEvent, host: Host, area: QPainterPath | None = None) -> Preview:
    """Return the preview of the brush at a position, and of the area that it has covered."""
    path = QPainterPath()
    radius = max(host.options.brush_radius, 0.5)
    path.addEllipse(QPointF(event.x, event.y), radius, radius)
    return Preview(path, area=area)


class PaintTool(StrokeTool):
    """Add pixels to the selected block with the brush.

    If none is selected, it is the block under the press. Ctrl swaps painting and erasing for one stroke.
    """

    options = ("brush", "similar_only", "new_block")
    guided = True
    leaves_trail = False
    erases = False
    hint = "Drag: add pixels to the block | Ctrl+drag: erase | [ ] or Ctrl+wheel: brush size"

    def __init__(self) -> None:
        super().__init__()
        self._erasing = False
        self._similar: NDArray[np.bool_] | None = None
        self._label = 0

    def cancel(self, host: Host) -> None:
        """Restore the stroke's pixels."""
        self._swept = None
        host.document.drop_stroke()

    def begin(self, event: PointerEvent, host: Host) -> bool:
        """Choose the block; refused without one, or if it is locked."""
        document = host.document
        chosen = document.selected
        self._label = chosen[0] if chosen else document.label_at(event.x, event.y)
        self._erasing = self.erases != event.opposite
        if self._label == 0:
            raise InputError("Select a block first, or start a new one with Blocks > New block.")
        check_unlocked(document, [self._label])
        self._similar = None
        if host.options.similar_only:
            edges = edges_of(host)
            self._similar = similar_pixels(edges.frame, edges.strength, event.x, event.y)
        if chosen != [self._label]:
            host.document.select([self._label])
        return True

    def cover(self, stroke: Region, host: Host) -> Region | None:
        """Paint or erase the pixels at once."""
        if self._similar is not None:
            stroke = Region(stroke.box, stroke.mask & self._similar[stroke.box])
            if not stroke.mask.any():
                return None
        change = erase if self._erasing else paint
        host.document.stroke(change(host.document.labels, stroke, self._label, host.document.locked))
        return stroke

    def apply(self, swept: Mask, host: Host) -> None:
        """Make the stroke one undo step; erased pixels go to the neighbours that fit best."""
        document = host.document
        patch = document.drop_stroke()
        if self._erasing and not host.options.to_no_block and (stroke := cropped(swept)) is not None:
            # the best neighbour can only be found for all pixels together
            patch = erase(document.labels, stroke, self._label, document.locked, frame=document.frame)
        name = document.info(self._label).name
        if not host.commit(patch, f"{'Erase from' if self._erasing else 'Paint'} {name}", self._label):
            if self._erasing:
                raise InputError(f"{name} is selected, and has no pixels here.")
            check_unlocked(document, np.unique(document.labels[swept]).tolist())


class EraseTool(PaintTool):
    """Remove pixels from the selected block.

    Other blocks lose none; on release, the pixels go to neighbours.
    """

    options = ("brush", "similar_only", "to_no_block")
    erases = True
    hint = "Drag: remove pixels from the block | Ctrl+drag: add | [ ] or Ctrl+wheel: brush size"


class MarkInvalidTool(StrokeTool):
    """Mark measured depth as invalid, for example behind glass: it counts as missing.

    With Ctrl, a stroke marks it valid again.
    """

    hint = "Drag: mark depth invalid, as behind glass | Ctrl+drag: mark valid | [ ] or Ctrl+wheel: brush size"

    def __init__(self) -> None:
        super().__init__()
        self._marks_valid = False

    def begin(self, event: PointerEvent, host: Host) -> bool:
        """Start a stroke, which marks depth valid with Ctrl."""
        self._marks_valid = event.opposite
        return True

    def apply(self, swept: Mask, host: Host) -> None:
        """Mark the measured depth under the stroke."""
        frame = host.document.frame
        before = np.zeros(frame.shape, bool) if frame.invalid_mask is None else frame.invalid_mask
        measured = swept & np.isfinite(frame.measured)
        after = before & ~measured if self._marks_valid else before | measured
        text = "Mark depth valid" if self._marks_valid else "Mark depth invalid"
        if np.array_equal(after, before):
            raise InputError(f"There is no {'invalid' if self._marks_valid else 'valid measured'} depth here.")
        host.document.set_invalid_mask(after, text)
