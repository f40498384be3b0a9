"""`ilf evaluate`: compute the errors of presets or of parameter values against ground truth or on hold-out."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass, fields, replace
from itertools import groupby
from typing import Any

from .._runtime.formatting import counted
from ..data.declarations import Value
from ..data.frame import RGBDFrame
from ..data.parameters import DEFAULT_PRESET, PRESETS, BlockParameters, Parameters
from ..errors import ParameterError
from ..evaluation.evaluation import Evaluation, Progress, RunEvaluation, run_to_end
from ..evaluation.ground_truth import ground_truth_steps
from ..evaluation.hold_out import HOLD_OUT_PATTERNS, HoldOutTest, compared_steps, hold_out_steps, untrusted_note
from ..evaluation.sweep import Sweep, sweep_steps
from ..io.tables import write_csv
from ..run.block_choice import BlockChoice
from ..run.run import Run
from .options import add_given_blocks, check_given_blocks
from .output import Column, ShareProgress, comparison_table, print_json, shows_progress, table, warn
from .parsing import (
    add_block_parameters,
    add_borders,
    add_companions,
    add_frame,
    add_invalid_mask,
    add_parameters,
    add_preset,
    add_seeds,
    frame_from,
    preset_from,
    seeds_from,
    value_from,
    with_given,
)
from .run_output import dominant_block, errors_record, unscored, unscored_lines
from .usage import Parser, UsageError, add_json, add_progress


@dataclass(frozen=True)
class Line:
    """The errors of one preset or value, on a frame (block None) or one of its blocks.

    Attributes
    ----------
    method : str
        The preset or the value.
    block : int or None
    pixels : int
        Number of compared pixels.
    rmse_m, mae_m, median_m, bias_m : float or None
        Errors [m]; None if no pixel was compared.
    within, coverage, seconds : float or None
        Share within the expected error; filled share and duration, for the whole frame only.
    """

    method: str
    block: int | None
    pixels: int
    rmse_m: float | None
    mae_m: float | None
    median_m: float | None
    bias_m: float | None
    within: float | None
    coverage: float | None = None
    seconds: float | None = None


_COLUMNS = (
    Column("RMSE [mm]", lambda line: _mm(line.rmse_m), ".2f"),
    Column("MAE [mm]", lambda line: _mm(line.mae_m), ".2f"),
    Column("median [mm]", lambda line: _mm(line.median_m), ".2f"),
    Column("bias [mm]", lambda line: _mm(line.bias_m), "+.2f", None),
    Column("within", lambda line: line.within, ".1%", None),
    Column("coverage", lambda line: line.coverage, ".1%", max),
    Column("seconds", lambda line: line.seconds, ".2f"),
)


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = "ilf evaluate (RGB DEPTH | FOLDER) [options]"
    parser.description = (
        "Complete a frame with one or more presets, or with values of a parameter, and compute the errors against "
        "ground truth where depth is missing, or against known depth that was held out. Errors are computed over the "
        "pixels that all of them fill."
    )
    parser.epilog = (
        "Hold-out patterns: " + "; ".join(f"{name}: {what}" for name, what in HOLD_OUT_PATTERNS.items()) + ". "
        "The JSON document contains frame, against (ground truth or hold-out), unscored (missing pixels without ground "
        "truth; null on hold-out), pattern, seeds and results. results: "
        "name, parameters, errors, coverage (share), seconds, blocks (label, errors). errors: pixels, rmse_m, mae_m, "
        "median_m, bias_m, within_expected_error (share). Unknown numbers are null."
    )
    parser.set_defaults(command=run)
    add_frame(parser)
    add_invalid_mask(parser)
    add_companions(parser)
    add_preset(parser, action="append")
    add_given_blocks(parser, "--blocks")
    add_borders(parser)
    parser.add_argument(
        "--hold-out",
        choices=tuple(HOLD_OUT_PATTERNS),
        help="evaluate on hold-out depth of this pattern (default: areas, if the frame has no ground truth)",
    )
    add_seeds(parser)
    parser.add_argument(
        "--sweep",
        action="append",
        metavar="NAME=V,V,...",
        help="compare values of a filter parameter; a second --sweep gives a grid",
    )
    output = parser.add_argument_group("output")
    output.add_argument("--by-block", action="store_true", help="also print the RMSE of every block")
    output.add_argument("--csv", metavar="FILE", help="write all errors as CSV, including those of every block")
    add_json(output)
    add_progress(output)
    add_parameters(parser, Parameters, "filter", presets=PRESETS, default=DEFAULT_PRESET)
    add_block_parameters(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    presets = [preset_from(name) for name in dict.fromkeys(arguments.preset or [DEFAULT_PRESET])]
    swept = dict(_parse_sweep(text) for text in arguments.sweep or ())
    if swept and len(presets) > 1:
        raise UsageError("--sweep varies one --preset: leave out the others.")
    if arguments.hold_out is not None and arguments.ground_truth is not None:
        raise UsageError("--hold-out and --ground-truth exclude each other: leave out one of them.")
    parameters = [with_given(preset.parameters, arguments) for preset in presets]
    extractions = [check_given_blocks(arguments, "--blocks", preset.extraction) for preset in presets]
    frame = frame_from(arguments)
    test = _hold_out(arguments, frame)
    runs, notes = _runs(arguments, frame, parameters, extractions)
    results: Sequence[RunEvaluation]
    with ShareProgress(shown=shows_progress(arguments)) as progress:
        if swept:
            found = run_to_end(
                sweep_steps(Sweep(runs[0], swept, test)),
                lambda item: progress.show(item) if isinstance(item, Progress) else None,
            )
            results, names = found.points, [_point_text(point.values) for point in found.points]
        else:
            several = [ground_truth_steps(run) if test is None else hold_out_steps(run, test) for run in runs]
            results, names = run_to_end(compared_steps(several), progress.show), [preset.name for preset in presets]
    warn([*notes, *([] if test is None else filter(None, [untrusted_note(frame)]))])
    if arguments.json:
        print_json(_record(frame, test, names, results))
    else:
        print("\n".join(_report(frame, test, names, results, arguments.by_block, "values" if swept else "preset")))
    if arguments.csv is not None:
        lines = _lines(names, results)
        write_csv(arguments.csv, [[field.name for field in fields(Line)], *map(astuple, lines)])


def _hold_out(arguments: argparse.Namespace, frame: RGBDFrame) -> HoldOutTest | None:
    """Return the hold-out; None to evaluate against ground truth."""
    if arguments.hold_out is None and frame.ground_truth is not None:
        if arguments.seeds is not None:
            raise UsageError("--seeds has no effect, because the frame has ground truth: add --hold-out.")
        return None
    return HoldOutTest(arguments.hold_out or "areas", seeds_from(arguments))


def _runs(
    arguments: argparse.Namespace,
    frame: RGBDFrame,
    parameters: Sequence[Parameters],
    extractions: Sequence[BlockParameters],
) -> tuple[list[Run], list[str]]:
    """Make a run per parameter set, and notes. Runs with equal extraction share their blocks."""
    made = {
        extraction: Run(
            frame, BlockChoice(extraction, arguments.blocks, arguments.fill_gaps, arguments.borders).blocks_of(frame)
        )
        for extraction in dict.fromkeys(extractions)
    }
    runs = [replace(made[extraction], parameters=own) for own, extraction in zip(parameters, extractions, strict=True)]
    return runs, [note for run in made.values() for note in run.blocks.notes]


def _parse_sweep(text: str) -> tuple[str, list[Value]]:
    """Parse name and values of a parameter from NAME=V,V,..."""
    name, equals, values = text.partition("=")
    name = name.strip().lstrip("-").replace("-", "_")
    known = Parameters.declarations()
    if not equals or not values.strip(","):
        raise UsageError(f"--sweep needs a parameter and its values, such as smoothness=0.3,1,3, not {text!r:.60}.")
    try:
        if name not in known:
            Parameters().replace(**{name: None})
        return name, [value_from(known[name], value.strip()) for value in values.split(",") if value.strip()]
    except ParameterError as error:
        raise UsageError(f"--sweep {text:.60}: {error}") from error


def _point_text(values: Mapping[str, Value]) -> str:
    """Format the values of a point with the parameter names of the command line."""
    declared = Parameters.declarations()
    return ", ".join(f"{name} {declared[name].to_text(value)}" for name, value in values.items())


def _report(
    frame: RGBDFrame,
    test: HoldOutTest | None,
    names: Sequence[str],
    results: Sequence[RunEvaluation],
    by_block: bool,
    heading: str,
) -> list[str]:
    pixels = max(result.whole.pixels for result in results)
    if test is None:
        lines = [f"{frame.name}, against ground truth, over {counted(pixels, 'missing pixel')}:"]
    else:
        seeds = counted(len(test.seeds), "hold-out")
        lines = [f"{frame.name}, {seeds} ({HOLD_OUT_PATTERNS[test.pattern]}), over {counted(pixels, 'pixel')}:"]
    whole = [line for line in _lines(names, results) if line.block is None]
    lines += comparison_table(_COLUMNS, names, whole, heading)
    if not pixels:
        lines.append("No pixel is filled by all of them.")
    else:
        name, best = min(zip(names, results, strict=True), key=lambda item: item[1].whole.rmse)
        if largest := dominant_block(best.whole, best.blocks):
            lines.append(f"{name}: block {largest[0]} has {largest[1]:.0%} of the squared error.")
    if test is None:
        lines += unscored_lines(frame)
    if by_block:
        for _, group in groupby(zip(names, results, strict=True), lambda item: item[1].run.blocks.labels.tobytes()):
            lines += ["", *_block_table(*zip(*group, strict=True))]
    return lines


def _record(
    frame: RGBDFrame, test: HoldOutTest | None, names: Sequence[str], results: Sequence[RunEvaluation]
) -> dict[str, Any]:
    """Describe the evaluation for JSON."""
    return {
        "frame": frame.name,
        "against": "ground truth" if test is None else "hold-out",
        "unscored": None if test is not None else unscored(frame),
        "pattern": None if test is None else test.pattern,
        "seeds": [] if test is None else test.seeds,
        "results": [
            {
                "name": name,
                "parameters": result.run.parameters.to_dict(),
                "errors": errors_record(result.whole),
                "coverage": result.coverage,
                "seconds": result.seconds,
                "blocks": [{"label": label, "errors": errors_record(one)} for label, one in result.blocks.items()],
            }
            for name, result in zip(names, results, strict=True)
        ],
    }


def _block_table(names: Sequence[str], results: Sequence[RunEvaluation]) -> list[str]:
    """Format a table of the RMSE of every block, for runs with the same blocks."""
    rows = []
    for label in sorted({label for result in results for label in result.blocks}):
        found = [result.blocks.get(label, Evaluation()) for result in results]
        rmse = ["-" if math.isnan(evaluation.rmse) else f"{1000 * evaluation.rmse:.2f}" for evaluation in found]
        rows.append((str(label), str(max(evaluation.pixels for evaluation in found)), *rmse))
    return table(("block", "pixels", *(f"RMSE [mm], {name}" for name in names)), rows)


def _lines(names: Sequence[str], results: Sequence[RunEvaluation]) -> list[Line]:
    lines = []
    for name, result in zip(names, results, strict=True):
        lines.append(_line(name, None, result.whole, result.coverage, result.seconds))
        lines += [_line(name, label, evaluation) for label, evaluation in result.blocks.items()]
    return lines


def _line(
    name: str,
    block: int | None,
    evaluation: Evaluation,
    coverage: float | None = None,
    seconds: float | None = None,
) -> Line:
    rmse, mae, median, bias = (
        None if math.isnan(measure) else measure
        for measure in (evaluation.rmse, evaluation.mae, evaluation.median, evaluation.bias)
    )
    return Line(name, block, evaluation.pixels, rmse, mae, median, bias, evaluation.within, coverage, seconds)


def _mm(metres: float | None) -> float | None:
    return None if metres is None else 1000 * metres
