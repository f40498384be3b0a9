"""Lines around blocks, in pixels of the screen: as wide at every zoom, and to be seen on any picture. No Qt."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.blocks import Box

from .changes import grown
from .sampling import Argb, Rims

_LINE = 0xC0C0C0C0
_HALO = 0x58000000
_CHOSEN = 0xFFFFFFFF
_RIM_HALO = 0xDC000000
_DOUBTFUL = 0xFFFFA020
_REACH = 4
"""Device pixels that a label reaches: what its lines cover, and those of its neighbours, at a ratio of 1."""
_SQUARE = np.ones((3, 3), np.uint8)
_CROSS = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))


class BlockLines:
    """What the lines around blocks look like, for any way in which the frame lies on the screen.

    A bright line with a dark halo parts blocks from each other and from what is no block; chosen blocks have a wider
    one all around, which lies inside them, and so have those that need a look, in another colour. With `in_colours`
    each block's side of the line has its own colour.
    """

    def __init__(self) -> None:
        self.in_colours = False
        self._colours = np.zeros((1, 4), np.uint8)
        self._shown = np.zeros(1, np.int32)
        self._lines = np.zeros(1, np.uint32)
        self._selected: tuple[int, ...] = ()
        self._doubtful_ones: tuple[int, ...] = ()
        self._chosen = self._doubtful = np.zeros(1, np.uint8)

    def set_colours(self, colours: NDArray[np.uint8]) -> None:
        """Colours of blocks, RGBA uint8 (N + 1, 4) by label; those of alpha 0 have no line of their own."""
        self._colours = colours
        visible = colours[:, 3] > 0
        visible[0] = False
        self._shown = np.where(visible, np.arange(len(colours), dtype=np.int32), 0)
        red, green, blue = (colours[:, channel].astype(np.uint32) for channel in range(3))
        self._lines = (np.uint32(0xFF000000) | (red << 16) | (green << 8) | blue).astype(np.uint32)
        self._mark()

    def set_selected(self, labels: Iterable[int]) -> list[int]:
        """These blocks are the chosen ones; returned are those that are chosen, or are not, other than before."""
        before, self._selected = self._selected, tuple(labels)
        self._mark()
        return sorted(set(before) ^ set(self._selected))

    def set_doubtful(self, labels: Iterable[int]) -> list[int]:
        """These blocks need a look; returned are those that do, or do not, other than before."""
        before, self._doubtful_ones = self._doubtful_ones, tuple(labels)
        self._mark()
        return sorted(set(before) ^ set(self._doubtful_ones))

    def mask_of(self, here: NDArray[np.int32], labels: Iterable[int]) -> NDArray[np.bool_]:
        """Where an array of labels has any of some labels that have colours."""
        wanted = np.zeros(len(self._colours), bool)
        wanted[[label for label in labels if label < len(wanted)]] = True
        return wanted[here]

    def _mark(self) -> None:
        self._chosen, self._doubtful = self._marked(self._selected), self._marked(self._doubtful_ones)

    def _marked(self, labels: Iterable[int]) -> NDArray[np.uint8]:
        """Label -> whether it is one of these."""
        marked = np.zeros(len(self._colours), np.uint8)
        marked[[label for label in labels if 0 < label < len(marked)]] = 1
        return marked

    def draw(self, here: NDArray[np.int32], drawn: Argb, box: Box, rims: Rims, ratio: int = 1) -> Box:
        """Draw what labels inside a box have to do with.

        Parameters
        ----------
        here : ndarray of int32, shape (h, w)
            Labels at the device pixels that show the frame.
        drawn : ndarray of uint32, shape (h, w)
            What is drawn there; changed in place.
        box : (slice, slice)
            Rows and columns of those where labels, or what is shown of them, have changed.
        rims : ((bool, bool), (bool, bool))
            Whether the frame's own rim is at the first and last row, and column, of `here`.
        ratio : int
            How many device pixels make one of the screen's.

        Returns
        -------
        (slice, slice)
            Where it has been drawn anew, which is a little more.
        """
        inner = grown(box, here.shape, _REACH * ratio)
        outer = grown(inner, here.shape, _REACH * ratio)
        rows, columns = (
            slice(own.start - around.start, own.stop - around.start) for own, around in zip(inner, outer, strict=True)
        )
        if 0 in here[inner].shape:  # the frame is out of sight
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
        drawn = np.zeros(shown.shape, np.uint32)
        drawn[cv2.dilate(line, _SQUARE, iterations=ratio) > 0] = _HALO
        on_line = line > 0
        drawn[on_line] = self._lines[shown[on_line]] if self.in_colours else np.uint32(_LINE)
        for marked, colour in ((self._doubtful & self._shown.astype(bool), _DOUBTFUL), (self._chosen, _CHOSEN)):
            if marked.any():
                self._draw_rim(marked[here], rims, drawn, colour, ratio)
        return drawn

    def _draw_rim(
        self, inside: NDArray[np.uint8], rims: tuple[tuple[bool, bool], ...], drawn: Argb, colour: int, ratio: int
    ) -> None:
        """A wide line inside some blocks; the frame's rim is a border, too."""
        padded = np.pad(inside, [(int(first), int(last)) for first, last in rims])
        within = cv2.erode(padded, _CROSS, iterations=2 * ratio)
        inner = cv2.erode(within, _SQUARE, iterations=ratio)
        outer = cv2.dilate(padded, _SQUARE, iterations=ratio)
        above, before = int(rims[0][0]), int(rims[1][0])
        part = slice(above, above + inside.shape[0]), slice(before, before + inside.shape[1])
        drawn[(outer > inner)[part]] = _RIM_HALO
        drawn[((inside > 0) & (within[part] == 0))] = colour
