"""Fit and check the expected error on hidden depth: `python -m ilf.lab.bench.calibration`."""

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

from ..._runtime.files import write_bytes
from ...completion.confidence import fitted as confidence
from ...completion.confidence.expected_error import DEFAULT_MODEL, difficulty_of, own_test
from ...completion.confidence.features import FEATURES, FLOOR, error_features, filled_pixels, usual_edges
from ...completion.confidence.fitted import MODELS
from ...completion.confidence.model import WITHIN, WITHIN_TWICE, Curve, ErrorModel, unusual, wideness
from ...data.frame import RGBDFrame
from ...errors import IlfError, InputError
from ...evaluation.metrics import share_within, sparsification_error
from ...segmentation.extraction import extract_blocks
from .frames import find_frames, load_bench_frame
from .methods import METHODS
from .patterns import Task, make_task
from .results import CALIBRATED

# Fit a model of the expected error to errors that are known.

Values = NDArray[np.float64]

_KNOTS = 6
"""Knots of every curve, at equal shares of the pixels."""

_OUTERMOST = 0.01
"""Share of the pixels that lies beyond the first knot, and beyond the last."""

_EITHER_WAY = {"depth", "edge", "edge near", "edges around"}
"""Features with which errors may grow or fall; with the others they grow."""

_STRAIGHT, _LEVEL = 1e-3, 1e-4
"""What it costs curves to bend, and to rise or fall."""

_SMOOTHINGS = (0.5, 0.1)
"""Widths over which the kink of the pinball loss is rounded, one after the other."""

_PROMISES = (1.0, WITHIN, 1.0), (2.0, WITHIN_TWICE, 0.3)
"""How many times the expected error, the share of errors that is to lie within that, and how much that matters."""

_DECIMALS = 3


@dataclass(frozen=True, eq=False)
class Sample:
    """Hidden pixels of one frame under one pattern, as a method has filled them.

    Attributes
    ----------
    sensor, pattern : str
        What measured the frame (`BenchFrame.sensor`), and how depth was hidden.
    features : ndarray of float, shape (N, 13)
        See `ilf.completion.confidence.features.error_features`.
    depths : ndarray of float64, shape (N,)
        Completed depth [m].
    shares : ndarray of float64, shape (N,)
        |error| / completed depth.
    distances : ndarray of float32, shape (N,)
        To the nearest known depth [px].
    own_test : (ndarray, ndarray) or None
        See `ilf.completion.confidence.expected_error.own_test`.
    weight : float
        How much it counts when a model is fitted.
    """

    sensor: str
    pattern: str
    features: NDArray[np.floating]
    depths: Values
    shares: Values
    distances: NDArray[np.float32]
    own_test: tuple[NDArray[np.floating], NDArray[np.floating]] | None = None
    weight: float = 1.0

    def expected(self, model: ErrorModel) -> Values:
        """The expected errors, as shares of depth."""
        difficulty = None if self.own_test is None else difficulty_of(*self.own_test, model)
        return model.shares(self.features, difficulty)


def fit(samples: Sequence[Sample]) -> ErrorModel:
    """The model of least loss.

    It is the pinball loss of the logarithm's 68 % quantile and, of the same number's double, of its 95 % quantile: one
    number for both of what one and two standard deviations promise, the first of which matters more. The curves come
    first, then what frames have of their own.
    """
    features = np.concatenate([sample.features for sample in samples]).astype(np.float64)
    logarithms = np.log(np.maximum(np.concatenate([sample.shares for sample in samples]), FLOOR))
    weights = np.concatenate([np.full(len(sample.shares), sample.weight / len(sample.shares)) for sample in samples])
    weights /= weights.sum()
    model = _fit_curves(features, logarithms, weights)
    above = [np.nan if sample.own_test is None else difficulty_of(*sample.own_test, model) for sample in samples]
    if not np.isfinite(above).any():
        return model
    usual = float(np.nanmedian(above))
    own = np.concatenate(
        [
            wideness(sample.features) * unusual(np.nan_to_num(value, nan=usual), usual)
            for sample, value in zip(samples, above, strict=True)
        ]
    )
    left = logarithms - model.logarithms(features)
    found = minimize_scalar(
        lambda factor: _loss(left - factor * own, weights, _SMOOTHINGS[-1])[0], bounds=(0.0, 1.5), method="bounded"
    )
    return replace(model, usual=round(usual, _DECIMALS), own=round(float(found.x), _DECIMALS))


