"""Screen-resolution overlays, as arrays: lines around blocks, and stripes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, QRect, QRectF, QSizeF

from ilf.data.blocks import Box, grown, whole

from .drawings import Argb

# The mapping of image pixels to screen pixels, for lines and stripes with the same width at every zoom.

Rims = tuple[tuple[bool, bool], tuple[bool, bool]]


@dataclass(frozen=True)
class Sampling:
    """Mapping of a frame to the device pixels of a view.

    Parameters
    ----------
    scale : float
        Device pixels per image pixel.
    x, y : int
        Device pixel of the frame's corner; may lie outside the view.
    size : (int, int)
        Width and height of the view in device pixels.
    frame : (int, int)
        Width and height of the frame.
    ratio : float
        Device pixels per screen pixel.
    """

    scale: float
    x: int
    y: int
    size: tuple[int, int]
    frame: tuple[int, int]
    ratio: float = 1.0

    @property
    def line_width(self) -> int:
        """Width [device px] of a line of one screen pixel."""
        return max(round(self.ratio), 1)

    @property
    def left(self) -> int:
        """First device pixel, from the left, that shows the frame."""
        return max(self.x, 0)

    @property
    def top(self) -> int:
        """First device pixel, from the top, that shows the frame."""
        return max(self.y, 0)

    @cached_property
    def columns(self) -> NDArray[np.intp]:
        """Image column of each device column that shows the frame."""
        return self._pixels(self.x, self.size[0], self.frame[0])

    @cached_property
    def rows(self) -> NDArray[np.intp]:
        """Image row of each device row that shows the frame."""
        return self._pixels(self.y, self.size[1], self.frame[1])

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of device pixels that show the frame."""
        return len(self.rows), len(self.columns)

    @property
    def rims(self) -> Rims:
        """Whether the frame's rim is visible: above and below, at the left and right."""
        width, height = self.frame
        if 0 in self.shape:
            return (False, False), (False, False)
        above, below = int(self.rows[0]) == 0, int(self.rows[-1]) == height - 1
        return (above, below), (int(self.columns[0]) == 0, int(self.columns[-1]) == width - 1)

    def sample(self, values: NDArray[Any], box: Box) -> NDArray[Any]:
        """Values (H, W) of the image on a box of the device pixels that show the frame."""
        rows, columns = self.rows[box[0]], self.columns[box[1]]
        return np.take(np.take(values, rows, axis=0), columns, axis=1)

    def box_of(self, box: Box) -> Box:
        """Device pixels that show a box of the image; empty if it is not visible."""
        rows, columns = (
            slice(int(np.searchsorted(shown, span.start)), int(np.searchsorted(shown, span.stop)))
            for shown, span in zip((self.rows, self.columns), box, strict=True)
        )
        return rows, columns

    def on_screen(self, box: Box) -> QRect:
        """Screen pixels of a box of the device pixels that show the frame."""
        rows, columns = box
        corner = QPointF(columns.start + self.left, rows.start + self.top) / self.ratio
        size = QSizeF(columns.stop - columns.start, rows.stop - rows.start) / self.ratio
        return QRectF(corner, size).toAlignedRect()

    def _pixels(self, start: int, view: int, frame: int) -> NDArray[np.intp]:
        first, last = max(start, 0), min(start + math.ceil(frame * self.scale), view)
        pixels = np.floor((np.arange(first, max(last, first)) + 0.5 - start) / self.scale).astype(np.intp)
        return pixels[pixels < frame]


# Lines around blocks in screen pixels: the same width at every zoom, visible on any picture. No Qt.

_LINE = 0xC0C0C0C0
_HALO = 0x58000000
_SELECTED = 0xFFFFFFFF
_TINT = 0x38383838
"""Over selected blocks, if there are several."""
_RIM_HALO = 0xDC000000
_TO_CHECK = 0xFFFFA020
_BAND = 4
"""Width [device px at ratio 1] of the tint along coloured lines, by which one knows the pieces of a block."""
_BAND_ALPHA = 100
_REACH = _BAND + 1
"""Distance [device px at ratio 1] up to which a label affects its own and its neighbours' lines."""
_SQUARE = np.ones((3, 3), np.uint8)
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


