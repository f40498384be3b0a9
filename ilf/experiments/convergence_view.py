"""The figures of the convergence experiment, and its words."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

from .experiment import METHOD_PRESETS, PAPER_PRESETS, Comparison, Drawing, Result, Row
from .plots import colour_of, legend, panels
from .verdicts import millimetres, percent

_DECADE = 10
"""Smaller spans are drawn on a linear axis."""

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_LABELS = {True: "with colour", False: "without colour"}


def draw_convergence(result: Result) -> list[Drawing]:
    """sigma_i, L1 and MAE against iteration: one column per preset."""
    curves = result.tables["curves"]
    figure, axes = panels(3, len(METHOD_PRESETS), width=3.7, height=2.5)
    for column, method in enumerate(METHOD_PRESETS):
        for line, (value, label, log) in enumerate(
            (
                ("sigma_mm", "sigma_i [mm]", True),
                ("l1_m", "L1 norm [m]", False),
                ("mae_mm", "MAE of the hole [mm]", True),
            )
        ):
            ax = axes[line * len(METHOD_PRESETS) + column]
            _lines(ax, [row for row in curves if row["method"] == method], value)
            values = [row[value] for row in curves if row["method"] == method and row[value]]
            if log and max(values) > _DECADE * min(values):
                ax.set_yscale("log")
            if column == 0:
                ax.set_ylabel(label)
            if line == 0:
                ax.set_title(method, fontsize=10)
                ax.axhline(1000 * result.parameters["presets"][method]["s_criteria"], color="#888888", linewidth=0.9,
                           linestyle=(0, (2, 2)), label="S_criteria")  # fmt: skip
        axes[2 * len(METHOD_PRESETS) + column].set_xlabel("iteration")
    legend(figure, axes[0])
    caption = (
        "Deviation sigma_i, L1 norm of the block, and mean absolute error of the defective area against the truth, "
        "with colour and without."
    )
    return [Drawing("curves", caption, figure), _draw_glitches(curves)]


def _lines(ax: Axes, rows: Sequence[Row], value: str) -> None:
    for colour, style in ((True, "-"), (False, "--")):
        mine = [row for row in rows if row["colour"] == colour and row[value] is not None]
        ax.plot(
            [row["i"] for row in mine],
            [row[value] for row in mine],
            style,
            color="#1b6ca8" if colour else "#d1495b",
            linewidth=1.3,
            label=_LABELS[colour],
        )


def _draw_glitches(curves: Sequence[Row]) -> Drawing:
    """The L1 norm of the staged schedule near its end value, enlargements and glitches marked."""
    rows = [row for row in curves if row["method"] == "paper" and row["colour"]]
    last = rows[-1]["l1_m"]
    start = next((place for place, row in enumerate(rows) if row["stage"] > 1), 1)
    rows = rows[max(start - 4, 0) :]
    figure, (ax,) = panels(1, 1, width=8.0, height=3.2)
    steps = [row["i"] for before, row in itertools.pairwise(rows) if row["stage"] > before["stage"]]
    for place, step in enumerate(steps):
        ax.axvline(step, color="#dddddd", linewidth=0.8, label="pass band enlarged" if place == 0 else None)
    ax.plot([row["i"] for row in rows], [row["l1_m"] for row in rows], color=colour_of("best"), linewidth=1.3,
            label="L1 norm")  # fmt: skip
    marked = [row for row in rows if row["glitch"]]
    ax.plot([row["i"] for row in marked], [row["l1_m"] for row in marked], "o", color=colour_of("paper"), markersize=4,
            label="glitch")  # fmt: skip
    ax.axhline(last, color="#888888", linewidth=0.9, linestyle=(0, (2, 2)), label="last value")
    ax.set_xlabel("iteration")
    ax.set_ylabel("L1 norm [m]")
    ax.grid(False, axis="x")
    ax.legend(fontsize=8, frameon=False, ncols=4)
    return Drawing(
        "glitches",
        "The glitches of Fig. 3a: the L1 norm of the preset paper, from just before the first enlargement on.",
        figure,
    )


def compare_convergence(rows: list[Row]) -> list[Comparison]:
    """Iterations, glitches, and what colour brings, beside the paper."""
    found = {(row["method"], row["colour"]): row for row in rows}
    comparisons = [_iterations(found["paper", True]), _glitches(found["paper", True])]
    comparisons += [_glitches_of_linear(found["released-code", True])]
    comparisons += [_colour(method, found[method, True], found[method, False]) for method in METHOD_PRESETS]
    return comparisons


def _iterations(row: Row) -> Comparison:
    settled = "sigma_i has fallen below S_criteria at the last radius" if row["settled"] else "sigma_i has not settled"
    return Comparison(
        "Iterations, paper",
        "at most 1500",
        str(row["iterations"]),
        f"After {row['iterations']} iterations {settled} (at last {millimetres(row['last_sigma_mm'])}). "
        "A small sigma_i says that the iteration is steady, not that it is right: "
        f"the mean absolute error of the hole is {millimetres(row['mae_mm'])} then.",
    )


def _glitches(row: Row) -> Comparison:
    share = f"{row['glitches']} of {row['enlargements']} enlargements"
    if row["glitches"]:
        text = (
            f"At {share} the L1 norm jumps up, after {row['fallen_back']} of these it falls again before the next, and "
            f"at {row['sigma_jumps']} sigma_i rises. A larger band first lets in more of what the known samples have "
            "over the surface, low-passed, and that spills into the hole; the iterations after it work it off."
        )
    else:
        text = f"The L1 norm jumps up at none of the {row['enlargements']} enlargements, unlike in the paper's Fig. 3a."
    if row["glitches"] < row["enlargements"]:
        text += (
            " The paper says that every enlargement has one. At the others here the norm falls, or rises less than "
            "before: the hole is still being lifted from 0 m, or has overshot. How large a step is, the paper leaves "
            "open."
        )
    return Comparison("Glitches, paper", "at every enlargement", share, text)


def _glitches_of_linear(row: Row) -> Comparison:
    return Comparison(
        "Glitches, released-code",
        "at every enlargement",
        f"{row['glitches']} in {row['iterations']} iterations",
        "The authors' program enlarges the radius a little at every iteration, unlike the text; a glitch is seen where "
        f"the ellipse takes in another wave, {row['sigma_jumps']} times with a rise of sigma_i.",
    )


def _colour(method: str, seen: Row, blind: Row) -> Comparison:
    change = seen["mae_mm"] / blind["mae_mm"] - 1
    if abs(change) < 0.005:
        text = "On this block colour makes no difference to the error at the end"
        if seen["weighted_iterations"]:
            text += (
                f": after the {seen['weighted_iterations']} weighted iterations the rest of the way wipes out the start"
            )
    else:
        direction = "smaller" if change < 0 else "larger"
        text = f"On this block colour makes the error {percent(round(abs(change), 2))} {direction}"
    ending = " (colour gives the edges here, not a weighted spectrum)."
    if method in PAPER_PRESETS:
        ending = ". The paper shows that the weight helps, on a block of its own."
        if seen["weighted_iterations"] == seen["iterations"]:
            ending += (
                " Here it is on from the first iteration to the last: the run is over before the weight is due to end."
            )
    if seen["least_mae_mm"] < 0.97 * seen["mae_mm"]:
        ending += (
            f" The error was smaller on the way: {millimetres(seen['least_mae_mm'])} at iteration "
            f"{seen['least_mae_at']}; sigma_i does not tell."
        )
    return Comparison(
        f"Colour, {method}",
        "colour helps",
        f"MAE {millimetres(seen['mae_mm'])} with, {millimetres(blind['mae_mm'])} without",
        text + ending,
    )