def _loss(left: Values, weights: Values, width: float) -> tuple[float, Values]:
    """Loss of what the logarithms have above the expected ones, and how it changes with each of the latter."""
    value, slopes = 0.0, np.zeros_like(left)
    for times, share, matters in _PROMISES:
        miss = left - np.log(times)
        rounded = np.hypot(miss, width)
        value += matters * float(weights @ ((share - 0.5) * miss + rounded / 2))
        slopes -= matters * weights * (share - 0.5 + miss / rounded / 2)
    return value, slopes


def _fit_curves(features: Values, logarithms: Values, weights: Values) -> ErrorModel:
    """A curve is the running sum of its steps from knot to knot, the first value being 0."""
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
        bounds += [(0.0, 0.0), *[(None if name in _EITHER_WAY else 0.0, None)] * (len(of_it) - 1)]
    for width in _SMOOTHINGS:
        constants = minimize(
            loss, constants, (width,), "L-BFGS-B", jac=True, bounds=bounds, options={"maxiter": 300, "maxfun": 600}
        ).x
    curves = tuple(
        Curve(_rounded(of_it), _rounded(np.cumsum(constants[1:][part])))
        for of_it, part in zip(knots, parts, strict=True)
    )
    return ErrorModel(round(float(constants[0]), _DECIMALS), curves)


def _hats(column: Values, knots: Values) -> csr_array:
    """How much every knot's value counts at every pixel, (N, knots)."""
    if len(knots) == 1:
        return csr_array(np.ones((len(column), 1)))
    place = np.clip(np.searchsorted(knots, column, side="right") - 1, 0, len(knots) - 2)
    beyond = np.clip((column - knots[place]) / np.diff(knots)[place], 0, 1)
    rows = np.arange(len(column))
    entries = np.concatenate([1 - beyond, beyond])
    return csr_array((entries, (np.tile(rows, 2), np.concatenate([place, place + 1]))), (len(column), len(knots)))


def _rounded(values: Values) -> tuple[float, ...]:
    return tuple(round(float(value), _DECIMALS) for value in values)


PATTERNS_USED = ("random", "areas")
DISTANCE_BINS = (0.0, 2.0, 5.0, 15.0, 50.0, np.inf)
"""Limits [px] between the distances to known depth that are reported one by one."""

_SAMPLES = 2000
"""Pixels taken of every frame and pattern."""

_LEAST_IN_BIN = 50
_LEAST_IN_SCENE = 200
"""Missing pixels that a generated scene must have to count."""

_SCENES, _SCENE_WEIGHT = 40, 0.25
"""So many generated scenes are taken, and each counts so much beside a frame under one pattern."""

_FITTED = '''"""The laws of the expected error, written by `python -m ilf.lab.bench.calibration --fit ... --write`."""

from .model import Curve, ErrorModel

# fmt: off
MODELS = {
%s}
"""Low-pass filter, as in `Parameters.filter`, -> how its errors grow."""
'''


