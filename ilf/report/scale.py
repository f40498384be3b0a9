"""The scale bar of a frame's pictures: a round length, at the depth at which it holds."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..frame import RGBDFrame
from .content import ScaleBar

_LARGEST_SHARE = 0.3


def scale_bar(frame: RGBDFrame, depth: NDArray[np.floating]) -> ScaleBar:
    """A round length of at most 30 % of the picture's width: in metres where the camera is known, else in pixels.

    Parameters
    ----------
    frame : RGBDFrame
    depth : ndarray of float, shape (H, W)
        Depth [m], NaN = missing; the bar holds at its median.

    Examples
    --------
    >>> import ilf
    >>> frame = ilf.RGBDFrame(np.zeros((30, 640, 3), np.uint8), np.full((30, 640), 2.0))
    >>> scale_bar(frame, frame.depth)
    ScaleBar(share=0.15625, text='100 px')
    """
    width = frame.shape[1]
    if frame.intrinsics is None:
        pixels = _round_down(_LARGEST_SHARE * width)
        return ScaleBar(pixels / width, f"{pixels:g} px")
    median = float(np.nanmedian(depth))
    across = width * median / frame.intrinsics.fx
    metres = _round_down(_LARGEST_SHARE * across)
    length = f"{metres:g} m" if metres >= 1 else f"{1000 * metres:g} mm" if metres < 0.01 else f"{100 * metres:g} cm"
    return ScaleBar(metres / across, f"{length} at {median:.2f} m depth")


def _round_down(value: float) -> float:
    """The next smaller 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(step * power for step in (1, 2, 5) if step * power <= value * (1 + 1e-9))
