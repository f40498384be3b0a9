"""`ilf bench`: compare presets and peers, or methods of making blocks, on any set of frames."""

from __future__ import annotations

import argparse
from functools import partial
from itertools import groupby
from operator import attrgetter

from .._runtime.formatting import counted
from ..errors import InputError
from ..lab.bench.blocks import (
    BLOCK_METHODS,
    BlockPlan,
    parse_block_methods,
    run_block_bench,
    summarise_blocks,
    write_block_csv,
    write_block_json,
)
from ..lab.bench.denoising import (
    DENOISE_METHODS,
    SCENES,
    DenoisePlan,
    DenoiseRow,
    parse_denoise_methods,
    run_denoise_bench,
)
from ..lab.bench.frames import find_frames, parse_names
from ..lab.bench.methods import GROUPS, parse_methods
from ..lab.bench.patterns import PATTERNS
from ..lab.bench.results import (
    BenchResult,
    Plan,
    Summary,
    records,
    summarise,
    write_bench_csv,
    write_content,
    write_json,
    write_table,
)
from ..lab.bench.runner import read_earlier_result, run_bench
from .output import Column, advance, comparison_table, skipped_lines, unit_bar, warn
from .usage import Parser, UsageError, add_progress, count, seed

# `ilf bench blocks`: compare methods of making operation blocks on any set of frames.

BLOCKS = "blocks"
"""The first positional argument that selects this benchmark."""

_BLOCK_COLUMNS = (
    Column("coverage", lambda line: line.coverage, ".2%", max),
    Column("of frame", lambda line: line.frame_coverage, ".2%", max),
    Column("recoverable", lambda line: line.recoverable, ".2%", max),
    Column("watertight", lambda line: line.watertight, ".1%", max),
    Column("purity", lambda line: line.purity, ".2%", max),
    Column("cut rate", lambda line: line.cut_rate, ".2%"),
    Column("recall", lambda line: line.recall, ".4f", max),
    Column("precision", lambda line: line.precision, ".4f", max),
    Column("F", lambda line: line.f, ".4f", max),
    Column("blocks", lambda line: line.blocks, ".1f", None),
    Column("seconds", lambda line: line.seconds, ".3f"),
)


def run_blocks(arguments: argparse.Namespace) -> None:
    """Run the command; the first of the folders is the mode's name."""
    folders = arguments.folders[1:]
    if not folders:
        raise UsageError(f"Give folders of frames after {BLOCKS!r}; for a folder of this name write ./{BLOCKS}.")
    if not {arguments.pattern, arguments.seed, arguments.peers_from} <= {None}:
        raise UsageError(f"With {BLOCKS!r}, no depth is held out: leave out --pattern, --seed and --peers-from.")
    plan = BlockPlan(
        folders=tuple(find_frames(folders)[: arguments.limit]),
        methods=tuple(parse_block_methods(arguments.methods)),
    )
    with unit_bar(arguments, len(plan.folders), "frames") as bar:
        result = run_block_bench(plan, jobs=arguments.jobs, on_progress=lambda name: advance(bar, name))
    warn(skipped_lines((item.frame, "", item.reason) for item in result.skipped))
    warn(
        f"{row.method} failed on {row.frame}, scored as no blocks. {row.failure}" for row in result.rows if row.failure
    )
    if not result.rows:
        raise InputError("No frame could be read, so there is nothing to compare. Check the folders.")
    lines = summarise_blocks(result)
    frames = lines[0].frames
    print(f"blocks: quality of operation blocks, without hold-out ({counted(frames, 'frame')})")
    print("\n".join(comparison_table(_BLOCK_COLUMNS, lines)))
    if arguments.csv is not None:
        write_block_csv(arguments.csv, result)
    if arguments.json is not None:
        write_block_json(arguments.json, result)


# `ilf bench denoise`: compare presets and denoising filters on generated scenes with known depth and noise.

DENOISE = "denoise"
"""The first positional argument that selects this benchmark."""

_DENOISE_COLUMNS = (
    Column("RMSE [mm]", lambda row: 1000 * row.rmse, ".3f"),
    Column("MAE [mm]", lambda row: 1000 * row.mae, ".3f"),
    Column("seconds", lambda row: row.seconds, ".3f", None),
)


def run_denoise(arguments: argparse.Namespace) -> None:
    """Run the command; the first of the folders is the mode's name."""
    if arguments.folders[1:]:
        raise UsageError(f"The scenes of {DENOISE!r} are generated: leave out folders of frames.")
    if not {arguments.pattern, arguments.limit, arguments.peers_from} <= {None}:
        raise UsageError(
            f"With {DENOISE!r}, all scenes are run unchanged: leave out --pattern, --limit and --peers-from."
        )
    plan = DenoisePlan(methods=tuple(parse_denoise_methods(arguments.methods)), seed=arguments.seed or 0)
    with unit_bar(arguments, len(SCENES), "scenes") as bar:
        rows = run_denoise_bench(plan, jobs=arguments.jobs, on_progress=lambda name: advance(bar, name))
    warn(
        f"{row.method} failed on {row.scene}, scored as the unfiltered depth. {row.failure}"
        for row in rows
        if row.failure
    )
    print("\n".join(_denoise_tables(rows)))
    if arguments.csv is not None:
        write_table(arguments.csv, DenoiseRow, rows)
    if arguments.json is not None:
        write_content(arguments.json, {"seed": plan.seed, "methods": list(plan.methods), "rows": records(rows)})


