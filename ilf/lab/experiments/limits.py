"""Limits of the methods (section 3.1): the largest defect rate with a small error, by noise and curvature."""

from __future__ import annotations

from dataclasses import replace

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
    run_counted,
)
from .plots import colour_of, legend, named, panels, percent
from .surfaces import INLIER_DEVIATIONS, Case, Surface, run_case

ERROR_MM = 10.0
"""Limit of the defective area's RMSE [mm]."""

_SHAPE, _QUICK_SHAPE = (180, 320), (90, 160)
_SPHERE = Surface("sphere", _SHAPE, (1.2, 2.6), 2.0, 2.0)
_SURFACES = (replace(_SPHERE, kind="plane"), *(replace(_SPHERE, radius=radius) for radius in (6.0, 3.0, 1.5)))
_NOISES = (0.0, 0.005, 0.02, 0.065)
_QUICK_NOISES = (0.0, 0.065)
_RATES = (0.02, *(share / 100 for share in range(5, 100, 5)))
_QUICK_RATES = (0.05, 0.2, 0.4, 0.6, 0.8)

_METHODS = (
    *METHOD_PRESETS, "polynomial-2", "polynomial-4",
    "nearest", "linear", "laplace", "colourisation", "thin-plate", "dct-smoothing",
)  # fmt: skip
_QUICK_METHODS = (*METHOD_PRESETS, "polynomial-2", "linear", "dct-smoothing")


def _run(settings: Settings, on_progress: OnProgress) -> Result:
    surfaces = [replace(item, shape=_QUICK_SHAPE) for item in _SURFACES[::2]] if settings.quick else list(_SURFACES)
    noises = _QUICK_NOISES if settings.quick else _NOISES
    rates = _QUICK_RATES if settings.quick else _RATES
    methods = _QUICK_METHODS if settings.quick else _METHODS
    units = [
        (Case(surface, noise, 0.0, "x", "fill", settings.seed), method, rates)
        for surface in surfaces
        for noise in noises
        for method in methods
    ]
    parts = run_counted(_run_unit, units, settings.jobs, on_progress)
    return Result(
        rows=[row for row, _ in parts],
        parameters={
            "surfaces": [surface.describe() for surface in surfaces],
            "noises_mm": [1000 * noise for noise in noises],
            "rates": list(rates),
            "error_mm": ERROR_MM,
            "presets": preset_parameters(mode="fill"),
            "polynomial_inlier_deviations": INLIER_DEVIATIONS,
            "chosen": "The paper has no such table. Here: 2.6 x 1.2 m of a plane and of spheres at 2 m, with a gap "
            "that grows along x; the rate grows step by step until the RMSE of the defective area reaches "
            f"{ERROR_MM:g} mm.",
        },
        notes=[
            "The defect rate of a row is the largest up to which all measured errors stay below the limit; 0 where "
            "the smallest defect already exceeds it. The errors of a row are those of the defective area at this rate.",
        ],
        tables={"steps": [row for _, steps in parts for row in steps]},
    )


def _run_unit(case: Case, method: str, rates: tuple[float, ...]) -> tuple[Row, list[Row]]:
    """Find the limit of one method on one surface with one noise; also return the steps up to it."""
    steps: list[Row] = []
    for rate in rates:
        (row,) = run_case(replace(case, rate=rate), [method])
        steps.append(row)
        if row["hole_rmse_mm"] >= ERROR_MM:
            break
    held = [row for row in steps if row["hole_rmse_mm"] < ERROR_MM]
    last = held[-1] if held else None
    return {
        "method": method,
        "surface": _name(case.surface),
        "radius_m": None if case.surface.kind == "plane" else case.surface.radius,
        "noise_mm": 1000 * case.noise,
        "defect_rate": last["defect_rate"] if last else 0.0,
        "acc_mm": last["hole_acc_mm"] if last else None,
        "prs_mm": last["hole_prs_mm"] if last else None,
        "rmse_mm": last["hole_rmse_mm"] if last else None,
        "never_failed": len(held) == len(rates),
        "seconds": sum(row["seconds"] for row in steps),
    }, steps


