"""The part of a report on one frame, and its row in the index."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._runtime.cancellation import cancellable_items
from .._runtime.formatting import millimetres
from ..completion.confidence.expected_error import RMS_NAME, ErrorSummary, error_summary, expected_error, summarised
from ..data.parameters import BlockParameters
from ..data.results import BlockResult, Completion, Status, blocks_by_message
from ..evaluation.evaluation import Evaluated, PixelErrors
from ..evaluation.hold_out import RunEvaluation
from ..run.options import ExportOptions
from ..run.record import make_record
from ..run.run import Run
from .curves import curve_lines, curve_plots
from .pictures import frame_pictures, thumbnail
from .subject import Subject
from .templates import render

GROUND_TRUTH = "Against ground truth"
_THUMBNAIL = 240


class FramePage:
    """The figures of a frame, and the parts of a report that show them.

    Parameters
    ----------
    subject : Subject
    hidden : RunEvaluation, optional
        The evaluation on hold-out, if there is one.

    Attributes
    ----------
    subject : Subject
    hidden : RunEvaluation or None
    expected : ndarray of float32, shape (H, W)
        `expected_error` of the completion [m].
    evaluations : dict of str to Evaluated
    blocks : dict of int to tuple
        Label -> number of pixels, and share of them without measured depth.
    """

    def __init__(self, subject: Subject, hidden: RunEvaluation | None = None) -> None:
        self.subject, self.hidden = subject, hidden
        self.expected: NDArray[np.float32] = expected_error(subject.completion)
        self.evaluations = self._evaluate()
        labels = subject.run.blocks.labels
        pixels = np.bincount(labels.ravel())
        known = np.bincount(labels[~subject.run.frame.missing], minlength=pixels.size)
        there = (int(label) for label in np.flatnonzero(pixels) if label)
        self.blocks = {label: (int(pixels[label]), 1 - known[label] / pixels[label]) for label in there}

    def html(self, id: str, most: int) -> str:
        """Return the frame's part of the page; its pictures have at most `most` pixels on the longer side."""
        subject, run = self.subject, self.subject.run
        lines = curve_lines(subject)
        return render(
            "frame.html",
            id=id,
            page=self,
            subject=subject,
            run=run,
            frame=run.frame,
            completion=subject.completion,
            pictures=cancellable_items(frame_pictures(subject, self.expected, self.hidden, most)),
            lines=lines,
            plots=curve_plots(subject, lines),
            record=make_record(run, subject.completion, ExportOptions()),
        )

    def index_row(self, id: str) -> dict[str, str]:
        """Return the frame's row in the index: id, name, picture, and text by the column's heading."""
        frame, completion = self.subject.run.frame, self.subject.completion
        against = self.evaluations.get(GROUND_TRUTH)
        return {
            "id": id,
            "name": frame.name,
            "image": thumbnail(self.subject, _THUMBNAIL),
            "size [px]": f"{frame.shape[1]} × {frame.shape[0]}",
            "missing in": f"{frame.missing_share:.1%}",
            "missing out": f"{float(np.mean(frame.missing & np.isnan(completion.depth))):.1%}",
            "blocks": str(len(self.blocks)),
            "with result": str(len(completion.results)),
            f"{RMS_NAME} [mm]": millimetres(self.errors.rms),
            "ground truth [mm]": "" if against is None else millimetres(against.whole.rmse),
            "hold-out [mm]": "" if self.hidden is None else millimetres(self.hidden.whole.rmse),
            "note": self.subject.note,
        }

    def _evaluate(self) -> dict[str, Evaluated]:
        """Return all evaluations of the frame by their names."""
        run, completion = self.subject.run, self.subject.completion
        found = {GROUND_TRUTH: _against_ground_truth(run, completion, completion.filled_by_blocks, self.expected)}
        if completion.extrapolated.any():
            whole = _against_ground_truth(run, completion, completion.filled, self.expected)
            found[f"{GROUND_TRUTH}, including extrapolated pixels"] = whole
        there = {name: evaluated for name, evaluated in found.items() if evaluated is not None}
        return there if self.hidden is None else there | _on_hold_out(self.hidden)

    @property
    def errors(self) -> ErrorSummary:
        """Summary of the expected error."""
        return error_summary(self.expected, self.subject.completion)

    def expected_of(self, result: BlockResult) -> float:
        """Return the RMS of the expected error [m] over the pixels that a block has filled; NaN if there are none."""
        box = result.block.box
        filled = result.block.mask & self.subject.completion.filled_by_blocks[box]
        return summarised(self.expected[box][filled]).rms

    @property
    def faults(self) -> dict[str, list[int]]:
        """What went wrong with blocks -> their labels."""
        wrong = Status.NOT_RECOVERABLE, Status.ITERATION_LIMIT
        outcomes = self.subject.completion.outcomes.values()
        return blocks_by_message(outcome for outcome in outcomes if outcome.status in wrong)

    @property
    def extraction(self) -> dict[str, object]:
        """The changes of the extraction that have an effect."""
        extraction = self.subject.run.blocks.extraction or BlockParameters()
        differs = extraction.differences_from(BlockParameters())
        return {name: value for name, value in differs.items() if extraction.has_effect(name)}

    @property
    def own(self) -> dict[int, object]:
        """Label -> the block's own parameters."""
        run = self.subject.run
        own = {label: run.parameters_of(label).differences_from(run.parameters) for label in sorted(run.blocks.own)}
        return {label: values for label, values in own.items() if values}


def _against_ground_truth(
    run: Run, completion: Completion, filled: NDArray[np.bool_], expected: NDArray[np.float32]
) -> Evaluated | None:
    """Evaluate some of the filled pixels against the frame's ground truth; None without it, or if no block was run.

    Parameters
    ----------
    run : Run
    completion : Completion
    filled : ndarray of bool, shape (H, W)
        The pixels to evaluate; the other missing ones count as not filled.
    expected : ndarray of float32, shape (H, W)
        `expected_error` of the completion [m].
    """
    ground_truth = run.frame.ground_truth
    if ground_truth is None or not completion.results:
        return None
    wanted = run.frame.missing & np.isfinite(ground_truth)
    depth = np.where(filled, completion.depth, np.float32(np.nan))
    errors = PixelErrors.at(wanted, depth, ground_truth, expected)
    return Evaluated(run.blocks.labels, (errors,))


def _on_hold_out(hidden: RunEvaluation) -> dict[str, Evaluated]:
    """Name the evaluation over all seeds of a hold-out test, and, if there are several, that of each."""
    test = hidden.test
    assert test is not None, "it is of a hold-out"
    seeds = ", ".join(map(str, test.seeds))
    named: dict[str, Evaluated] = {f"On hold-out ({test.pattern}; seed{'s' * (len(test.seeds) > 1)} {seeds})": hidden}
    if len(test.seeds) > 1:
        for seed, part in zip(test.seeds, hidden.parts, strict=True):
            named[f"seed {seed} alone"] = Evaluated(hidden.labels, (part,))
    return named
