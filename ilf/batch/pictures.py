"""Small pictures of a batch's frames, whose colours mean the same depth in all of them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ..drawing.colour_tables import depth_colours
from ..drawing.levels import robust_depth_levels, sample, to_indices
from ..errors import FormatError, IlfError, InputError
from ..frame import RGBDFrame
from ..io.atomic import write_bytes
from ..io.frame_source import FrameSource
from ..io.images import read_colour
from .apart import done_apart
from .frames import BatchFrame
from .settings import Levels

PREVIEW_FILE = "preview.png"

_WIDTH = 320
"""Pixels of each of the three pictures in a preview, at most."""

_SAMPLED = 16
"""Frames of a batch whose depth decides about the colours."""


def depth_levels(frames: Sequence[BatchFrame]) -> Levels:
    """Depth [m] of the two ends of the colours for all frames, from some that lie evenly among them.

    The same frames give the same levels; those that cannot be read do not count.
    """
    chosen = np.unique(np.linspace(0, len(frames) - 1, _SAMPLED).round().astype(int))
    sources = [frames[number].source for number in chosen.tolist()]
    found = [part for _, part in done_apart(_some_depth, sources) if part is not None]
    return robust_depth_levels(np.concatenate(found)) if found else (0.0, 1.0)


def _some_depth(source: FrameSource) -> NDArray[np.floating] | None:
    """Depth [m] of a frame at places that lie evenly in it; None if it cannot be read."""
    try:
        return sample(source.load().depth)
    except IlfError:
        return None


def write_preview(folder: Path, frame: RGBDFrame, depth: NDArray[np.float32], levels: Levels) -> str:
    """Write colour, measured and completed depth side by side into a frame's folder; returns the file's name.

    Parameters
    ----------
    folder : Path
    frame : RGBDFrame
    depth : ndarray of float32, shape (H, W)
        Completed depth [m], NaN = missing.
    levels : tuple of float
        Depth [m] of the two ends of the colours.

    Raises
    ------
    ExportError
        If it cannot be written.
    """
    table = depth_colours()
    pictures = [frame.rgb, *(table[to_indices(values, *levels)] for values in (frame.measured, depth))]
    height, width = frame.shape
    size = min(width, _WIDTH), max(round(height * min(width, _WIDTH) / width), 1)
    small = [cv2.resize(picture, size, interpolation=cv2.INTER_AREA) for picture in pictures]
    _, encoded = cv2.imencode(".png", np.hstack(small)[..., ::-1])
    write_bytes(folder / PREVIEW_FILE, encoded.tobytes())
    return PREVIEW_FILE


def read_preview(folder: Path) -> NDArray[np.uint8]:
    """The preview in a frame's folder, uint8 (H, W, 3), red first; raises FormatError if it cannot be read."""
    try:
        return read_colour(folder / PREVIEW_FILE)
    except InputError as error:
        raise FormatError(f"{error} Or complete the frame again.") from error
