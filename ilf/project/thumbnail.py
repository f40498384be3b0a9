"""Thumbnails: small pictures of frames with their blocks, for lists."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..drawing.blocks import block_colour
from .frame_state import FrameState

_LONGER_SIDE = 240
_BLOCKS = 0.45
_QUALITY = 80


def thumbnail_part(frame_id: str) -> str:
    """Return the name of the part with a frame's thumbnail."""
    return f"thumbnails/{frame_id}.jpg"


def thumbnail(state: FrameState) -> bytes:
    """Draw a frame tinted with the colours of its blocks, as JPEG with a longer side of at most 240 pixels.

    Examples
    --------
    >>> from ilf.data.frame import RGBDFrame
    >>> frame = RGBDFrame(np.zeros((30, 40, 3), np.uint8), np.full((30, 40), 2.0))
    >>> from ilf.data.blocks import Blocks
    >>> thumbnail(FrameState("a1", frame, Blocks(np.ones((30, 40), np.int32))))[:2]
    b'\\xff\\xd8'
    """
    height, width = state.frame.shape
    scale = min(_LONGER_SIDE / max(height, width), 1.0)
    size = max(round(width * scale), 1), max(round(height * scale), 1)
    small = cv2.resize(state.frame.rgb, size, interpolation=cv2.INTER_AREA).astype(np.uint8, copy=False)
    labels = cv2.resize(state.blocks.labels, size, interpolation=cv2.INTER_NEAREST_EXACT)
    picture = cv2.addWeighted(_colours(state)[labels], _BLOCKS, small, 1 - _BLOCKS, 0)
    picture = np.where((labels > 0)[..., None], picture, small)
    done, content = cv2.imencode(".jpg", picture[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    if not done:
        raise RuntimeError("the thumbnail could not be encoded")
    return content.tobytes()


def _colours(state: FrameState) -> NDArray[np.uint8]:
    """Label -> colour, (labels + 1, 3)."""
    infos = state.blocks.infos
    labels = range(int(state.blocks.labels.max(initial=0)) + 1)
    return np.array([infos[label].colour if label in infos else block_colour(label) for label in labels], np.uint8)
