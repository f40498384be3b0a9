"""Thumbnails: small pictures of frames, for lists."""

from __future__ import annotations

import cv2
import numpy as np

from .frame_state import FrameState

_LONGER_SIDE = 240
_QUALITY = 80


def thumbnail_part(frame_id: str) -> str:
    """Return the name of the part with a frame's thumbnail."""
    return f"thumbnails/{frame_id}.jpg"


def thumbnail(state: FrameState) -> bytes:
    """Return the colour image of a frame as JPEG with a longer side of at most 240 pixels: without its blocks, so that
    the frame looks the same as one that was never opened.

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
    _, content = cv2.imencode(".jpg", small[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    return content.tobytes()
