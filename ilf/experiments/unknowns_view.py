"""The figures of the unknowns experiment, and its words."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from .claims import CYLINDER_WON, JUDGED, LEAST_ORDER, PAPER_PRS, PAPER_RATE, SPHERE_WON
from .experiment import Comparison, Drawing, Result, Row
from .plots import against_rate, legend, log_millimetres, mark_rate, panels
from .readings import UNKNOWNS, in_words
from .sweep import ORDERS, POLYNOMIALS
from .unknowns import CYLINDER, USUAL
from .verdicts import joined, millimetres, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_Holds = Callable[[Row], bool]

_CLAIMS: dict[str, _Holds] = {
    "Fig. 4: 10.28 mm": lambda row: row["fig4"],
    "Fig. 6, same cylinder": lambda row: row["fig6_order"] >= LEAST_ORDER,
    "Fig. 6, another one": lambda row: row["fig6_apart_order"] >= LEAST_ORDER,
    "Fig. 5, no noise": lambda row: row["fig5_order"] >= LEAST_ORDER,
    "Fig. 5, 65 mm": lambda row: row["fig5_noise_order"] >= LEAST_ORDER,
    "all, same cylinder": lambda row: row[f"order, {USUAL}"] >= LEAST_ORDER,
    "all, another one": lambda row: row[f"order apart, {USUAL}"] >= LEAST_ORDER,
}
"""What may come out under a reading, as the map's columns have it."""

_VIEWS = ("pixels", "axis", "seen")


def draw_unknowns(result: Result) -> list[Drawing]:
    """The map of readings; where 10.28 mm lies; and the reading that comes closest."""
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
    ax.set_yticks(range(len(lines)), [in_words({name: value}, [name]) for name, value in lines])
    ax.tick_params(length=0)
    ax.spines[["left", "bottom"]].set_visible(False)
    for above, below in itertools.pairwise(range(len(lines))):
        if lines[above][0] != lines[below][0]:
            ax.axhline(above + 0.5, color="white", linewidth=3)
    caption = (
        "Under how many readings of the text each printed result comes out, by what is read how; the wins against "
        f"polynomials of order {LEAST_ORDER} at least."
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
        f"PRS at {percent(PAPER_RATE)} missing against the cylinder's radius, with the preset paper as it is: where "
        "the line of the paper is crossed, Fig. 4 comes out."
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
        ax.set_title(f"{name}, {'the preset' if preset else 'the closest reading'}", fontsize=9)
        _mark(ax, name)
    legend(figure, axes[0], columns=5)
    caption = (
        f"Above, the preset paper: {_scenes_in_words(_preset(result.rows))}. Below, the reading that comes closest "
        f"({in_words(closest)}): {_scenes_in_words(closest)}."
    )
    return Drawing("closest", caption, figure)


def _mark(ax: Axes, name: str) -> None:
    if name == "Fig. 4":
        ax.plot(100 * PAPER_RATE, PAPER_PRS, marker="*", markersize=11, color="black", linestyle="none")
    else:
        won = CYLINDER_WON if name == "Fig. 6" else SPHERE_WON
        mark_rate(ax, won, "paper: ILF wins up to here")


def compare_unknowns(rows: list[Row]) -> list[Comparison]:
    """How many readings give what is printed, what those have in common, and how far the preset gets."""
    preset = _preset(rows)
    fourth = [row for row in rows if row["fig4"]]
    nearest = f"The preset paper comes to {millimetres(preset['prs_mm'])} on this: {_cylinder_in_words(preset)}"
    return [
        Comparison(
            f"Fig. 4, PRS at {percent(PAPER_RATE)}", f"{PAPER_PRS} mm", f"{len(fourth)} of {len(rows)} readings",
            f"So many have a cylinder with this PRS. {nearest}; its mean error (ACC) is "
            f"{millimetres(preset['acc_mm'])} there.",
        ),
        _compare_wins("Fig. 6, on the same cylinder", CYLINDER_WON, rows, "fig6_order"),
        _compare_wins("Fig. 6, on a cylinder of its own", CYLINDER_WON, rows, "fig6_apart_order"),
        _compare_wins("Fig. 5, without noise", SPHERE_WON, rows, "fig5_order"),
        _compare_wins("Fig. 5, noise 65 mm", SPHERE_WON, rows, "fig5_noise_order"),
        _compare_all("All three, Fig. 4 and 6 on one cylinder", rows, "order"),
        _compare_all("All three, Fig. 6 on a cylinder of its own", rows, "order apart"),
    ]  # fmt: skip


def _compare_wins(what: str, paper: float, rows: list[Row], key: str) -> Comparison:
    preset = _preset(rows)
    winners = [row for row in rows if row[key] >= LEAST_ORDER]
    text = _against(preset[key], "The preset paper")
    return Comparison(what, f"0-{percent(paper)}", _counts(rows, key), f"{_in_common(winners, rows)}{text}")


def _compare_all(what: str, rows: list[Row], key: str) -> Comparison:
    usual = f"{key}, {USUAL}"
    winners = [row for row in rows if row[usual] >= LEAST_ORDER]
    text = _in_common(winners, rows) if winners else "No reading makes all of them come out. "
    others = [
        f"{judged}: {sum(row[f'{key}, {judged}'] >= LEAST_ORDER for row in rows)}"
        for judged in JUDGED
        if judged != USUAL
    ]
    text += f"Judged otherwise, against order {LEAST_ORDER}: {'; '.join(others)}."
    return Comparison(what, "one method", _counts(rows, usual), text)


def _counts(rows: Sequence[Row], key: str) -> str:
    """ "against order 2: 5, 3: 4, 4: 0 of 84"."""
    counts = [f"{order}: {sum(row[key] >= order for row in rows)}" for order in ORDERS if order >= LEAST_ORDER]
    return f"against order {', '.join(counts)} of {len(rows)} readings"


def _against(order: int, who: str) -> str:
    return f"{who} wins against orders up to {order}." if order >= LEAST_ORDER else f"{who} does not win."


def _in_common(winners: Sequence[Row], rows: Sequence[Row]) -> str:
    """What the winners agree on and others do not."""
    if not winners:
        return ""
    agreed = [
        name for name in UNKNOWNS if len({row[name] for row in winners}) == 1 and len({row[name] for row in rows}) > 1
    ]
    if not agreed:
        return "Those that win have nothing in common. "
    return f"All that win have {joined([in_words(winners[0], [name]) for name in agreed])}. "


def _preset(rows: Sequence[Row]) -> Row:
    return next(row for row in rows if row["preset"])


def _cylinder_in_words(row: Row, prefix: str = "") -> str:
    pixels, axis, seen, radius = (row[f"{prefix}{key}"] for key in CYLINDER)
    return f"{axis} cylinder of {radius:g} m radius, {percent(seen)} of its diameter seen on {pixels} pixels"


def _scenes_in_words(row: Row) -> str:
    sixth = "the same" if row["fig6_order"] >= LEAST_ORDER else _cylinder_in_words(row, "apart_")
    return f"{_cylinder_in_words(row)} in Fig. 4, {sixth} in Fig. 6, sphere of {row['sphere_radius_m']:g} m in Fig. 5"
