"""`ilf bench`: presets and peers compared on any set of frames."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..bench import PATTERNS, BenchResult, Plan, Summary, choose_methods, find_frames, run_bench, summarise
from ..bench.methods import GROUPS
from ..bench.results import write_csv, write_json
from ..errors import InputError, ParameterError
from .parsing import Commands
from .progress import Bar
from .report import table

_PATTERNS_USED = "random,areas"
_NAMES_LISTED = 6


@dataclass(frozen=True)
class _Column:
    """A column of the table: heading, value, how it is written, and what is best of several (None: nothing is)."""

    heading: str
    value: Callable[[Summary], float | None]
    form: str
    best: Callable[[Sequence[float]], float] | None = min


_COLUMNS = (
    _Column("RMSE [mm]", lambda line: line.rmse_mm, ".2f"),
    _Column("MAE [mm]", lambda line: line.mae_mm, ".2f"),
    _Column("median [mm]", lambda line: line.median_mm, ".2f"),
    _Column("Rel", lambda line: line.rel, ".4f"),
    _Column("delta<1.25", lambda line: line.delta_1, ".2%", max),
    _Column("coverage", lambda line: line.coverage, ".2%", max),
    _Column("within", lambda line: line.within, ".2%", None),
    _Column("seconds", lambda line: line.seconds, ".3f"),
    _Column("extraction [s]", lambda line: line.extraction_seconds, ".3f", None),
)


def add_command(commands: Commands) -> None:
    """Add the command to the parser."""
    parser = commands.add_parser(
        "bench",
        help="compare presets and other methods on frames with depth hidden",
        usage="ilf bench FOLDER... [options]",
        description="Hide known depth of frames, let every method complete it, and compare with what was hidden. "
        "Hidden pixels that a method leaves open count with their nearest known depth.",
        epilog="Patterns: " + "; ".join(f"{name}: {what}" for name, what in PATTERNS.items()) + ".",
        allow_abbrev=False,
    )
    parser.set_defaults(command=run)
    parser.add_argument(
        "folders",
        nargs="+",
        metavar="FOLDER",
        help="a folder with rgb.*, depth.* and meta.json, or one of such folders",
    )
    parser.add_argument(
        "--pattern",
        default=_PATTERNS_USED,
        metavar="LIST",
        help=f"any of {','.join(PATTERNS)} (default: {_PATTERNS_USED})",
    )
    parser.add_argument(
        "--methods",
        default="all",
        metavar="LIST",
        help="any of all; " + "; ".join(f"{group} = {','.join(names)}" for group, names in GROUPS.items())
        + " (default: all)",
    )  # fmt: skip
    parser.add_argument("--limit", type=_count, metavar="N", help="take the first N frames only")
    parser.add_argument(
        "--seed", type=_seed, default=0, metavar="N", help="what the hidden pixels follow from, 0 or more"
    )
    parser.add_argument(
        "--jobs",
        type=_count,
        default=1,
        metavar="N",
        help="frames at the same time; more than 1 spoils the seconds (default: 1)",
    )
    parser.add_argument("--csv", metavar="FILE", help="write the table")
    parser.add_argument("--json", metavar="FILE", help="write the table, the row of every frame, and the parameters")
    parser.add_argument(
        "--progress",
        action=argparse.BooleanOptionalAction,
        help="progress bar on stderr (default: if that is a terminal)",
    )


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out."""
    plan = Plan(
        folders=tuple(find_frames(arguments.folders)[: arguments.limit]),
        patterns=_chosen_patterns(arguments.pattern),
        methods=tuple(choose_methods(arguments.methods)),
        seed=arguments.seed,
    )
    shown = sys.stderr.isatty() if arguments.progress is None else arguments.progress
    bar = Bar(
        total=len(plan.folders) * len(plan.patterns),
        disable=not shown,
        mininterval=0,
        leave=False,
        dynamic_ncols=True,
        bar_format="{n_fmt}/{total_fmt} frames and patterns |{bar:30}| {elapsed}{postfix}",
    )
    with bar:

        def advance(name: str) -> None:
            bar.set_postfix_str(name, refresh=False)
            bar.update(1)

        result = run_bench(plan, jobs=arguments.jobs, on_progress=advance)
    for warning in _warnings(result):
        print("ilf: warning:", " ".join(warning.split()), file=sys.stderr)
    if not result.rows:
        raise InputError("No frame could be scored, so there is nothing to compare.")
    print("\n".join(_tables(result)))
    if arguments.csv is not None:
        write_csv(arguments.csv, result)
    if arguments.json is not None:
        write_json(arguments.json, result)


def _tables(result: BenchResult) -> list[str]:
    """Lines of one table per pattern, the lowest RMSE first; * marks the best of a column."""
    lines: list[str] = []
    summaries = summarise(result)
    for pattern in result.plan.patterns:
        of_pattern = [summary for summary in summaries if summary.pattern == pattern]
        if not of_pattern:
            continue
        if lines:
            lines.append("")
        frames = of_pattern[0].frames
        lines.append(f"{pattern}: {PATTERNS[pattern]} ({frames} frame{'s' * (frames != 1)}, seed {result.plan.seed})")
        columns = [_cells(column, of_pattern) for column in _COLUMNS]
        rows = [(summary.method, *cells) for summary, *cells in zip(of_pattern, *columns, strict=True)]
        lines += table(("method", *(f"{column.heading} " for column in _COLUMNS)), rows)
    return lines


def _cells(column: _Column, summaries: Sequence[Summary]) -> list[str]:
    values = [column.value(summary) for summary in summaries]
    texts = ["-" if value is None else format(value, column.form) for value in values]
    numbers = [value for value in values if value is not None]
    if column.best is None or not numbers:
        return [f"{text} " for text in texts]
    # what looks equal is equally good
    best = format(column.best(numbers), column.form)
    return [f"{text}{'*' if text == best else ' '}" for text in texts]


def _warnings(result: BenchResult) -> list[str]:
    """What was left out, one line per reason, and where methods failed."""
    by_reason: dict[tuple[str, str], list[str]] = {}
    for item in result.skipped:
        by_reason.setdefault((item.pattern, item.reason), []).append(item.frame)
    skipped = [
        f"skipped{f' for pattern {pattern}' if pattern else ''}: {_listed(frames)}. {reason}"
        for (pattern, reason), frames in by_reason.items()
    ]
    failed = [
        f"{row.method} failed on {row.frame}, pattern {row.pattern}, which counts as nothing filled. {row.failure}"
        for row in result.rows
        if row.failure
    ]
    return skipped + failed


def _listed(names: Sequence[str]) -> str:
    more = len(names) - _NAMES_LISTED
    return ", ".join(names[:_NAMES_LISTED]) + (f" and {more} more" if more > 0 else "")


def _chosen_patterns(names: str) -> tuple[str, ...]:
    chosen = tuple(dict.fromkeys(filter(None, (name.strip() for name in names.split(",")))))
    unknown = [name for name in chosen if name not in PATTERNS]
    if unknown or not chosen:
        what = f"There is no pattern {unknown[0]!r}" if unknown else "No pattern is named"
        raise ParameterError(f"{what}. Known: {', '.join(PATTERNS)}.")
    return chosen


def _count(text: str) -> int:
    return _whole_number(text, 1)


def _seed(text: str) -> int:
    return _whole_number(text, 0)


def _whole_number(text: str, least: int) -> int:
    if not text.isdecimal() or int(text) < least:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {least} on")
    return int(text)