@dataclass(frozen=True)
class Calibration:
    """How many errors lie within the expected one, under one pattern.

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
        Mean over frames of `ilf.judgement.sparsification_error`.
    by_distance : tuple of float
        Mean over frames in each of `DISTANCE_BINS`, NaN where there is none.
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
    """Hide depth of a frame, complete it, and take pixels of what was hidden.

    Raises
    ------
    InputError, FormatError
        If the frame cannot be read, or nothing of it can be hidden.
    """
    frame = load_bench_frame(folder)
    return _sample_of(make_task(frame, pattern, seed), frame.sensor, pattern, method, seed)


def take_scenes(folder: Path, count: int, method: str) -> list[Sample]:
    """Complete what simulated sensors have not seen of generated scenes, and take pixels of that.

    Holes that are made for a test lie anywhere; those that sensors leave lie at jumps, and on things that are black,
    shiny or bright as a whole. Of generated scenes their true depth is known.

    Parameters
    ----------
    folder : Path
        Of pictures that `assets/samples/make_scenes.py` has made.
    count : int
        So many of them are taken, evenly.

    Raises
    ------
    InputError
        If there are none.
    """
    paths = sorted(folder.glob("*.npz"))
    if not paths:
        raise InputError(f"There is no picture (*.npz) in {folder}.")
    samples = []
    for path in paths[:: max(len(paths) // count, 1)][:count]:
        with np.load(path) as arrays:
            frame = RGBDFrame(arrays["rgb"], arrays["measured"], name=f"scene {path.stem}")
            missing = ~frame.known & np.isfinite(arrays["exact"])
            task = Task(frame, arrays["exact"], missing)
        if frame.known.any() and np.count_nonzero(missing) >= _LEAST_IN_SCENE:
            # what is hidden from such a scene says nothing of its holes
            samples.append(
                replace(_sample_of(task, "generated", "truth", method, 0), own_test=None, weight=_SCENE_WEIGHT)
            )
    return samples


def _sample_of(task: Task, sensor: str, pattern: str, method: str, seed: int) -> Sample:
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
        sensor,
        pattern,
        error_features(task.frame, depth, usual_edges(task.frame))[scored],
        completed,
        np.abs(completed - truth) / completed,
        distance[filled][scored],
        own_test(task.frame),
    )


def calibrate(samples: Sequence[Sample], models: Sequence[ErrorModel]) -> list[Calibration]:
    """What share of the samples' errors lies within those of each one's model, for every pattern among them."""
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
                if np.count_nonzero(inside) >= _LEAST_IN_BIN:
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


def fit_to_others(samples: Sequence[Sample]) -> list[ErrorModel]:
    """For every sample, a model that is fitted to those of other sensors; raises InputError if there is but one."""
    if len({sample.sensor for sample in samples}) < 2:
        raise InputError("All frames are of one sensor, so that there are no others to fit to.")
    fitted = {
        sensor: fit([sample for sample in samples if sample.sensor != sensor])
        for sensor in dict.fromkeys(sample.sensor for sample in samples)
    }
    return [fitted[sample.sensor] for sample in samples]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m ilf.lab.bench.calibration",
        description="Fit the expected error to hidden depth of some frames and check it on others.",
        allow_abbrev=False,
    )
    parser.add_argument("--fit", nargs="+", default=[], metavar="FOLDER", help="frames to fit to; none: keep the model")
    parser.add_argument("--check", nargs="+", default=[], metavar="FOLDER", help="frames to check on")
    parser.add_argument("--method", choices=tuple(METHODS), default="best", help="what completes (default: best)")
    parser.add_argument(
        "--model", choices=tuple(MODELS), default=DEFAULT_MODEL, help=f"which is meant (default: {DEFAULT_MODEL})"
    )
    parser.add_argument(
        "--seed", type=int, nargs="+", default=[0], metavar="N", help="what the hidden pixels follow from (default: 0)"
    )
    parser.add_argument(
        "--scenes", type=Path, metavar="FOLDER", help=f"fit to the holes of {_SCENES} generated scenes in it as well"
    )
    parser.add_argument(
        "--others",
        action="store_true",
        help="also check every sensor's frames of --fit by what is fitted to the others",
    )
    parser.add_argument(
        "--write",
        action="store_true",
        help="write what is fitted into the installed ilf/completion/confidence/fitted.py",
    )
    given = parser.parse_args(arguments)
    try:
        fitted, checked = (
            [
                take_sample(folder, pattern, given.method, seed)
                for folder in (find_frames(folders) if folders else [])
                for pattern in PATTERNS_USED
                for seed in given.seed
            ]
            for folders in (given.fit, given.check)
        )
        if given.scenes is not None:
            fitted += take_scenes(given.scenes, _SCENES, given.method)
        others = fit_to_others(fitted) if given.others else []
    except IlfError as error:
        print("calibration: error:", error, file=sys.stderr)
        return 1
    model = fit(fitted) if fitted else MODELS[given.model]
    print(model)
    for name, samples in (("fitted", fitted), ("checked", checked)):
        print("\n".join(_lines(name, calibrate(samples, [model] * len(samples)))))
    if given.others:
        print("\n".join(_lines("fitted to others", calibrate(fitted, others))))
    if given.write:
        write_models({**MODELS, given.model: model})
    return 0


def write_models(models: dict[str, ErrorModel]) -> None:
    """Into the file that the models come from."""
    lines = []
    for name, model in models.items():
        lines.append(f'    "{name}": ErrorModel(level={model.level}, usual={model.usual}, own={model.own}, curves=(\n')
        lines += [f"        Curve({curve.knots}, {curve.values}),\n" for curve in model.curves]
        lines.append("    )),\n")
    write_bytes(Path(confidence.__file__).with_name("fitted.py"), (_FITTED % "".join(lines)).encode())


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
