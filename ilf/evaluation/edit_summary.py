"""Summary of an edit: errors before and after, by ground truth, expected error, and hold-out near the border."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from ..completion.confidence.expected_error import expected_error, summarised
from ..data.results import Completion
from ..errors import InputError
from ..run.run import Run
from ..segmentation.editing.patches import LabelPatch
from .evaluation import margin_of_mean

_BAND = 5
"""Known depth is hidden up to this distance [px] from the pixels that have changed blocks. All of it is hidden: a few
samples left on either side of the border would determine the depth between."""

_FEWEST = 20
"""Minimum number of pixels for an error."""


@dataclass(frozen=True)
class EditSummary:
    """Summary of an edit.

    Attributes
    ----------
    moved : int
        Number of pixels that have changed blocks.
    filled : (int, int) or None
        Number of filled pixels of the affected blocks, before and after; None if these have not been run.
    expected : (float, float) or None
        Root mean square of the expected error [m], before and after, of the pixels filled both times; None if there are
        too few.
    by_ground_truth : (float, float) or None
        Root mean square error [m] against ground truth, before and after, of the pixels of the affected blocks that are
        filled both times; None without ground truth or with too few such pixels.
    held_out : (float, float) or None
        Mean absolute error [m] on the hidden depth, before and after; None if there is too little known depth.
    hidden : int
        Number of pixels for `held_out`.
    margin : float
        Half the width of the 95 % confidence interval of the difference of the two errors in `held_out` [m].
    """

    moved: int
    filled: tuple[int, int] | None = None
    expected: tuple[float, float] | None = None
    held_out: tuple[float, float] | None = None
    hidden: int = 0
    by_ground_truth: tuple[float, float] | None = None
    margin: float = math.inf

    @property
    def held_out_differs(self) -> bool:
        """Whether the difference on hold-out exceeds its margin."""
        return self.held_out is not None and abs(self.held_out[1] - self.held_out[0]) > self.margin


def summarise_edit(
    before: Run,
    after: Run,
    patch: LabelPatch | None,
    completed: tuple[Completion | None, Completion | None] = (None, None),
) -> EditSummary:
    """Compute the effect of an edit of the label map on the depth around it, or of another edit on that of all blocks.

    Known depth near the pixels that have changed blocks is hidden, and the blocks there are completed without it, as
    before and as after the edit.

    Parameters
    ----------
    before, after : Run
        Of the same frame; their blocks differ by the edit.
    patch : LabelPatch or None
        The edit, in either direction; None if no pixel has changed blocks.
    completed : (Completion or None, Completion or None)
        Existing completions before and after; ignored if the affected blocks had other pixels.

    Returns
    -------
    EditSummary
    """
    changed = np.zeros(after.frame.shape, bool)
    if patch is not None:
        changed[patch.box] = patch.before != patch.after
    concerned = slice(None) if patch is None else changed
    runs = before, after
    touched = {*np.unique([run.blocks.labels[concerned] for run in runs]).tolist()} - {0}
    effect = replace(_at_filled_pixels(runs, completed, touched), moved=int(np.count_nonzero(changed)))
    if patch is None:
        return effect
    hidden = _near(changed) & after.frame.own
    errors = _errors(runs, hidden)
    both = np.isfinite(errors[0]) & np.isfinite(errors[1])
    count = int(np.count_nonzero(both))
    if count < _FEWEST:
        return effect
    absolute = [np.abs(error[both]) for error in errors]
    margin = margin_of_mean([absolute[1] - absolute[0]], [np.flatnonzero(hidden)[both]], hidden.shape[1])
    before_mean, after_mean = (float(np.mean(error, dtype=np.float64)) for error in absolute)
    return replace(effect, held_out=(before_mean, after_mean), hidden=count, margin=margin)


def _near(changed: NDArray[np.bool_]) -> NDArray[np.bool_]:
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * _BAND + 1, 2 * _BAND + 1))
    return cv2.dilate(changed.astype(np.uint8), disk).astype(bool)


def _errors(runs: tuple[Run, Run], hidden: NDArray[np.bool_]) -> list[NDArray[np.float32]]:
    """Errors [m] of the hidden pixels, completed without them by each run; NaN where they are not filled."""
    frame = runs[0].frame
    ground_truth = np.where(frame.trusted, frame.depth, np.float32(np.nan))[hidden]
    try:  # one frame for both runs, to share its cache
        without = frame.with_more_invalid(hidden)
    except InputError:  # no depth would be left
        return [np.full(ground_truth.shape, np.nan, np.float32)] * len(runs)
    labels = [frozenset(np.unique(run.blocks.labels[hidden]).tolist()) - {0} for run in runs]
    alone = [replace(run, frame=without, only=only, extrapolate=False) for run, only in zip(runs, labels, strict=True)]
    return [run.complete(threads=1).depth[hidden] - ground_truth for run in alone]


def _at_filled_pixels(
    runs: tuple[Run, Run], completed: tuple[Completion | None, Completion | None], touched: set[int]
) -> EditSummary:
    """What the affected blocks have filled, its expected error and, with ground truth, its error; blocks without
    results are only completed for the latter."""
    done = [
        one if one is not None and _matches_blocks(run, one, touched) else None
        for run, one in zip(runs, completed, strict=True)
    ]
    ground_truth, effect = runs[0].frame.ground_truth, EditSummary(0)
    was_run = all(one is not None for one in done)
    if ground_truth is None and not was_run:
        return effect
    pair = [_completed(run, touched) if one is None else one for run, one in zip(runs, done, strict=True)]
    there = np.isin([run.blocks.labels for run in runs], [*touched]).any(axis=0)
    first, second = (there & one.filled_by_blocks for one in pair)
    both = first & second
    if was_run:
        effect = replace(effect, filled=(int(np.count_nonzero(first)), int(np.count_nonzero(second))))
        if np.count_nonzero(both) >= _FEWEST:
            before, after = (summarised(expected_error(one)[both]).rms for one in pair)
            effect = replace(effect, expected=(before, after))
    if ground_truth is not None:
        both &= np.isfinite(ground_truth)
        if np.count_nonzero(both) >= _FEWEST:
            before, after = (_rms(one.depth[both] - ground_truth[both]) for one in pair)
            effect = replace(effect, by_ground_truth=(before, after))
    return effect


def _completed(run: Run, touched: set[int]) -> Completion:
    there = frozenset(touched & set(np.unique(run.blocks.labels).tolist()))
    return replace(run, only=there, extrapolate=False).complete(threads=1)


def _matches_blocks(run: Run, completion: Completion, touched: set[int]) -> bool:
    """Whether the existing results of these blocks have exactly the pixels of the run's blocks."""
    return all(
        np.array_equal(run.blocks.labels[result.block.box] == label, result.block.mask)
        and np.count_nonzero(run.blocks.labels == label) == result.depth.size
        for label, result in completion.results.items()
        if label in touched
    )


def _rms(values: NDArray[np.float32]) -> float:
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64))))
