"""Reading photos of phones with depth (HEIC): the colour image, and the disparity or depth image beside it."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from .._runtime.files import FileContent
from .._runtime.installation import optional
from .._runtime.memory import check_memory
from ..errors import FormatError
from .kinds import kind_of_file, wrong_kind

HEIC_SUFFIXES = ".heic", ".heif"

_INVERSE_DEPTH, _DISPARITY, _DEPTH = range(3)
"""Representation types of depth images in the HEVC standard: inverse depth, disparity [1/m], and depth, all uniform."""

_ORIENTATION = 274

_ASPECT_TOLERANCE = 0.01


def read_heic_depth(file: FileContent) -> NDArray[np.float32]:
    """Read the depth image of a photo.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.

    Raises
    ------
    InputError
        If pillow-heif is not installed.
    FormatError
        If the photo is damaged, or has no depth image whose values can be converted to metres.
    """
    with _opened(file) as photo:
        image = _depth_image(file, photo)
        check_memory(file, *image.size)
        values = np.asarray(image)
    if values.ndim != 2 or values.dtype.kind not in "ui":
        raise FormatError(f"{file}: its depth image has shape {values.shape} and type {values.dtype}, not one channel.")
    stated = image.info.get("metadata") or {}
    share = values.astype(np.float64) / np.iinfo(values.dtype).max
    kind = stated.get("representation_type")
    try:
        with np.errstate(divide="ignore", invalid="ignore"):
            if kind == _DISPARITY:
                metres = 1 / (stated["d_min"] + share * (stated["d_max"] - stated["d_min"]))
            elif kind == _INVERSE_DEPTH:
                far, near = 1 / stated["z_far"], 1 / stated["z_near"]
                metres = 1 / (far + share * (near - far))
            elif kind == _DEPTH:
                metres = stated["z_near"] + share * (stated["z_far"] - stated["z_near"])
            else:
                raise KeyError("representation_type")
    except (KeyError, TypeError, ArithmeticError) as error:
        raise FormatError(
            f"{file}: its depth image does not state how its values become metres. Give depth in a file of its own."
        ) from error
    return np.where(np.isfinite(metres) & (metres > 0), metres, np.nan).astype(np.float32)


def read_heic_colour(file: FileContent) -> NDArray[np.uint8]:
    """Read the colour of a photo, RGB (H, W, 3); with a depth image, which shows the same view, at its size, by area
    averages. Raises as `read_heic_depth`."""
    with _opened(file) as photo:
        colour = Image.frombytes(photo.mode, photo.size, photo.data, "raw", photo.mode, photo.stride).convert("RGB")
        images = photo.info.get("depth_images")
    if images:
        size = images[0].size
        if abs(size[0] / size[1] * colour.height / colour.width - 1) > _ASPECT_TOLERANCE:
            raise FormatError(
                f"{file}: its depth image of {size[0]} x {size[1]} pixels shows another view than colour."
            )
        colour = colour.resize(size, Image.Resampling.BOX)
    return np.asarray(colour, np.uint8)


def heic_orientation(file: FileContent) -> int:
    """The orientation tag of a photo, which its decoder has applied already; 1 if there is none."""
    with _opened(file) as photo:
        exif = Image.Exif()
        exif.load(photo.info.get("exif") or b"")
        return int(exif.get(_ORIENTATION, 1))


@contextmanager
def _opened(file: FileContent) -> Iterator[Any]:
    """Open a photo; its images are decoded in the block, whose errors of the decoder become FormatError."""
    heif = optional("pillow_heif", "ilf-studio[sensors]", "Reading HEIC")
    try:
        photo = heif.open_heif(io.BytesIO(file.data.tobytes()), convert_hdr_to_8bit=True)
        check_memory(file, *photo.size)
        yield photo
    except FormatError:
        raise
    except (ValueError, OSError, RuntimeError, SyntaxError, EOFError, MemoryError) as error:
        if file.data[4:8].tobytes() != b"ftyp" and kind_of_file(file, file.data):
            raise wrong_kind(file, file.data, "an HEIC photo") from error
        raise FormatError(f"{file}: this HEIC cannot be read ({error!s:.80}). Copy it again.") from error


def _depth_image(file: FileContent, photo: Any) -> Any:
    images = photo.info.get("depth_images") or []
    if not images:
        raise FormatError(f"{file} has no depth image. Take the photo in portrait mode, or export its depth.")
    return images[0]