def _denoise_tables(rows: list[DenoiseRow]) -> list[str]:
    """Format a table for every part of a scene, sorted by RMSE."""
    lines: list[str] = []
    for (scene, part), members in groupby(rows, key=lambda row: (row.scene, row.part)):
        ordered = sorted(members, key=lambda row: row.rmse)
        title = f"{scene}: {part} ({counted(ordered[0].pixels, 'pixel')})"
        lines += ["", title, *comparison_table(_DENOISE_COLUMNS, ordered)]
    return lines[1:]


_PATTERNS_USED = "random,areas"

_MEANS = (
    Column("RMSE [mm]", lambda line: line.rmse_mm, ".2f"),
    Column("MAE [mm]", lambda line: line.mae_mm, ".2f"),
    Column("median [mm]", lambda line: line.median_mm, ".2f"),
    Column("Rel", lambda line: line.rel, ".4f"),
    Column("delta<1.25", lambda line: line.delta_1, ".2%", max),
    Column("coverage", lambda line: line.coverage, ".2%", max),
    Column("seconds", lambda line: line.seconds, ".3f"),
    Column("extraction [s]", lambda line: line.extraction_seconds, ".3f", None),
)


def _beside_peers(measure: str) -> tuple[Column, ...]:
    """Return the columns of a measure: the fields of a summary whose names begin with it."""

    def interval(percent: int, line: Summary) -> str | None:
        low, high = (getattr(line, f"{measure}_{side}_{percent}") for side in ("low", "high"))
        return None if low is None else f"{low:.2f}-{high:.2f}"

    return (
        Column(f"{measure.upper()} [mm]", attrgetter(f"{measure}_geometric_mm"), ".2f"),
        Column("/ peer", attrgetter(f"{measure}_ratio"), ".3f"),
        Column("68 %", partial(interval, 68), "", None),
        Column("95 %", partial(interval, 95), "", None),
        Column("wins", attrgetter(f"{measure}_wins"), "d", max),
    )


_EXPECTED = (
    Column("within", lambda line: line.within, ".2%", None),
    Column("within twice", lambda line: line.within_twice, ".2%", None),
    Column("calibrated frames", lambda line: line.calibrated, ".1%", None),
    Column("sparsification", lambda line: line.sparsification, ".4f"),
)
_MORE = (
    (
        "frame by frame: geometric means of the error, and of its ratio to the best peer on the same frame",
        _beside_peers("rmse") + _beside_peers("mae"),
    ),
    ("expected error", _EXPECTED),
)


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
    parser.add_argument(
        "--pattern",
        metavar="LIST",
        help=f"any of {','.join(PATTERNS)} (default: {_PATTERNS_USED})",
    )
    parser.add_argument(
        "--methods",
        default="all",
        metavar="LIST",
        help="any of all; " + "; ".join(f"{group} = {','.join(names)}" for group, names in GROUPS.items())
        + f"; with {BLOCKS!r} any of all,{','.join(BLOCK_METHODS)}; with {DENOISE!r} any "
        f"of all,presets,peers,{','.join(DENOISE_METHODS)} (default: all)",
    )  # fmt: skip
    parser.add_argument("--limit", type=count, metavar="N", help="use only the first N frames")
    parser.add_argument(
        "--seed", type=seed, metavar="N", help="random seed of the hold-out pixels, 0 or more (default: 0)"
    )
    parser.add_argument(
        "--jobs",
        type=count,
        default=1,
        metavar="N",
        help="number of processes; more than 1 distorts the times (default: 1)",
    )
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
    for mode, run_mode in ((BLOCKS, run_blocks), (DENOISE, run_denoise)):
        if arguments.folders[0] == mode:
            run_mode(arguments)
            return
    patterns = _PATTERNS_USED if arguments.pattern is None else arguments.pattern
    plan = Plan(
        folders=tuple(find_frames(arguments.folders)[: arguments.limit]),
        patterns=tuple(parse_names(patterns, PATTERNS, what="pattern")),
        methods=tuple(parse_methods(arguments.methods)),
        seed=arguments.seed or 0,
    )
    earlier = None if arguments.peers_from is None else read_earlier_result(arguments.peers_from, plan.methods)
    with unit_bar(arguments, len(plan.folders) * len(plan.patterns), "frames and patterns") as bar:
        result = run_bench(plan, jobs=arguments.jobs, earlier=earlier, on_progress=lambda name: advance(bar, name))
    warn(skipped_lines((item.frame, item.pattern, item.reason) for item in result.skipped))
    warn(
        f"{row.method} failed on {row.frame}, pattern {row.pattern}, scored as nothing filled. {row.failure}"
        for row in result.rows
        if row.failure
    )
    if not result.rows:
        raise InputError("No frame could be scored, so there is nothing to compare. Check the folders.")
    print("\n".join(_tables(result)))
    if arguments.csv is not None:
        write_bench_csv(arguments.csv, result)
    if arguments.json is not None:
        write_json(arguments.json, result)


def _tables(result: BenchResult) -> list[str]:
    """Format three tables per pattern, sorted by mean RMSE."""
    lines: list[str] = []
    summaries = summarise(result)
    for pattern in result.plan.patterns:
        of_pattern = [summary for summary in summaries if summary.pattern == pattern]
        if not of_pattern:
            continue
        frames = of_pattern[0].frames
        title = f"{pattern}: {PATTERNS[pattern]} ({counted(frames, 'frame')}, seed {result.plan.seed})"
        for heading, columns in ((title, _MEANS), *((f"{pattern}, {what}", columns) for what, columns in _MORE)):
            lines += ["", heading, *comparison_table(columns, of_pattern)]
    return lines[1:]
