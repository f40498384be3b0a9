"""A guide from a file, and into one."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, InputError
from ..guide import Guide
from .atomic import write_bytes
from .exr_files import read_exr
from .files import FileContent, FileSource, read_file
from .images import read_image
from .npy_files import read_npy, read_npz
from .pfm_files import read_pfm

GUIDE_SUFFIXES = (".png", ".npy", ".npz", ".tif", ".tiff", ".pgm", ".pfm", ".exr")
"""Of files that a guide can be read from."""

_USUAL_NAMES = ("guide", "depth", "disparity", "prediction")
"""Names by which an NPZ with several arrays is asked for one, the first that is there."""

_READERS: dict[str, Callable[[FileContent], NDArray[Any]]] = {
    ".npy": read_npy,
    ".npz": lambda file: read_npz(file, _USUAL_NAMES),
    ".pfm": read_pfm,
    ".exr": read_exr,
}


def load_guide(path: FileSource, shape: tuple[int, int] | None = None) -> Guide:
    """Read a guide: depth or inverse depth of a frame, metric or relative.

    Parameters
    ----------
    path : path-like
        PNG or PGM with 8 or 16 bits, TIFF, PFM, EXR, NPY, or NPZ with one array, or one that is called guide, depth,
        disparity or prediction. NPY and NPZ of shape (2, H, W) have a confidence from 0 to 1 beside the values.
    shape : (int, int), optional
        Height and width of the frame, which it is resized to; it must have the same aspect.

    Raises
    ------
    InputError
        If there is no such file, it says nothing, or its aspect is not the frame's.
    FormatError
        If it is damaged or holds something else, such as a coloured picture of depth.
    """
    content = read_file(path)
    suffix = content.path.suffix.lower()
    array = _READERS[suffix](content) if suffix in _READERS else _one_channel(content, read_image(content))
    try:
        guide = Guide.of_array(array, str(content.path))
        return guide if shape is None else guide.of_size(shape)
    except InputError as error:
        raise InputError(f"{content}: {error}") from error


def write_guide(path: str | os.PathLike[str], guide: Guide) -> None:
    """Write a guide atomically as NPY, with every digit."""
    content = io.BytesIO()
    np.save(content, guide.array.astype("<f4"))
    write_bytes(path, content.getvalue())


def _one_channel(file: FileContent, image: NDArray[Any]) -> NDArray[Any]:
    """Many programs write grey in three channels; alpha says nothing."""
    if image.ndim == 2:
        return image
    colours = image[..., :3] if image.shape[2] >= 3 else image[..., :1]
    if (colours != colours[..., :1]).any():
        raise FormatError(
            f"{file}: this is a coloured picture of depth, whose colours do not rise with depth. Export the values "
            "themselves, in grey or as NPY."
        )
    return colours[..., 0]
