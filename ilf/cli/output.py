"""Output of the commands: warnings, tables, the progress bar, JSON; and of a run, its blocks and errors."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from operator import attrgetter
from typing import Any

import numpy as np
from tqdm import tqdm

from .._runtime.formatting import counted, covered, grouped
from .._runtime.schema import plain
from ..completion.completion import guide_text
from ..completion.confidence.expected_error import expected_error
from ..data.declarations import Value
from ..data.frame import RGBDFrame
from ..data.parameters import Parameters, nearest_preset
from ..data.results import BlockOutcome, Completion, Status, blocks_by_message
from ..errors import one_line, without_credentials
from ..evaluation.evaluation import Evaluation, evaluate_blocks, evaluate_completion
from ..run.run import EXTRAPOLATED, Run


def print_json(document: object) -> None:
    """Print one JSON document on stdout; numbers that are not finite become null."""
    print(json.dumps(plain(document), indent=2, allow_nan=False))


def warn(notes: Iterable[str]) -> None:
    """Print warnings on stderr, one line each and without repetition."""
    for note in dict.fromkeys(notes):
        print("ilf: warning:", one_line(without_credentials(note)), file=sys.stderr)


@dataclass(frozen=True)
class Column:
    """A column of a table: heading, value of an item (None or NaN for a dash), its format, and the function that
    selects the best of several values, which are marked by * (None: no best value)."""

    heading: str
    value: Callable[[Any], Any]
    form: str = ""
    best: Callable[[Sequence[float]], float] | None = None


def table(columns: Sequence[Column], items: Sequence[Any]) -> list[str]:
    """Format the lines of a table; text is left-aligned, numbers are right-aligned."""
    cells = [_cells(column, items) for column in columns]
    lefts = [any(cell[:1].isalpha() for cell in column[1:]) for column in cells]
    padded = [
        [cell.ljust(width) if left else cell.rjust(width) for cell in column]
        for column, left, width in zip(cells, lefts, (max(map(len, column)) for column in cells), strict=True)
    ]
    return ["  ".join(row).rstrip() for row in zip(*padded, strict=True)]


def _cells(column: Column, items: Sequence[Any]) -> list[str]:
    """The heading and the texts of a column; where the best is marked, with room for the mark."""
    values = [column.value(item) for item in items]
    known = [value is not None and value == value for value in values]
    texts = [format(value, column.form) if there else "-" for value, there in zip(values, known, strict=True)]
    if column.best is None:
        return [column.heading, *texts]
    numbers = [value for value, there in zip(values, known, strict=True) if there]
    # values that are printed equally are equally good
    best = format(column.best(numbers), column.form) if numbers else None
    return [f"{column.heading} ", *(f"{text}{'*' if text == best else ' '}" for text in texts)]


_NAMES_WIDTH = 13
"""Minimum width of the names of facts [characters]."""


def fact_lines(facts: Sequence[tuple[str, str]]) -> list[str]:
    """Format facts, each a name and a text, one below the other."""
    width = max([_NAMES_WIDTH, *(len(name) + 1 for name, _ in facts)])
    return [f"{name + ':':{width}} {text}" for name, text in facts]


def shows_progress(arguments: argparse.Namespace) -> bool:
    """Whether a command shows its progress: as --progress says, or on a terminal, but not with --quiet."""
    if getattr(arguments, "quiet", False):
        return False
    return bool(sys.stderr.isatty() if arguments.progress is None else arguments.progress)


class Bar(tqdm):
    """A progress bar on stderr, without the monitor thread of tqdm; a context manager.

    Parameters
    ----------
    total : float
        What there is to do; with the default it is shown in per cent.
    unit : str
        What is counted.
    shown : bool
        Whether to show the bar.
    done : float
        What was done before.
    """

    # otherwise the first bar starts a thread that keeps running
    monitor_interval = 0

    def __init__(self, total: float = 1.0, unit: str = "", *, shown: bool, done: float = 0) -> None:
        count = f"{{n_fmt}}/{{total_fmt}} {unit}" if unit else "{percentage:3.0f} %"
        super().__init__(
            total=total,
            initial=done,
            disable=not shown,
            mininterval=0.1,
            miniters=0,
            leave=False,
            dynamic_ncols=True,
            bar_format=f"{count} |{{bar:30}}| {{elapsed}}, {{remaining}} left{{postfix}}",
        )

    def show(self, done: float, text: str) -> None:
        """Show what has been done so far, and a text."""
        self.set_postfix_str(text, refresh=False)
        self.update(max(min(done, self.total) - self.n, 0))

    def advance(self, text: str) -> None:
        """Count one more, and show a text at once."""
        self.n += 1
        self.set_postfix_str(text)


# Of a run: its progress, then its blocks and errors, as text and as JSON.


def completed(run: Run, *, shown: bool) -> Completion:
    """Complete a run, with a progress bar of its blocks and the last iteration of one, if it is to be shown."""
    done, text = 0, ""
    with run.steps() as steps, Bar(len(steps.blocks), "blocks", shown=shown) as bar:
        for step in steps:
            if step.record is not None:
                what = "extrapolation" if step.label == EXTRAPOLATED else f"block {step.label}"
                sigma = f"sigma {step.record.sigma_i * 1000:.3g} mm"
                text = f"{what}: iteration {step.record.i}, stage {step.record.stage}, {sigma}"
            elif step.result is not None:
                done += 1
            bar.show(done, text)
    return steps.completion()


Errors = tuple[Evaluation | None, Mapping[int, Evaluation]]
"""Errors of a completion against ground truth, and those of its blocks by label; None and nothing without any."""


def errors_of(completion: Completion) -> Errors:
    """Evaluate a completion against its frame's ground truth, if any."""
    frame = completion.frame
    if frame.ground_truth is None:
        return None, {}
    whole = evaluate_completion(frame, completion, expected=expected_error(completion))
    return whole, evaluate_blocks(frame, completion, completion.run.blocks.labels)


