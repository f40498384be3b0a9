"""Open points of the paper's text about Fig. 4 to 6: which interpretations reproduce the printed results."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from .experiment import Comparison, Drawing, OnProgress, Result, Row, Settings, run_counted
from .interpretations import (
    CYLINDER_WON,
    EVALUATED,
    LITTLE_NOISE,
    MIN_ORDER,
    MORE_NOISE,
    PAPER_PRS,
    PAPER_RATE,
    PIXELS,
    PRESET,
    SPHERE_NOISES,
    SPHERE_WON,
    UNKNOWNS,
    Errors,
    Interpretation,
    case_of,
    cylinder,
    filtered,
    fitted,
    matches_paper_prs,
    orders_beaten,
    radius_of_fig_4,
    sphere,
    to_text,
)
from .plots import EQUAL_SHARE, against_rate, joined, legend, log_millimetres, mark_rate, millimetres, panels, percent
from .surfaces import INLIER_DEVIATIONS, ORDERS, POLYNOMIALS, Surface

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DEFAULT_EVALUATION = next(iter(EVALUATED))
"""Way in which the other experiments evaluate a method."""

_QUICK_UNKNOWNS = {
    **UNKNOWNS, "start": ("mean", "1 / shortest"), "step": (0.5,), "wavelength_px": (15.0,), "padding": (2.0,)
}  # fmt: skip

CYLINDER = ("pixels", "axis", "seen", "radius_m")
"""Keys of rows that define a cylinder."""

_AXES, _SEEN = ("upright", "lying"), (0.6, 1.0)
_SPHERE_RADII = (1.44, 1.6, 2.0)
"""For the smallest, the corners of the visible part lie just within the rim."""

_OTHER_RADIUS = 0.3
"""Radius [m] of the cylinders on which Fig. 6 is evaluated separately from Fig. 4."""

_EVERY, _CURVE_EVERY, _QUICK_EVERY = 5, 3, 10
_CURVE_RATES = (0.0, 0.1, 0.2, 0.3, SPHERE_WON, CYLINDER_WON, 0.6, 0.7, PAPER_RATE)
_QUICK_CURVE_RATES = (0.0, 0.4, PAPER_RATE)
_CURVE_RADII = (0.05, 0.07, 0.1, 0.14, 0.2, 0.28, 0.4, 0.57, 0.8)


def run_unknowns(settings: Settings, on_progress: OnProgress) -> Result:
    """Try every interpretation, and add curves of the preset's and of the closest one."""
    quick, seed = settings.quick, settings.seed
    values = _QUICK_UNKNOWNS if quick else UNKNOWNS
    interpretations = interpretations_of(values)
    total = len(interpretations) + 1
    parts = run_counted(
        try_interpretation,
        [(interpretation, quick, seed) for interpretation in interpretations],
        settings.jobs,
        lambda done, _: on_progress(done, total),
    )
    rows = [row for row, _, _ in parts]
    preset = interpretations.index(PRESET)
    closest = max(range(len(rows)), key=lambda place: (_score(rows[place]), _kept(interpretations[place])))
    rows[closest]["closest"] = True
    every = _QUICK_EVERY if quick else _EVERY
    tables = {
        "cylinders": [row for _, cylinders, _ in parts for row in cylinders],
        "spheres": [row for _, _, spheres in parts for row in spheres],
        "radii": _radii(every, seed),
        "curves": [line for row in (rows[preset], rows[closest]) for line in _curves(row, quick, seed)],
    }
    on_progress(total, total)
    return Result(
        rows=rows,
        parameters={
            "unknowns": {name: list(tried) for name, tried in values.items()},
            "cylinder": {"pixels": list(PIXELS), "axis": list(_AXES), "seen": list(_SEEN)},
            "sphere_radii_m": list(_SPHERE_RADII),
            "evaluated": list(EVALUATED),
            "orders": list(ORDERS),
            "every": every,
            "chosen": "The preset `paper` with every combination of the text's open points: start and step of the "
            "cut-off frequency, the shortest wave of the last pass band, subtraction of the mean, colour, and, with "
            "the preset's step and shortest wave, padding. Each is run on cylinders that differ in pixels, axis and "
            "visible share of the diameter, with the largest radius, in whole centimetres, that gives about the "
            "printed PRS (the more a surface bends, the worse a polynomial fits it), and on spheres of "
            f"{joined([f'{radius:g}' for radius in _SPHERE_RADII])} m. The search uses every {every}th row and column; "
            "a pixel's noise is that of the mean of the pixels that it represents.",
        },
        notes=[
            f"Fig. 4 is reproduced if a cylinder gives a PRS within {EQUAL_SHARE:.0%} of {PAPER_PRS} mm at "
            f"{percent(PAPER_RATE)} missing. Fig. 6 is evaluated on the same cylinder, and separately on cylinders of "
            f"{_OTHER_RADIUS:g} m; Fig. 5 on the most favourable sphere, with noise and without. A win against order k "
            "means: an RMSE of the block below that of the polynomials of all orders 1 to k, at all of four defect "
            f"rates up to the printed one. {MIN_ORDER} is the minimum order that counts: a plane fits none of these "
            "surfaces.",
        ],
        tables=tables,
    )


