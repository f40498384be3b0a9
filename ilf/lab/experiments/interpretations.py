"""Interpretations of the paper's text: values for everything that it leaves open about the filter."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...data.frame import RGBDFrame
from ...data.parameters import PRESETS, Parameters
from ...evaluation.metrics import measure_errors
from ...run.run import complete
from .plots import EQUAL_SHARE
from .surfaces import INLIER_DEVIATIONS, ORDERS, Case, Surface, closed, given, inlier_polynomial

UNKNOWNS: dict[str, tuple[Any, ...]] = {
    "start": ("mean", "1 / longest", "1 / shortest"),
    "step": (0.5, 1.0, 2.0),
    "wavelength_px": (15.0, 60.0),
    "mean": ("left in", "taken off"),
    "padding": (1.0, 2.0),
    "colour": ("weighted", "not used"),
}
"""Open points of the filter: the fields of `Interpretation` with the tried values."""

NAMES = {
    "start": "start",
    "step": "step [basebands]",
    "wavelength_px": "shortest wave [px]",
    "mean": "mean depth",
    "padding": "padding",
    "colour": "colour spectrum",
}
"""Labels of these fields."""


@dataclass(frozen=True)
class Interpretation:
    """One interpretation of the paper's text about the filter.

    Attributes
    ----------
    start : str
        First cut-off frequency: the mean alone, or 1 / longest or 1 / shortest length of the block.
    step : float
        Growth of the cut-off frequency per enlargement, in basebands.
    wavelength_px : float
        Shortest wave of the last pass band, in pixels of the full grid.
    mean : str
        Whether the mean of the known depth is subtracted before.
    padding : float
        Side of the padded grid, in sides of the block.
    colour : str
        Whether the colour spectrum weights the first iterations.
    """

    start: str
    step: float
    wavelength_px: float
    mean: str
    padding: float
    colour: str

    def parameters(self, shape: tuple[int, int], every: int) -> Parameters:
        """Parameters of `paper` under this interpretation, for a block of this shape, subsampled by `every`."""
        paper = PRESETS["paper"]
        starts = {"mean": 0.0, "1 / longest": 1.0, "1 / shortest": max(shape) / min(shape)}
        return paper.replace(
            mode="fill+denoise",
            staged_start=starts[self.start],
            stage_step=self.step,
            shortest_wavelength=max(self.wavelength_px / every, 2.0),
            centred=self.mean == "taken off",
            padding=self.padding,
            rgb_iterations=paper.rgb_iterations if self.colour == "weighted" else 0,
        )


PRESET = Interpretation("mean", 0.5, 15.0, "left in", 2.0, "weighted")
"""The interpretation that the preset `paper` follows."""


def to_text(values: dict[str, Any], names: Iterable[str] = UNKNOWNS) -> str:
    """Describe values in words, such as "start 1 / shortest, mean depth taken off"."""
    return ", ".join(f"{NAMES[name]} {_shown(values[name])}" for name in names)


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)


# Whether one interpretation of the text reproduces the printed results of Fig. 4 to 6 on a cylinder or sphere.

PAPER_PRS, PAPER_RATE = 10.28, 0.8022
"""PRS of Fig. 4 [mm], and its defect rate."""

CYLINDER_WON, SPHERE_WON = 0.4688, 0.4277
"""Defect rates up to which the filter wins in Fig. 6 and in Fig. 5."""

PIXELS = {"480 x 480": (480, 480), "960 x 540": (540, 960)}
LITTLE_NOISE, MORE_NOISE, SPHERE_NOISES = 0.0015, 0.0065, (0.0, 0.065)

EVALUATED = {
    "block": ("whole", INLIER_DEVIATIONS),
    "hole": ("hole", INLIER_DEVIATIONS),
    "PRS": ("prs", INLIER_DEVIATIONS),
    "block, plain fit": ("whole", math.inf),
    "hole, plain fit": ("hole", math.inf),
}
"""Ways to evaluate the claims: the error measure, and the limit of the polynomials' outliers in deviations."""

MIN_ORDER = 2
"""Minimum order that counts as a win: a plane, order 1, fits none of the surfaces."""

_DISTANCES = {"cylinder": 1.5, "sphere": 2.0}
_SPHERE_PIXELS, _SPHERE_SIZE = (540, 960), (1.2, 2.6)
_CENTIMETRES = (5, 10, 20, 40, 80)
_CYLINDER_RATES, _SPHERE_RATES = (0.0, 0.2, 0.4, CYLINDER_WON), (0.0, 0.15, 0.3, SPHERE_WON)


@dataclass(frozen=True)
class Errors:
    """Errors of a completed surface [mm]: RMSE over the whole block and over its hole, mean and deviation."""

    whole: float
    hole: float
    acc: float
    prs: float


