"""Results of the bench: summarised, and written as CSV and JSON."""

from __future__ import annotations

import dataclasses
import json
import os
import statistics
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..._runtime.files import write_bytes
from ..._runtime.installation import __version__
from ..._runtime.machine import library_versions
from ...data.parameters import PRESETS, BlockParameters
from ...evaluation.hold_out import AREA_SEMI_AXES, AREAS_HIDDEN, RANDOM_KEPT
from ...io.tables import write_csv
from ...run.record import PROGRAM

# Plan and result of a bench.


@dataclass(frozen=True)
class Plan:
    """Input of the bench: frame folders, names of patterns and methods, and the base seed of the patterns."""

    folders: tuple[Path, ...]
    patterns: tuple[str, ...]
    methods: tuple[str, ...]
    seed: int = 0


@dataclass(frozen=True)
class Row:
    """One method on one frame under one pattern.

    Attributes
    ----------
    pattern, frame, method : str
    pixels : int
        Pixels scored.
    rmse, mae, median : float
        Errors over these pixels [m].
    rel : float
    delta_1 : float
        Share with depth within a factor of 1.25 of the ground truth.
    coverage : float
        Share that the method filled itself.
    within : float or None
        Share of that whose error is at most the expected error; None if the method filled nothing.
    within_twice, sparsification : float or None
        As in `ilf.lab.bench.runner.Score`.
    seconds : float
    extraction_seconds : float or None
        Time of block extraction and of the filter's edges before; None for methods without blocks.
    failure : str
        Reason of a failure, "" if the method did not fail.
    """

    pattern: str
    frame: str
    method: str
    pixels: int
    rmse: float
    mae: float
    median: float
    rel: float
    delta_1: float
    coverage: float
    within: float | None
    within_twice: float | None
    sparsification: float | None
    seconds: float
    extraction_seconds: float | None
    failure: str = ""


@dataclass(frozen=True)
class TaskFacts:
    """One frame under one pattern: its sensor (see `BenchFrame`) and `Task.sha256`."""

    pattern: str
    frame: str
    sensor: str
    sha256: str


@dataclass(frozen=True)
class Skipped:
    """A frame skipped in one pattern or ("") in all, and the reason."""

    frame: str
    pattern: str
    reason: str


@dataclass(frozen=True)
class BenchResult:
    """All rows, by pattern, frame and method in the order of the plan, the tasks of the methods, and the skipped
    frames."""

    plan: Plan
    rows: tuple[Row, ...]
    tasks: tuple[TaskFacts, ...]
    skipped: tuple[Skipped, ...]


# A method compared with the best of all peers on every single frame, which cannot be picked in advance.
#
# Means over frames are dominated by the few frames with the largest errors. A geometric mean of ratios weights all
# frames equally, whatever their scale.

SMALLEST_ERROR = 1e-6
"""Smaller errors [m] count as this value, because an error of 0 has no ratio."""

RESAMPLES = 10_000
_SEED = 0


@dataclass(frozen=True)
class AgainstPeers:
    """One error measure of one method compared with the best of all peers, frame by frame.

    Attributes
    ----------
    ratio : float
        Geometric mean over frames of its error / the smallest error of any peer on that frame. For a peer itself it is
        1 or larger.
    low_68, high_68, low_95, high_95 : float or None
        Intervals of the ratio, from `bootstrap`; None where all frames are of one sensor.
    wins : int
        Frames on which its error does not exceed that of the best peer.
    """

    ratio: float
    low_68: float | None
    high_68: float | None
    low_95: float | None
    high_95: float | None
    wins: int


def against_peers(errors: Sequence[float], best: Sequence[float], sensors: Sequence[str]) -> AgainstPeers:
    """Compare a method's errors [m] with the best peers' on the same frames; `sensors` has the sensor of each frame."""
    logarithms = np.log(_floored(errors)) - np.log(_floored(best))
    ratios = bootstrap(logarithms, sensors)
    low_68, high_68, low_95, high_95 = (
        [None] * 4 if ratios is None else np.quantile(ratios, (0.16, 0.84, 0.025, 0.975)).tolist()
    )
    return AgainstPeers(
        float(np.exp(logarithms.mean())), low_68, high_68, low_95, high_95, int(np.count_nonzero(logarithms <= 0))
    )


def geometric_mean(errors: Sequence[float]) -> float:
    """Geometric mean of errors [m]; smaller ones count as `SMALLEST_ERROR`.

    Examples
    --------
    >>> round(geometric_mean([0.1, 0.4]), 6)
    0.2
    """
    return float(np.exp(np.log(_floored(errors)).mean()))


