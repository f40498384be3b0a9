"""Curves of a frame's blocks over the iterations, as SVG; it needs no style sheet, but can be styled by one."""

from __future__ import annotations

import colorsys
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .._runtime.formatting import grouped, length_text
from ..data.results import History, IterationRecord
from ..drawing.colours import Colour
from .content import Legend, Plot, Subject

# Colours of pages and plots.

_BRIGHTNESS = 0.21
"""Luminance of lines that are visible on white and on near black."""


def hex_of(colour: Colour) -> str:
    """Format a colour for HTML and SVG."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


def line_colour(colour: Colour) -> Colour:
    """Adapt the lightness of a block's colour for lines on any background; hue and saturation stay."""
    hue, _, saturation = colorsys.rgb_to_hls(*(part / 255 for part in colour))
    low, high = 0.0, 1.0
    for _ in range(12):
        middle = (low + high) / 2
        bright = _luminance(colorsys.hls_to_rgb(hue, middle, saturation)) > _BRIGHTNESS
        low, high = (low, middle) if bright else (middle, high)
    red, green, blue = (round(255 * part) for part in colorsys.hls_to_rgb(hue, low, saturation))
    return red, green, blue


def _luminance(rgb: tuple[float, float, float]) -> float:
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in rgb)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


MAX_CURVES = 6

_SIZE = 560, 320
_LEFT, _RIGHT, _TOP, _BOTTOM = 62, 12, 12, 44
_DASHES = ("", "7 3", "2 3")
_MAX_POINTS = 400
_INK, _FAINT = "#444a52", "#c9cdd3"

Point = tuple[float, float]


@dataclass(frozen=True)
class _Line:
    points: tuple[Point, ...]
    colour: Colour
    dashes: str


@dataclass(frozen=True)
class _Axis:
    """An axis: its range and its tick labels."""

    low: float
    high: float
    ticks: tuple[tuple[float, str], ...]

    def place(self, value: float) -> float:
        return (value - self.low) / (self.high - self.low)


def curve_plots(subject: Subject) -> tuple[Plot, ...]:
    """Plot sigma_i and the L1 norm over the iterations of the blocks that have filled most; () if none was iterated."""
    chosen = curve_blocks(subject)
    if not chosen:
        return ()
    results = subject.completion.results
    looks = {
        label: (line_colour(subject.colour_of(label)), _DASHES[number % len(_DASHES)])
        for number, label in enumerate(chosen)
    }

    def lines(value: Callable[[IterationRecord, History], float]) -> list[_Line]:
        found = []
        for label, (colour, dashes) in looks.items():
            history = results[label].history
            points = [(float(record.i), value(record, history)) for record in history]
            found.append(_Line(_thinned([point for point in points if math.isfinite(point[1])]), colour, dashes))
        return [line for line in found if line.points]

    def legend(text: Callable[[IterationRecord], str]) -> tuple[Legend, ...]:
        return tuple(
            Legend(
                colour, f"{label} {subject.name_of(label)}: {text(results[label].history[-1])}", dashes, is_line=True
            )
            for label, (colour, dashes) in looks.items()
        )

    limits = {results[label].parameters.s_criteria for label in chosen}
    limit = math.log10(limits.pop()) if len(limits) == 1 and min(limits) > 0 else None
    sigma = lines(lambda record, _: math.log10(record.sigma_i) if record.sigma_i > 0 else math.nan)
    l1 = lines(lambda record, history: 100 * record.l1 / history[-1].l1 if history[-1].l1 > 0 else math.nan)
    plots = []
    if sigma:
        plots.append(
            _plot(
                "sigma_i",
                sigma,
                _log_axis([*_values(sigma), *([] if limit is None else [limit])]),
                legend(lambda record: f"ends at {length_text(record.sigma_i)}"),
                limit,
            )
        )
    if l1:
        title = "L1 norm, in percent of its last value"
        plots.append(
            _plot(title, l1, _linear_axis(_values(l1)), legend(lambda record: f"ends at {grouped(round(record.l1))} m"))
        )
    return tuple(plots)


def curve_blocks(subject: Subject, most: int = MAX_CURVES) -> list[int]:
    """Return the labels of the blocks whose curves are shown: the iterated blocks that have filled most pixels."""
    iterated = {label: result for label, result in subject.completion.results.items() if len(result.history)}
    return sorted(iterated, key=lambda label: (-iterated[label].outcome.recovered, label))[:most]


