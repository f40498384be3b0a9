"""Lines around blocks, in pixels of the screen: as wide at every zoom, and to be seen on any picture. No Qt."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.blocks import Box

from .changes import grown, whole
from .sampling import Argb, Sampling

_LINE = 0xC0C0C0C0
_HALO = 0x58000000
_CHOSEN = 0xFFFFFFFF
_CHOSEN_HALO = 0xDC000000
_REACH = 4
"""Device pixels that a label reaches: what its lines cover, and those of its neighbours, at a ratio of 1."""
_SQUARE = np.ones((3, 3), np.uint8)
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


class BlockLines:
    """What the lines around blocks look like, for any way in which the frame lies on the screen.

    A bright line with a dark halo parts blocks from each other and from what is no block; chosen blocks have a wider
    one all around, which lies inside them. With `in_colours` each block's side of the line has its own colour.
    """

    def __init__(self) -> None:
        self.in_colours = False
        self._colours = np.zeros((1, 4), np.uint8)
        self._shown = np.zeros(1, np.int32)
        self._lines = np.zeros(1, np.uint32)
        self._selected: tuple[int, ...] = ()
        self._chosen = np.zeros(1, np.uint8)

    def set_colours(self, colours: NDArray[np.uint8]) -> None:
        """Colours of blocks, RGBA uint8 (N + 1, 4) by label; those of alpha 0 have no line of their own."""
        self._colours = colours
        visible = colours[:, 3] > 0
        visible[0] = False
        self._shown = np.where(visible, np.arange(len(colours), dtype=np.int32), 0)
        red, green, blue = (colours[:, channel].astype(np.uint32) for channel in range(3))
        self._lines = (np.uint32(0xFF000000) | (red << 16) | (green << 8) | blue).astype(np.uint32)
        self.set_selected(self._selected)

    def set_selected(self, labels: Iterable[int]) -> None:
        """These blocks are the chosen ones."""
        self._selected = tuple(labels)
        self._chosen = np.zeros(len(self._colours), np.uint8)
        self._chosen[[label for label in self._selected if 0 < label < len(self._chosen)]] = 1

    def draw(self, labels: NDArray[np.int32], sampling: Sampling, ratio: int = 1) -> Argb:
        """All lines of a label map, int32 (H, W), on the device pixels that show it.

        `ratio` is how many device pixels make one of the screen's.
        """
        return self._draw(labels, sampling, whole(sampling.shape), ratio)

    def redraw(self, labels: NDArray[np.int32], sampling: Sampling, box: Box, drawn: Argb, ratio: int = 1) -> Box:
        """The same in place, after the labels have changed inside a box (rows, columns); what was drawn anew."""
        inner = grown(sampling.box_of(box), sampling.shape, _REACH * ratio)
        outer = grown(inner, sampling.shape, _REACH * ratio)
        if all(span.start < span.stop for span in inner):
            part = self._draw(labels, sampling, outer, ratio)
            rows, columns = (
                slice(own.start - around.start, own.stop - around.start)
                for own, around in zip(inner, outer, strict=True)
            )
            drawn[inner] = part[rows, columns]
        return inner

    def _draw(self, labels: NDArray[np.int32], sampling: Sampling, box: Box, ratio: int) -> Argb:
        here = sampling.sample(labels, box)
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
        drawn[cv2.dilate(line, _SQUARE, iterations=ratio) > 0] = _HALO
        on_line = line > 0
        drawn[on_line] = self._lines[shown[on_line]] if self.in_colours else np.uint32(_LINE)
        if self._chosen.any():
            self._draw_chosen(self._chosen[here], sampling, box, drawn, ratio)
        return drawn

    def _draw_chosen(self, chosen: NDArray[np.uint8], sampling: Sampling, box: Box, drawn: Argb, ratio: int) -> None:
        """The frame's rim is a border, too; that of a box inside it is not."""
        rims = [(int(span.start == 0), int(span.stop == size)) for span, size in zip(box, sampling.shape, strict=True)]
        padded = np.pad(chosen, rims)
        inside = cv2.erode(padded, _CROSS, iterations=2 * ratio)
        inner = cv2.erode(inside, _SQUARE, iterations=ratio)
        outer = cv2.dilate(padded, _SQUARE, iterations=ratio)
        (above, _), (before, _) = rims
        part = slice(above, above + chosen.shape[0]), slice(before, before + chosen.shape[1])
        drawn[(outer > inner)[part]] = _CHOSEN_HALO
        drawn[((chosen > 0) & (inside[part] == 0))] = _CHOSEN
