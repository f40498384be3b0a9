"""Label maps as 16-bit PNG, and masks."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import ExportError, FormatError, InputError
from ..frame import RGBDFrame
from .atomic import write_bytes
from .files import FileSource
from .images import encode_image, read_image


def write_mask(path: str | os.PathLike[str], mask: NDArray[np.bool_]) -> None:
    """Write a mask (H, W) as 8-bit PNG, 255 where it is True; raises ExportError if the file cannot be written."""
    write_bytes(path, encode_image(".png", 255 * mask.astype(np.uint8)))


def read_mask(path: str | os.PathLike[str], shape: tuple[int, int] | None = None) -> NDArray[np.bool_]:
    """Mask of an image with one channel of 8 or 16 bits, bool (H, W): True where it is not 0.

    Parameters
    ----------
    path : path-like
    shape : (int, int), optional
        (H, W) that it must have.

    Raises
    ------
    InputError, FormatError
        As `read_labels`.
    """
    return read_labels(path, shape, what="mask") > 0


def also_distrusting(frame: RGBDFrame, path: str | os.PathLike[str]) -> RGBDFrame:
    """A frame that distrusts the depth of a mask's pixels, too; raises as `read_mask` does."""
    return frame.also_distrusting(read_mask(path, frame.shape))


def write_labels(path: str | os.PathLike[str], labels: ArrayLike) -> None:
    """Write a label map atomically.

    Parameters
    ----------
    path : path-like
        Must end in .png.
    labels : array_like
        Integers 0-65535, (H, W); 0 = no block.

    Raises
    ------
    ExportError
        If the labels do not fit into 16 bits or the file cannot be written.

    Examples
    --------
    >>> write_labels("blocks.png", [[0, 1], [1, 2]])
    >>> read_labels("blocks.png").tolist()
    [[0, 1], [1, 2]]
    """
    if Path(path).suffix.lower() != ".png":
        raise ExportError(f"Labels cannot be written as {str(path)!r}: use .png.")
    write_bytes(path, encode_image(".png", checked_to_write(labels).astype(np.uint16)))


def checked_to_write(labels: ArrayLike) -> NDArray[np.int32]:
    """The label map as int32 (H, W); raises ExportError if it is none, or does not fit into 16 bits."""
    array = np.asarray(labels)
    if array.ndim != 2 or array.size == 0 or array.dtype.kind not in "iu":
        raise ExportError(f"Labels must be whole numbers with shape (H, W), not {array.dtype} {array.shape}.")
    if array.min() < 0 or array.max() > 65535:
        raise ExportError(
            f"Labels must lie between 0 and 65535 to be written, not {array.min()} to {array.max()}. Renumber them."
        )
    return array.astype(np.int32)


def read_labels(
    path: FileSource, shape: tuple[int, int] | None = None, *, what: str = "label map"
) -> NDArray[np.int32]:
    """Label map of a PNG with 8 or 16 bits, int32 (H, W); 0 = no block.

    Parameters
    ----------
    path : path-like or FileContent
    shape : (int, int), optional
        (H, W) that it must have.
    what : str
        What messages call it.

    Raises
    ------
    InputError
        If there is no such file or its size differs from `shape`.
    FormatError
        If it is damaged or no label map.
    """
    image = read_image(path)
    if image.ndim != 2 or image.dtype.kind != "u" or image.dtype.itemsize > 2:
        raise FormatError(
            f"{path}: a {what} must have one channel with 8 or 16 bits, not {image.dtype} {image.shape}. "
            "Export the values themselves, not a coloured picture of them."
        )
    if shape is not None and image.shape != shape:
        raise InputError(
            f"{path}: the {what} is {image.shape[1]} x {image.shape[0]}, the frame {shape[1]} x "
            f"{shape[0]}. Use the {what} of this frame."
        )
    return image.astype(np.int32)
