"""Exact surfaces, and frames of them from a simulated sensor with noise and a continuous defect."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from ...completion.interpolation import nearest
from ...data.frame import RGBDFrame
from ...data.parameters import PRESETS
from ...errors import IlfError
from ...evaluation.bench.methods import METHODS
from ...evaluation.metrics import measure_errors
from ...run.run import complete
from .experiment import OnProgress, Row, run_counted

_LIGHT = np.array([-0.4, -0.5, -0.77])
"""Direction to the light: above the camera and left of it (x right, y down, z forward)."""

_COLOUR, _AMBIENT = np.array([205.0, 190.0, 170.0]), 0.25


@dataclass(frozen=True)
class Surface:
    """A part of a sphere, a cylinder or a plane as a height field: depth over an even grid, in parallel projection.

    Attributes
    ----------
    kind : str
        "sphere", "plane", "upright cylinder" (bent along rows) or "lying cylinder" (bent along columns).
    shape : tuple of int
        Pixels (H, W).
    size : tuple of float
        Height and width [m]; they need not have the aspect ratio of the pixels.
    distance : float
        Depth of the nearest point [m].
    radius : float
        [m]; unused for a plane.
    """

    kind: str
    shape: tuple[int, int]
    size: tuple[float, float]
    distance: float
    radius: float

    @property
    def depth(self) -> NDArray[np.float64]:
        """Depth [m], shape (H, W)."""
        y, x = np.meshgrid(*(np.linspace(-0.5, 0.5, n) * s for n, s in zip(self.shape, self.size, strict=True)),
                           indexing="ij")  # fmt: skip
        squares = {
            "sphere": x**2 + y**2,
            "upright cylinder": x**2,
            "lying cylinder": y**2,
            "plane": np.zeros(self.shape),
        }[self.kind]
        return self.distance + self.radius - np.sqrt(self.radius**2 - squares)

    def describe(self) -> dict[str, Any]:
        """Name -> value, ready for JSON."""
        return asdict(self)


def shaded(surface: Surface) -> NDArray[np.uint8]:
    """Render a matt surface under one light, uint8 (H, W, 3)."""
    pitches = (size / (count - 1) for size, count in zip(surface.size, surface.shape, strict=True))
    slope_y, slope_x = np.gradient(surface.depth, *pitches)
    normals = np.stack([slope_x, slope_y, -np.ones(surface.shape)], axis=-1)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    light = np.clip(normals @ (_LIGHT / np.linalg.norm(_LIGHT)), 0, 1)
    brightness = _AMBIENT + (1 - _AMBIENT) * light
    return np.round(brightness[..., None] * _COLOUR).astype(np.uint8)


def continuous_defect(shape: tuple[int, int], rate: float, along: str) -> NDArray[np.bool_]:
    """One gap in the middle: adjacent whole columns ("x") or rows ("y") with this share of the pixels.

    At least one row or column is left on either side.
    """
    axis = {"y": 0, "x": 1}[along]
    count = shape[axis]
    wide = min(round(rate * count), count - 2)
    start = (count - wide) // 2
    inside = np.zeros(count, bool)
    inside[start : start + wide] = True
    return np.broadcast_to(inside[:, None] if along == "y" else inside, shape).copy()


def sensed(surface: Surface, noise: float, defect: NDArray[np.bool_], seed: int) -> RGBDFrame:
    """Return a frame of the surface with Gaussian noise of standard deviation `noise` [m], without the defect's depth.

    The noise depends only on the seed and its strength, so the known depth stays the same as the defect grows.
    """
    rng = np.random.default_rng([seed, round(1e6 * noise)])
    depth = surface.depth + noise * rng.standard_normal(surface.shape)
    return RGBDFrame(shaded(surface), np.where(defect, np.nan, depth), name=surface.kind)


# Iterative-inlier polynomial surface fitting, the peer of the paper's experiments on spheres and cylinders.

INLIER_DEVIATIONS = 2.5
"""Known pixels farther from the surface than this number of standard deviations are outliers."""

MAX_ROUNDS = 50

_NORMAL_MAD = 0.6745
"""Median absolute deviation of a normal distribution, in standard deviations."""


def inlier_polynomial(
    depth: NDArray[np.floating], mask: NDArray[np.bool_], order: int, deviations: float = INLIER_DEVIATIONS
) -> tuple[NDArray[np.float64], int]:
    """Fit a polynomial, drop outliers, and fit again until the inliers do not change.

    The scale of outliers is the median absolute deviation of all known pixels from the current surface, so outliers
    may become inliers as the surface improves. The terms are products of Legendre polynomials of positions in
    [-1, 1], made orthonormal over the known pixels once: whatever part of the block is known, the normal equations of
    every round are well conditioned.

    Parameters
    ----------
    depth : ndarray of float, shape (h, w)
        Depth [m], NaN = missing.
    mask : ndarray of bool, shape (h, w)
        The block's pixels.
    order : int
        Largest total power of row and column.
    deviations : float
        Limit of outliers in standard deviations; infinity keeps every point.

    Returns
    -------
    surface : ndarray of float64, shape (h, w)
        Depth [m] everywhere; NaN if the known pixels do not determine the polynomial.
    rounds : int
        Number of fits.
    """
    known = mask & np.isfinite(depth)
    terms = _terms(known.shape, order)
    values = depth[known].astype(np.float64)
    basis = terms[known]
    if len(basis) < basis.shape[1] or np.linalg.matrix_rank(basis.T @ basis) < basis.shape[1]:
        return np.full(depth.shape, np.nan), 0
    orthonormal, triangle = np.linalg.qr(basis)
    inliers = np.ones(values.size, bool)
    rounds = 0
    while True:
        rounds += 1
        kept = orthonormal[inliers]
        weights = np.linalg.solve(kept.T @ kept, kept.T @ values[inliers])
        off = np.abs(values - orthonormal @ weights)
        scale = float(np.median(off)) / _NORMAL_MAD
        # rounding errors of an exact fit are not outliers
        now = off <= (max(deviations * scale, 1e-9) if scale else 1e-9)
        if rounds == MAX_ROUNDS or np.array_equal(now, inliers):
            break
        inliers = now
    return terms @ np.linalg.solve(triangle, weights), rounds


def _terms(shape: tuple[int, int], order: int) -> NDArray[np.float64]:
    """The terms at every pixel, shape (h, w, number of terms)."""
    y, x = (legendre.legvander((2 * np.arange(size) + 1) / size - 1, order) for size in shape)
    return np.stack([y[:, None, a] * x[None, :, b] for a in range(order + 1) for b in range(order + 1 - a)], axis=-1)


# Methods on exact surfaces with a growing defect.

_POLYNOMIAL = "polynomial-"

ORDERS = (1, 2, 3, 4)
"""Orders of the polynomials that the paper's method is compared with."""

