"""Portable float maps (PFM): text header, then float32 rows from the bottom to the top."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from .files import FileContent
from .float_rows import floats_behind

_HEADER = re.compile(rb"P([fF])\s+(\d{1,9})\s+(\d{1,9})\s+([-+]?[0-9.]{1,20}(?:[eE][-+]?\d{1,3})?)\s")
_LONGEST_HEADER = 100


def read_pfm(file: FileContent) -> NDArray[np.float32]:
    """Values (H, W) as they are stored, the top row first. The header's scale tells the byte order alone.

    Raises
    ------
    FormatError
        If it is no PFM, has colours, is cut short or goes on after its end.
    """
    header = _HEADER.match(file.data[:_LONGEST_HEADER].tobytes())
    if header is None:
        raise FormatError(f"{file}: this is not a PFM, whatever its name says. Copy or export it again.")
    kind, width, height, scale = header[1], int(header[2]), int(header[3]), header[4]
    if kind == b"F":
        raise FormatError(f"{file}: this PFM has three channels. Export depth with one.")
    order = "<f4" if scale.startswith(b"-") else ">f4"
    return floats_behind(file, header.end(), (height, width), order)[::-1].copy()
