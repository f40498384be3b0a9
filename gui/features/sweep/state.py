"""Results of a sweep so far: its points with their errors, the best of them, and their pictures."""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSize, Qt

from ilf._runtime.long_work import mapped_steps
from ilf.data.blocks import Box, grown
from ilf.data.declarations import Value
from ilf.data.parameters import Parameters
from ilf.drawing.colours import robust_depth_levels, robust_difference_level
from ilf.evaluation.sweep import Sweep, SweepPoint, SweepResult, sweep_steps
from ilf.segmentation.editing.patches import box_of

from ...state.document import Document
from ...views.colours import depth_table, difference_table
from ...work.jobs import spare_cores

Picture = NDArray[np.float32]
Scale = tuple[NDArray[np.uint8], tuple[float, float]]
"""Colour scale: a lookup table (256, 4), 0 is missing; and the lowest and highest value."""

PICTURE = QSize(176, 132)
"""Maximum size of a picture [px]."""
SMALL_PICTURE = QSize(128, 96)
"""Maximum size of a picture for pairs of values [px]."""
_LEAST_PICTURE = QSize(110, 40)

_MARGIN = 0.1
"""Margin around a single swept block, as a share of its longer side."""


class SweepState:
    """Results of one sweep of one frame.

    Parameters
    ----------
    document : Document
        Document of the frame.
    sweep : Sweep

    Attributes
    ----------
    label : int
        The only block swept; 0 for all.
    errors : list of float
        Root mean square errors [m] of the points so far, in the order of `sweep.points`; NaN where nothing could be
        evaluated.
    coverage : list of float
        Shares of the pixels to fill that they have filled, 0-1.
    result : SweepResult or None
        All points, evaluated over the same pixels, once they are there.
    reference : ndarray or None
        What differences are taken to: ground truth, or a result; None if there is neither.
    """

    def __init__(self, document: Document, sweep: Sweep) -> None:
        self.document, self.sweep = document, sweep
        self.label = next(iter(sweep.only or ()), 0)
        self.points = sweep.points
        self.errors: list[float] = []
        self.coverage: list[float] = []
        self.result: SweepResult | None = None
        self._depths: list[Picture] = []
        frame, completion = document.frame, document.completion()
        self._box = _block_box(document, self.label)
        self._levels = robust_depth_levels(frame.depth[self._box])
        reference = frame.ground_truth
        if reference is None and completion is not None:
            reference = completion.depth
        self.reference = None if reference is None else small(reference[self._box])

    def steps(self) -> Generator[float | SweepPoint, None, SweepResult]:
        """Run the sweep; yields shares done and points. Called in a worker thread."""
        steps = sweep_steps(self.sweep, threads=spare_cores())
        return mapped_steps(steps, lambda step: step if isinstance(step, SweepPoint) else step.share)

    def add(self, point: SweepPoint) -> None:
        """Add the next point."""
        self.errors.append(point.whole.rmse)
        self.coverage.append(point.coverage)
        self._depths.append(small(point.depth[self._box]))

    def finish(self, result: SweepResult) -> None:
        """Set the final errors, over the same pixels."""
        self.result, self.errors = result, [point.whole.rmse for point in result.points]

    @property
    def picture_size(self) -> QSize:
        """Size of a picture on the screen [px]."""
        rows, columns = self._box
        area = QSize(columns.stop - columns.start, rows.stop - rows.start)
        room = PICTURE if len(self.sweep.values) == 1 else SMALL_PICTURE
        return area.scaled(room, Qt.AspectRatioMode.KeepAspectRatio).expandedTo(_LEAST_PICTURE)

    @property
    def marked(self) -> frozenset[int]:
        """The point with the smallest error, once all are there among those that fill enough, with those that cannot be
        told from it."""
        if self.result is not None:
            return frozenset() if self.result.ties is None else self.result.ties.equal
        known = {number: error for number, error in enumerate(self.errors) if math.isfinite(error)}
        return frozenset([min(known, key=known.__getitem__)] if known else [])

    @property
    def best(self) -> int | None:
        """The point with the smallest error, or that with the current values if these cannot be told apart; None if
        there is none."""
        if self.present in self.marked:
            return self.present
        ties = None if self.result is None else self.result.ties
        return next(iter(self.marked), None) if ties is None else ties.best

    @property
    def present_values(self) -> dict[str, Value]:
        """Name -> current value."""
        now = self.document.parameters_of(self.label) if self.label else self.document.state.common
        return {name: getattr(now, name) for name in self.sweep.values}

    @property
    def present(self) -> int | None:
        """The point with the current values, if there is one."""
        return self.points.index(self.present_values) if self.present_values in self.points else None

    def text_of(self, number: int) -> str:
        """Text of the values of a point with their names."""
        labels = {name: declaration.label for name, declaration in Parameters.declarations().items()}
        return ", ".join(f"{labels[name]} {value:g}" for name, value in self.points[number].items())

    def pictures(self, differences: bool, colour_map: str, dark: bool) -> tuple[Sequence[Picture], Scale]:
        """Pictures of the points so far, with a common scale: depth [m] or differences [mm]."""
        if not differences or self.reference is None:
            return self._depths, (depth_table(colour_map), self._levels)
        found = [1000 * (depth - self.reference) for depth in self._depths]
        level = robust_difference_level(np.concatenate([picture.ravel()[::7] for picture in found])) if found else 1.0
        return found, (difference_table(dark), (-level, level))


def small(values: Picture) -> Picture:
    """Subsample a picture to at most twice its resolution on the screen."""
    height, width = values.shape
    stride = max(math.ceil(height / (2 * PICTURE.height())), math.ceil(width / (2 * PICTURE.width())))
    return np.ascontiguousarray(values[::stride, ::stride])


def _block_box(document: Document, label: int) -> Box:
    """Box of the block with a margin; the whole frame without a block."""
    height, width = document.labels.shape
    box = box_of(document.labels, label) if label else None
    if box is None:
        return slice(0, height), slice(0, width)
    largest = max(side.stop - side.start for side in box)
    return grown(box, round(_MARGIN * largest) + 2, (height, width))
