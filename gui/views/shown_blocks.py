"""The blocks over the pictures: fills, lines around them and names, drawn again only where they have changed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.data.blocks import Box, grown, whole
from ilf.drawing.blocks import inner_points

from ..state.document import Document
from ..state.parts import EVERY_PART, Part
from ..state.workspace import Workspace
from .drawings import Argb, Pixels, packed
from .image_view import ImageView, Rims, Sampling
from .view_data import ViewData, colour_table

BLOCK_PARTS = Part.FRAME | Part.LABELS | Part.STROKE | Part.INFOS | Part.SELECTION


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

    def _draw(self, here: NDArray[np.int32], rims: Rims, ratio: int) -> Argb:
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

    def _draw_rim(self, inside: NDArray[np.uint8], rims: Rims, drawn: Argb, colour: int, ratio: int) -> None:
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


class ShownBlocks:
    """Draws the blocks of the current document, or of what stands in for it, over some views.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W), or None
        The label map as it is drawn; the document's may have changed since.
    colours : ndarray of uint8, shape (N + 1, 4)
        RGBA by label; alpha 0 hides a block.
    pixels : ndarray of uint32, shape (H, W), or None
        Colours of all fills; None if nothing is filled.
    """

    def __init__(self, workspace: Workspace, data: ViewData, views: Sequence[ImageView]) -> None:
        self._views = views
        self.labels: NDArray[np.int32] | None = None
        self.colours = np.zeros((1, 4), np.uint8)
        self.pixels: Pixels | None = None
        self._look = BlockLines(self.colours)
        self._lines: dict[Sampling, tuple[NDArray[np.int32], Argb]] = {}
        """Labels at the device pixels that show the frame, and the lines there; for views with the same sampling."""
        self._data = data
        self._drawn: NDArray[np.int32] | None = None
        """The label map that was drawn last, of which `labels` is a copy."""
        self._boxes: list[Box] = []
        """Where it has changed since."""
        self._opacity = 0.45
        self._shows_names = self._contours_only = False
        workspace.labels_changed.connect(self._boxes.append)
        for view in views:  # drawn when a view is painted: it may be resized several times before
            view.lines.find = partial(self._find_lines, view)

    def draw(self, parts: Part) -> None:
        """Draw what has changed: all if colours have, else the changed boxes, the selection and the names."""
        parts &= BLOCK_PARTS
        boxes, document, labels = self._boxes.copy(), self._data.document, self._data.labels
        self._boxes.clear()
        if document is None or labels is None:
            self._clear()
            return
        own = self.labels if labels is self._drawn else None
        is_other = own is None
        if own is None:
            own, boxes, top = labels.copy(), [], int(labels.max())
            self._drawn, self.labels = labels, own
        else:
            for box in boxes:
                own[box] = labels[box]
            top = max([len(self.colours) - 1, *(int(own[box].max()) for box in boxes)])
        former, self.colours = self.colours, colour_table(document, top)
        if is_other or self.pixels is None or not np.array_equal(self.colours[: len(former)], former):
            self._fill()
        else:
            self._fill_boxes(boxes, own, self.pixels)
        former_look = self._look
        self._look = BlockLines(self.colours, document.selected, sorted(document.state.to_check), self._contours_only)
        if is_other or not self._look.looks_like(former_look):
            self._drop_lines()
        else:
            self._draw_lines(own, boxes)
        if is_other or parts & ~(Part.STROKE | Part.SELECTION):
            self._write_names(document, own)

    def set_contours_only(self, on: bool) -> None:
        """Set whether blocks are drawn as coloured outlines without fill."""
        self._contours_only = on
        self._fill()
        self.draw(EVERY_PART)

    def set_opacity(self, opacity: float) -> None:
        """Set the opacity of the fills, 0-1."""
        self._opacity = min(max(opacity, 0.0), 1.0)
        self._fill()

    def show_names(self, on: bool) -> None:
        """Show or hide the blocks' names."""
        self._shows_names = on
        self.draw(EVERY_PART)

    def _clear(self) -> None:
        if self.labels is not None:
            self._drawn = self.labels = None
            self._fill()
            self._drop_lines()
            for view in self._views:
                view.names.set_names({}, {}, view.frame)

    def _drop_lines(self) -> None:
        self._lines.clear()
        for view in self._views:
            view.viewport().update()

    def _draw_lines(self, labels: NDArray[np.int32], boxes: Sequence[Box]) -> None:
        """Draw the lines that depend on changed boxes of the label map."""
        for sampling, (here, pixels) in self._lines.items():
            parts = [sampling.box_of(box) for box in boxes]
            for part in parts:
                here[part] = sampling.sample(labels, part)
            for part in parts:
                if all(span.start < span.stop for span in part):
                    place = sampling.on_screen(self._look.draw(here, pixels, part, sampling))
                    for view in self._views:
                        if view.sampling == sampling:
                            view.viewport().update(place)

    def _find_lines(self, view: ImageView) -> Argb | None:
        sampling, labels = view.sampling, self.labels
        if not view.has_lines or labels is None or labels.shape != sampling.frame[::-1]:
            return None
        if sampling not in self._lines:
            seen = {view.sampling for view in self._views if view.isVisible()}
            self._lines = {key: lines for key, lines in self._lines.items() if key in seen}
            everywhere = whole(sampling.shape)
            here, pixels = sampling.sample(labels, everywhere), np.zeros(sampling.shape, np.uint32)
            self._look.draw(here, pixels, everywhere, sampling)
            self._lines[sampling] = here, pixels
        return self._lines[sampling][1]

    def _fill(self) -> None:
        fills = self._fills()
        self.pixels = fills[self.labels] if self.labels is not None and fills.any() else None
        for view in self._views:
            view.fills.set_pixels(self.pixels)

    def _fill_boxes(self, boxes: Sequence[Box], labels: NDArray[np.int32], pixels: Pixels) -> None:
        fills = self._fills()
        for box in boxes:
            pixels[box] = fills[labels[box]]
            for view in self._views:
                view.fills.notify_change(box)

    def _fills(self) -> Pixels:
        """Colour of the fill by label."""
        fills = self.colours.astype(np.float32)
        fills[0] = 0
        fills[:, 3] *= 0.0 if self._contours_only else self._opacity
        return packed(fills.round().astype(np.uint8))

    def _write_names(self, document: Document, labels: NDArray[np.int32]) -> None:
        names = {label: document.info(label).name for label in document.counts()} if self._shows_names else {}
        points = inner_points(labels) if names else {}
        for view in self._views:
            view.names.set_names(names, points, view.frame)
