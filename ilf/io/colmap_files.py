"""Depth maps of COLMAP: "width&height&1&" in ASCII, then float32 row by row, little-endian."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from .files import FileContent
from .float_rows import floats_behind

COLMAP_SUFFIX = ".bin"

_HEADER = re.compile(rb"(\d{1,9})&(\d{1,9})&(\d{1,9})&")
_LONGEST_HEADER = 30


def read_colmap(file: FileContent) -> NDArray[np.float32]:
    """Depth (H, W) in the units of the reconstruction, 0 or negative = missing.

    Raises
    ------
    FormatError
        If it is no such file, has several channels, is cut short or goes on after its end.
    """
    header = _HEADER.match(file.data[:_LONGEST_HEADER].tobytes())
    if header is None:
        raise FormatError(f"{file}: a depth map of COLMAP begins with width&height&1&, and this does not.")
    width, height, channels = map(int, header.groups())
    if channels != 1:
        raise FormatError(
            f"{file} has {channels} channels, as normal maps have, where depth has one. Give the file of depth_maps."
        )
    return floats_behind(file, header.end(), (height, width), "<f4")
