"""Results of a sweep so far: points by number, errors, the best point, and pictures."""

from __future__ import annotations

import math
from collections.abc import Collection, Generator, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QSize, Qt

from ilf._runtime.cancellation import mapped_steps
from ilf._runtime.formatting import counted
from ilf.data.declarations import Value
from ilf.data.label_map import Box
from ilf.data.parameters import Parameters
from ilf.drawing.colours import robust_depth_levels, robust_difference_level
from ilf.evaluation.sweep import Sweep, SweepPoint, SweepResult, sweep_steps
from ilf.evaluation.ties import Ties
from ilf.segmentation.editing.patches import box_of, grown

from ...state.document import Document
from ...views.colours import depth_table, difference_table
from ...work.jobs import spare_cores

Picture = NDArray[np.float32]

PICTURE = QSize(176, 132)
"""Maximum size of a picture [px]."""
SMALL_PICTURE = QSize(128, 96)
"""Maximum size of a picture for pairs of values [px]."""
_LEAST_PICTURE = QSize(110, 40)

_LISTED = 5
"""Maximum number of equal values that are listed."""

_MARGIN = 0.1
"""Margin around a single swept block, as a share of its longer side."""


class Scale(NamedTuple):
    """Colour scale: a lookup table (256, 4) for values from low to high; 0 is missing."""

    table: NDArray[np.uint8]
    low: float
    high: float


class SweepState:
    """Results of one sweep of one frame.

    Parameters
    ----------
    document : Document
        Document of the frame.
    sweep : Sweep
    label : int
        The only block swept; 0 for all.
    """

    def __init__(self, document: Document, sweep: Sweep, label: int) -> None:
        self.document, self.sweep, self.label = document, sweep, label
        self.errors: dict[int, float] = {}
        """Point by number -> root mean square error [m]; NaN where nothing could be evaluated."""
        self.coverage: dict[int, float] = {}
        """Point by number -> share of the pixels to fill that were filled, 0-1."""
        self.points = sweep.points
        self._numbers = {tuple(point.items()): number for number, point in enumerate(self.points)}
        self._result: SweepResult | None = None
        self._depths: dict[int, Picture] = {}
        frame = document.frame
        self._box = _block_box(document, label)
        self._levels = robust_depth_levels(frame.depth[self._box])
        completion = document.completion()
        reference = (
            frame.ground_truth if frame.ground_truth is not None else None if completion is None else completion.depth
        )
        self.reference = None if reference is None else small(reference[self._box])
        """What differences are taken to: ground truth, or a result; None if there is neither."""

    def steps(self) -> Generator[float | SweepPoint, None, SweepResult]:
        """Run the sweep; yields shares done and points. Called in a worker thread."""
        steps = sweep_steps(self.sweep, threads=spare_cores())
        return mapped_steps(steps, lambda step: step if isinstance(step, SweepPoint) else step.share)

    @property
    def picture_size(self) -> QSize:
        """Size of a picture on the screen [px]."""
        rows, columns = self._box
        area = QSize(columns.stop - columns.start, rows.stop - rows.start)
        room = PICTURE if len(self.sweep.values) == 1 else SMALL_PICTURE
        return area.scaled(room, Qt.AspectRatioMode.KeepAspectRatio).expandedTo(_LEAST_PICTURE)

    @property
    def best(self) -> int | None:
        """The point with the smallest error among those that fill enough, or that with the current values if these
        cannot be told apart; None if there is none."""
        if self._result is not None:
            ties = self._result.ties
            return None if ties is None else self.present if self.present in ties.equal else ties.best
        known = {number: error for number, error in self.errors.items() if math.isfinite(error)}
        return min(known, key=known.__getitem__) if known else None

    @property
    def is_over_all(self) -> bool:
        """Whether all errors are over the same pixels: those filled by every point."""
        return self._result is not None

    @property
    def ties(self) -> Ties | None:
        """The points that cannot be told from the best, once all are there; None if there is only one."""
        return None if self._result is None else self._result.ties or None

    @property
    def marked(self) -> frozenset[int]:
        """The best point, with those that cannot be told from it."""
        if self.ties is not None:
            return self.ties.equal
        return frozenset() if self.best is None else frozenset({self.best})

    def text_of(self, number: int) -> str:
        """Text of the values of a point with their names."""
        labels = {name: declaration.label for name, declaration in Parameters.declarations().items()}
        return ", ".join(f"{labels[name]} {value:g}" for name, value in self.points[number].items())

    def text_of_several(self, numbers: Collection[int]) -> str:
        """Text of the values of several points: all of one parameter up to a few, otherwise their number."""
        if len(numbers) > _LISTED or len(self.sweep.values) > 1:
            return f"{len(numbers)} of {counted(len(self.points), 'point')}"
        (name,) = self.sweep.values
        texts = [f"{self.points[number][name]:g}" for number in sorted(numbers)]
        return f"{Parameters.declarations()[name].label} {', '.join(texts[:-1])} and {texts[-1]}"

    @property
    def present_values(self) -> dict[str, Value]:
        """Name -> current value."""
        now = self.document.parameters_of(self.label) if self.label else self.document.state.common
        return {name: getattr(now, name) for name in self.sweep.values}

    @property
    def present(self) -> int | None:
        """The point with the current values, if there is one."""
        return self._numbers.get(tuple(self.present_values.items()))

    def add(self, point: SweepPoint) -> None:
        """Add a point."""
        number = self._number(point)
        self.errors[number], self.coverage[number] = point.whole.rmse, point.coverage
        self._depths[number] = small(point.depth[self._box])

    def finish(self, result: SweepResult) -> None:
        """Set the final errors, over the same pixels."""
        for point in result.points:
            self.errors[self._number(point)] = point.whole.rmse
        self._result = result

    def _number(self, point: SweepPoint) -> int:
        return self._numbers[tuple(point.values.items())]

    def pictures(self, differences: bool, colour_map: str, dark: bool) -> tuple[Mapping[int, Picture], Scale]:
        """Pictures of the points by number, with a common scale: depth [m] or differences [mm]."""
        if not differences or self.reference is None:
            return self._depths, Scale(depth_table(colour_map), *self._levels)
        found = {number: 1000 * (depth - self.reference) for number, depth in self._depths.items()}
        all_values = [picture.ravel()[::7] for picture in found.values()]
        level = robust_difference_level(np.concatenate(all_values)) if all_values else 1.0
        return found, Scale(difference_table(dark), -level, level)


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