def completion_report(completion: Completion, errors: Errors, record: Mapping[str, Any]) -> str:
    """Describe a result and its files as text, with its `completion_record`."""
    frame, labels, (whole, by_block) = completion.frame, completion.run.blocks.labels, errors
    covering = covered(len(completion.outcomes), np.count_nonzero(labels) / labels.size)
    filled_outside = 0 if frame.outside_view is None else np.count_nonzero(frame.outside_view & completion.filled)
    lines = [f"{frame.name}: {covering}.", _recovered_line(record, int(filled_outside))]
    if completion.suspect:
        lines.append(
            f"{counted(completion.suspect, 'pixel')} of known depth suspect: small islands far off everything near by, "
            "left out of the fill. They keep their depth; if it is wrong, mark it as invalid (--invalid-mask)."
        )
    if frame.guide is not None:
        lines.append(f"Guide: {guide_text(frame)}.")
    if whole is not None:
        lines += [_evaluation_line(whole), *unscored_lines(frame)]
    lines.append(f"Written to {record['folder']}: {', '.join(record['files'])}")
    lines += [f"Exported to {path}" for path in record["exports"]]
    return "\n".join([*lines, "", *outcome_lines(completion.outcomes.values(), by_block)])


def _recovered_line(record: Mapping[str, Any], filled_outside: int) -> str:
    """Describe how much depth was missing and recovered, by the JSON record of a run."""
    missing, recovered, outside = record["missing_before"], record["recovered"], ""
    effort = f"{counted(record['iterations'], 'iteration')} in {record['seconds']:.1f} s."
    if record["outside_view"]:
        filled = f"{grouped(filled_outside)} of them filled without any measurement there"
        left = filled if filled_outside else "left missing"
        outside = f"{counted(record['outside_view'], 'pixel')} outside the depth camera's view, {left}. "
    if missing == 0:
        return f"No pixel was missing. {outside}{effort}"
    counts = {"measured by neighbours": record["from_neighbours"], "by hand": record["by_hand"]}
    of_them = "".join(f", {grouped(count)} of them {what}" for what, count in counts.items() if count)
    share = f"{recovered / missing:.1%}"
    return (
        f"{grouped(recovered)} of {counted(missing, 'missing pixel')} recovered ({share}){of_them}. {outside}{effort}"
    )


def completion_record(completion: Completion, errors: Errors, seconds: float, **written: Any) -> dict[str, Any]:
    """Describe a result that took so long for JSON, with entries on what was written; lengths in metres."""
    run, frame, (whole, by_block) = completion.run, completion.frame, errors
    outcomes = completion.outcomes.values()
    outside = 0 if frame.outside_view is None else np.count_nonzero(frame.outside_view)
    return {
        "frame": frame.name,
        "width": frame.shape[1],
        "height": frame.shape[0],
        "preset": nearest_preset(run.parameters).preset,
        "parameters": run.parameters.to_dict(),
        "missing_before": int(np.count_nonzero(frame.missing)),
        "missing_after": int(np.count_nonzero(frame.missing & ~completion.filled)),
        "recovered": int(np.count_nonzero(frame.missing & completion.filled)),
        "from_neighbours": int(np.count_nonzero(completion.from_neighbours)),
        "by_hand": int(np.count_nonzero(completion.by_hand)),
        "outside_view": int(outside),
        "suspect": completion.suspect,
        "blocks": [outcome_record(outcome, by_block.get(outcome.label)) for outcome in outcomes],
        "iterations": sum(outcome.iterations for outcome in outcomes),
        "seconds": seconds,
        "errors": errors_record(whole),
        **written,
    }


