"""`ilf bench blocks`: ways to make operation blocks compared on any set of frames."""

from __future__ import annotations

import argparse

from ..bench import find_frames
from ..bench.block_methods import choose_block_methods
from ..bench.block_results import summarise_blocks, write_block_csv, write_block_json
from ..bench.block_runner import BlockPlan, run_block_bench
from ..errors import InputError
from .comparison import Column, advance, comparison_table, skipped_lines, unit_bar
from .parsing import UsageError
from .report import warn

MODE = "blocks"
"""The first positional argument that asks for this bench."""

_COLUMNS = (
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


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out; the first of the folders is the mode's name."""
    folders = arguments.folders[1:]
    if not folders:
        raise UsageError(f"Give folders of frames after {MODE!r}; for a folder of this name write ./{MODE}.")
    if not {arguments.pattern, arguments.seed, arguments.peers_from} <= {None}:
        raise UsageError("No depth is hidden to measure blocks: leave out --pattern, --seed and --peers-from.")
    plan = BlockPlan(
        folders=tuple(find_frames(folders)[: arguments.limit]),
        methods=tuple(choose_block_methods(arguments.methods)),
    )
    with unit_bar(arguments, len(plan.folders), "frames") as bar:
        result = run_block_bench(plan, jobs=arguments.jobs, on_progress=lambda name: advance(bar, name))
    warn(skipped_lines((item.frame, "", item.reason) for item in result.skipped))
    warn(
        f"{row.method} failed on {row.frame}, which counts as no blocks. {row.failure}"
        for row in result.rows
        if row.failure
    )
    if not result.rows:
        raise InputError("No frame could be read, so there is nothing to compare.")
    lines = summarise_blocks(result)
    frames = lines[0].frames
    print(f"blocks: quality of operation blocks, nothing hidden ({frames} frame{'s' * (frames != 1)})")
    print("\n".join(comparison_table(_COLUMNS, lines)))
    if arguments.csv is not None:
        write_block_csv(arguments.csv, result)
    if arguments.json is not None:
        write_block_json(arguments.json, result)
