"""`ilf evaluate`: compute the errors of presets or of parameter values against ground truth or on hold-out."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import groupby
from typing import Any

from .._runtime.formatting import counted
from .._runtime.long_work import run_to_end
from .._runtime.schema import plain
from ..data.declarations import Value
from ..data.frame import RGBDFrame
from ..data.parameters import DEFAULT_PRESET, Parameters
from ..errors import ParameterError, told_as
from ..evaluation import hold_out
from ..evaluation.evaluation import Evaluation, Progress
from ..evaluation.ground_truth import ground_truth_steps
from ..evaluation.sweep import Sweep, sweep_steps
from ..io.tables import write_csv
from ..run.run import BlockChoice, Run
from . import parsing
from .output import Bar, Column, errors_record, print_json, shows_progress, table, unscored, unscored_lines, warn
from .usage import Parser, UsageError, declare

_Named = tuple[str, hold_out.RunEvaluation]
"""The errors of a preset or value, and its name."""


_COLUMNS = (
    Column("RMSE [mm]", lambda item: 1000 * item[1].whole.rmse, ".2f", min),
    Column("MAE [mm]", lambda item: 1000 * item[1].whole.mae, ".2f", min),
    Column("median [mm]", lambda item: 1000 * item[1].whole.median, ".2f", min),
    Column("bias [mm]", lambda item: 1000 * item[1].whole.bias, "+.2f"),
    Column("within", lambda item: item[1].whole.within, ".1%"),
    Column("coverage", lambda item: item[1].coverage, ".1%", max),
    Column("seconds", lambda item: item[1].seconds, ".2f", min),
)


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = "ilf evaluate (RGB DEPTH | FOLDER) [options]"
    parser.description = (
        "Complete a frame with one or more presets, or with values of a parameter, and compute the errors against "
        "ground truth where depth is missing, or against known depth that was held out (areas, if there is no ground "
        "truth). Errors are computed over the pixels that all of them fill."
    )
    parsing.add_frame(parser)
    parsing.add_shared(parser, "--invalid-mask")
    blocks = parser.add_argument_group("blocks")
    parsing.add_given_blocks(blocks, "--blocks")
    parsing.add_shared(blocks, "--drawn")
    compared = parser.add_argument_group("evaluation")
    parsing.add_shared(compared, "--hold-out", "--seeds")
    sweep = "compare values of a filter parameter; a second --sweep gives a grid"
    declare(compared, f"--sweep NAME=V,V,... ...  {sweep}")
    output = parser.add_argument_group("output")
    declared = """
        --by-block  also print the RMSE of every block
        --csv FILE  write all errors as CSV, including those of every block
    """
    declare(output, declared)
    parsing.add_shared(output, "--json", "--progress")
    parsing.add_settings(parser, several_presets=True)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    presets = [parsing.preset_from(name) for name in dict.fromkeys(arguments.preset or [DEFAULT_PRESET])]
    swept = dict(_parse_sweep(text) for text in arguments.sweep)
    if swept and len(presets) > 1:
        raise UsageError("--sweep varies one --preset: leave out the others.")
    if arguments.hold_out is not None and arguments.ground_truth is not None:
        raise UsageError("--hold-out and --ground-truth exclude each other: leave out one of them.")
    settings = [parsing.settings_from(arguments, preset) for preset in presets]
    frame = parsing.frame_from(arguments)
    if arguments.hold_out is None and frame.ground_truth is None:
        arguments.hold_out = "areas"
    test = parsing.hold_out_from(arguments)
    runs, notes = _runs(frame, settings)
    results: Sequence[hold_out.RunEvaluation]
    with Bar(shown=shows_progress(arguments)) as bar:

        def show(step: object) -> None:
            if isinstance(step, Progress):
                bar.show(step.share, step.text)

        if swept:
            results = found = run_to_end(sweep_steps(Sweep(runs[0], swept, test)), show).points
            declared = Parameters.declarations()
            tried = [{name: declared[name].to_text(value) for name, value in point.values.items()} for point in found]
            names = [", ".join(map(" ".join, values.items())) for values in tried]
        else:
            several = [ground_truth_steps(run) if test is None else hold_out.hold_out_steps(run, test) for run in runs]
            results, names = run_to_end(hold_out.compared_steps(several), show), [preset.name for preset in presets]
    named = list(zip(names, results, strict=True))
    warn([*notes, *([] if test is None else filter(None, [hold_out.untrusted_note(frame)]))])
    if arguments.json:
        print_json(_record(frame, test, named))
    else:
        print("\n".join(_report(frame, test, named, "values" if swept else "preset")))
        if arguments.by_block:
            for _, group in groupby(named, lambda item: item[1].run.blocks.labels.tobytes()):
                print("", *_block_table(list(group)), sep="\n")
    if arguments.csv is not None:
        lines = list(_lines(named))
        write_csv(arguments.csv, [list(lines[0]), *(line.values() for line in lines)])


def _runs(frame: RGBDFrame, settings: Sequence[tuple[Parameters, BlockChoice]]) -> tuple[list[Run], list[str]]:
    """Make a run per parameter set, and notes on blocks and networks. Runs with equal extraction share their blocks."""
    made = {choice: choice.run_of(frame) for choice in dict.fromkeys(choice for _, choice in settings)}
    runs = [replace(made[choice], parameters=parameters) for parameters, choice in settings]
    missing = (note for one in settings for note in parsing.missing_networks(*one))
    return runs, [*missing, *(note for run in made.values() for note in run.blocks.notes)]


def _parse_sweep(text: str) -> tuple[str, list[Value]]:
    """Parse name and values of a parameter from NAME=V,V,..."""
    name, equals, values = text.partition("=")
    name = name.strip().lstrip("-").replace("-", "_")
    known = Parameters.declarations()
    if not equals or not values.strip(","):
        raise UsageError(f"--sweep needs a parameter and its values, such as smoothness=0.3,1,3, not {text!r:.60}.")
    with told_as(UsageError, f"--sweep {text:.60}: {{error}}", ParameterError):
        if name not in known:
            Parameters().replace(**{name: None})
        return name, [parsing.value_from(known[name], value.strip()) for value in values.split(",") if value.strip()]


def _report(frame: RGBDFrame, test: hold_out.HoldOutTest | None, named: Sequence[_Named], heading: str) -> list[str]:
    pixels = max(result.whole.pixels for _, result in named)
    if test is None:
        title = f"{frame.name}, against ground truth, over {counted(pixels, 'missing pixel')}:"
    else:
        seeds = counted(len(test.seeds), "hold-out")
        title = f"{frame.name}, {seeds} ({hold_out.HOLD_OUT_PATTERNS[test.pattern]}), over {counted(pixels, 'pixel')}:"
    lines = [title, *table([Column(heading, lambda item: item[0]), *_COLUMNS], named)]
    if not pixels:
        lines.append("No pixel is filled by all of them.")
    return lines if test is not None else lines + unscored_lines(frame)


def _block_table(named: Sequence[_Named]) -> list[str]:
    """Format a table of the RMSE of every block, for runs with the same blocks."""
    labels = sorted({label for _, result in named for label in result.blocks})
    errors = {label: [result.blocks.get(label, Evaluation()) for _, result in named] for label in labels}
    columns = [
        Column("block", int),
        Column("pixels", lambda label: max(one.pixels for one in errors[label])),
    ]
    for number, (name, _) in enumerate(named):
        rmse = {label: 1000 * of_label[number].rmse for label, of_label in errors.items()}
        columns.append(Column(f"RMSE [mm], {name}", rmse.get, ".2f"))
    return table(columns, labels)


def _record(frame: RGBDFrame, test: hold_out.HoldOutTest | None, named: Sequence[_Named]) -> dict[str, Any]:
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
            for name, result in named
        ],
    }


def _lines(named: Sequence[_Named]) -> Iterator[dict[str, Any]]:
    """Yield the errors of every preset or value over the frame, then over each block, for CSV."""
    for name, result in named:
        whole = {"coverage": result.coverage, "seconds": result.seconds}
        yield {"method": name, "block": None, **plain(errors_record(result.whole)), **whole}
        for label, one in result.blocks.items():
            yield {"method": name, "block": label, **plain(errors_record(one)), **dict.fromkeys(whole)}
