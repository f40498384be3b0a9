"""Fit and check the expected error on hidden depth: `python -m ilf.bench.calibration`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from ..confidence import DEFAULT_MODEL, FLOOR, MODELS, WITHIN, ErrorModel, error_features, filled_pixels
from ..ebs import extract_blocks
from ..errors import IlfError
from .frames import find_frames, load_bench_frame
from .methods import METHODS
from .patterns import make_task

PATTERNS_USED = ("random", "areas")
DISTANCE_BINS = (0.0, 2.0, 5.0, 15.0, 50.0, np.inf)
"""Limits [px] between the distances to known depth that are reported one by one."""

_SAMPLES = 6000
"""Pixels taken of every frame and pattern."""

_LEAST_IN_BIN = 50
_SMOOTHINGS = (0.5, 0.2, 0.05)
"""Widths over which the kink of the pinball loss is rounded, one after the other."""


@dataclass(frozen=True, eq=False)
class Sample:
    """Hidden pixels of one frame under one pattern, as a method has filled them.

    Attributes
    ----------
    frame, pattern : str
    features : ndarray of float, shape (N, 6)
        See `ilf.confidence.error_features`.
    shares : ndarray of float64, shape (N,)
        |error| / completed depth.
    distances : ndarray of float32, shape (N,)
        To the nearest known depth [px].
    """

    frame: str
    pattern: str
    features: NDArray[np.floating]
    shares: NDArray[np.float64]
    distances: NDArray[np.float32]


@dataclass(frozen=True)
class Calibration:
    """How many errors lie within the expected one, under one pattern.

    Attributes
    ----------
    pattern : str
    frames : int
    mean, spread, lowest, highest : float
        Of the frames' shares (0-1); the spread is their standard deviation.
    by_distance : tuple of float
        Mean over frames in each of `DISTANCE_BINS`, NaN where there is none.
    """

    pattern: str
    frames: int
    mean: float
    spread: float
    lowest: float
    highest: float
    by_distance: tuple[float, ...]


def take_sample(folder: Path, pattern: str, method: str, seed: int = 0) -> Sample:
    """Hide depth of a frame, complete it, and take pixels of what was hidden.

    Raises
    ------
    InputError, FormatError
        If the frame cannot be read, or nothing of it can be hidden.
    """
    source = load_bench_frame(folder)
    task = make_task(source, pattern, seed)
    chosen = METHODS[method]
    labels = extract_blocks(task.frame) if chosen.needs_blocks else np.zeros(task.frame.shape, np.int32)
    depth = np.asarray(chosen.run(task.frame, labels))
    filled = filled_pixels(task.frame, depth)
    distance = np.asarray(cv2.distanceTransform((~task.frame.known).astype(np.uint8), cv2.DIST_L2, 5), np.float32)
    scored = np.flatnonzero(task.scored[filled])
    if scored.size > _SAMPLES:
        scored = np.sort(np.random.default_rng(seed).choice(scored, _SAMPLES, replace=False))
    completed, truth = depth[filled][scored].astype(np.float64), task.truth[filled][scored].astype(np.float64)
    return Sample(
        source.frame.name,
        pattern,
        error_features(task.frame, depth)[scored],
        np.abs(completed - truth) / completed,
        distance[filled][scored],
    )


def fit(samples: Sequence[Sample]) -> ErrorModel:
    """The model whose 68 % quantile of log |error| has the least pinball loss; every sample counts the same."""
    features = np.concatenate([sample.features for sample in samples]).astype(np.float64)
    logarithms = np.log(np.maximum(np.concatenate([sample.shares for sample in samples]), FLOOR))
    weights = np.concatenate([np.full(len(sample.shares), 1 / len(sample.shares)) for sample in samples])
    weights /= weights.sum()
    design = np.column_stack([np.ones(len(features)), features])

    def loss(constants: NDArray[np.float64], width: float) -> tuple[float, NDArray[np.float64]]:
        misses = logarithms - design @ constants
        rounded = np.hypot(misses, width)
        value = weights @ ((WITHIN - 0.5) * misses + rounded / 2)
        return float(value), -(weights * (WITHIN - 0.5 + misses / rounded / 2)) @ design

    constants = np.zeros(design.shape[1])
    constants[0] = np.quantile(logarithms, WITHIN)
    bounds = [(None, None), (None, None), *[(0, None)] * (design.shape[1] - 2)]
    for width in _SMOOTHINGS:
        found = minimize(
            loss, constants, (width,), "L-BFGS-B", jac=True, bounds=bounds,
            options={"maxiter": 2000, "maxfun": 5000, "ftol": 1e-12, "gtol": 1e-8},
        )  # fmt: skip
        constants = found.x
    return ErrorModel(*(round(float(value), 3) for value in constants))


def calibrate(model: ErrorModel, samples: Sequence[Sample]) -> list[Calibration]:
    """What share of the samples' errors lies within the model's, for every pattern among them."""
    found = []
    for pattern in dict.fromkeys(sample.pattern for sample in samples):
        shares: list[float] = []
        bins: list[list[float]] = [[] for _ in DISTANCE_BINS[1:]]
        for sample in samples:
            if sample.pattern != pattern:
                continue
            within = sample.shares <= model.shares(sample.features)
            shares.append(float(within.mean()))
            place = np.digitize(sample.distances, DISTANCE_BINS, right=True) - 1
            for number, values in enumerate(bins):
                inside = within[place == number]
                if inside.size >= _LEAST_IN_BIN:
                    values.append(float(inside.mean()))
        found.append(
            Calibration(
                pattern,
                len(shares),
                float(np.mean(shares)),
                float(np.std(shares)),
                min(shares),
                max(shares),
                tuple(float(np.mean(values)) if values else float("nan") for values in bins),
            )
        )
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m ilf.bench.calibration",
        description="Fit the expected error to hidden depth of some frames and check it on others.",
        allow_abbrev=False,
    )
    parser.add_argument("--fit", nargs="+", default=[], metavar="FOLDER", help="frames to fit to; none: keep the model")
    parser.add_argument("--check", nargs="+", default=[], metavar="FOLDER", help="frames to check on")
    parser.add_argument("--method", choices=tuple(METHODS), default="best", help="what completes (default: best)")
    parser.add_argument(
        "--model", choices=tuple(MODELS), default=DEFAULT_MODEL, help=f"without --fit (default: {DEFAULT_MODEL})"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="what the hidden pixels follow from")
    given = parser.parse_args(arguments)
    try:
        fitted, checked = (
            [
                take_sample(folder, pattern, given.method, given.seed)
                for folder in find_frames(folders)
                for pattern in PATTERNS_USED
            ]
            for folders in (given.fit, given.check)
        )
    except IlfError as error:
        print("calibration: error:", error, file=sys.stderr)
        return 1
    model = fit(fitted) if fitted else MODELS[given.model]
    print(f"ErrorModel({', '.join(map(str, astuple(model)))})")
    for name, samples in (("fitted", fitted), ("checked", checked)):
        print("\n".join(_lines(name, calibrate(model, samples))))
    return 0


def _lines(name: str, calibrations: Iterable[Calibration]) -> list[str]:
    limits = [f"{limit:g}" for limit in DISTANCE_BINS]
    bins = [f"{low}-{high} px" for low, high in pairwise(limits)]
    return [
        f"{name}, {line.pattern}: {line.mean:.1%} within, {line.frames} frames, spread {line.spread:.1%}, "
        f"{line.lowest:.1%} to {line.highest:.1%}; "
        + ", ".join(
            f"{text} {share:.1%}" for text, share in zip(bins, line.by_distance, strict=True) if np.isfinite(share)
        )
        for line in calibrations
    ]


if __name__ == "__main__":
    sys.exit(main())
