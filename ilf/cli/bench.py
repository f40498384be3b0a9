"""`ilf bench`: compare presets and peers, or methods of making blocks, on any set of frames."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from dataclasses import astuple
from functools import partial
from itertools import groupby
from operator import itemgetter
from typing import Any, NamedTuple

from .._runtime.formatting import counted
from ..errors import InputError
from ..evaluation.bench.blocks import BLOCK_METHODS, run_block_bench, summarise_blocks
from ..evaluation.bench.denoising import DENOISE_GROUPS, SCENES, run_denoise_bench
from ..evaluation.bench.frames import find_frames, parse_names
from ..evaluation.bench.methods import GROUPS, METHODS
from ..evaluation.bench.patterns import PATTERNS
from ..evaluation.bench.results import Line, Skipped, content, summarise, write_content
from ..evaluation.bench.runner import read_earlier_result, run_bench
from ..io.tables import write_csv
from .output import Column, advance, comparison_table, skipped_lines, unit_bar, warn
from .usage import Parser, UsageError, add_progress, count, seed

BLOCKS, DENOISE = "blocks", "denoise"
"""The first positional argument that selects another benchmark than that of completion."""

_PATTERNS_USED = "random,areas"


Table = tuple[str, Sequence[Column], Sequence[Line]]
"""Title, columns and lines of a table to print."""


class Output(NamedTuple):
    """What a benchmark has found: tables to print, lines for CSV, content for JSON."""

    tables: list[Table]
    lines: list[Line]
    content: dict[str, Any]


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = (
        f"ilf bench FOLDER... [options]\n       ilf bench {BLOCKS} FOLDER... [options]\n"
        f"       ilf bench {DENOISE} [options]"
    )
    parser.description = (
        "Hold out known depth of frames, complete it with every method, and compute the errors: over all frames, and "
        "frame by frame relative to the best peer (method other than a preset) on that frame. Hold-out pixels that a "
        f"method leaves missing are scored with their nearest known depth. With {BLOCKS!r} first: measure the "
        f"operation blocks of several methods; nothing is held out. With {DENOISE!r}: compare the remaining noise of "
        "presets in mode fill+denoise and of other filters on generated scenes."
    )
    parser.epilog = "Patterns: " + "; ".join(f"{name}: {what}" for name, what in PATTERNS.items()) + "."
    parser.set_defaults(command=run)
    parser.add_argument(
        "folders",
        nargs="+",
        metavar="FOLDER",
        help="folder with rgb.*, depth.* and meta.json, or folder of such folders; "
        f"write ./{BLOCKS} for a folder named {BLOCKS}",
    )
    parser.add_argument("--pattern", metavar="LIST", help=f"any of {','.join(PATTERNS)} (default: {_PATTERNS_USED})")
    parser.add_argument(
        "--methods",
        default="all",
        metavar="LIST",
        help="any of all; " + "; ".join(f"{group} = {','.join(names)}" for group, names in GROUPS.items())
        + f"; with {BLOCKS!r} any of all,{','.join(BLOCK_METHODS)}; with {DENOISE!r} any "
        f"of all,presets,peers,{','.join(DENOISE_GROUPS['all'])} (default: all)",
    )  # fmt: skip
    parser.add_argument("--limit", type=count, metavar="N", help="use only the first N frames")
    parser.add_argument(
        "--seed", type=seed, metavar="N", help="random seed of the hold-out pixels, 0 or more (default: 0)"
    )
    jobs = "number of processes; more than 1 distorts the times (default: 1)"
    parser.add_argument("--jobs", type=count, default=1, metavar="N", help=jobs)
    parser.add_argument(
        "--peers-from",
        metavar="RESULT.json",
        help="reuse the results of peers that need no blocks from an earlier --json of the same frames, patterns and "
        "seed; an error if their inputs differ",
    )
    parser.add_argument("--csv", metavar="FILE", help="write the table as CSV")
    parser.add_argument(
        "--json", metavar="FILE", help="write the table, all rows per frame, and the parameters as JSON"
    )
    add_progress(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    other: dict[str, Callable[[argparse.Namespace], Output]] = {BLOCKS: _blocks, DENOISE: _denoise}
    found = other.get(arguments.folders[0], _completion)(arguments)
    for number, (title, columns, lines) in enumerate(found.tables):
        names = [line["method"] for line in lines]
        print("\n" * bool(number) + "\n".join([title, *comparison_table(columns, names, lines)]))
    if arguments.csv is not None:
        write_csv(arguments.csv, [list(found.lines[0]), *(line.values() for line in found.lines)])
    if arguments.json is not None:
        write_content(arguments.json, found.content)


_MEANS = (
    Column("RMSE [mm]", itemgetter("rmse_mm"), ".2f"),
    Column("MAE [mm]", itemgetter("mae_mm"), ".2f"),
    Column("median [mm]", itemgetter("median_mm"), ".2f"),
    Column("Rel", itemgetter("rel"), ".4f"),
    Column("delta<1.25", itemgetter("delta_1"), ".2%", max),
    Column("coverage", itemgetter("coverage"), ".2%", max),
    Column("seconds", itemgetter("seconds"), ".3f"),
    Column("extraction [s]", itemgetter("extraction_seconds"), ".3f", None),
)


def _beside_peers(measure: str) -> tuple[Column, ...]:
    """Return the columns of a measure: the values of a line whose names begin with it."""

    def interval(percent: int, line: Line) -> str | None:
        low, high = (line[f"{measure}_{side}_{percent}"] for side in ("low", "high"))
        return None if low is None else f"{low:.2f}-{high:.2f}"

    return (
        Column(f"{measure.upper()} [mm]", itemgetter(f"{measure}_geometric_mm"), ".2f"),
        Column("/ peer", itemgetter(f"{measure}_ratio"), ".3f"),
        Column("68 %", partial(interval, 68), "", None),
        Column("95 %", partial(interval, 95), "", None),
        Column("wins", itemgetter(f"{measure}_wins"), "d", max),
    )


_EXPECTED = (
    Column("within", itemgetter("within"), ".2%", None),
    Column("within twice", itemgetter("within_twice"), ".2%", None),
    Column("calibrated frames", itemgetter("calibrated"), ".1%", None),
    Column("sparsification", itemgetter("sparsification"), ".4f"),
)


def _completion(arguments: argparse.Namespace) -> Output:
    folders = find_frames(arguments.folders)[: arguments.limit]
    given = _PATTERNS_USED if arguments.pattern is None else arguments.pattern
    patterns = parse_names(given, PATTERNS, what="pattern")
    methods = parse_names(arguments.methods, METHODS, {"all": tuple(METHODS), **GROUPS})
    seed = arguments.seed or 0
    earlier = None if arguments.peers_from is None else read_earlier_result(arguments.peers_from, methods)
    with unit_bar(arguments, len(folders) * len(patterns), "frames and patterns") as bar:
        result = run_bench(
            folders, patterns, methods, seed, jobs=arguments.jobs, earlier=earlier, on_progress=partial(advance, bar)
        )
    _warn_of_skipped(result.skipped)
    _warn_of_failures(map(vars, result.rows), "{frame}, pattern {pattern}", "nothing filled")
    if not result.rows:
        raise InputError("No frame could be scored, so there is nothing to compare. Check the folders.")
    lines = summarise(result)
    tables: list[Table] = []
    for pattern, members in groupby(lines, itemgetter("pattern")):
        own = list(members)
        title = f"{pattern}: {PATTERNS[pattern]} ({counted(own[0]['frames'], 'frame')}, seed {seed})"
        beside = "frame by frame: geometric means of the error, and of its ratio to the best peer on the same frame"
        tables += [
            (title, _MEANS, own),
            (f"{pattern}, {beside}", _beside_peers("rmse") + _beside_peers("mae"), own),
            (f"{pattern}, expected error", _EXPECTED, own),
        ]
    return Output(tables, lines, content(result, patterns, methods, seed))


_BLOCK_COLUMNS = (
    Column("coverage", itemgetter("coverage"), ".2%", max),
    Column("of frame", itemgetter("frame_coverage"), ".2%", max),
    Column("recoverable", itemgetter("recoverable"), ".2%", max),
    Column("watertight", itemgetter("watertight"), ".1%", max),
    Column("purity", itemgetter("purity"), ".2%", max),
    Column("cut rate", itemgetter("cut_rate"), ".2%"),
    Column("recall", itemgetter("recall"), ".4f", max),
    Column("precision", itemgetter("precision"), ".4f", max),
    Column("F", itemgetter("f"), ".4f", max),
    Column("blocks", itemgetter("blocks"), ".1f", None),
    Column("seconds", itemgetter("seconds"), ".3f"),
)


def _blocks(arguments: argparse.Namespace) -> Output:
    if not arguments.folders[1:]:
        raise UsageError(f"Give folders of frames after {BLOCKS!r}; for a folder of this name write ./{BLOCKS}.")
    if not {arguments.pattern, arguments.seed, arguments.peers_from} <= {None}:
        raise UsageError(f"With {BLOCKS!r}, no depth is held out: leave out --pattern, --seed and --peers-from.")
    folders = find_frames(arguments.folders[1:])[: arguments.limit]
    methods = parse_names(arguments.methods, BLOCK_METHODS, {"all": tuple(BLOCK_METHODS)})
    with unit_bar(arguments, len(folders), "frames") as bar:
        rows, skipped = run_block_bench(folders, methods, jobs=arguments.jobs, on_progress=partial(advance, bar))
    _warn_of_skipped(skipped)
    _warn_of_failures(rows, "{frame}", "no blocks")
    if not rows:
        raise InputError("No frame could be read, so there is nothing to compare. Check the folders.")
    lines = summarise_blocks(rows)
    title = f"blocks: quality of operation blocks, without hold-out ({counted(lines[0]['frames'], 'frame')})"
    found = {
        "frames": list(dict.fromkeys(row["frame"] for row in rows)),
        "methods": {name: BLOCK_METHODS[name].settings for name in methods},
        "table": lines,
        "rows": rows,
        "skipped": [{"frame": item.frame, "reason": item.reason} for item in skipped],
    }
    return Output([(title, _BLOCK_COLUMNS, lines)], lines, found)


_DENOISE_COLUMNS = (
    Column("RMSE [mm]", lambda row: 1000 * row["rmse"], ".3f"),
    Column("MAE [mm]", lambda row: 1000 * row["mae"], ".3f"),
    Column("seconds", itemgetter("seconds"), ".3f", None),
)


def _denoise(arguments: argparse.Namespace) -> Output:
    if arguments.folders[1:]:
        raise UsageError(f"The scenes of {DENOISE!r} are generated: leave out folders of frames.")
    if not {arguments.pattern, arguments.limit, arguments.peers_from} <= {None}:
        raise UsageError(
            f"With {DENOISE!r}, all scenes are run unchanged: leave out --pattern, --limit and --peers-from."
        )
    methods, seed = parse_names(arguments.methods, DENOISE_GROUPS["all"], DENOISE_GROUPS), arguments.seed or 0
    with unit_bar(arguments, len(SCENES), "scenes") as bar:
        rows = run_denoise_bench(methods, seed, jobs=arguments.jobs, on_progress=partial(advance, bar))
    _warn_of_failures(rows, "{scene}", "the unfiltered depth")
    tables: list[Table] = []
    for (scene, part), members in groupby(rows, itemgetter("scene", "part")):
        ordered = sorted(members, key=itemgetter("rmse"))
        tables.append((f"{scene}: {part} ({counted(ordered[0]['pixels'], 'pixel')})", _DENOISE_COLUMNS, ordered))
    return Output(tables, rows, {"seed": seed, "methods": methods, "rows": rows})


def _warn_of_skipped(skipped: Iterable[Skipped]) -> None:
    warn(skipped_lines(map(astuple, skipped)))


def _warn_of_failures(rows: Iterable[Line], where: str, scored_as: str) -> None:
    warn(
        f"{row['method']} failed on {where.format_map(row)}, scored as {scored_as}. {row['failure']}"
        for row in rows
        if row["failure"]
    )
