"""The pictures of a frame: colour with its blocks, depth before and after, errors, origin of the depth, and curves."""

from __future__ import annotations

import base64
import io
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from .._runtime.formatting import counted, length_text
from ..completion.confidence.expected_error import expected_error
from ..data.pictures import MISSING, Colour, depth_colours, difference_colours, error_colours
from ..data.results import History, IterationRecord
from ..drawing.blocks import inner_points
from ..drawing.colours import (
    log_indices,
    robust_depth_levels,
    robust_difference_level,
    robust_error_levels,
    round_up,
    to_indices,
)
from ..evaluation.hold_out import RunEvaluation
from .subject import Subject
from .templates import render

_QUALITY = 85
_MIN_LABEL_RADIUS = 0.014
"""Minimum radius of a block's inner circle, as a share of the picture's width, to print the block's number."""
_MM = np.float32(1000)


@dataclass(frozen=True)
class Picture:
    """A picture with its colour scale; images are data URIs.

    Attributes
    ----------
    title, image, caption : str
    bar : str
        Colour bar as wide as the picture; "" for none.
    ticks : tuple of str
        Labels of the colour bar, from its start to its end.
    legend : mapping of str to Colour
    """

    title: str
    image: str = field(repr=False)
    caption: str = ""
    bar: str = field(default="", repr=False)
    ticks: tuple[str, ...] = ()
    legend: Mapping[str, Colour] = field(default_factory=dict)


def frame_pictures(subject: Subject, hidden: RunEvaluation | None, most: int) -> Iterator[Picture]:
    """Draw all pictures of a frame.

    Parameters
    ----------
    subject : Subject
    hidden : RunEvaluation or None
    most : int
        Maximum width and height of a picture [px].
    """
    frame, completion = subject.run.frame, subject.completion
    shape = _reduced(frame.shape, most)
    blocks = np.unique(subject.run.blocks.labels[subject.run.blocks.labels > 0]).size
    caption = f"{counted(blocks, 'block')}, numbered as in the table." if blocks else "There are no blocks."
    yield Picture("Colour and blocks", _numbered(subject, shape), caption)
    levels = robust_depth_levels(np.stack([frame.depth, completion.depth]))
    ticks = tuple(f"{level:.2f} m" for level in np.linspace(*levels, 3))
    for title, depth in (("Depth in", frame.own_depth), ("Depth out", completion.depth)):
        indices, table = to_indices(_resized(depth, shape), *levels), depth_colours()
        legend = {} if indices.all() else {"no depth": MISSING}
        yield Picture(title, _png(indices, table), "", _bar(table), ticks, legend)
    yield _origin(subject, shape)
    expected = expected_error(completion)
    if np.isfinite(expected).any():
        yield _expected(expected, shape)
    if frame.ground_truth is not None and completion.filled.any():
        error = np.where(completion.filled, completion.depth - frame.ground_truth, np.float32(np.nan))
        yield _difference("Error against ground truth", error, shape, "Of filled pixels: depth out minus ground truth.")
    if hidden is not None:
        error = np.full(frame.shape, np.nan, np.float32)
        for part in hidden.parts:
            error.ravel()[part.places[part.filled]] = part.error[part.filled]
        yield _difference("Error on hold-out", error, shape, "Of held-out pixels: completed minus measured depth.")
    change = completion.depth - frame.depth
    if np.nanmax(np.abs(change), initial=0.0) > 0:
        yield _difference("Change of measured depth", change, shape, "Depth out minus depth in.")


def thumbnail(subject: Subject, most: int) -> str:
    """Draw a small colour image with the outlines of its blocks, as data URI."""
    return _jpeg(Image.fromarray(_outlined(subject, _reduced(subject.run.frame.shape, most))))


def _expected(expected: NDArray[np.float32], shape: tuple[int, int]) -> Picture:
    low, high = robust_error_levels(expected * _MM)
    table = error_colours()
    image = _png(log_indices(_resized(expected, shape), (low, high)), table)
    caption = "About 68 % of the true errors of filled pixels are expected to lie within it."
    ticks = f"{low:g} mm", f"{np.sqrt(low * high):.3g} mm", f"{high:g} mm"
    return Picture("Expected error", image, caption, _bar(table), ticks, legend={"not filled": MISSING})


def _difference(title: str, metres: NDArray[np.float32], shape: tuple[int, int], caption: str) -> Picture:
    level = robust_difference_level(metres * _MM)
    table = difference_colours()
    image = _png(to_indices(_resized(metres, shape) * _MM, -level, level), table)
    ticks = f"\N{MINUS SIGN}{level:g} mm", "0", f"+{level:g} mm"
    return Picture(title, image, caption, _bar(table), ticks, legend={"not compared": MISSING})


