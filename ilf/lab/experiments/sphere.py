"""The paper's sphere, Fig. 5: the filter against polynomials, with and without noise."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from .cylinder import compare_wins
from .experiment import (
    METHOD_PRESETS,
    Comparison,
    Drawing,
    Experiment,
    OnProgress,
    Result,
    Row,
    Settings,
    preset_parameters,
)
from .plots import against_rate, legend, log_millimetres, mark_rate, panels
from .surfaces import INLIER_DEVIATIONS, POLYNOMIALS, Case, Surface, completed, run_cases

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SURFACE = Surface("sphere", (540, 960), (1.2, 2.6), 2.0, 2.0)
_QUICK_SHAPE = (108, 192)

_PAPER_WON = 0.4277
_CLOUD_RATE = 0.51

_RATES = (0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.4277, 0.47, 0.51, 0.55, 0.6)
_QUICK_RATES = (0.0, 0.4277, 0.51)
_NOISES = (0.0, 0.065)

_METHODS = (*METHOD_PRESETS, *POLYNOMIALS)
_CLOUD_METHODS = (*METHOD_PRESETS, POLYNOMIALS[-1])
_CLOUD_GRID = 60, 110
"""Grid of points in the figure of the cloud."""


def _run(settings: Settings, on_progress: OnProgress) -> Result:
    surface = replace(_SURFACE, shape=_QUICK_SHAPE) if settings.quick else _SURFACE
    rates = _QUICK_RATES if settings.quick else _RATES
    cases = [Case(surface, noise, rate, "x", "fill+denoise", settings.seed) for noise in _NOISES for rate in rates]
    rows = run_cases(cases, _METHODS, settings.jobs, on_progress)
    cloud_case = Case(surface, _NOISES[-1], _CLOUD_RATE, "x", "fill+denoise", settings.seed)
    return Result(
        rows=rows,
        parameters={
            "surface": surface.describe(),
            "noises_mm": [1000 * noise for noise in _NOISES],
            "defect": "whole columns around the middle",
            "presets": preset_parameters(mode="fill+denoise"),
            "polynomial_inlier_deviations": INLIER_DEVIATIONS,
            "chosen": f"The paper does not give the sphere's radius; here {_SURFACE.radius:g} m, nearest point at "
            f"{_SURFACE.distance:g} m, in parallel projection.",
        },
        notes=[
            "ACC and PRS are those of the whole block in the mode fill+denoise, against the surface without noise; "
            "the table also lists those of the defective area alone (hole_...).",
        ],
        tables={"cloud": _cloud(cloud_case)},
    )


def _cloud(case: Case) -> list[Row]:
    """Points of the surface on a coarse grid: position, input depth and completed depth [m]."""
    steps = tuple(max(1, size // count) for size, count in zip(case.surface.shape, _CLOUD_GRID, strict=True))
    ys, xs = (np.linspace(-0.5, 0.5, n) * s for n, s in zip(case.surface.shape, case.surface.size, strict=True))
    rows: list[Row] = []
    for method in _CLOUD_METHODS:
        frame, depth = completed(case, method)
        for i in range(0, frame.shape[0], steps[0]):
            for j in range(0, frame.shape[1], steps[1]):
                known = bool(frame.known[i, j])
                rows.append({
                    "method": method,
                    "x_m": float(xs[j]),
                    "y_m": float(ys[i]),
                    "given_m": float(frame.depth[i, j]) if known else None,
                    "depth_m": float(depth[i, j]),
                    "missing": not known,
                })  # fmt: skip
    return rows


def _draw(result: Result) -> list[Drawing]:
    figure, axes = panels(2, 2)
    for column, noise in enumerate(_NOISES):
        rows = [row for row in result.rows if row["noise_mm"] == 1000 * noise]
        for line, (value, label) in enumerate((("acc_mm", "|ACC| [mm]"), ("prs_mm", "PRS [mm]"))):
            ax = axes[2 * line + column]
            against_rate(ax, rows, _METHODS, value, size=True)
            log_millimetres(ax)
            ax.set_ylabel(label)
            if line == 0:
                ax.set_title(f"noise {1000 * noise:g} mm", fontsize=10)
            mark_rate(ax, _PAPER_WON, "paper: ILF wins up to here")
    legend(figure, axes[0], columns=4)
    curves = Drawing(
        "curves",
        "Mean error (absolute ACC) and standard deviation (PRS) over the whole block against the defect rate; defect "
        "growing along x.",
        figure,
    )
    return [curves, _draw_cloud(result.tables["cloud"])]


def _draw_cloud(rows: list[Row]) -> Drawing:
    methods = list(dict.fromkeys(row["method"] for row in rows))
    # seen from above, every column of points falls on one place, which shows the section of the sphere
    figure, axes = panels(1, len(methods) + 1, width=2.5, height=2.9)
    given = [row for row in rows if row["method"] == methods[0] and not row["missing"]]
    _points(axes[0], "given", [(row["x_m"], row["y_m"], row["given_m"]) for row in given], "#555555")
    for ax, method in zip(axes[1:], methods, strict=True):
        mine = [row for row in rows if row["method"] == method]
        for missing, colour in ((False, "#9db4c8"), (True, "#d1495b")):
            points = [(row["x_m"], row["y_m"], row["depth_m"]) for row in mine if row["missing"] == missing]
            _points(ax, method, points, colour)
    heights = [row["depth_m"] for row in rows] + [row["given_m"] for row in given]
    for ax in axes:
        ax.set_ylim(max(heights) + 0.05, min(heights) - 0.05)
        ax.set_xlabel("x [m]")
    axes[0].set_ylabel("depth [m]")
    caption = (
        f"The point cloud at {_CLOUD_RATE:.0%} continuous defect and {1000 * _NOISES[-1]:g} mm of noise, seen from "
        "above and slightly tilted: input, and completed with fill+denoise (red: missing in the input)."
    )
    return Drawing("cloud", caption, figure)


def _points(ax: Axes, title: str, points: list[tuple[float, float, float]], colour: str) -> None:
    x, y, depth = np.array(points).T
    # the tilt separates the rows of points
    ax.scatter(x + 0.12 * y, depth + 0.1 * y, s=0.5, color=colour, linewidths=0, rasterized=True)
    ax.set_title(title, fontsize=9)


def _compare(rows: list[Row]) -> list[Comparison]:
    return [
        comparison
        for noise in _NOISES
        for comparison in compare_wins(
            [row for row in rows if row["noise_mm"] == 1000 * noise], f"noise {1000 * noise:g} mm", _PAPER_WON
        )
    ]


SPHERE = Experiment(
    name="sphere",
    title="Sphere with a growing continuous defect",
    source="Fig. 5",
    about="2.6 x 1.2 m of a sphere at 2 m on 960 x 540 pixels, with 65 mm of noise and without; a gap grows along x. "
    "Peer: polynomials with iterative inlier selection.",
    run=_run,
    draw=_draw,
    compare=_compare,
)
