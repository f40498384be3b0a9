"""Fit the model of the expected error to hold-outs of some frames, and check it on others.

    python assets/models/fit_expected_error.py --fit FRAME... --check FRAME... --write FILE

FRAME are folders of frames, as for `ilf bench`, or folders of such folders. FILE takes the models; those that the
program uses are in ilf/completion/confidence/fitted.py.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, minimize_scalar
from scipy.sparse import csr_array, hstack

from ilf.completion.confidence.expected_error import DEFAULT_MODEL, difficulty_of, difficulty_samples
from ilf.completion.confidence.fitted import MODELS
from ilf.completion.confidence.model import (
    FEATURES,
    FLOOR,
    WITHIN,
    WITHIN_TWICE,
    ErrorModel,
    default_edges,
    error_features,
    filled_pixels,
    gap_weight,
    unusual,
)
from ilf.data.frame import RGBDFrame
from ilf.errors import IlfError, InputError
from ilf.evaluation.bench.frames import PATTERNS, Task, find_frames, load_bench_frame, make_task
from ilf.evaluation.bench.methods import BY_BLOCKS, METHODS
from ilf.evaluation.bench.results import CALIBRATED
from ilf.evaluation.bench.runner import sparsification_error
from ilf.evaluation.evaluation import share_within
from ilf.segmentation.extraction import extract_blocks

Values = NDArray[np.float64]

_KNOTS = 6
"""Knots of every curve, at equal shares of the pixels."""

_OUTERMOST = 0.01
"""Share of the pixels that lies beyond the first knot, and beyond the last."""

_NON_MONOTONE = {"depth", "edge", "edge near", "edges around"}
"""Features whose curves may rise or fall; all other curves only rise."""

_STRAIGHT, _LEVEL = 1e-3, 1e-4
"""Penalties of a curve's bends, and of its slopes."""

_SMOOTHINGS = (0.5, 0.1)
"""Widths over which the kink of the pinball loss is rounded, in turn."""

_QUANTILE_TARGETS = (1.0, WITHIN, 1.0), (2.0, WITHIN_TWICE, 0.3)
"""Multiple of the expected error, target share of errors within it, and weight of this target in the loss."""

_DECIMALS = 3


@dataclass(frozen=True, eq=False)
class Sample:
    """Held-out pixels of one frame under one pattern, as a method filled them.

    Attributes
    ----------
    sensor, pattern : str
        Sensor of the frame (`BenchFrame.sensor`), and pattern of the hold-out.
    features : ndarray of float, shape (N, 13)
        See `ilf.completion.confidence.model.error_features`.
    depths : ndarray of float64, shape (N,)
        Completed depth [m].
    shares : ndarray of float64, shape (N,)
        |error| / completed depth.
    distances : ndarray of float32, shape (N,)
        To the nearest known depth [px].
    difficulty_samples : (ndarray, ndarray) or None
        See `ilf.completion.confidence.expected_error.difficulty_samples`.
    weight : float
        Weight in the fit.
    """

    sensor: str
    pattern: str
    features: NDArray[np.floating]
    depths: Values
    shares: Values
    distances: NDArray[np.float32]
    difficulty_samples: tuple[NDArray[np.floating], NDArray[np.floating]] | None = None
    weight: float = 1.0

    def expected(self, model: ErrorModel) -> Values:
        """The expected errors, as shares of depth."""
        difficulty = None if self.difficulty_samples is None else difficulty_of(*self.difficulty_samples, model)
        return model.shares(self.features, difficulty)


def fit(samples: Sequence[Sample]) -> ErrorModel:
    """Fit the model that minimises the loss.

    The loss is the pinball loss of the 68 % quantile of the log error, plus that of the 95 % quantile at twice the
    expected error, with a smaller weight: one number serves as one and two standard deviations. The curves are fitted
    first, then the factor of each frame's own test.
    """
    features = np.concatenate([sample.features for sample in samples]).astype(np.float64)
    logarithms = np.log(np.maximum(np.concatenate([sample.shares for sample in samples]), FLOOR))
    weights = np.concatenate([np.full(len(sample.shares), sample.weight / len(sample.shares)) for sample in samples])
    weights /= weights.sum()
    model = _fit_curves(features, logarithms, weights)
    above = [
        np.nan if sample.difficulty_samples is None else difficulty_of(*sample.difficulty_samples, model)
        for sample in samples
    ]
    if not np.isfinite(above).any():
        return model
    usual = float(np.nanmedian(above))
    own = np.concatenate(
        [
            gap_weight(sample.features) * unusual(np.nan_to_num(value, nan=usual), usual)
            for sample, value in zip(samples, above, strict=True)
        ]
    )
    left = logarithms - model.logarithms(features)
    found = minimize_scalar(
        lambda factor: _loss(left - factor * own, weights, _SMOOTHINGS[-1])[0], bounds=(0.0, 1.5), method="bounded"
    )
    return replace(model, usual=round(usual, _DECIMALS), own=round(float(found.x), _DECIMALS))


