"""Layers: what each content of a view shows, a function of `ViewData`. A new content is one function and one line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush, QColor

from ilf.drawing.blocks import STAGES, marked_picture
from ilf.drawing.colours import robust_difference_level, robust_error_levels, sample, to_indices

from ..base.theme import blend
from .colours import Levels, difference_table, error_table, full_levels, mark_table, strength_table
from .drawings import missing_brush
from .view_data import (
    BEFORE_IN,
    BEFORE_OUT,
    COMPARABLE,
    DIFFERENCE,
    EARLIER,
    EVALUATION,
    FLICKERS,
    INTERPOLATED,
    RUNS,
    SIDES,
    Depth,
    MarkedDepth,
    Mask,
    Spectrum,
    ViewData,
    capital,
    operands_of,
    short_title,
)

Legend = list[tuple[QBrush, str]]


@dataclass(frozen=True, eq=False)
class Layer:
    """What a content shows: arrays of the frame, how they become values with a unit, and the colours of the values.

    Attributes
    ----------
    arrays : tuple of ndarray, shape (H, W)
        What is shown; they may be changed in place later. Empty if there is only `message`.
    measure : callable
        From the arrays to values in the unit of the colour bar, NaN = missing; also from the same piece of each, even a
        single pixel, so that a value depends on its own pixel alone.
    levels : (float, float)
        Values at the ends of the colours.
    logarithmic : bool
        Whether colours are spaced logarithmically.
    table : ndarray of uint8, shape (256, 4)
        Colours of the values; index 0 is missing.
    stale : ndarray of bool, shape (H, W), or None
        Pixels that are shown in grey.
    marks : callable or None
        From the arrays to indices into `mark_table`, drawn where values are missing.
    has_dots : bool
        Whether single pixels of a sparse picture are drawn as dots.
    picture : callable or None
        Finds a colour picture, uint8 (H, W, 3), which is shown instead of values until these are other arrays.
    message, text : str
        Shown in place of the picture, if it is not "", and beside the title.
    legend : list of (QBrush, str)
    """

    arrays: tuple[NDArray[Any], ...] = ()
    measure: Callable[..., NDArray[np.floating]] = lambda values: values
    levels: Levels = (0.0, 1.0)
    logarithmic: bool = False
    table: NDArray[np.uint8] = field(default_factory=lambda: np.zeros((256, 4), np.uint8))
    stale: Mask | None = None
    marks: Callable[..., NDArray[np.uint8]] | None = None
    mark_table: NDArray[np.uint8] | None = None
    has_dots: bool = False
    picture: Callable[[], NDArray[np.uint8]] | None = None
    message: str = ""
    text: str = ""
    legend: Legend = field(default_factory=list)

    @property
    def has_values(self) -> bool:
        """Whether there are values with a scale, not only a colour picture or a message."""
        return bool(self.arrays) and self.picture is None and not self.message

    @property
    def look(self) -> list[Any]:
        """What the colours of the arrays follow from."""
        tables = [None if table is None else table.tobytes() for table in (self.table, self.mark_table)]
        return [self.levels, self.logarithmic, *tables]

    def indices(self, *arrays: NDArray[Any]) -> NDArray[np.uint8]:
        """Indices into the table of the arrays, or of the same piece of each."""
        values, levels = self.measure(*arrays), self.levels
        if self.logarithmic:
            values, levels = np.log(values), (float(np.log(levels[0])), float(np.log(levels[1])))
        return to_indices(values, *levels)

    def value_at(self, x: int, y: int, arrays: Sequence[NDArray[Any]]) -> float | None:
        """Value of the arrays at a pixel, in the unit of the colour bar; None if there is none."""
        if not arrays or not (0 <= y < arrays[0].shape[0] and 0 <= x < arrays[0].shape[1]):
            return None
        value = float(self.measure(*(array[y : y + 1, x : x + 1] for array in arrays))[0, 0])
        return value if np.isfinite(value) else None


class Content(NamedTuple):
    """Title of a content, function that finds its layer, names of the data that it uses (of `READ`, or found by
    workers: it is drawn again when these change), kind of its colour range ("" for none), unit of its colour bar."""

    title: str
    find: Callable[[ViewData, str], Layer]
    uses: frozenset[str] = frozenset()
    range_kind: str = ""
    unit: str = ""


def checked(content: str) -> str:
    """Return the name; raise ValueError if it is not a content's."""
    pair = operands_of(content)
    there = *CONTENTS, DIFFERENCE, EVALUATION, *SIDES
    if content in there or (pair and set(pair) <= set(COMPARABLE)):
        return content
    raise ValueError(f"a cell cannot show {content!r}; it can show {', '.join(there)}")