class BlockLines:
    """Draws the lines around blocks for any sampling of the frame on the screen, given their colours, RGBA uint8
    (N + 1, 4) by label, alpha 0 for no line.

    A bright line with a dark halo separates blocks from each other and from pixels without block. Selected blocks have
    a wider outline inside them, and a tint if there are several; blocks that need checking have the outline in another
    colour. With `in_colours`, each block's side of the line has its own colour, with a band of it along the line.
    """

    def __init__(
        self,
        colours: NDArray[np.uint8],
        selected: Sequence[int] = (),
        to_check: Sequence[int] = (),
        in_colours: bool = False,
    ) -> None:
        visible = colours[:, 3] > 0
        visible[0] = False
        self._shown = np.where(visible, np.arange(len(colours), dtype=np.int32), 0)
        self._lines, self._bands = _argb(colours, 255), _argb(colours, _BAND_ALPHA)
        self._selected, self._to_check = (np.zeros(len(colours), np.uint8) for _ in range(2))
        self._selected[[label for label in selected if label < len(colours)]] = 1
        self._to_check[[label for label in to_check if label < len(colours)]] = 1
        self._has_tint = len(selected) > 1
        self.in_colours = in_colours
        self._looks = np.column_stack((colours, self._selected * (1 + self._has_tint), self._to_check))

    def looks_like(self, other: BlockLines) -> bool:
        """Whether the blocks that both know look the same."""
        known = min(len(self._looks), len(other._looks))
        return self.in_colours == other.in_colours and np.array_equal(self._looks[:known], other._looks[:known])

    def draw(self, here: NDArray[np.int32], drawn: Argb, box: Box, sampling: Sampling) -> Box:
        """Draw the lines that depend on the labels inside a box.

        Parameters
        ----------
        here : ndarray of int32, shape (h, w)
            Labels at the device pixels that show the frame.
        drawn : ndarray of uint32, shape (h, w)
            Pixels drawn there; changed in place.
        box : (slice, slice)
            Rows and columns where labels or their appearance changed.
        sampling : Sampling

        Returns
        -------
        (slice, slice)
            The box that was redrawn, slightly larger.
        """
        ratio = sampling.line_width
        inner = grown(box, _REACH * ratio, here.shape)
        outer = grown(inner, _REACH * ratio, here.shape)
        rows, columns = (
            slice(own.start - around.start, own.stop - around.start) for own, around in zip(inner, outer, strict=True)
        )
        if 0 in here[inner].shape:  # the frame is not visible
            return inner
        at_rims = tuple(
            (rim[0] and span.start == 0, rim[1] and span.stop == size)
            for rim, span, size in zip(sampling.rims, outer, here.shape, strict=True)
        )
        drawn[inner] = self._draw(here[outer], at_rims, ratio)[rows, columns]
        return inner

    def _draw(self, here: NDArray[np.int32], rims: tuple[tuple[bool, bool], ...], ratio: int) -> Argb:
        shown = self._shown[here]
        across, down = shown[:, 1:] != shown[:, :-1], shown[1:] != shown[:-1]
        line = np.zeros(shown.shape, np.uint8)
        line[:, :-1] |= across
        line[:-1] |= down
        if self.in_colours:
            line[:, 1:] |= across
            line[1:] |= down
            line[shown == 0] = 0
        if ratio > 1:
            line[:] = cv2.dilate(line, _SQUARE, iterations=ratio // 2)
        drawn = np.zeros(shown.shape, np.uint32)
        if self._has_tint:
            drawn[self._selected[here] > 0] = _TINT
        if self.in_colours:
            band = (cv2.dilate(line, _SQUARE, iterations=_BAND * ratio) > 0) & (shown > 0)
            drawn[band] = self._bands[shown[band]]
        drawn[cv2.dilate(line, _SQUARE, iterations=ratio) > 0] = _HALO
        on_line = line > 0
        drawn[on_line] = self._lines[shown[on_line]] if self.in_colours else np.uint32(_LINE)
        for marked, colour in ((self._to_check & self._shown.astype(bool), _TO_CHECK), (self._selected, _SELECTED)):
            if marked.any():
                self._draw_rim(marked[here], rims, drawn, colour, ratio)
        return drawn

    def _draw_rim(
        self, inside: NDArray[np.uint8], rims: tuple[tuple[bool, bool], ...], drawn: Argb, colour: int, ratio: int
    ) -> None:
        """Draw a wide line inside some blocks; the frame's rim also counts as border."""
        padded = np.pad(inside, [(int(first), int(last)) for first, last in rims])
        within = cv2.erode(padded, _CROSS, iterations=2 * ratio)
        inner = cv2.erode(within, _SQUARE, iterations=ratio)
        outer = cv2.dilate(padded, _SQUARE, iterations=ratio)
        above, before = int(rims[0][0]), int(rims[1][0])
        part = slice(above, above + inside.shape[0]), slice(before, before + inside.shape[1])
        drawn[(outer > inner)[part]] = _RIM_HALO
        drawn[((inside > 0) & (within[part] == 0))] = colour


def _argb(colours: NDArray[np.uint8], alpha: int) -> NDArray[np.uint32]:
    """Premultiplied ARGB of colours, uint8 (N, 3 or 4), with this alpha."""
    red, green, blue = (colours[:, channel].astype(np.uint32) * alpha // 255 for channel in range(3))
    return (np.uint32(alpha << 24) | (red << 16) | (green << 8) | blue).astype(np.uint32)


# Stripes over part of a picture, in screen pixels, moving with the picture. No Qt.

_PERIOD = 8
_WIDTH = 2


class Style(NamedTuple):
    """Colours of a stripe and of the dark one beside it, the direction of their slope, and the colour in legends."""

    stripe: int
    shade: int
    lean: int
    legend: str


STYLES = {
    "extrapolated": Style(0xBEBEBEBE, 0x60000000, 1, "#bebebe"),
    "missing": Style(0xE6E6E6E6, 0x96000000, 1, "#e6e6e6"),
    "outside view": Style(0xFF3C8CDC, 0x961E4678, -1, "#3c8cdc"),
    "unsupported": Style(0xFFFFFFFF, 0xDC000000, -1, "#808080"),
    "suspect": Style(0xFFFFE040, 0xDC000000, 1, "#e6be00"),
    "invalid": Style(0xFFFF9020, 0xB4000000, -1, "#ff9020"),
    "by hand": Style(0xFF9E6ECE, 0xA0FFFFFF, 1, "#9e6ece"),
}
"""What is striped -> how; later ones lie over earlier ones."""


def stripes(masks: Mapping[str, NDArray[np.bool_]], sampling: Sampling) -> Argb | None:
    """Stripes in masks, bool (H, W), by their names in `STYLES`, at the device pixels that show the frame; transparent
    elsewhere. None if there are no masks."""
    drawn, everywhere = None, whole(sampling.shape)
    period, width = _PERIOD * sampling.line_width, _WIDTH * sampling.line_width
    down = np.arange(len(sampling.rows))[:, None] + sampling.top - sampling.y
    along = np.arange(len(sampling.columns)) + sampling.left - sampling.x
    for name, mask in masks.items():
        if mask.shape == sampling.frame[::-1]:
            style = STYLES[name]
            phase = (down + style.lean * along) % period
            shade = np.where(phase < 2 * width, np.uint32(style.shade), np.uint32(0))
            pattern = np.where(phase < width, np.uint32(style.stripe), shade)
            below = np.zeros(sampling.shape, np.uint32) if drawn is None else drawn
            drawn = np.where(sampling.sample(mask, everywhere), pattern, below)
    return drawn