def _loss(left: Values, weights: Values, width: float) -> tuple[float, Values]:
    """Loss of the residuals of the logarithms, and its gradient by the expected logarithms."""
    value, slopes = 0.0, np.zeros_like(left)
    for times, share, matters in _QUANTILE_TARGETS:
        miss = left - np.log(times)
        rounded = np.hypot(miss, width)
        value += matters * float(weights @ ((share - 0.5) * miss + rounded / 2))
        slopes -= matters * weights * (share - 0.5 + miss / rounded / 2)
    return value, slopes


def _fit_curves(features: Values, logarithms: Values, weights: Values) -> ErrorModel:
    """Fit the curves; each is the cumulative sum of its steps from knot to knot, starting at 0."""
    columns = features.T
    knots = [np.unique(np.quantile(column, np.linspace(_OUTERMOST, 1 - _OUTERMOST, _KNOTS))) for column in columns]
    design = hstack([_hats(column, of_it) for column, of_it in zip(columns, knots, strict=True)]).tocsr()
    transposed = design.T.tocsr()
    parts = [slice(*ends) for ends in pairwise(np.cumsum([0, *map(len, knots)]).tolist())]

    def loss(constants: Values, width: float) -> tuple[float, Values]:
        steps = constants[1:]
        values = np.concatenate([np.cumsum(steps[part]) for part in parts])
        value, slopes = _loss(logarithms - constants[0] - design @ values, weights, width)
        of_values = transposed @ slopes
        gradient = np.concatenate([[slopes.sum()], *(np.cumsum(of_values[part][::-1])[::-1] for part in parts)])
        for part in parts:
            inner, of_steps = steps[part][1:], gradient[1:][part][1:]
            bends = np.diff(inner)
            value += _STRAIGHT * float(bends @ bends) + _LEVEL * float(inner @ inner)
            of_steps += 2 * _LEVEL * inner
            of_steps[:-1] -= 2 * _STRAIGHT * bends
            of_steps[1:] += 2 * _STRAIGHT * bends
        return value, gradient

    constants = np.zeros(1 + design.shape[1])
    constants[0] = np.quantile(logarithms, WITHIN)
    bounds: list[tuple[float | None, float | None]] = [(None, None)]
    for name, of_it in zip(FEATURES, knots, strict=True):
        bounds += [(0.0, 0.0), *[(None if name in _NON_MONOTONE else 0.0, None)] * (len(of_it) - 1)]
    for width in _SMOOTHINGS:
        constants = minimize(
            loss, constants, (width,), "L-BFGS-B", jac=True, bounds=bounds, options={"maxiter": 300, "maxfun": 600}
        ).x
    curves = tuple(
        (_rounded(of_it), _rounded(np.cumsum(constants[1:][part]))) for of_it, part in zip(knots, parts, strict=True)
    )
    return ErrorModel(round(float(constants[0]), _DECIMALS), curves)


def _hats(column: Values, knots: Values) -> csr_array:
    """Weight of every knot's value at every pixel, (N, knots)."""
    if len(knots) == 1:
        return csr_array(np.ones((len(column), 1)))
    place = np.clip(np.searchsorted(knots, column, side="right") - 1, 0, len(knots) - 2)
    beyond = np.clip((column - knots[place]) / np.diff(knots)[place], 0, 1)
    rows = np.arange(len(column))
    entries = np.concatenate([1 - beyond, beyond])
    return csr_array((entries, (np.tile(rows, 2), np.concatenate([place, place + 1]))), (len(column), len(knots)))


def _rounded(values: Values) -> tuple[float, ...]:
    return tuple(round(float(value), _DECIMALS) for value in values)


DISTANCE_BINS = (0.0, 2.0, 5.0, 15.0, 50.0, np.inf)
"""Limits [px] of the bins of distance to known depth that are reported separately."""

_SAMPLES = 2000
"""Pixels taken of every frame and pattern."""

_MIN_IN_BIN = 50
_MIN_IN_SCENE = 200
"""Minimum number of missing pixels of a generated scene."""

_SCENES, _SCENE_WEIGHT = 40, 0.5
"""Number of generated scenes, and the weight of each relative to a frame under one pattern."""

_FITTED = '''"""Models of the expected error, written by assets/models/fit_expected_error.py."""

from .model import ErrorModel

# fmt: off
MODELS = {
%s}
"""Low-pass filter, as in `Parameters.filter`, -> model of its errors; "sparse": that of the edge-aware filter in sparse
frames."""
'''


