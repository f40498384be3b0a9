"""Methods on exactly known surfaces whose defect grows."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..bench.methods import METHODS
from ..bench.peers.interpolation import nearest
from ..completion import complete
from ..errors import IlfError
from ..frame import RGBDFrame
from ..metrics import measure_errors
from ..parameters import PRESETS
from .experiment import OnProgress, Row
from .inlier_polynomial import inlier_polynomial
from .surfaces import Surface, continuous_defect, sensed
from .units import run_counted

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
        Defect rate asked for, 0-1.
    along : str
        Direction in which the defect grows: "x" or "y".
    mode : str
        In which the presets run: "fill", or "fill+denoise" where the whole block is to be judged.
    seed : int
    """

    surface: Surface
    noise: float
    rate: float
    along: str
    mode: str
    seed: int


def run_case(case: Case, methods: Sequence[str]) -> list[Row]:
    """One row per method.

    ACC, PRS and RMSE [mm] are those of the whole block; those whose names begin with "hole_" of its defective area,
    None where nothing is missing. What a method leaves open counts with its nearest known depth; "covered" is the
    share of the block that has depth without that.
    """
    frame = given(case)
    return [_row(case, name, frame, *_completed(case, name, frame)) for name in methods]


def run_cases(cases: Sequence[Case], methods: Sequence[str], jobs: int, on_progress: OnProgress) -> list[Row]:
    """The rows of all cases, in their order."""
    parts = run_counted(run_case, [(case, methods) for case in cases], jobs, on_progress)
    return [row for part in parts for row in part]


def completed(case: Case, method: str) -> tuple[RGBDFrame, NDArray[np.floating]]:
    """What the method is given, and what it makes of it [m], holes closed with the nearest known depth."""
    frame = given(case)
    depth, _, _ = _completed(case, method, frame)
    return frame, closed(depth, frame)


def given(case: Case) -> RGBDFrame:
    """The surface as a sensor sees it, with the case's noise and defect."""
    defect = continuous_defect(case.surface.shape, case.rate, case.along)
    return sensed(case.surface, case.noise, defect, case.seed)


def _completed(case: Case, name: str, frame: RGBDFrame) -> tuple[NDArray[np.floating], float, str]:
    """Depth, seconds, and why the method failed if it did: then it has filled nothing."""
    labels = np.ones(frame.shape, np.int32)
    failure = ""
    started = time.perf_counter()
    try:
        depth = _depth(name, frame, labels, case.mode)
    except (IlfError, MemoryError) as error:
        depth, failure = frame.depth, str(error) or type(error).__name__
    return depth, time.perf_counter() - started, failure


def closed(depth: NDArray[np.floating], frame: RGBDFrame) -> NDArray[np.floating]:
    """Depth [m] whose holes have the nearest known depth."""
    return np.where(np.isfinite(depth) & (depth > 0), depth, nearest(frame))


def _depth(name: str, frame: RGBDFrame, labels: NDArray[np.int32], mode: str) -> NDArray[np.floating]:
    if name in PRESETS:
        return complete(frame, labels, PRESETS[name].replace(mode=mode), threads=1).depth
    if name in POLYNOMIALS:
        surface, _ = inlier_polynomial(frame.depth, labels > 0, int(name.removeprefix(_POLYNOMIAL)))
        return np.where(frame.known, frame.depth, surface) if mode == "fill" else surface
    return METHODS[name].run(frame, labels)


def _row(case: Case, name: str, frame: RGBDFrame, depth: NDArray[np.floating], seconds: float, failure: str) -> Row:
    truth, dense = case.surface.depth, closed(depth, frame)
    whole = measure_errors(dense, truth, np.ones(truth.shape, bool))
    hole = None if frame.known.all() else measure_errors(dense, truth, ~frame.known)
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
