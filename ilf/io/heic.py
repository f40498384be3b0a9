"""Reading photos of phones with depth (HEIC): the colour image, and the disparity or depth image beside it."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any, TypeVar

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

Result = TypeVar("Result")


def read_heic_depth(file: FileContent) -> NDArray[np.float32]:
    """Read the depth image of a photo, as all else of it, in a child.

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
    return _in_child(_depth, file)


def read_heic_colour(file: FileContent) -> NDArray[np.uint8]:
    """Read the colour of a photo, RGB (H, W, 3); with a depth image, which shows the same view, at its size, by area
    averages. Raises as `read_heic_depth`."""
    return _in_child(_colour, file)


def heic_orientation(file: FileContent) -> int:
    """The orientation tag of a photo, which its decoder has applied already; 1 if there is none."""
    return _in_child(_orientation, file)


def _in_child(read: Callable[[FileContent], Result], file: FileContent) -> Result:
    from .._runtime.children import run_in_child

    if file.data[4:8].tobytes() != b"ftyp" and kind_of_file(file, file.data):
        raise wrong_kind(file, file.data, "an HEIC photo")
    return run_in_child(read, file, file=str(file), doing="reading this HEIC")


def _opened(file: FileContent) -> Any:
    """The photo, whose images are decoded when they are asked for."""
    heif = optional("pillow_heif", "ilf-studio[sensors]", "Reading HEIC")
    photo = heif.open_heif(io.BytesIO(file.data.tobytes()), convert_hdr_to_8bit=True)
    check_memory(file, *photo.size)
    return photo


def _depth(file: FileContent) -> NDArray[np.float32]:
    images = _opened(file).info.get("depth_images") or []
    if not images:
        raise FormatError(f"{file} has no depth image. Take the photo in portrait mode, or export its depth.")
    image = images[0]
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
        raise FormatError(f"{file} does not state how its depth becomes metres. Give a file of depth.") from error
    return np.where(np.isfinite(metres) & (metres > 0), metres, np.nan).astype(np.float32)


def _colour(file: FileContent) -> NDArray[np.uint8]:
    photo = _opened(file)
    colour = Image.frombytes(photo.mode, photo.size, photo.data, "raw", photo.mode, photo.stride).convert("RGB")
    if images := photo.info.get("depth_images"):
        size = images[0].size
        if abs(size[0] / size[1] * colour.height / colour.width - 1) > _ASPECT_TOLERANCE:
            raise FormatError(f"{file}: its depth of {size[0]} x {size[1]} pixels shows another view than colour.")
        colour = colour.resize(size, Image.Resampling.BOX)
    return np.asarray(colour, np.uint8)


def _orientation(file: FileContent) -> int:
    exif = Image.Exif()
    exif.load(_opened(file).info.get("exif") or b"")
    return int(exif.get(_ORIENTATION, 1))
