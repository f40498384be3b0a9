"""Curves of a frame's blocks over the iterations, as SVG."""

from __future__ import annotations

import base64
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .._runtime.formatting import length_text
from ..data.results import History, IterationRecord
from ..drawing.colours import round_up
from .subject import Subject
from .templates import render

MAX_CURVES = 6

_DASHES = (("", "———"), ("7 3", "– – –"), ("2 3", "······"))
"""Dash patterns of SVG, and text that looks like them."""
_MAX_LUMA = 135
"""Brightness of lines that are visible on white, 0-255."""

Points = list[tuple[float, float]]


@dataclass(frozen=True)
class LineStyle:
    """The look of a block's curves: colour for SVG and HTML, dashes for SVG, and text that looks like them."""

    label: int
    colour: str
    dashes: str
    sample: str


def curve_lines(subject: Subject) -> list[LineStyle]:
    """Choose the blocks whose curves are shown: the iterated blocks that have filled most pixels."""
    iterated = {label: result for label, result in subject.completion.results.items() if len(result.history)}
    chosen = sorted(iterated, key=lambda label: (-iterated[label].outcome.recovered, label))[:MAX_CURVES]
    return [
        LineStyle(label, _line_colour(subject.colour_of(label)), *_DASHES[number % len(_DASHES)])
        for number, label in enumerate(chosen)
    ]


def curve_plots(subject: Subject, lines: Sequence[LineStyle]) -> dict[str, str]:
    """Plot sigma_i and the L1 norm of the lines' blocks over the iterations: title -> data URI of an SVG."""
    results = subject.completion.results

    def points(value: Callable[[IterationRecord, History], float]) -> list[tuple[LineStyle, Points]]:
        found = []
        for line in lines:
            history = results[line.label].history
            values = [(float(record.i), value(record, history)) for record in history]
            found.append((line, [point for point in values if math.isfinite(point[1])]))
        return [(line, places) for line, places in found if places]

    plots = {}
    if sigma := points(lambda record, _: math.log10(record.sigma_i) if record.sigma_i > 0 else math.nan):
        limits = {results[line.label].parameters.s_criteria for line in lines}
        limit = math.log10(limits.pop()) if len(limits) == 1 and min(limits) > 0 else None
        plots["sigma_i"] = _plot(sigma, lambda power: length_text(10.0**power), least_step=1, criterion=limit)
    if l1 := points(lambda record, history: 100 * record.l1 / history[-1].l1 if history[-1].l1 > 0 else math.nan):
        plots["L1 norm, in percent of its last value"] = _plot(l1, lambda share: f"{share:.6g} %")
    return plots


def _plot(
    curves: Sequence[tuple[LineStyle, Points]],
    text: Callable[[float], str],
    least_step: float = 0.02,
    criterion: float | None = None,
) -> str:
    """Draw curves; the axis has about five ticks at round values, `text` is their label."""
    values = [y for _, places in curves for _, y in places] + ([] if criterion is None else [criterion])
    step = max(round_up(max(max(values) - min(values), 1e-9) / 5), least_step)
    first = math.floor(min(values) / step)
    last = max(math.ceil(max(values) / step), first + 1)
    iterations = max(x for _, places in curves for x, _ in places)
    svg = render(
        "plot.svg",
        curves=curves,
        last=max(iterations, 1),
        step=max(1, round(round_up(max(iterations, 1) / 5))),
        low=first * step,
        high=last * step,
        ticks={number * step: text(number * step) for number in range(first, last + 1)},
        criterion=criterion,
    )
    return f"data:image/svg+xml;base64,{base64.b64encode(svg.encode()).decode()}"


def _line_colour(colour: tuple[int, int, int]) -> str:
    """Format a block's colour for SVG and HTML, darkened as far as lines on white need."""
    red, green, blue = colour
    luma = 0.299 * red + 0.587 * green + 0.114 * blue
    factor = min(1.0, _MAX_LUMA / max(luma, 1))
    return "#{:02x}{:02x}{:02x}".format(*(round(factor * part) for part in colour))
