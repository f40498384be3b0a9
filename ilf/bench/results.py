"""The bench's results: summed up, and written as CSV and JSON."""

from __future__ import annotations

import os
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..judgement.hiding import AREA_SEMI_AXES, AREAS_HIDDEN, RANDOM_KEPT
from ..parameters import PRESETS, BlockParameters
from .result_files import records, write_content, write_table
from .runner import BenchResult, Row


@dataclass(frozen=True)
class Summary:
    """One method under one pattern, over all frames: means of the frames' values, and the median of the seconds.

    Errors in millimetres; `rel`, `delta_1`, `coverage` and `within` are shares; `failures` counts the frames that the
    method failed on, which count as left open. `within` is the mean over the frames where the method filled anything.
    """

    pattern: str
    method: str
    frames: int
    failures: int
    rmse_mm: float
    mae_mm: float
    median_mm: float
    rel: float
    delta_1: float
    coverage: float
    within: float | None
    seconds: float
    extraction_seconds: float | None


def summarise(result: BenchResult) -> list[Summary]:
    """One line per pattern and method, patterns in the order of the plan, the lowest RMSE first."""
    lines = []
    for pattern in result.plan.patterns:
        of_pattern = [row for row in result.rows if row.pattern == pattern]
        by_method = [[row for row in of_pattern if row.method == method] for method in result.plan.methods]
        lines += sorted((_summary(rows) for rows in by_method if rows), key=lambda line: line.rmse_mm)
    return lines


def write_csv(path: str | os.PathLike[str], result: BenchResult) -> None:
    """Write the table, all patterns in one, atomically; raises ExportError if that fails."""
    write_table(path, Summary, summarise(result))


def write_json(path: str | os.PathLike[str], result: BenchResult) -> None:
    """Write the table, the row of every frame, and all that they depend on, atomically.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    content = {
        "bench": {
            "frames": list(dict.fromkeys(row.frame for row in result.rows)),
            "patterns": list(result.plan.patterns),
            "methods": list(result.plan.methods),
            "seed": result.plan.seed,
            "random_kept": RANDOM_KEPT,
            "areas_hidden": AREAS_HIDDEN,
            "area_semi_axes": list(AREA_SEMI_AXES),
        },
        "extraction": BlockParameters().to_dict(),
        "presets": {name: values.to_dict() for name, values in PRESETS.items() if name in result.plan.methods},
        "table": records(summarise(result)),
        "rows": records(result.rows),
        "skipped": records(result.skipped),
    }
    write_content(path, content)


def _summary(rows: Sequence[Row]) -> Summary:
    def mean(value: Callable[[Row], float]) -> float:
        return statistics.fmean(map(value, rows))

    within = [row.within for row in rows if row.within is not None]
    extraction = [row.extraction_seconds for row in rows if row.extraction_seconds is not None]
    return Summary(
        pattern=rows[0].pattern,
        method=rows[0].method,
        frames=len(rows),
        failures=sum(bool(row.failure) for row in rows),
        rmse_mm=1000 * mean(lambda row: row.rmse),
        mae_mm=1000 * mean(lambda row: row.mae),
        median_mm=1000 * mean(lambda row: row.median),
        rel=mean(lambda row: row.rel),
        delta_1=mean(lambda row: row.delta_1),
        coverage=mean(lambda row: row.coverage),
        within=statistics.fmean(within) if within else None,
        seconds=statistics.median(row.seconds for row in rows),
        extraction_seconds=statistics.median(extraction) if extraction else None,
    )