def interpretations_of(values: dict[str, tuple[Any, ...]]) -> list[Interpretation]:
    """Return every combination; paddings other than the preset's only with its step and shortest wave."""
    interpretations = [Interpretation(*chosen) for chosen in itertools.product(*values.values())]
    usual = PRESET.step, PRESET.wavelength_px
    return [
        item for item in interpretations if item.padding == PRESET.padding or (item.step, item.wavelength_px) == usual
    ]


def try_interpretation(interpretation: Interpretation, quick: bool, seed: int) -> tuple[Row, list[Row], list[Row]]:
    """Evaluate an interpretation: a row for its most favourable cylinder and sphere, and rows for all of them."""
    started = time.perf_counter()
    every = _QUICK_EVERY if quick else _EVERY
    views = list(itertools.product(tuple(PIXELS)[: 1 if quick else None], _AXES, _SEEN[-1 if quick else 0 :]))
    name: Row = {"method": "paper", **vars(interpretation)}
    cylinders = [{**name, **_on_cylinder(interpretation, view, every, seed)} for view in views]
    cylinders += [{**name, **_on_other(interpretation, view, every, seed)} for view in views]
    spheres = [
        {**name, **_on_sphere(interpretation, radius, every, seed)} for radius in _SPHERE_RADII[: 1 if quick else None]
    ]
    row = {**name, "preset": interpretation == PRESET, "closest": False, **_best_of(cylinders, spheres)}
    return {**row, "seconds": time.perf_counter() - started}, cylinders, spheres


def _on_cylinder(interpretation: Interpretation, view: tuple[str, str, float], every: int, seed: int) -> Row:
    """Find the cylinder with the PRS of Fig. 4, or the nearest, and the orders beaten on it with Fig. 6's noise."""

    def errors(radius: float) -> Errors:
        return filtered(
            interpretation, case_of(cylinder(*view, radius, every), LITTLE_NOISE, PAPER_RATE, every, seed), every
        )

    radius = radius_of_fig_4(lambda tried: errors(tried).prs)
    there = errors(radius)
    out = matches_paper_prs(there.prs)
    beaten = dict.fromkeys(EVALUATED, 0)
    if out:
        beaten = orders_beaten(interpretation, cylinder(*view, radius, every), MORE_NOISE, every, seed)
    return {**_in_words(view, radius), "acc_mm": there.acc, "prs_mm": there.prs, "fig4": out, **beaten}


def _on_other(interpretation: Interpretation, view: tuple[str, str, float], every: int, seed: int) -> Row:
    """Return the orders beaten with the noise of Fig. 6 on a cylinder that may differ from that of Fig. 4."""
    beaten = orders_beaten(interpretation, cylinder(*view, _OTHER_RADIUS, every), MORE_NOISE, every, seed)
    return {**_in_words(view, _OTHER_RADIUS), "acc_mm": None, "prs_mm": None, "fig4": None, **beaten}


