"""Results of the bench: rows of methods on frames, summarised over the frames."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from itertools import groupby
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.parameters import PRESETS, BlockParameters
from ..hold_out import AREA_SEMI_AXES, AREAS_HIDDEN, RANDOM_KEPT

Line = dict[str, Any]
"""A line of a table: name of a column -> value."""


@dataclass(frozen=True)
class Score:
    """Score of completed depth.

    Attributes
    ----------
    pixels : int
        Pixels scored.
    rmse, mae, median, rel, delta_1 : float
        Errors over these pixels, as in `ilf.evaluation.evaluation.Evaluation`.
    coverage : float
        Share of these (0-1) that the method filled itself.
    within : float or None
        Share of the filled pixels whose error lies within the expected error; None if the method filled none.
    within_twice : float or None
        The same for twice the expected error.
    sparsification : float or None
        `ilf.evaluation.bench.runner.sparsification_error` of the filled pixels.
    """

    pixels: int
    rmse: float
    mae: float
    median: float
    rel: float
    delta_1: float
    coverage: float
    within: float | None = None
    within_twice: float | None = None
    sparsification: float | None = None


@dataclass(frozen=True, kw_only=True)
class BenchRow(Score):
    """One method on one frame under one pattern.

    Attributes
    ----------
    frame, method, pattern : str
    sensor : str
        Of the frame, see `BenchFrame`.
    seconds : float
    extraction_seconds : float or None
        Time of block extraction and of the filter's edges before; None for methods without blocks.
    failure : str
        Reason of a failure, "" if the method did not fail.
    """

    frame: str
    method: str
    pattern: str = ""
    sensor: str = ""
    seconds: float
    extraction_seconds: float | None
    failure: str = ""


@dataclass(frozen=True)
class Skipped:
    """A frame skipped in one pattern or ("") in all, and the reason."""

    frame: str
    pattern: str
    reason: str


@dataclass(frozen=True)
class BenchResult:
    """All rows, by pattern, frame and method, and the skipped frames."""

    rows: tuple[BenchRow, ...]
    skipped: tuple[Skipped, ...]


CALIBRATED = (0.55, 0.80)
"""A frame counts as calibrated if its share of errors within the expected error lies between these limits."""


def summarise(result: BenchResult) -> list[Line]:
    """Return one line per pattern and method, patterns in the order of the rows, the lowest RMSE first.

    Values are means over frames; seconds are medians. Errors are in millimetres; `rel`, `delta_1`, `coverage`,
    `within`, `within_twice` and `calibrated` (frames within `CALIBRATED`) are shares. Peers, with which
    `against_peers` compares, are all methods that are not presets; without them its values are None.
    """
    lines = []
    for _, of_pattern in groupby(result.rows, key=lambda row: row.pattern):
        by_method: dict[str, list[BenchRow]] = {}
        for row in of_pattern:
            by_method.setdefault(row.method, []).append(row)
        peers = [rows for method, rows in by_method.items() if method not in PRESETS]
        lines += sorted((_line(rows, peers) for rows in by_method.values()), key=lambda line: line["rmse_mm"])
    return lines


def _line(rows: Sequence[BenchRow], peers: Sequence[Sequence[BenchRow]]) -> Line:
    """Summarise one method's rows, given those of every peer."""
    extraction = [row.extraction_seconds for row in rows if row.extraction_seconds is not None]
    line = {
        "pattern": rows[0].pattern,
        "method": rows[0].method,
        "frames": len(rows),
        "failures": sum(bool(row.failure) for row in rows),
        **{f"{name}_mm": 1000 * statistics.fmean(values(rows, name)) for name in ("rmse", "mae", "median")},
        **{name: statistics.fmean(values(rows, name)) for name in ("rel", "delta_1", "coverage")},
        "seconds": statistics.median(row.seconds for row in rows),
        "extraction_seconds": statistics.median(extraction) if extraction else None,
        **{f"{name}_geometric_mm": 1000 * geometric_mean(values(rows, name)) for name in ("rmse", "mae")},
    }
    for name in ("rmse", "mae"):
        best = [min(errors) for errors in zip(*(values(peer, name) for peer in peers), strict=True)]
        found = against_peers(values(rows, name), best, [row.sensor for row in rows])
        line |= {f"{name}_{key}": value for key, value in found.items()}
    shares = [row.within for row in rows if row.within is not None]
    return line | {
        "within": mean(shares),
        "within_twice": mean(row.within_twice for row in rows),
        "calibrated": mean(float(CALIBRATED[0] <= share <= CALIBRATED[1]) for share in shares),
        "sparsification": mean(row.sparsification for row in rows),
    }


