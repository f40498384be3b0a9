"""`ilf bench denoise`: presets and filters against noise compared on generated scenes of known depth and noise."""

from __future__ import annotations

import argparse
from itertools import groupby

from ..bench.denoise_runner import DenoisePlan, DenoiseRow, choose_denoise_methods, run_denoise_bench
from ..bench.denoise_scenes import SCENES
from ..bench.result_files import records, write_content, write_table
from .comparison import Column, advance, comparison_table, unit_bar
from .parsing import UsageError
from .report import warn

MODE = "denoise"
"""The first positional argument that asks for this bench."""

_COLUMNS = (
    Column("RMSE [mm]", lambda row: 1000 * row.rmse, ".3f"),
    Column("MAE [mm]", lambda row: 1000 * row.mae, ".3f"),
    Column("seconds", lambda row: row.seconds, ".3f", None),
)


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out; the first of the folders is the mode's name."""
    if arguments.folders[1:]:
        raise UsageError(f"The scenes of {MODE!r} are generated: leave out folders of frames.")
    if not {arguments.pattern, arguments.limit, arguments.peers_from} <= {None}:
        raise UsageError(
            f"With {MODE!r}, leave out --pattern, --limit and --peers-from: all scenes are run as they are."
        )
    plan = DenoisePlan(methods=tuple(choose_denoise_methods(arguments.methods)), seed=arguments.seed or 0)
    with unit_bar(arguments, len(SCENES), "scenes") as bar:
        rows = run_denoise_bench(plan, jobs=arguments.jobs, on_progress=lambda name: advance(bar, name))
    warn(f"{row.method} failed on {row.scene}, which counts as given. {row.failure}" for row in rows if row.failure)
    print("\n".join(_tables(rows)))
    if arguments.csv is not None:
        write_table(arguments.csv, DenoiseRow, rows)
    if arguments.json is not None:
        write_content(arguments.json, {"seed": plan.seed, "methods": list(plan.methods), "rows": records(rows)})


def _tables(rows: list[DenoiseRow]) -> list[str]:
    """A table for every part of a scene, the lowest RMSE first."""
    lines: list[str] = []
    for (scene, part), members in groupby(rows, key=lambda row: (row.scene, row.part)):
        ordered = sorted(members, key=lambda row: row.rmse)
        lines += ["", f"{scene}: {part} ({ordered[0].pixels} pixels)", *comparison_table(_COLUMNS, ordered)]
    return lines[1:]
