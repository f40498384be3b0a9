"""Figures: curves against the defect rate, and common elements of all figures."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from .experiment import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STYLES = {
    "best": ("#1b6ca8", "-", "o"),
    "paper": ("#d1495b", "-", "s"),
    "released-code": ("#e5a33b", "-", "^"),
    "polynomial-1": ("#c9c9c9", "--", ""),
    "polynomial-2": ("#a0a0a0", "--", ""),
    "polynomial-3": ("#777777", "-.", ""),
    "polynomial-4": ("#444444", ":", ""),
}
"""Method -> colour, line, marker; other methods take their colour from `_OTHERS`."""

_MIN_MM = 0.01
"""Lower end of logarithmic axes of errors [mm]."""

_OTHERS = ("#5b8e7d", "#8a6fae", "#b07d62", "#3d9db3", "#9aa83b", "#c06c9b", "#6b7a8f", "#7f4f24")


def style_of(method: str, others: Sequence[str] = ()) -> dict[str, Any]:
    """Return the line style of a method; `others` are the methods without a style in `_STYLES`, in their order."""
    if method in _STYLES:
        colour, line, marker = _STYLES[method]
        return {"color": colour, "linestyle": line, "marker": marker, "markersize": 4, "linewidth": 1.6}
    place = list(others).index(method) if method in others else 0
    return {"color": _OTHERS[place % len(_OTHERS)], "linestyle": "-", "linewidth": 1.4}


def colour_of(method: str, others: Sequence[str] = ()) -> str:
    """A method's colour."""
    return str(style_of(method, others)["color"])


def panels(rows: int, columns: int, *, width: float = 4.6, height: float = 3.4) -> tuple[Figure, list[Axes]]:
    """A figure with a grid of axes, row by row."""
    from matplotlib.figure import Figure  # imported here because it is slow and listing experiments needs no figure

    figure = Figure(figsize=(width * columns, height * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    for ax in axes.flat:
        tidy(ax)
    return figure, list(axes.flat)


def tidy(ax: Axes) -> None:
    """Draw a light grid, and no frame at the top and right."""
    ax.grid(True, color="#e3e3e3", linewidth=0.7)
    ax.set_axisbelow(True)
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(labelsize=8)
    ax.xaxis.label.set_fontsize(9)
    ax.yaxis.label.set_fontsize(9)


def legend(figure: Figure, ax: Axes, columns: int = 7) -> None:
    """Add one legend for all panels, below them."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside lower center", ncols=min(columns, len(labels)), fontsize=8, frameon=False
    )


def against_rate(ax: Axes, rows: Iterable[Row], methods: Sequence[str], value: str, *, size: bool = False) -> None:
    """Plot one line per method: a value [mm], or with `size` its absolute value, against the defect rate."""
    rows = list(rows)
    for method in methods:
        points = [(100 * row["defect_rate"], row[value]) for row in rows if row["method"] == method]
        shown = [(rate, abs(y) if size else y) for rate, y in points if y is not None and math.isfinite(y)]
        if shown:
            ax.plot(*zip(*shown, strict=True), label=method, **style_of(method))
    ax.set_xlabel("defect rate [%]")


def log_millimetres(ax: Axes) -> None:
    """Use a logarithmic axis of errors, limited below to errors that no sensor can resolve."""
    ax.set_yscale("log")
    low, _ = ax.get_ylim()
    ax.set_ylim(bottom=max(low, _MIN_MM))


def mark_rate(ax: Axes, rate: float, text: str) -> None:
    """Draw a vertical line at a defect rate (0-1) of the paper."""
    ax.axvline(100 * rate, color="#888888", linewidth=0.9, linestyle=(0, (2, 2)))
    ax.annotate(text, (100 * rate, 0.98), xycoords=("data", "axes fraction"), rotation=90, fontsize=7,
                color="#666666", ha="right", va="top", zorder=1, bbox={"color": "white", "pad": 0.6})  # fmt: skip


# Texts of comparisons, chosen by the numbers alone.

_MAX_NAMES = 3
"""Longer lists of names are replaced by their number."""

EQUAL_SHARE = 0.05
"""Values that differ by less than this share count as about equal."""


def millimetres(value: float) -> str:
    """Format a length in millimetres with three significant digits."""
    return f"{value:.0f} mm" if abs(value) >= 100 else f"{value:#.3g} mm".replace(". mm", " mm")


def percent(share: float) -> str:
    """Format a share (0-1) in per cent, without trailing zeros."""
    return f"{100 * share:.2f}".rstrip("0").rstrip(".") + " %"


def counted(number: int, thing: str) -> str:
    """ "1 frame", "2 frames"."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def compared_with_paper(ours: float, paper: float) -> str:
    """Describe a ratio to the paper, such as "lower than in the paper, by 20 %"."""
    if abs(ours - paper) <= EQUAL_SHARE * abs(paper):
        return "about as in the paper"
    factor = max(ours, paper) / max(min(ours, paper), 1e-12)
    times = f"by {100 * (factor - 1):.0f} %" if factor < 2 else f"by a factor of {factor:.1f}"
    return f"{'higher' if ours > paper else 'lower'} than in the paper, {times}"


def at_rate(rows: Iterable[Row], method: str, rate: float) -> Row:
    """Return a method's row at the defect rate nearest to `rate`."""
    return min((row for row in rows if row["method"] == method), key=lambda row: abs(row["defect_rate"] - rate))


def won_rates(rows: Sequence[Row], method: str, rivals: Sequence[str], value: str = "rmse_mm") -> list[float]:
    """Defect rates at which the method's value is below that of every rival."""
    theirs = [row for row in rows if row["method"] in rivals]
    return [
        row["defect_rate"]
        for row in rows
        if row["method"] == method
        and all(row[value] < other[value] for other in theirs if other["defect_rate"] == row["defect_rate"])
    ]


def spans(rates: Iterable[float], among: Sequence[float]) -> str:
    """Format defect rates as spans of neighbours among all measured rates: "0-40 %, 60-80 %", or "none"."""
    chosen = set(rates)
    groups: list[list[float]] = []
    open_group = False
    for rate in sorted(set(among)):
        if rate in chosen:
            if not open_group:
                groups.append([])
            groups[-1].append(rate)
        open_group = rate in chosen
    if not groups:
        return "none"
    return ", ".join(
        percent(group[0]) if len(group) == 1 else f"{percent(group[0])[:-2]}-{percent(group[-1])}" for group in groups
    )


def joined(words: Sequence[str]) -> str:
    """ "a, b and c"."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def named(words: Sequence[str], total: int) -> str:
    """Join a few names; for more, return their number of the total."""
    return joined(words) if len(words) <= _MAX_NAMES else f"{len(words)} of {total}"


def lowest(rows: Iterable[Row], value: Callable[[Row], float]) -> Row:
    """The row with the smallest value."""
    return min(rows, key=value)