def values(rows: Iterable[BenchRow], name: str) -> list[float]:
    """The values of one field of rows."""
    return [getattr(row, name) for row in rows]


def mean(values: Iterable[float | None]) -> float | None:
    """Mean of the values that are not None; None if there are none."""
    given = [value for value in values if value is not None]
    return statistics.fmean(given) if given else None


# Means over frames are dominated by the few frames with the largest errors. A geometric mean of ratios weights all
# frames equally, whatever their scale.

SMALLEST_ERROR = 1e-6
"""Smaller errors [m] count as this value, because an error of 0 has no ratio."""

RESAMPLES = 10_000
_SEED = 0


def against_peers(errors: Sequence[float], best: Sequence[float], sensors: Sequence[str]) -> Line:
    """Compare a method with the best of all peers on every single frame, which cannot be picked in advance.

    Parameters
    ----------
    errors : sequence of float
        Of the method, by frame [m].
    best : sequence of float
        The smallest error of any peer on the same frame [m]; empty without peers.
    sensors : sequence of str
        The sensor of each frame.

    Returns
    -------
    dict
        `ratio`: geometric mean over frames of error / best, 1 or larger for a peer itself; `low_68`, `high_68`,
        `low_95`, `high_95`: its intervals by `bootstrap`, None where all frames are of one sensor; `wins`: frames on
        which the error does not exceed the best. Without peers, all are None.
    """
    names = ("ratio", "low_68", "high_68", "low_95", "high_95", "wins")
    if not best:
        return dict.fromkeys(names)
    logarithms = _logarithms(errors) - _logarithms(best)
    ratios = bootstrap(logarithms, sensors)
    limits = [None] * 4 if ratios is None else np.quantile(ratios, (0.16, 0.84, 0.025, 0.975)).tolist()
    wins = int(np.count_nonzero(logarithms <= 0))
    return dict(zip(names, (float(np.exp(logarithms.mean())), *limits, wins), strict=True))


def geometric_mean(errors: Sequence[float]) -> float:
    """Geometric mean of errors [m]; smaller ones count as `SMALLEST_ERROR`.

    Examples
    --------
    >>> round(geometric_mean([0.1, 0.4]), 6)
    0.2
    """
    return float(np.exp(_logarithms(errors).mean()))


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


def _logarithms(errors: Sequence[float]) -> NDArray[np.float64]:
    return np.log(np.maximum(np.asarray(errors, np.float64), SMALLEST_ERROR))


def content(result: BenchResult, patterns: Sequence[str], methods: Sequence[str], seed: int) -> dict[str, Any]:
    """The table, the rows of all frames, and all settings that they depend on."""
    return {
        "bench": {
            "frames": list(dict.fromkeys(row.frame for row in result.rows)),
            "patterns": patterns,
            "methods": methods,
            "seed": seed,
            "random_kept": RANDOM_KEPT,
            "areas_hidden": AREAS_HIDDEN,
            "area_semi_axes": AREA_SEMI_AXES,
        },
        "extraction": BlockParameters().to_dict(),
        "presets": {name: preset.to_dict() for name, preset in PRESETS.items() if name in methods},
        "table": summarise(result),
        **asdict(result),
    }
