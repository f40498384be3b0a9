"""`ilf report`: one HTML page about a frame, a recorded run, a project, or several of them."""

from __future__ import annotations

import argparse
import sys
from contextlib import ExitStack
from pathlib import Path

from ..judgement import HIDDEN_PATTERNS, HiddenTest
from ..judgement.step import run_out
from ..parameters import DEFAULT_PRESET, PRESETS, Parameters
from ..report import ReportOptions, report_steps, write_report
from ..run.options import as_file_name
from .parsing import (
    Commands,
    UsageError,
    add_block_parameters,
    add_distrusted,
    add_frame,
    add_guide,
    add_look_in,
    add_parameters,
    add_preset,
    add_progress,
    add_seeds,
    add_truth,
    seeds_of,
)
from .progress import ShareProgress
from .report import warn
from .report_sources import read_subjects, report_sources

_USAGE = """ilf report RGB DEPTH [options]
       ilf report (FOLDER | run.json | PROJECT.ilf)... [options]"""


def add_command(commands: Commands) -> None:
    """Add the command to the parser."""
    parser = commands.add_parser(
        "report",
        help="write one HTML page about frames: pictures, blocks, parameters, curves, errors, versions and hashes",
        usage=_USAGE,
        description="Write one HTML page that needs no other file and no network. A frame is completed first, a "
        "recorded run made again, and of a project all frames that have been worked on are taken as they are. Several "
        "of them make one page with an index. For PDF, print the page in a browser, or use File > Report… in the "
        "window.",
        allow_abbrev=False,
    )
    parser.set_defaults(command=run)
    add_frame(parser)
    add_distrusted(parser)
    add_guide(parser)
    add_truth(parser)
    add_look_in(parser)
    add_preset(parser)
    parser.add_argument(
        "--hidden",
        choices=tuple(HIDDEN_PATTERNS),
        help="also judge on known depth that is hidden, in this pattern; takes as long as the run, once per seed",
    )
    add_seeds(parser)
    output = parser.add_argument_group("output")
    output.add_argument("--out", metavar="FILE.html", help="the page (default: NAME-report.html here)")
    add_progress(output)
    add_parameters(parser, Parameters, "filter", presets=PRESETS, default=DEFAULT_PRESET)
    add_block_parameters(parser)


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out."""
    options, path = _test(arguments), _output(arguments)
    notes: list[str] = []
    shown = sys.stderr.isatty() if arguments.progress is None else arguments.progress
    with ExitStack() as opened:
        sources = report_sources(arguments, opened)
        progress = opened.enter_context(ShareProgress(shown=shown))
        subjects = read_subjects(sources, notes, progress.update)
        only = Path(arguments.inputs[0])
        title = only.stem if len(arguments.inputs) == 1 else "Report"
        made = ReportOptions(title, options)
        content = run_out(report_steps(subjects, made, len(sources)), progress.update)
    warn(notes)
    if path is None:
        path = Path(f"{as_file_name(content.title)}-report.html")
    write_report(path, content, made)
    print(f"Written to {path}, {path.stat().st_size / 1000:.0f} kB.")


def _test(arguments: argparse.Namespace) -> HiddenTest | None:
    if arguments.hidden is None:
        if arguments.seeds is not None:
            raise UsageError("--seeds is about hidden depth: add --hidden.")
        return None
    return HiddenTest(arguments.hidden, seeds_of(arguments))


def _output(arguments: argparse.Namespace) -> Path | None:
    """Where the page goes, if that is said."""
    if arguments.out is None:
        return None
    path = Path(arguments.out)
    if path.suffix.lower() not in (".html", ".htm"):
        raise UsageError(
            f"--out is an HTML page: {path.name} should end in .html. For PDF, print the page in a browser, or use "
            "File > Report… in the window."
        )
    return path
