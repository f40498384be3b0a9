"""Stripes over part of a picture, in pixels of the screen, moving with the picture. No Qt."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ilf.blocks import Box

from .sampling import Argb, Sampling

_PERIOD = 8
_WIDTH = 2

MISSING = np.uint32(0xE6E6E6E6), np.uint32(0x96000000), 1
DISTRUSTED = np.uint32(0xFFFF9020), np.uint32(0xB4000000), -1
UNVOUCHED = np.uint32(0xFFFFFFFF), np.uint32(0xDC000000), -1
OUTSIDE = np.uint32(0xC83C8CDC), np.uint32(0x96000000), -1
"""Colours of a stripe and of the dark one beside it, and which way they lean."""
Style = tuple[np.uint32, np.uint32, int]


def stripes(mask: NDArray[np.bool_], sampling: Sampling, box: Box, style: Style, ratio: int = 1) -> Argb:
    """Stripes where a mask, bool (H, W), holds, on a box of the device pixels that show the frame; clear elsewhere."""
    stripe, shade, lean = style
    period, width = _PERIOD * ratio, _WIDTH * ratio
    down = np.arange(box[0].start, box[0].stop) + sampling.top - sampling.y
    along = np.arange(box[1].start, box[1].stop) + sampling.left - sampling.x
    phase = (down[:, None] + lean * along[None]) % period
    pattern = np.where(phase < width, stripe, np.where(phase < 2 * width, shade, np.uint32(0)))
    return np.where(sampling.sample(mask, box), pattern, np.uint32(0)).astype(np.uint32)
