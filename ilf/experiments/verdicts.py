"""Words for comparisons: what is said follows from the numbers alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence

from .experiment import Row

_NAMED = 3
"""More names than that are counted."""

EQUAL_SHARE = 0.05
"""Values that differ by less than this share are called about the same."""


def millimetres(value: float) -> str:
    """A length in millimetres, to three digits that matter."""
    return f"{value:.0f} mm" if abs(value) >= 100 else f"{value:#.3g} mm".replace(". mm", " mm")


def percent(share: float) -> str:
    """A share (0-1) in per cent, with the decimals it has."""
    return f"{100 * share:.2f}".rstrip("0").rstrip(".") + " %"


def counted(number: int, thing: str) -> str:
    """ "1 frame", "2 frames"."""
    return f"{number} {thing}{'s' * (number != 1)}"


def how_it_compares(ours: float, paper: float) -> str:
    """ "lower than in the paper" and the like, with the factor."""
    if abs(ours - paper) <= EQUAL_SHARE * abs(paper):
        return "about as in the paper"
    factor = max(ours, paper) / max(min(ours, paper), 1e-12)
    times = f"by {100 * (factor - 1):.0f} %" if factor < 2 else f"by a factor of {factor:.1f}"
    return f"{'higher' if ours > paper else 'lower'} than in the paper, {times}"


def at_rate(rows: Iterable[Row], method: str, rate: float) -> Row:
    """A method's row at the defect rate that is nearest to the one asked for."""
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
    """Defect rates, named as spans of neighbours among all that were measured: "0-40 %, 60-80 %", or "none"."""
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
    """A few names, or how many of all it would be."""
    return joined(words) if len(words) <= _NAMED else f"{len(words)} of {total}"


def lowest(rows: Iterable[Row], value: Callable[[Row], float]) -> Row:
    """The row with the smallest value."""
    return min(rows, key=value)