def _values(lines: Sequence[_Line]) -> list[float]:
    return [y for line in lines for _, y in line.points]


def _log_axis(values: Sequence[float]) -> _Axis:
    low, high = math.floor(min(values)), max(math.ceil(max(values)), math.floor(min(values)) + 1)
    step = max(1, math.ceil((high - low) / 6))
    return _Axis(low, high, tuple((power, length_text(10.0**power)) for power in range(low, high + 1, step)))


def _linear_axis(values: Sequence[float], unit: str = " %") -> _Axis:
    low, high = min(values), max(values)
    if high - low < 1e-3 * max(abs(high), 1):
        low, high = low - 1, high + 1
    step = _round_step((high - low) / 4)
    low, high = math.floor(low / step) * step, math.ceil(high / step) * step
    digits = max(0, -math.floor(math.log10(step) + 1e-9))
    count = round((high - low) / step)
    return _Axis(low, high, tuple((low + n * step, f"{low + n * step:.{digits}f}{unit}") for n in range(count + 1)))


def _round_step(least: float) -> float:
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in (1, 2, 5, 10) if step * power >= least)


def _plot(
    title: str, lines: Sequence[_Line], axis: _Axis, legend: tuple[Legend, ...], limit: float | None = None
) -> Plot:
    width, height = _SIZE
    right, bottom = width - _RIGHT, height - _BOTTOM
    last = max(x for line in lines for x, _ in line.points)
    step = max(1, round(_round_step(last / 5)))
    across = _Axis(0, max(last, 1), tuple((float(n), str(n)) for n in range(0, int(last) + 1, step)))

    def x_of(value: float) -> float:
        return _LEFT + across.place(value) * (right - _LEFT)

    def y_of(value: float) -> float:
        return bottom - axis.place(value) * (bottom - _TOP)

    parts = []
    for value, text in axis.ticks:
        y = y_of(value)
        parts.append(f'<line class="grid" x1="{_LEFT}" y1="{y:.1f}" x2="{right}" y2="{y:.1f}" stroke="{_FAINT}"/>')
        parts.append(_text(_LEFT - 7, y + 4.5, text, "end"))
    for value, text in across.ticks:
        x = x_of(value)
        parts.append(
            f'<line class="grid" x1="{x:.1f}" y1="{bottom}" x2="{x:.1f}" y2="{bottom + 5}" stroke="{_FAINT}"/>'
        )
        parts.append(_text(x, bottom + 19, text, "middle"))
    parts.append(_text((_LEFT + right) / 2, height - 6, "iteration", "middle"))
    if limit is not None:
        y = y_of(limit)
        parts.append(
            f'<line class="ink" x1="{_LEFT}" y1="{y:.1f}" x2="{right}" y2="{y:.1f}" stroke="{_INK}" '
            f'stroke-dasharray="3 4"/>{_text(_LEFT + 6, y + 15, "S_criteria", "start")}'
        )
    for line in lines:
        places = " ".join(f"{x_of(x):.1f},{y_of(y):.1f}" for x, y in line.points)
        look = f'stroke="{hex_of(line.colour)}" stroke-width="2"'
        if len(line.points) == 1:
            across_at, down_at = places.split(",")
            parts.append(f'<circle cx="{across_at}" cy="{down_at}" r="3.5" fill="{hex_of(line.colour)}"/>')
        else:
            dashes = f' stroke-dasharray="{line.dashes}"' if line.dashes else ""
            parts.append(f'<polyline points="{places}" fill="none" {look} stroke-linejoin="round"{dashes}/>')
    svg = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" '
        f'font-family="system-ui, sans-serif" font-size="14">{"".join(parts)}</svg>'
    )
    return Plot(title, svg, _SIZE, legend)


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text class="ink" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" fill="{_INK}">{text}</text>'


def _thinned(points: Sequence[Point]) -> tuple[Point, ...]:
    """Reduce points to a visible number, keeping the highest and the lowest of each stretch."""
    if len(points) <= _MAX_POINTS:
        return tuple(points)
    stretch = math.ceil(2 * len(points) / _MAX_POINTS)
    kept = {points[0], points[-1]}
    for start in range(0, len(points), stretch):
        few = points[start : start + stretch]
        kept |= {min(few, key=lambda point: point[1]), max(few, key=lambda point: point[1])}
    return tuple(sorted(kept))
