"""Where the linked views look: one centre and one scale for all of them, without any Qt."""

from __future__ import annotations

FIT_MARGIN = 2
"""Screen pixels left free on each side of a fitted frame."""
SMALLEST_SHARE = 0.25
"""Furthest out: the frame takes this share of the view that fits it."""
CLOSEST_PIXELS = 8
"""Furthest in: image pixels across the view."""


class ViewTransform:
    """Image point in the middle of the views and screen pixels per image pixel.

    The scale is that of the view given by `set_view`; one of another size shows the same at its `share` of it.
    """

    def __init__(self) -> None:
        self.x = self.y = 0.5
        self.scale = 1.0
        self.fitted = True
        self._frame = (1, 1)
        self._view = (1, 1)

    def set_frame(self, width: int, height: int) -> None:
        """Take a frame of this size [px] and fit it."""
        self._frame = (width, height)
        self.fit()

    def set_view(self, width: int, height: int) -> None:
        """Take the views' size in screen pixels; a fitted frame stays fitted, any other scale is kept."""
        self._view = (max(width, 1), max(height, 1))
        if self.fitted:
            self.fit()

    @property
    def aspect(self) -> float:
        """Width over height of the frame."""
        return self._frame[0] / self._frame[1]

    def share(self, width: int, height: int) -> float:
        """Scale of a view of this size over that of the view that was set: a frame fits both at once."""
        return self._fitting(width, height) / self._fitting(*self._view)

    def fit(self) -> None:
        """Show the whole frame."""
        self.x, self.y = self._frame[0] / 2, self._frame[1] / 2
        self.scale = self._fit_scale()
        self.fitted = True

    def show(self, left: float, top: float, right: float, bottom: float, margin: float = 0.15) -> None:
        """Show a box of the image with a margin, given as a share of the box, on each side."""
        self.x, self.y = (left + right) / 2, (top + bottom) / 2
        spread = 1 + 2 * margin
        width, height = max(right - left, 1) * spread, max(bottom - top, 1) * spread
        self.set_scale(min(self._view[0] / width, self._view[1] / height))

    def look_at(self, x: float, y: float, scale: float) -> None:
        """Show an image point in the middle, at `scale` screen pixels per image pixel, within the limits."""
        self.x, self.y = x, y
        self.set_scale(scale)
        self._keep_in_frame()

    def pan(self, dx: float, dy: float) -> None:
        """Move the image by screen pixels."""
        self.x -= dx / self.scale
        self.y -= dy / self.scale
        self._keep_in_frame()

    def zoom(self, factor: float, x: float, y: float) -> None:
        """Scale by a factor; the image point (x, y) keeps its place on the screen."""
        before = self.scale
        self.set_scale(before * factor)
        ratio = before / self.scale
        self.x, self.y = x - (x - self.x) * ratio, y - (y - self.y) * ratio
        self._keep_in_frame()

    def set_scale(self, scale: float) -> None:
        """Show `scale` screen pixels per image pixel around the present centre, within the limits."""
        lowest = self._fit_scale() * SMALLEST_SHARE
        self.scale = max(min(scale, max(self._view[0] / CLOSEST_PIXELS, lowest)), lowest)
        self.fitted = False

    def _fit_scale(self) -> float:
        return self._fitting(*self._view)

    def _fitting(self, width: int, height: int) -> float:
        room = (max(size - 2 * FIT_MARGIN, 1) for size in (width, height))
        return min(space / size for space, size in zip(room, self._frame, strict=True))

    def _keep_in_frame(self) -> None:
        self.x = min(max(self.x, 0.0), float(self._frame[0]))
        self.y = min(max(self.y, 0.0), float(self._frame[1]))
        self.fitted = False
