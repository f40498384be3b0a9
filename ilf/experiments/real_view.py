"""The figures of the experiment on real frames, and its words."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..parameters import PRESETS
from .experiment import METHOD_PRESETS, Comparison, Drawing, Result, Row
from .plots import colour_of, legend, panels
from .real import COMPLETED, GIVEN, SPOT, SPOT_PICTURE
from .verdicts import counted, millimetres, named, percent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROWS_SHOWN, _SPOTS_A_ROW = 8, 4

_ALL_OF_IT = 0.9995
"""Share of the missing pixels from which on none is said to be left."""


def draw_real(result: Result) -> list[Drawing]:
    """The frames and their clouds, raw and completed, the spots, and the errors in them."""
    frames = list(dict.fromkeys(row["frame"] for row in result.rows))[:_ROWS_SHOWN]
    names = {row["frame"]: f"{row['frame']}\n{row['sensor']}" for row in result.rows}
    methods = [GIVEN, *METHOD_PRESETS]
    depths = ["colour/", *(f"depth/{method}" for method in methods)]
    clouds = [f"cloud/{method}" for method in methods]
    shows_data = not result.parameters["sample"]
    drawings = [
        Drawing(
            "depth",
            "Colour, raw depth (black: missing), and depth completed by the presets. What no block vouches for stays "
            "missing.",
            _grid(result, frames, depths, ["colour", *methods], names),
            shows_data,
        ),
        Drawing(
            "cloud",
            "The same as point clouds, seen from the side and above.",
            _grid(result, frames, clouds, methods, names),
            shows_data,
        ),
    ]
    rows = [row for row in result.rows if row["part"] == SPOT]
    if rows:
        drawings += [_draw_spot_places(result, shows_data), _draw_spot_errors(rows)]
    return drawings


def _grid(
    result: Result, frames: Sequence[str], keys: Sequence[str], titles: Sequence[str], names: dict[str, str]
) -> Figure:
    """One row of pictures per frame, one column per key."""
    figure, axes = panels(len(frames), len(keys), width=1.9, height=1.5)
    for place, ax in enumerate(axes):
        line, column = divmod(place, len(keys))
        _show(ax, result.pictures[f"{frames[line]}/{keys[column]}"])
        if line == 0:
            ax.set_title(titles[column], fontsize=8)
        if column == 0:
            ax.set_ylabel(names[frames[line]], fontsize=6)
    return figure


def _show(ax: Axes, picture: NDArray[np.uint8]) -> None:
    ax.imshow(picture, interpolation="nearest")
    ax.set_xticks([])
    ax.set_yticks([])
    ax.spines[:].set_visible(False)
    ax.grid(False)


def _draw_spot_places(result: Result, shows_data: bool) -> Drawing:
    shown = [name for name in result.pictures if name.endswith(SPOT_PICTURE)]
    columns = min(len(shown), _SPOTS_A_ROW)
    figure, axes = panels(math.ceil(len(shown) / columns), columns, width=2.4, height=2.0)
    for ax in axes[len(shown) :]:
        ax.set_visible(False)
    for ax, name in zip(axes, shown, strict=False):
        _show(ax, result.pictures[name])
        ax.set_title(name.removesuffix(SPOT_PICTURE), fontsize=8)
    return Drawing("spots", "The spots of 15 cm, here with glare; red: where depth is taken away.", figure, shows_data)


def _draw_spot_errors(rows: list[Row]) -> Drawing:
    methods = sorted(
        dict.fromkeys(row["method"] for row in rows), key=lambda name: _mean(rows, name, False), reverse=True
    )
    figure, (ax,) = panels(1, 1, width=7.0, height=4.4)
    for place, method in enumerate(methods):
        colour = colour_of(method) if method in PRESETS else "#98a1ab"
        for glare, offset, marker in ((False, 0.17, "o"), (True, -0.17, "x")):
            values = [row["rmse_mm"] for row in rows if row["method"] == method and row["glare"] == glare]
            if not values:
                continue
            ax.plot(values, [place + offset] * len(values), marker, color=colour, markersize=3.5, alpha=0.6)
            ax.plot(_mean(rows, method, glare), place + offset, "|", color=colour, markersize=11, markeredgewidth=2)
    for marker, label in (("o", "colour as it is"), ("x", "with glare (presets only)")):
        ax.plot([], [], marker, color="#555555", markersize=4, label=label)
    ax.set_yticks(range(len(methods)), methods)
    ax.set_xscale("log")
    ax.set_xlabel("RMSE in the spot [mm]; bars: mean of the frames")
    legend(figure, ax)
    return Drawing(
        "errors", "Error of depth completed in a round spot of 15 cm, of single frames and in the mean.", figure
    )


def _mean(rows: Sequence[Row], method: str, glare: bool) -> float:
    return float(np.mean([row["rmse_mm"] for row in rows if row["method"] == method and row["glare"] == glare]))


def compare_real(rows: list[Row]) -> list[Comparison]:
    """Share recovered, and the error in the spot; the paper shows pictures here."""
    whole = [row for row in rows if row["part"] == COMPLETED]
    spots = [row for row in rows if row["part"] == SPOT]
    comparisons = [_recovered(whole, method) for method in METHOD_PRESETS]
    methods = list(dict.fromkeys(row["method"] for row in spots))
    return comparisons + [_spot(spots, methods, method) for method in METHOD_PRESETS if spots]


def _recovered(rows: list[Row], method: str) -> Comparison:
    mine = [row for row in rows if row["method"] == method and row["recovered"] is not None]
    if not mine:
        return Comparison(
            f"Missing depth recovered, {method}", "pictures only", "nothing was missing", "No frame has holes."
        )
    shares = [row["recovered"] for row in mine]
    least = min(mine, key=lambda row: row["recovered"])
    left = "In no frame is anything left open."
    if least["recovered"] < _ALL_OF_IT:
        left = (
            f"Least in {least['frame']}, {percent(round(least['recovered'], 3))}: the rest lies in no block, or in one "
        )
        left += "without enough known depth."
    return Comparison(
        f"Missing depth recovered, {method}",
        "pictures only",
        f"{percent(round(float(np.mean(shares)), 3))} of the missing pixels, mean of {counted(len(mine), 'frame')}",
        f"{left} How right it is, pictures do not tell; the table does.",
    )


def _spot(rows: list[Row], methods: list[str], method: str) -> Comparison:
    plain, glare = _mean(rows, method, False), _mean(rows, method, True)
    frames = len({row["frame"] for row in rows})
    rivals = [name for name in methods if name != method]
    better = [name for name in rivals if _mean(rows, name, False) < plain]
    text = f"RMSE, mean of {counted(frames, 'frame')}. Without glare "
    if better:
        text += f"{named(better, len(rivals))} {'is' if len(better) == 1 else 'are'} nearer."
    else:
        text += f"it is the lowest of {len(methods)} methods."
    change = glare / plain
    if change > 1.1:
        text += f" Glare in the colour image makes it {change:.1f} times as large: "
        text += "colour edges, the glare's rim among them, are taken for boundaries."
    elif change < 0.9:
        text += f" Glare in the colour image makes it smaller ({percent(round(1 - change, 3))})."
    else:
        text += " Glare in the colour image changes it little."
    return Comparison(
        f"15 cm spot, {method}",
        "pictures only",
        f"{millimetres(plain)}; with glare {millimetres(glare)}",
        text,
    )