def _in_words(view: tuple[str, str, float], radius: float) -> Row:
    return dict(zip(CYLINDER, (*view, radius), strict=True))


def _on_sphere(interpretation: Interpretation, radius: float, every: int, seed: int) -> Row:
    """Return the orders beaten on a sphere: without noise, and with it ("..., noise")."""
    row: Row = {"sphere_radius_m": radius}
    for noise in SPHERE_NOISES:
        beaten = orders_beaten(interpretation, sphere(radius, every), noise, every, seed)
        row |= {f"{evaluated}, noise" if noise else evaluated: order for evaluated, order in beaten.items()}
    return row


def _best_of(cylinders: Sequence[Row], spheres: Sequence[Row]) -> Row:
    """Return the most favourable cylinder and sphere, and the order up to which all claims are reproduced."""
    tried = [row for row in cylinders if row["fig4"] is not None]
    on = max(tried, key=lambda row: (row[DEFAULT_EVALUATION], row["fig4"], -abs(math.log(row["prs_mm"] / PAPER_PRS))))
    off = max(
        spheres,
        key=lambda row: (_fig5(row, DEFAULT_EVALUATION), row[DEFAULT_EVALUATION] + row[f"{DEFAULT_EVALUATION}, noise"]),
    )
    apart = max(cylinders, key=lambda row: row[DEFAULT_EVALUATION])
    fourth = any(row["fig4"] for row in tried)
    orders = {}
    for evaluated in EVALUATED:
        fifth = max(_fig5(row, evaluated) for row in spheres)
        orders[f"order, {evaluated}"] = min(fifth, max(row[evaluated] for row in tried))
        orders[f"order apart, {evaluated}"] = min(fifth, max(row[evaluated] for row in cylinders)) if fourth else 0
    return {
        **{key: on[key] for key in CYLINDER},
        "defect_rate": PAPER_RATE,
        "acc_mm": on["acc_mm"],
        "prs_mm": on["prs_mm"],
        "rmse_mm": math.hypot(on["acc_mm"], on["prs_mm"]),
        "fig4": fourth,
        "fig6_order": on[DEFAULT_EVALUATION],
        "fig6_apart_order": apart[DEFAULT_EVALUATION],
        **{f"apart_{key}": apart[key] for key in CYLINDER},
        "sphere_radius_m": off["sphere_radius_m"],
        "fig5_order": off[DEFAULT_EVALUATION],
        "fig5_noise_order": off[f"{DEFAULT_EVALUATION}, noise"],
        **orders,
    }


def _fig5(row: Row, evaluated: str) -> int:
    return min(row[evaluated], row[f"{evaluated}, noise"])


def _score(row: Row) -> tuple[int, int, int]:
    """Score of the agreement of an interpretation with all printed results; higher is closer."""
    single = row["fig6_order"] + row["fig5_order"] + row["fig5_noise_order"]
    return row[f"order, {DEFAULT_EVALUATION}"], row[f"order apart, {DEFAULT_EVALUATION}"], single


def _kept(interpretation: Interpretation) -> int:
    """Number of fields in which an interpretation equals the preset's."""
    return sum(getattr(interpretation, name) == getattr(PRESET, name) for name in UNKNOWNS)


def _radii(every: int, seed: int) -> list[Row]:
    """PRS of the preset at the defect rate of Fig. 4, against the cylinder's radius."""
    rows: list[Row] = []
    for pixels, axis, seen, radius in itertools.product(PIXELS, _AXES, _SEEN, _CURVE_RADII):
        case = case_of(cylinder(pixels, axis, seen, radius, every), LITTLE_NOISE, PAPER_RATE, every, seed)
        errors = filtered(PRESET, case, every)
        rows.append({
            "pixels": pixels, "axis": axis, "seen": seen, "radius_m": radius,
            "acc_mm": errors.acc, "prs_mm": errors.prs,
        })  # fmt: skip
    return rows