def outcome_record(outcome: BlockOutcome, errors: Evaluation | None = None) -> dict[str, Any]:
    """Describe a block that was run, for JSON."""
    record = asdict(outcome)
    sigma_i = record.pop("sigma_i")
    return {**record, "missing_share": outcome.defect_rate, "sigma_i_m": sigma_i, "errors": errors_record(errors)}


def errors_record(errors: Evaluation | None) -> dict[str, Any] | None:
    """Describe errors for JSON; None if there are none."""
    if errors is None:
        return None
    return {
        "pixels": errors.pixels,
        "rmse_m": errors.rmse,
        "mae_m": errors.mae,
        "median_m": errors.median,
        "bias_m": errors.bias,
        "within_expected_error": errors.within,
    }


def parameters_text(parameters: Parameters) -> str:
    """Describe parameters by the nearest preset and what differs from it."""
    nearest = nearest_preset(parameters)
    return f"preset {nearest.preset}" + (f" with {values_text(nearest.differs)}" if nearest.differs else "")


def values_text(values: Mapping[str, Value]) -> str:
    """List names and values."""
    return ", ".join(f"{name} {value}" for name, value in values.items())


_OUTCOMES = (
    Column("block", attrgetter("label")),
    Column("pixels", attrgetter("pixels")),
    Column("missing", attrgetter("defect_rate"), ".1%"),
    Column("recovered", attrgetter("recovered")),
    Column("status", attrgetter("status.value")),
    Column("iterations", attrgetter("iterations")),
    Column("stages", attrgetter("stages")),
    Column("sigma [mm]", lambda outcome: 1000 * outcome.sigma_i, ".3g"),
)


def outcome_lines(outcomes: Iterable[BlockOutcome], errors: Mapping[int, Evaluation] | None = None) -> list[str]:
    """Format a table of the blocks that were run, with their errors if known, followed by remarks on single blocks."""
    outcomes, columns = list(outcomes), list(_OUTCOMES)
    if errors:
        rmse = {label: 1000 * one.rmse for label, one in errors.items()}
        columns.append(Column("RMSE [mm]", lambda outcome: rmse.get(outcome.label), ".2f"))
    messages = blocks_by_message(outcome for outcome in outcomes if outcome.status is not Status.NOTHING_MISSING)
    remarks = [f"{_blocks_text(labels)}: {message}" for message, labels in messages.items()]
    return [*table(columns, outcomes), *([""] if remarks else []), *remarks]


def _blocks_text(labels: Sequence[int]) -> str:
    if len(labels) == 1:
        return f"Block {labels[0]}"
    return f"{counted(len(labels), 'block')} ({', '.join(map(str, labels))})"


def _evaluation_line(evaluation: Evaluation) -> str:
    """Describe the errors of the filled depth against ground truth."""
    if not evaluation.pixels:
        return "Against ground truth: no filled pixel has ground truth."
    within = "" if evaluation.within is None else f"; {evaluation.within:.0%} within the expected error"
    return (
        f"Against ground truth, over {counted(evaluation.pixels, 'filled pixel')}: median error "
        f"{1000 * evaluation.median:.2f} mm, MAE {1000 * evaluation.mae:.2f} mm, RMSE {1000 * evaluation.rmse:.2f} mm"
        f"{within}."
    )


def unscored(frame: RGBDFrame) -> int:
    """Number of missing pixels for which there is no ground truth either."""
    return int(
        np.count_nonzero(frame.missing if frame.ground_truth is None else frame.missing & np.isnan(frame.ground_truth))
    )


def unscored_lines(frame: RGBDFrame) -> list[str]:
    """Describe the missing pixels that no error is computed for, as a line; none if there are none."""
    count, missing = unscored(frame), int(np.count_nonzero(frame.missing))
    if not count:
        return []
    share = f"{grouped(count)} of {counted(missing, 'missing pixel')} ({count / missing:.1%})"
    return [f"Not scored: {share} have no ground truth."]