POLYNOMIALS = tuple(f"{_POLYNOMIAL}{order}" for order in ORDERS)


@dataclass(frozen=True)
class Case:
    """One surface with one defect.

    Attributes
    ----------
    surface : Surface
    noise : float
        Standard deviation of the known depth [m].
    rate : float
        Requested defect rate, 0-1.
    along : str
        Direction in which the defect grows: "x" or "y".
    mode : str
        Mode of the presets: "fill", or "fill+denoise" to evaluate the whole block.
    seed : int
    """

    surface: Surface
    noise: float
    rate: float
    along: str
    mode: str
    seed: int


def run_case(case: Case, methods: Sequence[str]) -> list[Row]:
    """Return one row per method.

    ACC, PRS and RMSE [mm] are those of the whole block; with the prefix "hole_", those of its defective area, None
    where nothing is missing. Pixels that a method does not fill count with their nearest known depth; "covered" is the
    share of the block that has depth without this.
    """
    frame = given(case)
    return [_row(case, name, frame, *_completed(case, name, frame)) for name in methods]


def run_cases(cases: Sequence[Case], methods: Sequence[str], jobs: int, on_progress: OnProgress) -> list[Row]:
    """Return the rows of all cases, in their order."""
    parts = run_counted(run_case, [(case, methods) for case in cases], jobs, on_progress)
    return [row for part in parts for row in part]


def completed(case: Case, method: str) -> tuple[RGBDFrame, NDArray[np.floating]]:
    """Return the method's input, and its result [m] with remaining holes filled with the nearest known depth."""
    frame = given(case)
    depth, _, _ = _completed(case, method, frame)
    return frame, closed(depth, frame)


def given(case: Case) -> RGBDFrame:
    """Return the frame of the surface with the case's noise and defect."""
    defect = continuous_defect(case.surface.shape, case.rate, case.along)
    return sensed(case.surface, case.noise, defect, case.seed)


def _completed(case: Case, name: str, frame: RGBDFrame) -> tuple[NDArray[np.floating], float, str]:
    """Return depth, seconds, and the reason of a failure ("" if none); a failed method fills nothing."""
    labels = np.ones(frame.shape, np.int32)
    failure = ""
    started = time.perf_counter()
    try:
        depth = _depth(name, frame, labels, case.mode)
    except (IlfError, MemoryError) as error:
        depth, failure = frame.depth, str(error) or type(error).__name__
    return depth, time.perf_counter() - started, failure


def closed(depth: NDArray[np.floating], frame: RGBDFrame) -> NDArray[np.floating]:
    """Fill the holes of depth [m] with the nearest known depth."""
    return np.where(np.isfinite(depth) & (depth > 0), depth, nearest(frame))


def _depth(name: str, frame: RGBDFrame, labels: NDArray[np.int32], mode: str) -> NDArray[np.floating]:
    if name in PRESETS:
        return complete(frame, labels, PRESETS[name].replace(mode=mode), threads=1).depth
    if name in POLYNOMIALS:
        surface, _ = inlier_polynomial(frame.depth, labels > 0, int(name.removeprefix(_POLYNOMIAL)))
        return np.where(frame.known, frame.depth, surface) if mode == "fill" else surface
    return METHODS[name].run(frame, labels)


def _row(case: Case, name: str, frame: RGBDFrame, depth: NDArray[np.floating], seconds: float, failure: str) -> Row:
    ground_truth, dense = case.surface.depth, closed(depth, frame)
    whole = measure_errors(dense, ground_truth, np.ones(ground_truth.shape, bool))
    hole = None if frame.known.all() else measure_errors(dense, ground_truth, ~frame.known)
    return {
        "method": name,
        "surface": case.surface.kind,
        "radius_m": case.surface.radius,
        "noise_mm": 1000 * case.noise,
        "defect_rate": frame.missing_share,
        "acc_mm": 1000 * whole.acc,
        "prs_mm": 1000 * whole.prs,
        "rmse_mm": 1000 * whole.rmse,
        "hole_acc_mm": None if hole is None else 1000 * hole.acc,
        "hole_prs_mm": None if hole is None else 1000 * hole.prs,
        "hole_rmse_mm": None if hole is None else 1000 * hole.rmse,
        "covered": float(np.mean(np.isfinite(depth) & (depth > 0))),
        "seconds": seconds,
        "failure": failure,
    }