def _curves(row: Row, quick: bool, seed: int) -> list[Row]:
    """Curves of an interpretation and of polynomials against the defect rate, on its most favourable surfaces."""
    every = _QUICK_EVERY if quick else _CURVE_EVERY
    interpretation = Interpretation(**{name: row[name] for name in UNKNOWNS})
    one = _cylinder_of(row, "", every)
    sixth = one if row["fig6_order"] >= MIN_ORDER else _cylinder_of(row, "apart_", every)
    ball = sphere(row["sphere_radius_m"], every)
    figures = {"Fig. 4": (one, LITTLE_NOISE), "Fig. 6": (sixth, MORE_NOISE)}
    figures |= {f"Fig. 5, {1000 * noise:g} mm": (ball, noise) for noise in SPHERE_NOISES}
    rows: list[Row] = []
    for figure, (surface, noise) in figures.items():
        for rate in _QUICK_CURVE_RATES if quick else _CURVE_RATES:
            case = case_of(surface, noise, rate, every, seed)
            methods: dict[str, Callable[[], Errors]] = {"paper": partial(filtered, interpretation, case, every)}
            for name, order in zip(POLYNOMIALS, ORDERS, strict=True):
                methods[name] = partial(fitted, case, order, INLIER_DEVIATIONS)
            for method, errors in methods.items():
                rows.append(
                    {"preset": row["preset"], "figure": figure, "method": method, "defect_rate": rate,
                     **_in_row(errors())}
                )  # fmt: skip
    return rows


def _cylinder_of(row: Row, prefix: str, every: int) -> Surface:
    pixels, axis, seen, radius = (row[f"{prefix}{key}"] for key in CYLINDER)
    return cylinder(pixels, axis, seen, radius, every)


def _in_row(errors: Errors) -> Row:
    return {"rmse_mm": errors.whole, "hole_rmse_mm": errors.hole, "acc_mm": errors.acc, "prs_mm": errors.prs}


# Figures and comparison texts of the unknowns experiment.

_Holds = Callable[[Row], bool]

_CLAIMS: dict[str, _Holds] = {
    "Fig. 4: 10.28 mm": lambda row: row["fig4"],
    "Fig. 6, same cylinder": lambda row: row["fig6_order"] >= MIN_ORDER,
    "Fig. 6, another one": lambda row: row["fig6_apart_order"] >= MIN_ORDER,
    "Fig. 5, no noise": lambda row: row["fig5_order"] >= MIN_ORDER,
    "Fig. 5, 65 mm": lambda row: row["fig5_noise_order"] >= MIN_ORDER,
    "all, same cylinder": lambda row: row[f"order, {DEFAULT_EVALUATION}"] >= MIN_ORDER,
    "all, another one": lambda row: row[f"order apart, {DEFAULT_EVALUATION}"] >= MIN_ORDER,
}
"""Results that an interpretation may reproduce: the columns of the map."""

_VIEWS = ("pixels", "axis", "seen")


def draw_unknowns(result: Result) -> list[Drawing]:
    """Draw the map of interpretations, PRS against radius, and the closest interpretation."""
    return [_draw_map(result.rows), _draw_radii(result.tables["radii"]), _draw_closest(result)]


