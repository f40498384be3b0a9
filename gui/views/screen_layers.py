"""Screen-resolution overlays: lines around blocks, and stripes. Views with the same sampling share them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.data.label_map import Box, whole
from ilf.segmentation.editing.patches import bounds, grown

from .image_view import ImageView
from .screen_items import Argb, Rims, Sampling

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
    """Draws the lines around blocks for any sampling of the frame on the screen.

    A bright line with a dark halo separates blocks from each other and from pixels without block. Selected blocks have
    a wider outline inside them, and a tint if there are several; blocks that need checking have the outline in another
    colour. With `in_colours`, each block's side of the line has its own colour, with a band of it along the line.
    """

    def __init__(self) -> None:
        self.in_colours = False
        self._colours = np.zeros((1, 4), np.uint8)
        self._shown = np.zeros(1, np.int32)
        self._lines = self._bands = np.zeros(1, np.uint32)
        self._selected: tuple[int, ...] = ()
        self._labels_to_check: tuple[int, ...] = ()

    def set_colours(self, colours: NDArray[np.uint8]) -> None:
        """Set the colours of blocks, RGBA uint8 (N + 1, 4) by label; alpha 0 means no line."""
        self._colours = colours
        visible = colours[:, 3] > 0
        visible[0] = False
        self._shown = np.where(visible, np.arange(len(colours), dtype=np.int32), 0)
        self._lines, self._bands = _argb(colours, 255), _argb(colours, _BAND_ALPHA)

    def set_selected(self, labels: Iterable[int]) -> list[int]:
        """Set the selected blocks; return the labels whose selection changed."""
        before, now = self._selected, tuple(labels)
        self._selected = now
        tints = (len(before) > 1) != (len(now) > 1)
        return sorted(set(before) | set(now) if tints else set(before) ^ set(now))

    def set_to_check(self, labels: Iterable[int]) -> list[int]:
        """Set the blocks that need checking; return the labels that changed."""
        before, self._labels_to_check = self._labels_to_check, tuple(labels)
        return sorted(set(before) ^ set(self._labels_to_check))

    def marked(self, labels: Iterable[int]) -> NDArray[np.uint8]:
        """Label -> whether it is one of these."""
        marked = np.zeros(len(self._colours), np.uint8)
        marked[[label for label in labels if 0 < label < len(marked)]] = 1
        return marked

    def draw(self, here: NDArray[np.int32], drawn: Argb, box: Box, rims: Rims, ratio: int = 1) -> Box:
        """Draw the lines that depend on the labels inside a box.

        Parameters
        ----------
        here : ndarray of int32, shape (h, w)
            Labels at the device pixels that show the frame.
        drawn : ndarray of uint32, shape (h, w)
            Pixels drawn there; changed in place.
        box : (slice, slice)
            Rows and columns where labels or their appearance changed.
        rims : ((bool, bool), (bool, bool))
            Whether the frame's own rim is at the first and last row, and column, of `here`.
        ratio : int
            Device pixels per screen pixel.

        Returns
        -------
        (slice, slice)
            The box that was redrawn, slightly larger.
        """
        inner = grown(box, _REACH * ratio, here.shape)
        outer = grown(inner, _REACH * ratio, here.shape)
        rows, columns = (
            slice(own.start - around.start, own.stop - around.start) for own, around in zip(inner, outer, strict=True)
        )
        if 0 in here[inner].shape:  # the frame is not visible
            return inner
        at_rims = tuple(
            (rim[0] and span.start == 0, rim[1] and span.stop == size)
            for rim, span, size in zip(rims, outer, here.shape, strict=True)
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
        drawn, selected = np.zeros(shown.shape, np.uint32), self.marked(self._selected)
        if len(self._selected) > 1:
            drawn[selected[here] > 0] = _TINT
        if self.in_colours:
            band = (cv2.dilate(line, _SQUARE, iterations=_BAND * ratio) > 0) & (shown > 0)
            drawn[band] = self._bands[shown[band]]
        drawn[cv2.dilate(line, _SQUARE, iterations=ratio) > 0] = _HALO
        on_line = line > 0
        drawn[on_line] = self._lines[shown[on_line]] if self.in_colours else np.uint32(_LINE)
        for marked, colour in (
            (self.marked(self._labels_to_check) & self._shown.astype(bool), _TO_CHECK),
            (selected, _SELECTED),
        ):
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
    "missing": Style(0xE6E6E6E6, 0x96000000, 1, "#e6e6e6"),
    "outside view": Style(0xFF3C8CDC, 0x961E4678, -1, "#3c8cdc"),
    "unsupported": Style(0xFFFFFFFF, 0xDC000000, -1, "#808080"),
    "suspect": Style(0xFFFFE040, 0xDC000000, 1, "#e6be00"),
    "invalid": Style(0xFFFF9020, 0xB4000000, -1, "#ff9020"),
    "by hand": Style(0xFF9E6ECE, 0xA0FFFFFF, 1, "#9e6ece"),
}
"""What is striped -> how; later ones lie over earlier ones."""


def stripes(mask: NDArray[np.bool_], sampling: Sampling, box: Box, style: Style, ratio: int = 1) -> Argb:
    """Stripes in a mask, bool (H, W), on a box of the frame's device pixels; transparent elsewhere."""
    stripe, shade = np.uint32(style.stripe), np.uint32(style.shade)
    period, width = _PERIOD * ratio, _WIDTH * ratio
    down = np.arange(box[0].start, box[0].stop) + sampling.top - sampling.y
    along = np.arange(box[1].start, box[1].stop) + sampling.left - sampling.x
    phase = (down[:, None] + style.lean * along[None]) % period
    pattern = np.where(phase < width, stripe, np.where(phase < 2 * width, shade, np.uint32(0)))
    return np.where(sampling.sample(mask, box), pattern, np.uint32(0)).astype(np.uint32)