def _name(surface: Surface) -> str:
    return "plane" if surface.kind == "plane" else f"sphere, radius {surface.radius:g} m"


def _draw(result: Result) -> list[Drawing]:
    surfaces = list(dict.fromkeys(row["surface"] for row in result.rows))
    methods = list(dict.fromkeys(row["method"] for row in result.rows))
    noises = list(dict.fromkeys(row["noise_mm"] for row in result.rows))
    others = methods[len(METHOD_PRESETS) :]
    figure, axes = panels(len(surfaces), 1, width=9.0, height=2.1)
    width = 0.84 / len(methods)
    for ax, surface in zip(axes, surfaces, strict=True):
        for place, method in enumerate(methods):
            heights = [
                100 * next(
                    row["defect_rate"] for row in result.rows
                    if (row["surface"], row["method"], row["noise_mm"]) == (surface, method, noise)
                )
                for noise in noises
            ]  # fmt: skip
            middles = [index - 0.42 + (place + 0.5) * width for index in range(len(noises))]
            ax.bar(middles, heights, 0.9 * width, color=colour_of(method, others), label=method)
            for x, height in zip(middles, heights, strict=True):
                if height == 0:
                    ax.plot(x, 1.5, marker="x", markersize=3.5, color=colour_of(method, others))
        ax.set_ylim(0, 100)
        ax.set_title(surface, fontsize=9)
        ax.set_ylabel("defect rate [%]")
        ax.set_xticks(range(len(noises)), [f"noise {noise:g} mm" for noise in noises])
        ax.grid(False, axis="x")
    legend(figure, axes[0], columns=6)
    caption = (
        f"The largest continuous defect at which the error (RMSE of the defective area) stays below {ERROR_MM:g} mm. "
        "A cross marks methods that already exceed it at the smallest defect."
    )
    return [Drawing("limits", caption, figure)]


def _compare(rows: list[Row]) -> list[Comparison]:
    comparisons = []
    for surface, noise in dict.fromkeys((row["surface"], row["noise_mm"]) for row in rows):
        here = {row["method"]: row for row in rows if (row["surface"], row["noise_mm"]) == (surface, noise)}
        peers = {name: row for name, row in here.items() if name not in METHOD_PRESETS}
        far = max(row["defect_rate"] for row in peers.values())
        farthest = [name for name, row in peers.items() if row["defect_rate"] == far]
        get = "gets" if len(farthest) == 1 else "get"
        reach = "No peer stays below the limit"
        if far:
            reach = f"Of the peers {named(farthest, len(peers))} {get} farthest, up to {percent(round(far, 3))}"
        ahead = [name for name in METHOD_PRESETS if here[name]["defect_rate"] > far]
        level = [name for name in METHOD_PRESETS if here[name]["defect_rate"] == far]
        behind = [name for name in METHOD_PRESETS if here[name]["defect_rate"] < far]
        parts = [
            f"{', '.join(chosen)} {word}"
            for chosen, word in ((ahead, "farther"), (level, "as far"), (behind, "less far"))
            if chosen
        ]
        comparisons.append(
            Comparison(
                f"{surface}, noise {noise:g} mm",
                "no number",
                ", ".join(f"{name} {_reach(here[name])}" for name in METHOD_PRESETS),
                f"{reach}; {'; '.join(parts)}.",
            )
        )
    return comparisons


def _reach(row: Row) -> str:
    return f"{percent(round(row['defect_rate'], 3))}{' or more' if row['never_failed'] else ''}"


LIMITS = Experiment(
    name="limits",
    title="Limits of the methods",
    source="Section 3.1",
    about=f"The largest defect rate at which the error stays below {ERROR_MM:g} mm, by noise and curvature.",
    run=_run,
    draw=_draw,
    compare=_compare,
)