@dataclass(frozen=True)
class Calibration:
    """Share of errors within the expected error, under one pattern.

    Attributes
    ----------
    pattern : str
    frames : int
    mean, spread, lowest, highest : float
        Of the frames' shares (0-1); the spread is their standard deviation.
    calibrated : float
        Share of the frames (0-1) whose share lies in `CALIBRATED`.
    twice : float
        Mean over frames of the share within twice the expected error.
    sparsification : float
        Mean over frames of `ilf.evaluation.bench.runner.sparsification_error`.
    by_distance : tuple of float
        Mean over frames in each of `DISTANCE_BINS`, NaN where a bin is empty.
    """

    pattern: str
    frames: int
    mean: float
    spread: float
    lowest: float
    highest: float
    calibrated: float
    twice: float
    sparsification: float
    by_distance: tuple[float, ...]


def take_sample(folder: Path, pattern: str, method: str, seed: int = 0) -> Sample:
    """Hold out depth of a frame, complete it, and sample the held-out pixels.

    Raises
    ------
    InputError, FormatError
        If the frame cannot be read, or no depth can be held out.
    """
    frame = load_bench_frame(folder)
    return _sample_of(make_task(frame, pattern, seed), frame.sensor, pattern, method, seed)


def take_scenes(folder: Path, count: int, method: str) -> list[Sample]:
    """Complete the missing depth of generated scenes, and sample the filled pixels.

    Hold-outs lie anywhere; holes of real sensors lie at jumps, and on objects that are black, shiny or bright as a
    whole. For generated scenes the true depth in such holes is known.

    Parameters
    ----------
    folder : Path
        Folder of pictures made by `assets/models/make_scenes.py`.
    count : int
        Number of pictures, taken evenly.

    Raises
    ------
    InputError
        If the folder has no pictures.
    """
    paths = sorted(folder.glob("*.npz"))
    if not paths:
        raise InputError(f"{folder} has no pictures (*.npz). Make some with assets/models/make_scenes.py.")
    samples = []
    for path in paths[:: max(len(paths) // count, 1)][:count]:
        with np.load(path) as arrays:
            frame = RGBDFrame(arrays["rgb"], arrays["measured"], name=f"scene {path.stem}")
            missing = ~frame.known & np.isfinite(arrays["exact"])
            task = Task(frame, arrays["exact"], missing)
        if frame.known.any() and np.count_nonzero(missing) >= _MIN_IN_SCENE:
            # a hold-out in such a scene is not representative of its holes
            samples.append(
                replace(
                    _sample_of(task, "generated", "ground-truth", method, 0),
                    difficulty_samples=None,
                    weight=_SCENE_WEIGHT,
                )
            )
    return samples


def _sample_of(task: Task, sensor: str, pattern: str, method: str, seed: int) -> Sample:
    labels = extract_blocks(task.frame) if method in BY_BLOCKS else np.zeros(task.frame.shape, np.int32)
    depth = np.asarray(METHODS[method](task.frame, labels))
    filled = filled_pixels(task.frame, depth)
    distance = np.asarray(cv2.distanceTransform((~task.frame.known).astype(np.uint8), cv2.DIST_L2, 5), np.float32)
    scored = np.flatnonzero(task.scored[filled])
    if scored.size > _SAMPLES:
        scored = np.sort(np.random.default_rng(seed).choice(scored, _SAMPLES, replace=False))
    completed, ground_truth = (
        depth[filled][scored].astype(np.float64),
        task.ground_truth[filled][scored].astype(np.float64),
    )
    return Sample(
        sensor,
        pattern,
        error_features(task.frame, depth, default_edges(task.frame).strength)[scored],
        completed,
        np.abs(completed - ground_truth) / completed,
        distance[filled][scored],
        difficulty_samples(task.frame),
    )


def calibrate(samples: Sequence[Sample], models: Sequence[ErrorModel]) -> list[Calibration]:
    """Return the share of errors within the expected error of each sample's model, for every pattern."""
    found = []
    for pattern in dict.fromkeys(sample.pattern for sample in samples):
        shares: list[float] = []
        twice: list[float] = []
        sparsifications: list[float] = []
        bins: list[list[float]] = [[] for _ in DISTANCE_BINS[1:]]
        for sample, model in zip(samples, models, strict=True):
            if sample.pattern != pattern:
                continue
            expected = sample.expected(model)
            shares.append(share_within(sample.shares, expected))
            twice.append(share_within(sample.shares, expected, 2))
            sparsifications.append(sparsification_error(sample.shares * sample.depths, expected * sample.depths))
            place = np.digitize(sample.distances, DISTANCE_BINS, right=True) - 1
            for number, values in enumerate(bins):
                inside = place == number
                if np.count_nonzero(inside) >= _MIN_IN_BIN:
                    values.append(share_within(sample.shares[inside], expected[inside]))
        found.append(
            Calibration(
                pattern,
                len(shares),
                float(np.mean(shares)),
                float(np.std(shares)),
                min(shares),
                max(shares),
                float(np.mean([CALIBRATED[0] <= share <= CALIBRATED[1] for share in shares])),
                float(np.mean(twice)),
                float(np.mean(sparsifications)),
                tuple(float(np.mean(values)) if values else float("nan") for values in bins),
            )
        )
    return found


def fit_without_own_sensor(samples: Sequence[Sample]) -> list[ErrorModel]:
    """Fit, for every sample, a model to the samples of other sensors; raise InputError if there is only one sensor."""
    if len({sample.sensor for sample in samples}) < 2:
        raise InputError("All frames are of one sensor. Add frames of other sensors to fit to.")
    fitted = {
        sensor: fit([sample for sample in samples if sample.sensor != sensor])
        for sensor in dict.fromkeys(sample.sensor for sample in samples)
    }
    return [fitted[sample.sensor] for sample in samples]


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Parse the arguments."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0], allow_abbrev=False)
    parser.add_argument(
        "--fit", nargs="+", default=[], metavar="FRAME", help="frames to fit to (default: keep the model)"
    )
    parser.add_argument("--check", nargs="+", default=[], metavar="FRAME", help="frames to check on")
    parser.add_argument("--method", choices=tuple(METHODS), default="best", help="completion method (default: best)")
    parser.add_argument(
        "--model", choices=tuple(MODELS), default=DEFAULT_MODEL, help=f"model to use (default: {DEFAULT_MODEL})"
    )
    parser.add_argument(
        "--pattern",
        choices=tuple(PATTERNS),
        nargs="+",
        default=["random", "areas"],
        help="patterns of the hold-outs (default: random areas)",
    )
    parser.add_argument(
        "--seed", type=int, nargs="+", default=[0], metavar="N", help="seeds of the hold-outs (default: 0)"
    )
    parser.add_argument(
        "--scenes", type=Path, metavar="FOLDER", help=f"also fit to the holes of {_SCENES} generated scenes in FOLDER"
    )
    parser.add_argument(
        "--others",
        action="store_true",
        help="also check each sensor's frames of --fit with a model fitted to the other sensors",
    )
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the models, with the fitted one, as Python")
    return parser.parse_args(arguments)


def take_samples(folders: Sequence[str], given: argparse.Namespace) -> list[Sample]:
    """Take the samples of frames under the chosen patterns and seeds."""
    return [
        take_sample(folder, pattern, given.method, seed)
        for folder in (find_frames(folders) if folders else [])
        for pattern in given.pattern
        for seed in given.seed
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Fit, check, print, and return the exit status."""
    given = parsed(arguments)
    try:
        fitted, checked = take_samples(given.fit, given), take_samples(given.check, given)
        if given.scenes is not None:
            fitted += take_scenes(given.scenes, _SCENES, given.method)
        others = fit_without_own_sensor(fitted) if given.others else []
    except IlfError as error:
        print("fit_expected_error: error:", error, file=sys.stderr)
        return 1
    model = fit(fitted) if fitted else MODELS[given.model]
    print(model)
    for name, samples in (("fitted", fitted), ("checked", checked)):
        print("\n".join(_lines(name, calibrate(samples, [model] * len(samples)))))
    if given.others:
        print("\n".join(_lines("fitted to others", calibrate(fitted, others))))
    if given.write:
        given.write.write_text(as_python({**MODELS, given.model: model}), encoding="utf-8")
    return 0


def as_python(models: dict[str, ErrorModel]) -> str:
    """The text of `ilf/completion/confidence/fitted.py` with these models."""
    lines = []
    for name, model in models.items():
        lines.append(f'    "{name}": ErrorModel(level={model.level}, usual={model.usual}, own={model.own}, curves=(\n')
        lines += [f"        ({knots}, {values}),\n" for knots, values in model.curves]
        lines.append("    )),\n")
    return _FITTED % "".join(lines)


def _lines(name: str, calibrations: Iterable[Calibration]) -> list[str]:
    limits = [f"{limit:g}" for limit in DISTANCE_BINS]
    bins = [f"{low}-{high} px" for low, high in pairwise(limits)]
    return [
        f"{name}, {line.pattern}: {line.mean:.1%} within, {line.frames} frames, spread {line.spread:.1%}, "
        f"{line.lowest:.1%} to {line.highest:.1%}, {line.calibrated:.0%} of them calibrated; "
        f"{line.twice:.1%} within twice; sparsification error {line.sparsification:.3f}; "
        + ", ".join(
            f"{text} {share:.1%}" for text, share in zip(bins, line.by_distance, strict=True) if np.isfinite(share)
        )
        for line in calibrations
    ]


if __name__ == "__main__":
    sys.exit(main())