def _origin(subject: Subject, shape: tuple[int, int]) -> Picture:
    frame, completion = subject.run.frame, subject.completion
    nowhere = np.zeros(frame.shape, bool)
    invalid = nowhere if frame.invalid_mask is None else frame.invalid_mask & np.isfinite(frame.measured)
    outside = nowhere if frame.outside_view is None else frame.outside_view
    parts: tuple[tuple[str, Colour, NDArray[np.bool_]], ...] = (  # each above those before
        ("still missing", MISSING, ~nowhere),
        ("marked invalid", (196, 64, 80), invalid),
        ("measured", (86, 96, 110), frame.known),
        ("filled by blocks", (38, 150, 120), completion.filled),
        ("depth by hand", (158, 110, 206), completion.by_hand),
        ("extrapolated", (222, 168, 40), completion.extrapolated),
        ("measured by neighbours", (140, 170, 60), completion.from_neighbours),
        ("outside the view", (60, 100, 160), outside),
        ("filled outside the view", (120, 170, 225), outside & completion.filled),
    )
    origin, table = np.zeros(frame.shape, np.uint8), np.zeros((256, 3), np.uint8)
    for number, (_, colour, there) in enumerate(parts):
        origin[there], table[number] = number, colour
    shares = np.bincount(origin.ravel(), minlength=len(parts)) / origin.size
    legend = {f"{name} {share:.1%}": colour for (name, colour, _), share in zip(parts, shares, strict=True) if share}
    return Picture("Origin of the depth", _png(_resized(origin, shape), table), legend=legend)


def _outlined(subject: Subject, shape: tuple[int, int]) -> NDArray[np.uint8]:
    """Draw the colour image at a shape, with the blocks' borders in their colours on both sides."""
    blocks = subject.run.blocks.labels
    picture = np.array(_resized(subject.run.frame.rgb, shape, smooth=True))
    labels = _resized(blocks, shape)
    there = np.flatnonzero(np.bincount(blocks.ravel()))
    numbers = np.searchsorted(there, labels).astype(np.float32)  # small enough to be exact
    side = 3 if max(shape) < 900 else 5
    kernel = np.ones((side, side), np.uint8)
    border = (cv2.dilate(numbers, kernel) != cv2.erode(numbers, kernel)) & (labels > 0)
    table = np.array([subject.colour_of(int(label)) for label in there], np.uint8)
    picture[border] = table[np.searchsorted(there, labels[border])]
    return picture


def _numbered(subject: Subject, shape: tuple[int, int]) -> str:
    """Draw the outlined colour image with the numbers of all blocks that are large enough."""
    image = Image.fromarray(_outlined(subject, shape))
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(max(shape[1] / 40, 8))
    width = subject.run.frame.shape[1]
    for label, (x, y, radius) in inner_points(subject.run.blocks.labels).items():
        if radius >= _MIN_LABEL_RADIUS * width:
            at = x * shape[1] / width, y * shape[1] / width
            draw.text(at, str(label), "white", font, anchor="mm", stroke_width=2, stroke_fill="black")
    return _jpeg(image)


def _reduced(shape: tuple[int, int], most: int) -> tuple[int, int]:
    """Return height and width of a picture reduced to at most `most` pixels on its longer side."""
    factor = min(1.0, most / max(shape))
    return max(round(shape[0] * factor), 1), max(round(shape[1] * factor), 1)


def _resized(values: NDArray[Any], shape: tuple[int, int], smooth: bool = False) -> NDArray[Any]:
    """Resample an array of pixels: by nearest neighbour, or averaged (`smooth`)."""
    if values.shape[:2] == shape:
        return values
    how = cv2.INTER_AREA if smooth else cv2.INTER_NEAREST
    return np.asarray(cv2.resize(values, shape[::-1], interpolation=how))


def _bar(table: NDArray[np.uint8]) -> str:
    """Draw the colour bar of a lookup table, without the colour of missing values."""
    return _png(np.arange(1, 256, dtype=np.uint8)[None], table)


def _png(indices: NDArray[np.uint8], table: NDArray[np.uint8]) -> str:
    """Encode indices, uint8 (H, W), into a lookup table, uint8 (256, 3), without loss."""
    image = Image.fromarray(indices)
    image.putpalette(table.tobytes())
    return _data_uri(image, "png")


def _jpeg(image: Image.Image) -> str:
    return _data_uri(image, "jpeg", quality=_QUALITY)


def _data_uri(image: Image.Image, kind: str, **options: int) -> str:
    buffer = io.BytesIO()
    image.save(buffer, kind, optimize=True, **options)
    return f"data:image/{kind};base64,{base64.b64encode(buffer.getvalue()).decode()}"


# Curves of its blocks over the iterations, as SVG.

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
