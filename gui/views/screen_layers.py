"""What lies over the pictures in pixels of the screen: lines around blocks, and stripes. Views alike share the work."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilf.blocks import Box

from .block_lines import BlockLines
from .changes import box_of, whole
from .image_view import ImageView
from .sampling import Argb, Sampling
from .stripes import DISTRUSTED, MISSING, OUTSIDE, UNVOUCHED, stripes

Mask = NDArray[np.bool_]


class _Lines(NamedTuple):
    """Labels at the device pixels that show the frame, and the lines drawn there."""

    labels: NDArray[np.int32]
    pixels: Argb
    ratio: int


class ScreenLayers:
    """Lines and stripes of the views that are to be seen."""

    def __init__(self) -> None:
        self._views: Sequence[ImageView] = ()
        self._blocks = BlockLines()
        self._labels: NDArray[np.int32] | None = None
        self._missing: Mask | None = None
        self._outside: Mask | None = None
        self._distrusted: Mask | None = None
        self._unvouched: Mask | None = None
        self._lines: dict[Sampling, _Lines] = {}
        self._stripes: dict[tuple[Sampling, bool, bool], Argb | None] = {}

    def show(self, views: Sequence[ImageView]) -> None:
        """Draw for these views, as the frame lies in them now."""
        self._views = views
        wanted = {view.sampling for view in views}
        self._lines = {sampling: lines for sampling, lines in self._lines.items() if sampling in wanted}
        self._stripes = {key: drawn for key, drawn in self._stripes.items() if key[0] in wanted}
        for view in views:
            self._show_lines(view)
            self._show_stripes(view)

    def set_blocks(self, labels: NDArray[np.int32] | None, colours: NDArray[np.uint8] | None = None) -> None:
        """Draw a label map, int32 (H, W), which the caller changes in place, with RGBA by label; None for none."""
        self._labels = labels
        if colours is not None:
            self._blocks.set_colours(colours)
        self._draw_lines()

    def add_colours(self, colours: NDArray[np.uint8]) -> None:
        """Take RGBA by label that begins as the present ones; no block has the further labels yet."""
        self._blocks.set_colours(colours)

    def update_region(self, box: Box) -> None:
        """The label map has changed inside a box (rows, columns)."""
        if self._labels is None:
            return
        for sampling, lines in self._lines.items():
            part = sampling.box_of(box)
            if all(span.start < span.stop for span in part):
                lines.labels[part] = sampling.sample(self._labels, part)
                self._redraw(sampling, part)

    def set_selected(self, labels: Iterable[int]) -> None:
        """These blocks are the chosen ones."""
        self._redraw_blocks(self._blocks.set_selected(labels))

    def set_doubtful(self, labels: Iterable[int]) -> None:
        """These blocks need a look."""
        self._redraw_blocks(self._blocks.set_doubtful(labels))

    def _redraw_blocks(self, others: Sequence[int]) -> None:
        for sampling, lines in self._lines.items():
            part = box_of(self._blocks.mask_of(lines.labels, others)) if others else None
            if part is not None:
                self._redraw(sampling, part)

    def _redraw(self, sampling: Sampling, part: Box) -> None:
        lines = self._lines[sampling]
        drawn = self._blocks.draw(lines.labels, lines.pixels, part, sampling.rims, lines.ratio)
        for view in self._views:
            if view.sampling == sampling:
                view.lines.note_change(drawn)

    def set_in_colours(self, on: bool) -> None:
        """Whether lines have the colours of their blocks."""
        self._blocks.in_colours = on
        self._draw_lines()

    def set_missing(self, mask: Mask | None) -> None:
        """Pixels, bool (H, W), to be striped as missing where a view shows it; None for none."""
        self._missing = mask
        self._draw_stripes()

    def set_outside(self, mask: Mask | None) -> None:
        """Pixels, bool (H, W), to be striped as outside the depth camera's view: in all views but those that show what
        is missing, and there with it; None for none."""
        self._outside = mask
        self._draw_stripes()

    def set_distrusted(self, mask: Mask | None) -> None:
        """Pixels, bool (H, W), to be striped as distrusted in all views; None for none."""
        self._distrusted = mask
        self._draw_stripes()

    def set_unvouched(self, mask: Mask | None) -> None:
        """Pixels, bool (H, W), to be striped as vouched for by nothing where a view shows it; None for none."""
        self._unvouched = mask
        self._draw_stripes()

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
            part = whole(sampling.shape)
            lines = _Lines(sampling.sample(self._labels, part), np.zeros(sampling.shape, np.uint32), view.pixel_ratio)
            self._blocks.draw(lines.labels, lines.pixels, part, sampling.rims, lines.ratio)
            self._lines[sampling] = lines
        if view.lines.pixels is not self._lines[sampling].pixels:
            view.lines.show_pixels(self._lines[sampling].pixels, sampling, view.devicePixelRatioF())

    def _draw_stripes(self) -> None:
        self._stripes.clear()
        for view in self._views:
            self._show_stripes(view)

    def _show_stripes(self, view: ImageView) -> None:
        sampling = view.sampling
        if sampling is None:
            return
        key = sampling, view.shows_missing, view.shows_unvouched
        if key not in self._stripes:
            self._stripes[key] = self._striped(sampling, view)
        drawn = self._stripes[key]
        if drawn is None:
            view.stripes.clear()
        elif view.stripes.pixels is not drawn:
            view.stripes.show_pixels(drawn, sampling, view.devicePixelRatioF())

    def _striped(self, sampling: Sampling, view: ImageView) -> Argb | None:
        drawn = None
        masks = (
            (self._missing if view.shows_missing else None, MISSING),
            (self._outside if self._missing is not None or not view.shows_missing else None, OUTSIDE),
            (self._unvouched if view.shows_unvouched else None, UNVOUCHED),
            (self._distrusted, DISTRUSTED),
        )
        for mask, style in masks:
            if mask is not None and mask.shape == sampling.frame[::-1]:
                part = stripes(mask, sampling, whole(sampling.shape), style, view.pixel_ratio)
                drawn = part if drawn is None else np.where(sampling.sample(mask, whole(sampling.shape)), part, drawn)
        return drawn