def content_of(name: str) -> Content:
    """How a concrete content is drawn."""
    return _DIFFERENCE if name not in CONTENTS and operands_of(name) else CONTENTS[name]


def uses(name: str, data: ViewData) -> frozenset[str]:
    """Parts of the data that a concrete content uses now."""
    depths = operands_of(name) or ()
    if name == "result" and (data.swipe_column is not None or data.shows_a_as_result):
        depths = data.sides
    return content_of(name).uses.union(*(_PARTS[depth] for depth in depths))


def title_of(name: str, data: ViewData) -> str:
    """Title of a concrete content."""
    if name == "result" and data.shows_a_as_result:
        name = data.sides[0]
    names = data.names
    if name == "result" and data.swipe_column is not None:
        first, second = (short_title(side, names) for side in data.sides)
        return f"A: {first} | B: {second}"
    if name == "extraction":
        return f"{CONTENTS[name].title}: {STAGES[data.stage.name].lower()}"
    if title := content_of(name).title:
        return title
    pair = operands_of(name)
    if pair is None:
        return names.get(name) or capital(short_title(name, names))
    return f"Difference: {short_title(pair[0], names)} \N{MINUS SIGN} {short_title(pair[1], names)}"


def levels_of(
    data: ViewData, kind: str, robust: Callable[[], Levels], values: Callable[[], NDArray[np.floating]]
) -> Levels:
    """Colour range of a kind for some values, in its unit, with this robust range; the former one during playing."""
    former = data.ranges[kind].levels
    if data.played is not None and former is not None:
        return former
    return data.ranges[kind].find(robust, lambda: full_levels(values()))


def striped(data: ViewData, name: str) -> dict[str, Mask]:
    """What is striped over the picture of a concrete content -> its pixels, from below."""
    is_colour, frame = name == "colour", data.frame
    if frame is None:
        return {}
    shown = _depth_shown(data, name) if name in _PARTS else None
    masks = {
        "extrapolated": None if shown is None else shown.extrapolated,
        "missing": ~np.isfinite(frame.measured) if is_colour and data.shows_missing else None,
        "outside view": frame.outside_view if data.shows_missing or not is_colour else None,
        "unsupported": data.unsupported if name == "expected-error" else None,
        "suspect": data.suspect,
        "invalid": data.invalid_mask,
        "by hand": data.by_hand,
    }
    return {what: mask for what, mask in masks.items() if mask is not None}


_LACKING = {
    "ground_truth": "This frame has no ground truth",
    "guide": "This frame has no guide: File > Load guide\N{HORIZONTAL ELLIPSIS}",
    "from_neighbours": "No depth of neighbours is used: File > Use neighbours",
}
"""What a frame may be without -> what to say then."""


def lacking(content: str, data: ViewData) -> str:
    """Why the frame has nothing of a content; "" if it has, or may get it."""
    needed, frame = operands_of(content) or (content,), data.frame
    there: dict[str, Any] = {"guide": data.guide}
    if frame is not None:
        there |= {"ground_truth": frame.ground_truth, "from_neighbours": frame.from_neighbours}
    return next((why for name, why in _LACKING.items() if name in needed and there.get(name) is None), "")


def missing_reason(depth: str, data: ViewData) -> str:
    """Why a depth is not there."""
    reasons = {
        "result": data.no_result,
        EARLIER: "No run before this one",
        INTERPOLATED: "Interpolating\N{HORIZONTAL ELLIPSIS}",
        **_LACKING,
        BEFORE_IN: data.before.text,
        BEFORE_OUT: data.before.text if data.before.depth_in is None else "The frame before has no result",
    }
    if depth in RUNS:
        return f"No run {RUNS.index(depth) + 1} is ticked for comparison"
    return reasons.get(depth, "")


