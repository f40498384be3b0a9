"""The part of a report on one frame, and its row in the index."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import millimetres
from .._runtime.long_work import cancellable_items
from ..completion.confidence.expected_error import RMS_NAME, error_summary, expected_error, summarised
from ..data.parameters import BlockParameters
from ..data.results import BlockResult, Status, blocks_by_message
from ..evaluation.evaluation import Evaluated, PixelErrors
from ..evaluation.hold_out import RunEvaluation
from ..run.options import ExportOptions
from ..run.record import make_record
from ..run.run import Run
from .pictures import curve_lines, curve_plots, frame_pictures, thumbnail
from .subject import Subject
from .templates import render

GROUND_TRUTH = "Against ground truth"
_THUMBNAIL = 240


def frame_page(subject: Subject, id: str, most: int, hidden: RunEvaluation | None = None) -> tuple[str, dict[str, str]]:
    """Return a frame's part of the page, and its row in the index: id, name, picture, and text by the column's heading.

    Parameters
    ----------
    subject : Subject
    id : str
        Name of the part within the page.
    most : int
        Its pictures have at most so many pixels on the longer side.
    hidden : RunEvaluation, optional
        The evaluation on hold-out, if there is one.
    """
    run, completion, frame = subject.run, subject.completion, subject.run.frame
    expected, errors = expected_error(completion), error_summary(completion)
    evaluations = _evaluations(subject, hidden)
    blocks, lines = _blocks(run), curve_lines(subject)
    extraction = run.blocks.extraction or BlockParameters()
    differs = extraction.differences_from(BlockParameters())
    own = {label: run.parameters_of(label).differences_from(run.parameters) for label in sorted(run.blocks.own)}
    wrong = Status.NOT_RECOVERABLE, Status.ITERATION_LIMIT

    def expected_of(result: BlockResult) -> float:
        """RMS of the expected error [m] over the pixels that a block has filled; NaN if there are none."""
        box = result.block.box
        return summarised(expected[box][result.block.mask & completion.filled_by_blocks[box]]).rms

    html = render(
        "frame.html",
        id=id,
        subject=subject,
        run=run,
        frame=frame,
        completion=completion,
        hidden=hidden,
        errors=errors,
        evaluations=evaluations,
        blocks=blocks,
        expected_of=expected_of,
        faults=blocks_by_message(outcome for outcome in completion.outcomes.values() if outcome.status in wrong),
        extraction={name: value for name, value in differs.items() if extraction.has_effect(name)},
        own={label: values for label, values in own.items() if values},
        pictures=cancellable_items(frame_pictures(subject, hidden, most)),
        lines=lines,
        plots=curve_plots(subject, lines),
        record=make_record(completion, ExportOptions()),
    )
    against = evaluations.get(GROUND_TRUTH)
    return html, {
        "id": id,
        "name": frame.name,
        "image": thumbnail(subject, _THUMBNAIL),
        "size [px]": f"{frame.shape[1]} × {frame.shape[0]}",
        "missing in": f"{frame.missing_share:.1%}",
        "missing out": f"{float(np.mean(frame.missing & np.isnan(completion.depth))):.1%}",
        "blocks": str(len(blocks)),
        "with result": str(len(completion.results)),
        f"{RMS_NAME} [mm]": millimetres(errors.rms),
        "ground truth [mm]": "" if against is None else millimetres(against.whole.rmse),
        "hold-out [mm]": "" if hidden is None else millimetres(hidden.whole.rmse),
        "note": subject.note,
    }


def _blocks(run: Run) -> dict[int, tuple[int, float]]:
    """Label -> number of pixels, and share of them without measured depth."""
    labels = run.blocks.labels
    pixels = np.bincount(labels.ravel())
    known = np.bincount(labels[~run.frame.missing], minlength=pixels.size)
    there = (int(label) for label in np.flatnonzero(pixels) if label)
    return {label: (int(pixels[label]), 1 - known[label] / pixels[label]) for label in there}


def _evaluations(subject: Subject, hidden: RunEvaluation | None) -> dict[str, Evaluated]:
    """All evaluations of the frame by their names."""
    completion = subject.completion
    found = {GROUND_TRUTH: _against_ground_truth(subject, completion.filled_by_blocks)}
    if completion.extrapolated.any():
        whole = _against_ground_truth(subject, completion.filled)
        found[f"{GROUND_TRUTH}, including extrapolated pixels"] = whole
    there = {name: evaluated for name, evaluated in found.items() if evaluated is not None}
    if hidden is not None and (test := hidden.test) is not None:
        seeds = f"seed{'s' * (len(test.seeds) > 1)} {', '.join(map(str, test.seeds))}"
        there[f"On hold-out ({test.pattern}; {seeds})"] = hidden
    return there


def _against_ground_truth(subject: Subject, filled: NDArray[np.bool_]) -> Evaluated | None:
    """Evaluate some of the filled pixels against the frame's ground truth; None without it, or if no block was run.

    Parameters
    ----------
    subject : Subject
    filled : ndarray of bool, shape (H, W)
        The pixels to evaluate; the other missing ones count as not filled.
    """
    run, completion = subject.run, subject.completion
    ground_truth = run.frame.ground_truth
    if ground_truth is None or not completion.results:
        return None
    wanted = run.frame.missing & np.isfinite(ground_truth)
    depth = np.where(filled, completion.depth, np.float32(np.nan))
    errors = PixelErrors.at(wanted, depth, ground_truth, expected_error(completion))
    return Evaluated(run.blocks.labels, (errors,))