def _draw_map(rows: list[Row]) -> Drawing:
    lines = [(name, value) for name in UNKNOWNS for value in dict.fromkeys(row[name] for row in rows)]
    figure, (ax,) = panels(1, 1, width=9.4, height=0.34 * len(lines) + 1.6)
    shares = []
    for line, (name, value) in enumerate(lines):
        here = [row for row in rows if row[name] == value]
        counts = [sum(map(holds, here)) for holds in _CLAIMS.values()]
        shares.append([count / len(here) for count in counts])
        for column, count in enumerate(counts):
            dark = shares[-1][column] > 0.55
            ax.text(column, line, f"{count} of {len(here)}", ha="center", va="center", fontsize=8,
                    color="white" if dark else "#333333" if count else "#b0b0b0")  # fmt: skip
    ax.imshow(shares, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    ax.grid(False)
    ax.set_xticks(range(len(_CLAIMS)), [name.replace(", ", ",\n").replace(": ", ":\n") for name in _CLAIMS])
    ax.xaxis.tick_top()
    ax.set_yticks(range(len(lines)), [to_text({name: value}, [name]) for name, value in lines])
    ax.tick_params(length=0)
    ax.spines[["left", "bottom"]].set_visible(False)
    for above, below in itertools.pairwise(range(len(lines))):
        if lines[above][0] != lines[below][0]:
            ax.axhline(above + 0.5, color="white", linewidth=3)
    caption = (
        "Number of interpretations of the text that reproduce each printed result, by interpretation of each open "
        f"point; wins against polynomials of at least order {MIN_ORDER}."
    )
    return Drawing("map", caption, figure)


def _draw_radii(rows: list[Row]) -> Drawing:
    views = list(dict.fromkeys(tuple(row[key] for key in _VIEWS) for row in rows))
    figure, axes = panels(1, 2, width=4.8, height=3.6)
    for ax, axis in zip(axes, dict.fromkeys(view[1] for view in views), strict=True):
        for pixels, _, seen in (view for view in views if view[1] == axis):
            mine = [row for row in rows if tuple(row[key] for key in _VIEWS) == (pixels, axis, seen)]
            ax.plot([row["radius_m"] for row in mine], [row["prs_mm"] for row in mine], marker="o", markersize=3.5,
                    linewidth=1.4, label=f"{pixels} pixels, {percent(seen)} of the diameter seen")  # fmt: skip
        ax.set_xscale("log")
        log_millimetres(ax)
        ax.set_ylim(1, 1.5 * max(row["prs_mm"] for row in rows))
        ax.axhline(PAPER_PRS, color="black", linewidth=0.9, linestyle=(0, (2, 2)))
        ax.annotate(f"paper: {PAPER_PRS} mm", (0.02, PAPER_PRS), xycoords=("axes fraction", "data"), fontsize=7,
                    va="bottom")  # fmt: skip
        ax.set_title(f"{axis} cylinder", fontsize=10)
        ax.set_xlabel("radius [m]")
        ax.set_ylabel("PRS [mm]")
        radii = sorted({row["radius_m"] for row in rows})[::2]
        ax.set_xticks(radii, [f"{radius:g}" for radius in radii])
        ax.minorticks_off()
    legend(figure, axes[0], columns=2)
    caption = (
        f"PRS at {percent(PAPER_RATE)} missing against the cylinder's radius, with the unchanged preset paper: Fig. 4 "
        "is reproduced where a curve crosses the paper's line."
    )
    return Drawing("radii", caption, figure)


def _draw_closest(result: Result) -> Drawing:
    curves = result.tables["curves"]
    closest = next(row for row in result.rows if row["closest"])
    names = list(dict.fromkeys(row["figure"] for row in curves))
    figure, axes = panels(2, len(names), width=3.3, height=3.1)
    for ax, (preset, name) in zip(axes, itertools.product((True, False), names), strict=True):
        mine = [row for row in curves if (row["preset"], row["figure"]) == (preset, name)]
        fourth = name == "Fig. 4"
        against_rate(ax, mine, ("paper", *POLYNOMIALS), "prs_mm" if fourth else "rmse_mm")
        log_millimetres(ax)
        ax.set_ylabel("PRS [mm]" if fourth else "RMSE [mm]")
        ax.set_title(f"{name}, {'preset' if preset else 'closest interpretation'}", fontsize=9)
        _mark(ax, name)
    legend(figure, axes[0], columns=5)
    caption = (
        f"Top: the preset paper, {_scenes_in_words(_preset(result.rows))}. Bottom: the closest interpretation "
        f"({to_text(closest)}), {_scenes_in_words(closest)}."
    )
    return Drawing("closest", caption, figure)


def _mark(ax: Axes, name: str) -> None:
    if name == "Fig. 4":
        ax.plot(100 * PAPER_RATE, PAPER_PRS, marker="*", markersize=11, color="black", linestyle="none")
    else:
        won = CYLINDER_WON if name == "Fig. 6" else SPHERE_WON
        mark_rate(ax, won, "paper: ILF wins up to here")


def compare_unknowns(rows: list[Row]) -> list[Comparison]:
    """Count the interpretations that reproduce the printed results, with their common choices and the preset."""
    preset = _preset(rows)
    fourth = [row for row in rows if row["fig4"]]
    nearest = f"The preset paper gives {millimetres(preset['prs_mm'])} on this surface: {_cylinder_in_words(preset)}"
    return [
        Comparison(
            f"Fig. 4, PRS at {percent(PAPER_RATE)}", f"{PAPER_PRS} mm", f"{len(fourth)} of {len(rows)} interpretations",
            f"These have a cylinder with this PRS. {nearest}; its mean error (ACC) there is "
            f"{millimetres(preset['acc_mm'])}.",
        ),
        _compare_wins("Fig. 6, on the same cylinder", CYLINDER_WON, rows, "fig6_order"),
        _compare_wins("Fig. 6, on another cylinder", CYLINDER_WON, rows, "fig6_apart_order"),
        _compare_wins("Fig. 5, without noise", SPHERE_WON, rows, "fig5_order"),
        _compare_wins("Fig. 5, noise 65 mm", SPHERE_WON, rows, "fig5_noise_order"),
        _compare_all("All three, Fig. 4 and 6 on one cylinder", rows, "order"),
        _compare_all("All three, Fig. 6 on another cylinder", rows, "order apart"),
    ]  # fmt: skip


def _compare_wins(what: str, paper: float, rows: list[Row], key: str) -> Comparison:
    preset = _preset(rows)
    winners = [row for row in rows if row[key] >= MIN_ORDER]
    text = _against(preset[key], "The preset paper")
    return Comparison(what, f"0-{percent(paper)}", _counts(rows, key), f"{_in_common(winners, rows)}{text}")


def _compare_all(what: str, rows: list[Row], key: str) -> Comparison:
    usual = f"{key}, {DEFAULT_EVALUATION}"
    winners = [row for row in rows if row[usual] >= MIN_ORDER]
    text = _in_common(winners, rows) if winners else "No interpretation reproduces all of them. "
    others = [
        f"{evaluated}: {sum(row[f'{key}, {evaluated}'] >= MIN_ORDER for row in rows)}"
        for evaluated in EVALUATED
        if evaluated != DEFAULT_EVALUATION
    ]
    text += f"Other evaluations, against order {MIN_ORDER}: {'; '.join(others)}."
    return Comparison(what, "one method", _counts(rows, usual), text)


def _counts(rows: Sequence[Row], key: str) -> str:
    """ "against order 2: 5, 3: 4, 4: 0 of 84"."""
    counts = [f"{order}: {sum(row[key] >= order for row in rows)}" for order in ORDERS if order >= MIN_ORDER]
    return f"against order {', '.join(counts)} of {len(rows)} interpretations"


def _against(order: int, who: str) -> str:
    return f"{who} wins against orders up to {order}." if order >= MIN_ORDER else f"{who} does not win."


def _in_common(winners: Sequence[Row], rows: Sequence[Row]) -> str:
    """Describe the choices that all winners share, if others differ."""
    if not winners:
        return ""
    agreed = [
        name for name in UNKNOWNS if len({row[name] for row in winners}) == 1 and len({row[name] for row in rows}) > 1
    ]
    if not agreed:
        return "Those that win have nothing in common. "
    return f"All that win have {joined([to_text(winners[0], [name]) for name in agreed])}. "


def _preset(rows: Sequence[Row]) -> Row:
    return next(row for row in rows if row["preset"])


def _cylinder_in_words(row: Row, prefix: str = "") -> str:
    pixels, axis, seen, radius = (row[f"{prefix}{key}"] for key in CYLINDER)
    return f"{axis} cylinder of {radius:g} m radius, {percent(seen)} of its diameter seen on {pixels} pixels"


def _scenes_in_words(row: Row) -> str:
    sixth = "the same" if row["fig6_order"] >= MIN_ORDER else _cylinder_in_words(row, "apart_")
    return f"{_cylinder_in_words(row)} in Fig. 4, {sixth} in Fig. 6, sphere of {row['sphere_radius_m']:g} m in Fig. 5"
