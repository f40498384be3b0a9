"""How sure the sensor was of its depth, pixel by pixel: what is below a level is distrusted."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, InputError, ParameterError
from ..numbers import as_float
from .files import FileSource, read_file
from .images import read_image
from .npy_files import read_npy

CONFIDENCE_SUFFIXES = (".png", ".tif", ".tiff", ".pgm", ".npy")

UNUSED = (
    "There is a confidence map, and all depth counts all the same: with a least confidence (a row of the open dialog, "
    "--min-confidence, min_confidence=; 2 for what ARKit calls high) what is below it is missing."
)
"""What is said where a confidence map is not used."""

NO_MAP = "There is no confidence map, so the least confidence changes nothing."
"""What is said where there is none to use."""


def read_confidence(path: FileSource, shape: tuple[int, int]) -> NDArray[Any]:
    """Read a confidence map.

    Parameters
    ----------
    path : path-like
        PNG, TIFF, PGM or NPY with one channel; the larger a value, the surer.
    shape : (int, int)
        Height and width of the frame's depth.

    Returns
    -------
    ndarray, shape (H, W)
        Real numbers of any type, as they are stored.

    Raises
    ------
    InputError
        If there is no such file, or its size is not that of the depth.
    FormatError
        If it is damaged or has several channels.
    """
    content = read_file(path)
    values = read_npy(content) if content.path.suffix.lower() == ".npy" else read_image(content)
    if values.ndim != 2 or values.dtype.kind not in "biuf":
        raise FormatError(f"{content}: a confidence map has one number per pixel, and this is {_kind(values)}.")
    if values.shape != shape:
        raise InputError(
            f"{content} is {values.shape[1]} x {values.shape[0]}, but the depth is {shape[1]} x {shape[0]}: a "
            "confidence map must show the same pixels."
        )
    return values


def below(confidence: NDArray[Any], least: float, depth: NDArray[np.floating]) -> tuple[NDArray[np.bool_], str]:
    """Known depth whose confidence is below a level, as a mask (H, W), and what to say of it.

    Parameters
    ----------
    confidence : ndarray
        (H, W); NaN is no confidence.
    least : float
    depth : ndarray
        [m], (H, W), NaN = missing.

    Raises
    ------
    InputError
        If no known depth is left.
    """
    known = np.isfinite(depth)
    low = known & ~(confidence >= least)
    count, whole = int(np.count_nonzero(low)), int(np.count_nonzero(known))
    if count == whole:
        raise InputError(
            f"No depth has a confidence of {least:g} or more: the map goes from {confidence.min():g} to "
            f"{confidence.max():g}. Give a lower least confidence."
        )
    share = count / whole
    return low, f"Depth of a confidence below {least:g} counts as missing: {count} pixels, {share:.1%} of the known."


def checked_least(value: object) -> float:
    """The least confidence as float; ParameterError unless it is a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise ParameterError(f"The least confidence must be a number, not {value!r:.60}.")
    number = as_float(value)
    if not math.isfinite(number):
        raise ParameterError("The least confidence must be a finite number, a level of the confidence map.")
    return number


def _kind(values: NDArray[Any]) -> str:
    return f"{values.dtype} of shape {values.shape}"