def cylinder(pixels: str, axis: str, seen: float, radius: float, every: int) -> Surface:
    """A cylinder of which the share `seen` of the diameter is visible, on square pixels, subsampled by `every`."""
    height, width = (count // every for count in PIXELS[pixels])
    across = 2 * radius * seen
    size = (across * height / width, across) if axis == "upright" else (across, across * width / height)
    return Surface(f"{axis} cylinder", (height, width), size, _DISTANCES["cylinder"], radius)


def sphere(radius: float, every: int) -> Surface:
    """The part of a sphere that is visible in the paper."""
    height, width = (count // every for count in _SPHERE_PIXELS)
    return Surface("sphere", (height, width), _SPHERE_SIZE, _DISTANCES["sphere"], radius)


def case_of(surface: Surface, noise: float, rate: float, every: int, seed: int) -> Case:
    """A defect as in the paper, along the cylinder's vertical or the sphere's x. `noise` [m] is that of a pixel of the
    full grid; it is reduced to that of the mean over the pixels that one subsampled pixel represents."""
    along = "x" if surface.kind == "sphere" else "y"
    return Case(surface, noise / every, rate, along, "fill+denoise", seed)


def matches_paper_prs(prs: float) -> bool:
    """Return whether a PRS [mm] is about that of Fig. 4."""
    return abs(prs - PAPER_PRS) <= EQUAL_SHARE * PAPER_PRS


def radius_of_fig_4(prs: Callable[[float], float]) -> float:
    """Find the largest radius [m], in whole centimetres, with about the PRS [mm] of Fig. 4; if none, the nearest.

    A few radii are tried, then radii between neighbours that bracket the PRS.
    """
    tried = {centimetres: prs(centimetres / 100) for centimetres in _CENTIMETRES}
    for low, high in itertools.pairwise(_CENTIMETRES):
        while (tried[low] - PAPER_PRS) * (tried[high] - PAPER_PRS) < 0 and high - low > 1:
            middle = round(math.sqrt(low * high)) if high - low > 2 else low + 1
            tried[middle] = prs(middle / 100)
            if (tried[low] - PAPER_PRS) * (tried[middle] - PAPER_PRS) < 0:
                high = middle
            else:
                low = middle
    fitting = [centimetres for centimetres, value in tried.items() if matches_paper_prs(value)]
    nearest = min(tried, key=lambda centimetres: abs(math.log(tried[centimetres] / PAPER_PRS)))
    return max(fitting, default=nearest) / 100


def orders_beaten(
    interpretation: Interpretation, surface: Surface, noise: float, every: int, seed: int
) -> dict[str, int]:
    """Way to evaluate -> largest k such that polynomials of orders 1 to k are worse at all rates up to the printed one.

    If no way reaches `MIN_ORDER`, smaller rates are skipped.
    """
    beaten = dict.fromkeys(EVALUATED, max(ORDERS))
    for rate in reversed(_SPHERE_RATES if surface.kind == "sphere" else _CYLINDER_RATES):
        case = case_of(surface, noise, rate, every, seed)
        mine = filtered(interpretation, case, every)
        for evaluated, (error, deviations) in EVALUATED.items():
            if error == "hole" and not rate:
                continue
            losses = (
                order
                for order in range(1, beaten[evaluated] + 1)
                if getattr(mine, error) >= getattr(fitted(case, order, deviations), error)
            )
            beaten[evaluated] = next(losses, beaten[evaluated] + 1) - 1
        if max(beaten.values()) < MIN_ORDER:
            break
    return beaten


def filtered(interpretation: Interpretation, case: Case, every: int) -> Errors:
    """Return the errors of the filter under an interpretation."""
    return _filtered(interpretation.parameters(case.surface.shape, every), case)


@lru_cache(maxsize=4096)  # on a square grid some interpretations give the same parameters
def _filtered(parameters: Parameters, case: Case) -> Errors:
    frame = given(case)
    depth = complete(frame, np.ones(frame.shape, np.int32), parameters, threads=1).depth
    return _measured(depth, frame, case.surface)


@lru_cache(maxsize=4096)  # shared by all interpretations
def fitted(case: Case, order: int, deviations: float) -> Errors:
    """Return the errors of a polynomial whose outliers are more than `deviations` off."""
    frame = given(case)
    depth, _ = inlier_polynomial(frame.depth, np.ones(frame.shape, bool), order, deviations)
    return _measured(depth, frame, case.surface)


def _measured(depth: NDArray[np.floating], frame: RGBDFrame, surface: Surface) -> Errors:
    ground_truth, dense, missing = surface.depth, closed(depth, frame), ~frame.known
    whole = measure_errors(dense, ground_truth, np.ones(ground_truth.shape, bool))
    hole = measure_errors(dense, ground_truth, missing).rmse if missing.any() else math.nan
    return Errors(1000 * whole.rmse, 1000 * hole, 1000 * whole.acc, 1000 * whole.prs)
