"""What is shown of a run: a bar while it runs, then its blocks and errors, as text and as JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from .._runtime.formatting import counted, covered
from ..completion.confidence.expected_error import expected_error, unvouched
from ..completion.edge_aware.fitted_guide import fit_guide
from ..data.frame import RGBDFrame
from ..data.results import BlockOutcome, Completion, Progress, Status, blocks_by_message
from ..evaluation.evaluation import Judgement, judge_blocks, judge_completion
from ..run.run import GUESS, Run, RunSteps
from .output import ProgressBar, table


class RunProgress(ProgressBar):
    """A bar on stderr: blocks done, and the last iteration of a block that runs.

    Parameters
    ----------
    run : RunSteps
    shown : bool
        Whether there is a bar at all.
    """

    def __init__(self, run: RunSteps, *, shown: bool) -> None:
        super().__init__(len(run.blocks), "{n_fmt}/{total_fmt} blocks", shown)

    def update(self, step: Progress) -> None:
        """Show a step of the run."""
        record = step.record
        if record is None:
            self.bar.update(step.result is not None)
            return
        what = "guessing the rest" if step.label == GUESS else f"block {step.label}"
        self.bar.set_postfix_str(
            f"{what}: iteration {record.i}, stage {record.stage}, sigma {record.sigma_i * 1000:.3g} mm",
            refresh=False,
        )
        self.bar.update(0)


_MOST = 0.5
"""The larger part of a whole, from this share on."""


def completion_report(
    run: Run,
    completion: Completion,
    seconds: float,
    folder: Path,
    files: Sequence[Path],
) -> str:
    """What came out of a run, and where it lies."""
    outcomes, frame = completion.outcomes.values(), run.frame
    judged: list[str] = []
    guide = fit_guide(frame)
    errors: dict[int, Judgement] = {}
    if frame.truth is not None:
        expected = expected_error(frame, completion)
        whole = judge_completion(frame, completion, expected=expected)
        errors = judge_blocks(frame, completion, run.blocks)
        judged = [_judgement_line(whole), *_source_of_error(run, completion, largest_share(whole, errors))]
    return "\n".join([
        *outcome_lines(outcomes, errors),
        "",
        f"{frame.name}: {covered(len(outcomes), np.count_nonzero(run.blocks) / run.blocks.size)}.",
        _recovered_line(frame, completion, seconds),
        *([] if guide is None else [f"Guide: {guide.in_words()}."]),
        *judged,
        f"Written to {folder}: {', '.join(file.name for file in files)}",
    ])  # fmt: skip


def outcome_lines(outcomes: Iterable[BlockOutcome], errors: Mapping[int, Judgement] | None = None) -> list[str]:
    """Table of the blocks that were run, with their errors if any are known, and below it what there is to say about
    single ones."""
    outcomes = list(outcomes)
    rows = [
        [
            str(outcome.label),
            str(outcome.pixels),
            f"{outcome.defect_rate:.1%}",
            str(outcome.recovered),
            outcome.status.value,
            str(outcome.iterations),
            str(outcome.stages),
            "-" if math.isnan(outcome.sigma_i) else f"{outcome.sigma_i * 1000:.3g}",
        ]
        for outcome in outcomes
    ]
    head = ["block", "pixels", "missing", "recovered", "status", "iterations", "stages", "sigma [mm]"]
    if errors:
        head.append("RMSE [mm]")
        for row, outcome in zip(rows, outcomes, strict=True):
            row.append(f"{1000 * errors[outcome.label].rmse:.2f}" if outcome.label in errors else "-")
    told = blocks_by_message(outcome for outcome in outcomes if outcome.status is not Status.NOTHING_MISSING)
    remarks = [f"{_blocks_text(labels)}: {message}" for message, labels in told.items()]
    return [*table(head, rows), *([""] if remarks else []), *remarks]


def _blocks_text(labels: Sequence[int]) -> str:
    if len(labels) == 1:
        return f"Block {labels[0]}"
    return f"{counted(len(labels), 'block')} ({', '.join(map(str, labels))})"


def largest_share(whole: Judgement, blocks: Mapping[int, Judgement]) -> tuple[int, float] | None:
    """The block that has at least half of the squared error of the whole in less than half of its pixels, and its
    share of the error, 0-1; None if no block has."""
    for label, one in blocks.items():
        if 0 < one.pixels < _MOST * whole.pixels and one.rmse > 0:
            share = one.pixels * one.rmse**2 / (whole.pixels * whole.rmse**2)
            if share >= _MOST:
                return label, share
    return None


def _judgement_line(judgement: Judgement) -> str:
    """How far the filled depth is from the truth, in words."""
    if not judgement.pixels:
        return "Against the truth: it is not known where depth was filled."
    within = "" if judgement.within is None else f"; {judgement.within:.0%} within the expected error"
    return (
        f"Against the truth, over {judgement.pixels} filled pixels: median error {1000 * judgement.median:.2f} mm, "
        f"MAE {1000 * judgement.mae:.2f} mm, RMSE {1000 * judgement.rmse:.2f} mm{within}."
    )


def _source_of_error(run: Run, completion: Completion, largest: tuple[int, float] | None) -> list[str]:
    """Where most of the error comes from, as a line; none if it comes from all over the frame."""
    if largest is None:
        return []
    label, share = largest
    doubtful = unvouched(run.frame, completion)[completion.filled & (run.blocks == label)].mean()
    why = f"; nothing measured vouches for {doubtful:.0%} of its filled pixels" if doubtful >= _MOST else ""
    return [f"Block {label} has {share:.0%} of the squared error{why}."]


def _recovered_line(frame: RGBDFrame, completion: Completion, seconds: float) -> str:
    missing = int(np.count_nonzero(frame.missing))
    iterations = sum(outcome.iterations for outcome in completion.outcomes.values())
    effort = f"{iterations} iterations in {seconds:.1f} s."
    outside = _outside_sentence(frame, completion)
    if missing == 0:
        return f"No pixel was missing. {outside}{effort}"
    recovered = int(np.count_nonzero(completion.filled & frame.missing))
    return f"{recovered} of {missing} missing pixels recovered ({recovered / missing:.1%}). {outside}{effort}"


def _outside_sentence(frame: RGBDFrame, completion: Completion) -> str:
    if frame.outside_view is None:
        return ""
    pixels, filled = (
        int(np.count_nonzero(mask)) for mask in (frame.outside_view, frame.outside_view & completion.filled)
    )
    left = "left missing" if not filled else f"{filled} of them filled, though nothing could be measured there"
    return f"{pixels} pixels outside the depth camera's view, {left}. "
