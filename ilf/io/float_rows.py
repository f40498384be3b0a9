"""Files that are a short header and float32 values, row by row."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from .files import FileContent
from .images import check_pixel_count


def floats_behind(file: FileContent, start: int, shape: tuple[int, int], order: str) -> NDArray[np.float32]:
    """The values (H, W) behind a header of `start` bytes, in an order of bytes, "<f4" or ">f4".

    Raises
    ------
    FormatError
        If there are too many pixels, or others than the header announces.
    """
    height, width = shape
    check_pixel_count(file, width, height)
    values = file.data[start:]
    if values.size != 4 * width * height:
        raise FormatError(
            f"{file}: {width} x {height} pixels are announced, which are {4 * width * height} bytes, and {values.size} "
            "are there: it is truncated or damaged. Copy or export it again."
        )
    return np.frombuffer(values.tobytes(), order).astype(np.float32).reshape(shape)
