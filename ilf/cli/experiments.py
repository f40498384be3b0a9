"""`ilf experiments`: repeat the paper's experiments and report the results."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._runtime.files import ensure_folder
from .._runtime.formatting import counted
from .output import Bar, unit_bar, warn
from .usage import Parser, add_progress, count, seed

if TYPE_CHECKING:
    from ..lab.experiments.experiment import Progress

_OUT = "experiments"
"""Default output folder."""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Repeat the paper's experiments with fixed seeds, and report the results next to those of the paper."
    )
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)
    listing = actions.add_parser("list", help="list the experiments")
    listing.set_defaults(command=_list)
    _add_run(actions)
    reporting = actions.add_parser(
        "report",
        help="write one HTML page of all results in a folder",
        description="Write report.html, a self-contained page, from the results in a folder.",
    )
    _add_out(reporting)
    reporting.add_argument(
        "--markdown",
        metavar="FILE",
        help="also write Markdown, with its figures in images/experiments beside it, without figures of your own "
        "frames",
    )
    reporting.set_defaults(command=_report)


def _add_run(actions: Any) -> None:
    parser = actions.add_parser(
        "run",
        help="run one experiment, or all",
        description="Run experiments. Each writes NAME.json, NAME.csv and its figures as PNG and SVG when it has "
        "finished; after Ctrl+C the results of finished experiments are complete.",
    )
    parser.add_argument("names", metavar="NAME", help="names from `ilf experiments list`, separated by commas, or all")
    _add_out(parser)
    parser.add_argument(
        "--data",
        type=Path,
        metavar="PATH",
        help="folder of frames for the experiments real and table, as for `ilf bench`, or nyu_depth_v2_labeled.mat "
        "(default: the bundled sample)",
    )
    parser.add_argument(
        "--split",
        type=Path,
        metavar="FILE",
        help="which frames of nyu_depth_v2_labeled.mat: splits.mat (its test frames), or a text file with one number "
        "from 1 per line (default: splits.mat beside it, or else all frames)",
    )
    parser.add_argument("--limit", type=count, metavar="N", help="use only the first N frames of the data")
    parser.add_argument(
        "--quick",
        action="store_true",
        help="quick check with fewer points, smaller grids and few frames; its figures are not comparable",
    )
    parser.add_argument(
        "--seed", type=seed, default=0, metavar="N", help="random seed of noise and hold-out pixels (default: 0)"
    )
    parser.add_argument(
        "--jobs",
        type=count,
        default=1,
        metavar="N",
        help="number of processes; more than 1 distorts the times (default: 1)",
    )
    add_progress(parser)
    parser.set_defaults(command=_run)


def _add_out(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--out", default=_OUT, metavar="DIR", help=f"output folder (default: {_OUT})")


def _list(arguments: argparse.Namespace) -> None:
    from ..lab.experiments.registry import EXPERIMENTS

    width = max(map(len, EXPERIMENTS))
    for name, experiment in EXPERIMENTS.items():
        print(f"{name:{width}}  {experiment.title} ({experiment.source})")


def _run(arguments: argparse.Namespace) -> None:
    from ..lab.experiments.experiment import Settings
    from ..lab.experiments.files import write_result
    from ..lab.experiments.registry import EXPERIMENTS, run_experiment, selected_experiments
    from ..lab.experiments.sources import find_sources

    names = selected_experiments(arguments.names)
    settings = Settings(
        data=arguments.data,
        split=arguments.split,
        limit=arguments.limit,
        quick=arguments.quick,
        seed=arguments.seed,
        jobs=arguments.jobs,
    )
    if any(EXPERIMENTS[name].needs_frames for name in names):
        find_sources(settings)  # reports problems of the data before anything is run or written
    folder = ensure_folder(arguments.out)
    for name in names:
        with unit_bar(arguments, 0, name) as bar:
            result = run_experiment(name, settings, partial(_advance, bar))
        files = write_result(result, EXPERIMENTS[name], folder)
        print(f"{name}: {counted(len(result.rows), 'row')} in {result.seconds:.0f} s, {files[0]}", flush=True)
        if EXPERIMENTS[name].needs_frames:
            warn(f"{name}: {note}" for note in result.notes)
    print(f"To report them: ilf experiments report --out {folder}")


def _report(arguments: argparse.Namespace) -> None:
    from ..lab.experiments.report import write_report

    for path in write_report(arguments.out, markdown_file=arguments.markdown):
        print(f"Written: {path}")


def _advance(bar: Bar, progress: Progress) -> None:
    bar.total = progress.total
    bar.update(progress.done - bar.n)
