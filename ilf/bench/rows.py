"""What a bench is asked for, and what comes of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Plan:
    """What is compared: frame folders, names of patterns and methods, and the patterns' base seed."""

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
        Over them [m].
    rel : float
    delta_1 : float
        Share with depth within a factor of 1.25 of the truth.
    coverage : float
        Share that the method filled itself.
    within : float or None
        Share of that whose error is at most the expected error; None if the method filled nothing.
    within_twice, sparsification : float or None
        As in `ilf.bench.Score`.
    seconds : float
    extraction_seconds : float or None
        Time that the extraction of the blocks took before, and the filter's edges; None for methods without blocks.
    failure : str
        Why the method gave nothing, "" if it did not fail.
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
    """What one frame under one pattern was: its sensor (see `BenchFrame`) and `Task.sha256`."""

    pattern: str
    frame: str
    sensor: str
    sha256: str


@dataclass(frozen=True)
class Skipped:
    """A frame that was left out, of one pattern or ("") of all, and why."""

    frame: str
    pattern: str
    reason: str


@dataclass(frozen=True)
class BenchResult:
    """All rows, by pattern, frame and method in the order of the plan, what was asked of the methods, and the frames
    that were left out."""

    plan: Plan
    rows: tuple[Row, ...]
    tasks: tuple[TaskFacts, ...]
    skipped: tuple[Skipped, ...]