Mask = NDArray[np.bool_]


@dataclass
class _Lines:
    """The lines at the device pixels that show the frame, and the labels there; drawn when they are looked at first,
    for a view may be resized several times before it is painted."""

    pixels: Argb
    ratio: int
    labels: NDArray[np.int32] | None = None


class ScreenLayers:
    """Lines and stripes of the visible views."""

    def __init__(self) -> None:
        self._views: Sequence[ImageView] = ()
        self._blocks = BlockLines()
        self._labels: NDArray[np.int32] | None = None
        self._masks: dict[str, Mask] = {}
        self._lines: dict[Sampling, _Lines] = {}
        self._stripes: dict[tuple[Sampling, bool, bool], Argb | None] = {}

    def show(self, views: Sequence[ImageView]) -> None:
        """Draw for these views with their current sampling."""
        self._views = views
        wanted = {view.sampling for view in views}
        self._lines = {sampling: lines for sampling, lines in self._lines.items() if sampling in wanted}
        self._stripes = {key: drawn for key, drawn in self._stripes.items() if key[0] in wanted}
        for view in views:
            self._show_lines(view)
            self._show_stripes(view)

    def set_blocks(self, labels: NDArray[np.int32] | None, colours: NDArray[np.uint8] | None = None) -> None:
        """Set a label map, int32 (H, W), which the caller changes in place, and RGBA by label; None for none."""
        self._labels = labels
        if colours is not None:
            self._blocks.set_colours(colours)
        self._draw_lines()

    def add_colours(self, colours: NDArray[np.uint8]) -> None:
        """Set RGBA by label that extends the current table; no block has the further labels yet."""
        self._blocks.set_colours(colours)

    def update_region(self, box: Box) -> None:
        """Redraw after the label map changed inside a box (rows, columns)."""
        if self._labels is None:
            return
        for sampling, lines in self._lines.items():
            part = sampling.box_of(box)
            if lines.labels is not None and all(span.start < span.stop for span in part):
                lines.labels[part] = sampling.sample(self._labels, part)
                self._redraw(sampling, lines.labels, part)

    def set_selected(self, labels: Iterable[int]) -> None:
        """Set the selected blocks."""
        self._redraw_blocks(self._blocks.set_selected(labels))

    def set_to_check(self, labels: Iterable[int]) -> None:
        """Set the blocks that need checking."""
        self._redraw_blocks(self._blocks.set_to_check(labels))

    def _redraw_blocks(self, others: Sequence[int]) -> None:
        for sampling, lines in self._lines.items():
            if lines.labels is not None and others:
                part = bounds(self._blocks.marked(others)[lines.labels] > 0)
                if part is not None:
                    self._redraw(sampling, lines.labels, part)

    def _redraw(self, sampling: Sampling, labels: NDArray[np.int32], part: Box) -> None:
        lines = self._lines[sampling]
        drawn = self._blocks.draw(labels, lines.pixels, part, sampling.rims, lines.ratio)
        for view in self._views:
            if view.sampling == sampling:
                view.lines.notify_change(drawn)

    def set_in_colours(self, on: bool) -> None:
        """Set whether lines have the colours of their blocks."""
        self._blocks.in_colours = on
        self._draw_lines()

    def set_masks(self, masks: Mapping[str, Mask | None]) -> None:
        """Set the pixels, bool (H, W), that are striped, by the names of `STYLES`; None for none. The same arrays are
        not drawn again."""
        present = {name: mask for name, mask in masks.items() if mask is not None}
        if present.keys() != self._masks.keys() or any(mask is not self._masks[name] for name, mask in present.items()):
            self._masks = present
            self._draw_stripes()

    def striped_in(self, view: ImageView) -> list[str]:
        """What is striped in a view. Views that show missing depth stripe what is outside the view only with it."""
        hidden = set() if view.shows_missing else {"missing"}
        if view.shows_missing and "missing" not in self._masks:
            hidden.add("outside view")
        if not view.shows_unsupported:
            hidden.add("unsupported")
        return [name for name in STYLES if name in self._masks and name not in hidden]

    def _draw_lines(self) -> None:
        self._lines.clear()
        for view in self._views:
            self._show_lines(view)

    def _show_lines(self, view: ImageView) -> None:
        sampling = view.sampling
        if not view.has_lines or self._labels is None or sampling is None or self._labels.shape != sampling.frame[::-1]:
            view.lines.clear()
            return
        if sampling not in self._lines:
            self._lines[sampling] = _Lines(np.zeros(sampling.shape, np.uint32), view.pixel_ratio)
        lines = self._lines[sampling]
        if not view.lines.shows(lines.pixels):
            prepare = partial(self._draw_first, sampling, lines)
            view.lines.show_pixels(lines.pixels, sampling, view.devicePixelRatioF(), prepare)

    def _draw_first(self, sampling: Sampling, lines: _Lines) -> None:
        if lines.labels is None and self._labels is not None and self._labels.shape == sampling.frame[::-1]:
            part = whole(sampling.shape)
            lines.labels = sampling.sample(self._labels, part)
            self._blocks.draw(lines.labels, lines.pixels, part, sampling.rims, lines.ratio)

    def _draw_stripes(self) -> None:
        self._stripes.clear()
        for view in self._views:
            self._show_stripes(view)

    def _show_stripes(self, view: ImageView) -> None:
        sampling = view.sampling
        if sampling is None:
            return
        key = sampling, view.shows_missing, view.shows_unsupported
        if key not in self._stripes:
            self._stripes[key] = self._striped(sampling, view)
        drawn = self._stripes[key]
        if drawn is None:
            view.stripes.clear()
        elif not view.stripes.shows(drawn):
            view.stripes.show_pixels(drawn, sampling, view.devicePixelRatioF())

    def _striped(self, sampling: Sampling, view: ImageView) -> Argb | None:
        drawn = None
        for name in self.striped_in(view):
            mask = self._masks[name]
            if mask.shape == sampling.frame[::-1]:
                part = stripes(mask, sampling, whole(sampling.shape), STYLES[name], view.pixel_ratio)
                drawn = part if drawn is None else np.where(sampling.sample(mask, whole(sampling.shape)), part, drawn)
        return drawn
