"""A frame's colour image, small, and read as fast as it can be."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from .files import read_file
from .frame_source import FrameSource
from .frames import frame_folder
from .headers import check_checksums, image_header
from .images import check_pixel_count, quietly
from .recordings import opened

THUMBNAIL_WIDTH = 160
_REDUCED = ((8, cv2.IMREAD_REDUCED_COLOR_8), (4, cv2.IMREAD_REDUCED_COLOR_4), (2, cv2.IMREAD_REDUCED_COLOR_2))


def read_thumbnail(source: FrameSource, width: int = THUMBNAIL_WIDTH) -> NDArray[np.uint8]:
    """The colour image of a frame that is not read otherwise: decoded small, to look at.

    Returns
    -------
    ndarray of uint8, shape (h, width, 3)
        Red first.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it cannot be decoded.
    """
    if source.frame is not None:
        with opened(source.rgb) as recording:
            return thumbnail_of(recording.colour(source.frame), width)
    path = frame_folder(source.rgb).rgb if source.depth is None else Path(source.rgb)
    data = read_file(path).data
    content = data.tobytes()
    header = image_header(path, content)
    check_pixel_count(path, header.width, header.height)
    if header.kind == "PNG":  # whose decoder takes as much memory as a damaged length asks for
        check_checksums(path, content)
    flag = next((flag for factor, flag in _REDUCED if header.width >= factor * width), cv2.IMREAD_COLOR)
    image = quietly(lambda: cv2.imdecode(data, flag | cv2.IMREAD_IGNORE_ORIENTATION))
    if image is None:
        raise FormatError(f"{path}: this {header.kind} cannot be decoded: it is truncated, damaged, or of a rare kind.")
    return thumbnail_of(np.asarray(image)[..., ::-1], width)


def thumbnail_of(rgb: NDArray[Any], width: int = THUMBNAIL_WIDTH) -> NDArray[np.uint8]:
    """A colour image, uint8 (H, W, 3), made `width` pixels wide.

    Examples
    --------
    >>> thumbnail_of(np.zeros((480, 640, 3), np.uint8)).shape
    (120, 160, 3)
    """
    height = max(round(width * rgb.shape[0] / rgb.shape[1]), 1)
    small = cv2.resize(np.ascontiguousarray(rgb), (width, height), interpolation=cv2.INTER_AREA)
    return small.astype(np.uint8, copy=False)