def bootstrap(logarithms: NDArray[np.float64], groups: Sequence[str]) -> NDArray[np.float64] | None:
    """Bootstrap geometric means over groups of frames, with a fixed seed; None for a single group.

    `RESAMPLES` times, as many groups as there are are drawn with replacement, each with all of its frames: frames of
    one sensor resemble each other, so they are less informative than frames of different sensors.

    Parameters
    ----------
    logarithms : ndarray of float64, shape (N,)
        Logarithms of the averaged values.
    groups : sequence of str
        The group of each.
    """
    names, group = np.unique(np.asarray(groups), return_inverse=True)
    if names.size < 2:
        return None
    drawn = np.random.default_rng(_SEED).multinomial(names.size, np.full(names.size, 1 / names.size), RESAMPLES)
    return np.exp((drawn @ np.bincount(group, logarithms)) / (drawn @ np.bincount(group)))


def _floored(errors: Sequence[float]) -> NDArray[np.float64]:
    return np.maximum(np.asarray(errors, np.float64), SMALLEST_ERROR)


# Files of any bench: a table as CSV, everything as JSON.


def write_table(path: str | os.PathLike[str], kind: type[Any], lines: Iterable[Any]) -> None:
    """Write instances of a dataclass as CSV, atomically, with its fields as columns; raise ExportError on failure."""
    write_csv(path, [[field.name for field in dataclasses.fields(kind)], *map(dataclasses.astuple, lines)])


def write_content(path: str | os.PathLike[str], content: Mapping[str, Any]) -> None:
    """Write results as JSON, atomically, with the versions of program and libraries; raise ExportError on failure."""
    versions = {"program": PROGRAM, "version": __version__, "versions": library_versions()}
    write_bytes(path, (json.dumps(versions | dict(content), indent=1, allow_nan=False) + "\n").encode())


def records(items: Iterable[Any]) -> list[dict[str, Any]]:
    """Instances of dataclasses as dicts, ready for JSON."""
    return [dataclasses.asdict(item) for item in items]


CALIBRATED = (0.55, 0.80)
"""A frame counts as calibrated if its share of errors within the expected error lies between these limits."""


@dataclass(frozen=True)
class Summary:
    """One method under one pattern, over all frames: means of the frames' values unless stated otherwise.

    Errors in millimetres; `rel`, `delta_1`, `coverage`, `within`, `within_twice` and `calibrated` are shares.

    Attributes
    ----------
    failures : int
        Frames on which the method failed; they count as not filled.
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
    """Return one summary per pattern and method, patterns in the order of the plan, the lowest RMSE first.

    Peers are all methods that are not presets.
    """
    lines = []
    for pattern in result.plan.patterns:
        of_pattern = [row for row in result.rows if row.pattern == pattern]
        sensors = {task.frame: task.sensor for task in result.tasks if task.pattern == pattern}
        by_method = [[row for row in of_pattern if row.method == method] for method in result.plan.methods]
        peers = [rows for rows in by_method if rows and rows[0].method not in PRESETS]
        lines += sorted((_summary(rows, peers, sensors) for rows in by_method if rows), key=lambda line: line.rmse_mm)
    return lines


def write_bench_csv(path: str | os.PathLike[str], result: BenchResult) -> None:
    """Write one table for all patterns, atomically; raise ExportError on failure."""
    write_table(path, Summary, summarise(result))


def write_json(path: str | os.PathLike[str], result: BenchResult) -> None:
    """Write the table, the rows of all frames, and all settings that they depend on, atomically.

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
    """Summarise one method's rows, given those of every peer and the sensor of every frame."""

    def mean(value: Callable[[Row], float]) -> float:
        return statistics.fmean(map(value, rows))

    def mean_of_given(value: Callable[[Row], float | None]) -> float | None:
        given = [found for found in map(value, rows) if found is not None]
        return statistics.fmean(given) if given else None

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
        within=mean_of_given(lambda row: row.within),
        within_twice=mean_of_given(lambda row: row.within_twice),
        calibrated=mean_of_given(calibrated),
        sparsification=mean_of_given(lambda row: row.sparsification),
    )


def _against(
    measure: str, rows: Sequence[Row], peers: Sequence[Sequence[Row]], sensors: Mapping[str, str]
) -> dict[str, Any]:
    """Return the `AgainstPeers` fields of a summary for one error measure of the rows."""
    names = [f"{measure}_{field.name}" for field in fields(AgainstPeers)]
    if not peers:
        return dict.fromkeys(names)
    error = attrgetter(measure)
    best = [min(map(error, of_frame)) for of_frame in zip(*peers, strict=True)]
    found = against_peers(list(map(error, rows)), best, [sensors[row.frame] for row in rows])
    return dict(zip(names, astuple(found), strict=True))