# Colour, masks over the dimmed colour image, and edges.


def colour(data: ViewData, name: str) -> Layer:
    """The colour image, which the view's fills of blocks lie over."""
    if data.frame is None:
        return Layer()
    rgb = data.frame.rgb
    return Layer((rgb,), picture=lambda: rgb)


_MASK_COLOURS = {"extrapolated": (90, 200, 255), "invalid_mask": (255, 144, 32), "from_neighbours": (120, 220, 110)}


def mask(data: ViewData, name: str) -> Layer:
    """Extrapolated pixels, invalid ones, or those from neighbours, with their share of the frame."""
    result, frame, colour = data.depth("result"), data.frame, _MASK_COLOURS[name]
    if frame is None:
        return Layer()
    masks = {"invalid_mask": data.invalid_mask, "from_neighbours": frame.from_neighbours}
    shown, rgb = masks.get(name, None if result is None else result.extrapolated), frame.rgb
    if shown is None:
        reasons = {"invalid_mask": "No invalid depth", **_LACKING}
        otherwise = data.no_result if data.result is None else "Nothing is extrapolated"
        return Layer(message=reasons.get(name, otherwise))
    return Layer(
        (shown, rgb),
        picture=lambda: marked_picture(rgb, shown, colour),
        text=f"{np.count_nonzero(shown) / shown.size:.1%} of the frame",
        # invalid depth has stripes, which have a legend already
        legend=[] if name == "invalid_mask" else [(QBrush(QColor(*colour)), name.replace("_", " "))],
    )


def edges(data: ViewData, name: str) -> Layer:
    """Edge strength, from which blocks are extracted, or crease strength, if the detector finds them, 0-1."""
    found = data.edges
    strength = None if found is None else found.crease if name == "creases" else found.strength
    if strength is not None:
        return Layer((strength,), table=strength_table())
    if found is not None:
        return Layer(message="Only the detector rgbd finds creases")
    return Layer(message="" if data.frame is None else "Finding edges\N{HORIZONTAL ELLIPSIS}")


# A stage of the extraction, and the spectrum of a block.


def stage(data: ViewData, name: str) -> Layer:
    """The selected stage of the extraction."""
    board = data.stage
    legend = [(QBrush(QColor(*colour)), text) for colour, text in board.legend]
    picture = board.picture
    if picture is None:
        return Layer(message=board.message, text=board.text, legend=legend)
    if picture.ndim == 3:
        return Layer((picture,), picture=lambda: picture, text=board.text, legend=legend)
    return Layer(
        (picture,),
        lambda indices: np.where(indices > 0, (indices - np.float32(1)) / 254, np.float32(np.nan)),
        table=strength_table(),
        text=board.text,
        legend=legend,
    )


_BAND = 90, 230, 255
_SPECTRUM_SIDE = 512
"""Side of the picture of a spectrum, about."""


def spectrum(data: ViewData, name: str) -> Layer:
    """The spectrum of the selected block, with the pass band of its filter; it has no pixels of the frame."""
    shown = data.spectrum
    if isinstance(shown, str):
        return Layer(message=shown)
    legend = [(QBrush(QColor(*_BAND)), "pass band")]
    return Layer((shown.magnitude,), picture=lambda: _spectrum_picture(shown), text=shown.text, legend=legend)


