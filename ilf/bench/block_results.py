"""The block bench's results: summed up, and written as CSV and JSON."""

from __future__ import annotations

import os
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .block_methods import BLOCK_METHODS
from .block_runner import BlockBenchResult, BlockRow
from .result_files import records, write_content, write_table


@dataclass(frozen=True)
class BlockSummary:
    """One method over all frames: the median of the seconds, and means of all else over the frames that have a value.

    `watertight` is the share of the frames without a leak; `failures` counts the frames that the method failed on,
    which count as no blocks at all.
    """

    method: str
    frames: int
    failures: int
    coverage: float
    frame_coverage: float
    recoverable: float | None
    watertight: float
    purity: float | None
    cut_rate: float | None
    recall: float | None
    precision: float | None
    f: float | None
    blocks: float
    seconds: float


def summarise_blocks(result: BlockBenchResult) -> list[BlockSummary]:
    """One line per method, the highest boundary F first."""
    by_method = [[row for row in result.rows if row.method == method] for method in result.plan.methods]
    lines = [_summary(rows) for rows in by_method if rows]
    return sorted(lines, key=lambda line: -1.0 if line.f is None else line.f, reverse=True)


def write_block_csv(path: str | os.PathLike[str], result: BlockBenchResult) -> None:
    """Write the table, atomically; raises ExportError if that fails."""
    write_table(path, BlockSummary, summarise_blocks(result))


def write_block_json(path: str | os.PathLike[str], result: BlockBenchResult) -> None:
    """Write the table, the row of every frame, and the methods' settings; raises ExportError if that fails."""
    content = {
        "frames": list(dict.fromkeys(row.frame for row in result.rows)),
        "methods": {name: dict(BLOCK_METHODS[name].settings) for name in result.plan.methods},
        "table": records(summarise_blocks(result)),
        "rows": records(result.rows),
        "skipped": records(result.skipped),
    }
    write_content(path, content)


def _summary(rows: Sequence[BlockRow]) -> BlockSummary:
    def mean(value: Callable[[BlockRow], float | None]) -> float | None:
        values = [found for found in map(value, rows) if found is not None]
        return statistics.fmean(values) if values else None

    return BlockSummary(
        method=rows[0].method,
        frames=len(rows),
        failures=sum(bool(row.failure) for row in rows),
        coverage=statistics.fmean(row.coverage for row in rows),
        frame_coverage=statistics.fmean(row.frame_coverage for row in rows),
        recoverable=mean(lambda row: row.recoverable),
        watertight=statistics.fmean(row.leaks == 0 for row in rows),
        purity=mean(lambda row: row.purity),
        cut_rate=mean(lambda row: row.cut_rate),
        recall=mean(lambda row: row.recall),
        precision=mean(lambda row: row.precision),
        f=mean(lambda row: row.f),
        blocks=statistics.fmean(row.blocks for row in rows),
        seconds=statistics.median(row.seconds for row in rows),
    )
