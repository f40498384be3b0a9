"""Arrays to encoded images of a sensible size."""

from __future__ import annotations

import io
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from .content import ColourBar, Image

_QUALITY = 85
_BAR_PIXELS = 255


def photo(rgb: NDArray[np.uint8], quality: int = _QUALITY) -> Image:
    """A colour image, uint8 (H, W, 3), as JPEG."""
    buffer = io.BytesIO()
    Pillow.fromarray(rgb).save(buffer, "JPEG", quality=quality, optimize=True)
    return Image(buffer.getvalue(), "jpeg", rgb.shape[1], rgb.shape[0])


def by_table(indices: NDArray[np.uint8], table: NDArray[np.uint8]) -> Image:
    """Indices, uint8 (H, W), to a lookup table, uint8 (256, 3), as PNG without loss."""
    picture = Pillow.fromarray(indices)
    picture.putpalette(table.tobytes())
    buffer = io.BytesIO()
    picture.save(buffer, "PNG", optimize=True)
    return Image(buffer.getvalue(), "png", indices.shape[1], indices.shape[0])


def colour_bar(table: NDArray[np.uint8], ticks: tuple[str, str, str]) -> ColourBar:
    """The colours of a lookup table, without that of missing values."""
    row = np.arange(1, _BAR_PIXELS + 1, dtype=np.uint8)[None]
    return ColourBar(by_table(row, table), ticks)


def shrunk_shape(shape: tuple[int, int], most: int) -> tuple[int, int]:
    """Height and width of a picture that is `most` pixels wide or high at most."""
    factor = min(1.0, most / max(shape))
    return max(round(shape[0] * factor), 1), max(round(shape[1] * factor), 1)


def shrunk(values: NDArray[Any], shape: tuple[int, int], smooth: bool = False) -> NDArray[Any]:
    """An array of pixels at another size: by the nearest, or averaged over what falls into one."""
    if values.shape[:2] == shape:
        return values
    how = cv2.INTER_AREA if smooth else cv2.INTER_NEAREST
    return np.asarray(cv2.resize(values, shape[::-1], interpolation=how))
