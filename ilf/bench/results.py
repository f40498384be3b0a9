"""The bench's results: summed up, and written as CSV and JSON."""

from __future__ import annotations

import os
import statistics
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from operator import attrgetter
from typing import Any

from ..judgement.hiding import AREA_SEMI_AXES, AREAS_HIDDEN, RANDOM_KEPT
from ..parameters import PRESETS, BlockParameters
from .against_peers import AgainstPeers, against_peers, geometric_mean
from .result_files import records, write_content, write_table
from .rows import BenchResult, Row

CALIBRATED = (0.55, 0.80)
"""Share of errors within the expected error between which a single frame counts as calibrated."""


@dataclass(frozen=True)
class Summary:
    """One method under one pattern, over all frames: means of the frames' values where nothing else is said.

    Errors in millimetres; `rel`, `delta_1`, `coverage`, `within`, `within_twice` and `calibrated` are shares.

    Attributes
    ----------
    failures : int
        Frames that the method failed on, which count as left open.
    seconds, extraction_seconds : float
        Medians.
    rmse_geometric_mm, mae_geometric_mm : float
        Geometric means.
    rmse_ratio ... mae_wins
        `AgainstPeers` of RMSE and of MAE; None if no peer is compared.
    within, within_twice, sparsification : float or None
        Over the frames where the method filled anything.
    calibrated : float or None
        Share of those where `within` lies in `CALIBRATED`.
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
    seconds: float
    extraction_seconds: float | None
    rmse_geometric_mm: float
    mae_geometric_mm: float
    rmse_ratio: float | None
    rmse_low_68: float | None
    rmse_high_68: float | None
    rmse_low_95: float | None
    rmse_high_95: float | None
    rmse_wins: int | None
    mae_ratio: float | None
    mae_low_68: float | None
    mae_high_68: float | None
    mae_low_95: float | None
    mae_high_95: float | None
    mae_wins: int | None
    within: float | None
    within_twice: float | None
    calibrated: float | None
    sparsification: float | None


def summarise(result: BenchResult) -> list[Summary]:
    """One line per pattern and method, patterns in the order of the plan, the lowest RMSE first.

    Peers are all methods that are no presets.
    """
    lines = []
    for pattern in result.plan.patterns:
        of_pattern = [row for row in result.rows if row.pattern == pattern]
        sensors = {task.frame: task.sensor for task in result.tasks if task.pattern == pattern}
        by_method = [[row for row in of_pattern if row.method == method] for method in result.plan.methods]
        peers = [rows for rows in by_method if rows and rows[0].method not in PRESETS]
        lines += sorted((_summary(rows, peers, sensors) for rows in by_method if rows), key=lambda line: line.rmse_mm)
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
        "tasks": records(result.tasks),
        "rows": records(result.rows),
        "skipped": records(result.skipped),
    }
    write_content(path, content)


def _summary(rows: Sequence[Row], peers: Sequence[Sequence[Row]], sensors: Mapping[str, str]) -> Summary:
    """Of one method's rows; those of every peer, and the sensor of every frame, beside them."""

    def mean(value: Callable[[Row], float]) -> float:
        return statistics.fmean(map(value, rows))

    def mean_of_said(value: Callable[[Row], float | None]) -> float | None:
        said = [found for found in map(value, rows) if found is not None]
        return statistics.fmean(said) if said else None

    def calibrated(row: Row) -> float | None:
        return None if row.within is None else float(CALIBRATED[0] <= row.within <= CALIBRATED[1])

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
        seconds=statistics.median(row.seconds for row in rows),
        extraction_seconds=statistics.median(extraction) if extraction else None,
        rmse_geometric_mm=1000 * geometric_mean([row.rmse for row in rows]),
        mae_geometric_mm=1000 * geometric_mean([row.mae for row in rows]),
        **_against("rmse", rows, peers, sensors),
        **_against("mae", rows, peers, sensors),
        within=mean_of_said(lambda row: row.within),
        within_twice=mean_of_said(lambda row: row.within_twice),
        calibrated=mean_of_said(calibrated),
        sparsification=mean_of_said(lambda row: row.sparsification),
    )


def _against(
    measure: str, rows: Sequence[Row], peers: Sequence[Sequence[Row]], sensors: Mapping[str, str]
) -> dict[str, Any]:
    """The fields of a summary that `AgainstPeers` fills with one measure of the rows."""
    names = [f"{measure}_{field.name}" for field in fields(AgainstPeers)]
    if not peers:
        return dict.fromkeys(names)
    error = attrgetter(measure)
    best = [min(map(error, of_frame)) for of_frame in zip(*peers, strict=True)]
    found = against_peers(list(map(error, rows)), best, [sensors[row.frame] for row in rows])
    return dict(zip(names, astuple(found), strict=True))