def _spectrum_picture(shown: Spectrum) -> NDArray[np.uint8]:
    height, width = shown.magnitude.shape
    scale = max(round(_SPECTRUM_SIDE / max(height, width)), 1)
    colours = strength_table()[1 + np.round(254 * shown.magnitude).astype(np.uint8), :3]
    picture = np.ascontiguousarray(colours.repeat(scale, axis=0).repeat(scale, axis=1))
    # k = 0 is the sample in the middle, as from `fftshift`
    centre = (width // 2 + 0.5) * scale, (height // 2 + 0.5) * scale
    down, across = (2 * max(radius * scale, 3.0) for radius in shown.radii)
    for colour, line in (((0, 0, 0), 4), (_BAND, 2)):
        cv2.ellipse(picture, (centre, (across, down), 0.0), colour, line, cv2.LINE_AA)
    return picture


# Depth.

_STALE = QColor(140, 146, 140)


def _missing(data: ViewData) -> tuple[QBrush, str]:
    return missing_brush(data.colours), "missing"


def depth(data: ViewData, name: str) -> Layer:
    """One depth [m]; missing depth is hatched, stale depth grey; the view stripes extrapolated pixels."""
    shown = _depth_shown(data, name)
    text = data.moment if name == "result" and not data.shows_a_as_result else ""
    if shown is None:
        return Layer(message=missing_reason(name, data), text=text, legend=[_missing(data)])
    stale = _stale_pixels(shown)
    return Layer(
        (shown.depth,),
        levels=data.ranges["depth"].levels or (0.0, 1.0),
        table=data.depth_table,
        stale=stale,
        has_dots=True,
        text=text,
        legend=[*_stale_legend(stale), _missing(data)],
    )


def _depth_shown(data: ViewData, name: str) -> MarkedDepth | None:
    """The depth to draw; depth in includes invalid depth, under its stripes."""
    if name == "depth-in":
        return None if data.frame is None else MarkedDepth(data.frame.measured)
    column = data.swipe_column
    swiped = data.swiped(column) if name == "result" and column is not None else None
    return data.depth(name) if swiped is None else swiped


def _stale_pixels(shown: MarkedDepth) -> Mask:
    return np.zeros(shown.depth.shape, bool) if shown.stale is None else shown.stale


def _stale_legend(stale: Mask) -> Legend:
    return [(QBrush(_STALE), "stale")] if stale.any() else []


# The difference of two depths in millimetres, centred at 0, such as the error against ground truth.

_MM = np.float32(1000)
_FLICKER_PERCENT = 90
"""Share of the pixels in the colour range of flicker: beside outlines, a moving camera changes depth by far more."""


def difference(data: ViewData, name: str) -> Layer:
    """The first depth minus the second; pixels with only one of them are marked.

    It stays to be seen while side A is shown in place of the result.
    """
    pair = operands_of(name) or ("result", "depth-in")
    one, other = (data.own_depth(operand) for operand in pair)
    if one is None or other is None:
        missing = pair[0] if one is None else pair[1]
        return Layer(message=missing_reason(missing, data), text=_note(data, name))
    first, second = one.depth, other.depth
    sampled = _difference(sample(first), sample(second))
    note = ""
    if not np.nanmax(np.abs(sampled), initial=0.0) > 0:
        note = _equality(first, second)
    message, note = (note, "") if note == _NO_DIFFERENCE else ("", note)

    def robust() -> Levels:
        level = robust_difference_level(sampled[sampled != 0], _FLICKER_PERCENT if name in FLICKERS else 99)
        return -level, level

    # equal pixels, such as most measured ones, are ignored
    low, high = levels_of(data, "signed", robust, lambda: _difference(first, second))
    level = max(abs(low), abs(high))
    colours = [blend(data.colours.background, only, 0.55) for only in (data.colours.good, data.colours.warning)]
    return Layer(
        (first, second),
        _difference,
        (-level, level),
        table=difference_table(data.colours.is_dark),
        marks=_one_only,
        mark_table=mark_table(*colours),
        message=message,
        text=_note(data, name, note),
        legend=[] if message else [*_one_only_legend(data, name, pair, colours), _missing(data)],
    )


def _difference(first: Depth, second: Depth) -> NDArray[np.float32]:
    return (first - second) * _MM


def _one_only(first: Depth, second: Depth) -> NDArray[np.uint8]:
    """1 where only the first is known, 2 where only the second is."""
    known, other = np.isfinite(first), np.isfinite(second)
    return (known & ~other).view(np.uint8) + 2 * (other & ~known).view(np.uint8)


_NO_DIFFERENCE = "No difference"


def _equality(first: Depth, second: Depth) -> str:
    """What to say if two depths are equal: no difference, also in which pixels they have, or only where both are."""
    both = np.isfinite(first) & np.isfinite(second)
    if (first[both] != second[both]).any():
        return ""
    if np.array_equal(np.isfinite(first), np.isfinite(second)):
        return _NO_DIFFERENCE
    return "no difference" if both.any() else "no pixel has both"


def _note(data: ViewData, name: str, text: str = "") -> str:
    """A text about the difference, and the iteration of the result, or which frame is the one before."""
    if name in FLICKERS:
        about = "" if data.before.depth_in is None else data.before.text
    else:
        about = data.moment if "result" in (operands_of(name) or ()) else ""
    return ", ".join(part for part in (text, about) if part)


def _one_only_legend(data: ViewData, name: str, pair: tuple[str, str], colours: list[QColor]) -> Legend:
    if pair[1] == "depth-in" or name in FLICKERS:
        return [(QBrush(colours[0]), "filled" if pair[1] == "depth-in" else "not seen before")]
    names = data.names
    return [(QBrush(colour), f"only {short_title(depth, names)}") for colour, depth in zip(colours, pair, strict=True)]


# The expected error of filled pixels, in logarithmic colours; measured pixels are marked.

_MIN_MM = 0.01


def expected(data: ViewData, name: str) -> Layer:
    """The expected error, grey where depth is stale; the view stripes unsupported pixels."""
    frame, error = data.frame, data.expected
    measured = blend(data.colours.background, data.colours.text, 0.2 if data.colours.is_dark else 0.14)
    legend = [(QBrush(measured), "measured"), _missing(data)]
    if frame is None or error is None:
        waiting = "Estimating\N{HORIZONTAL ELLIPSIS}" if data.error_is_outdated else data.no_result
        return Layer(message=waiting, legend=legend)
    sampled = sample(error) * _MM
    low, high = levels_of(data, "expected", lambda: robust_error_levels(sampled), lambda: error * _MM)
    stale = _stale_pixels(data.result or MarkedDepth(error))
    current = "of the current result" if data.moment else ""
    return Layer(
        (error, frame.own_depth),
        lambda error, depth_in: error * _MM,
        (max(low, _MIN_MM), max(high, 2 * max(low, _MIN_MM))),
        logarithmic=True,
        table=error_table(),
        stale=stale,
        marks=lambda error, depth_in: np.isfinite(depth_in).view(np.uint8),
        mark_table=mark_table(measured),
        text="of the previous result" if data.error_is_outdated else current,
        legend=[*_stale_legend(stale), *legend],
    )


# The table.

_PARTS = {
    "depth-in": {"frame", "invalid_mask"},
    "result": {"result", "swipe", "runs"},
    **{run: {"runs"} for run in (*RUNS, EARLIER)},
    "ground_truth": {"ground_truth"},
    "guide": {"guide"},
    INTERPOLATED: {INTERPOLATED},
    **{before: {"before"} for before in (BEFORE_IN, BEFORE_OUT)},
}
"""Depth -> the parts of the data that it is from."""

_TITLES = {"depth-in": "Depth in", "result": "Depth out", "ground_truth": "Ground truth", "guide": "Guide, fitted"}
_DIFFERENCE = Content("", difference, frozenset({"levels", "runs"}), "signed", "mm")

CONTENTS = {
    "colour": Content("Colour + blocks", colour, frozenset({"frame"})),
    **{
        name: Content(_TITLES.get(name, ""), depth, frozenset({"levels", *parts}), "depth", "m")
        for name, parts in _PARTS.items()
    },
    "error": _DIFFERENCE._replace(title="Error: result \N{MINUS SIGN} ground truth"),
    "expected-error": Content(
        "Expected error",
        expected,
        frozenset({"invalid_mask", "expected", "levels", "result"}),
        "expected",
        "mm",
    ),
    "flicker": _DIFFERENCE._replace(title="Flicker of depth out"),
    "flicker-in": _DIFFERENCE._replace(title="Flicker of depth in"),
    "strength": Content("Edge strength", edges, frozenset({"edges"})),
    "creases": Content("Creases", edges, frozenset({"edges"})),
    "extraction": Content("Extraction", stage, frozenset({"stage"})),
    "extrapolated": Content("Extrapolated", mask, frozenset({"frame", "result"})),
    "invalid_mask": Content("Invalid", mask, frozenset({"frame", "invalid_mask"})),
    "from_neighbours": Content("From neighbours", mask, frozenset({"frame", "from_neighbours"})),
    "spectrum": Content("Spectrum", spectrum, frozenset({"spectrum"})),
}
"""Content -> its title and how it is drawn; differences of any two depths are contents, too."""
