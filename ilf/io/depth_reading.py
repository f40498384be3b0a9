"""Reading depth files by their encoding."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent, with_dataset
from .._runtime.formatting import counted
from ..errors import FormatError, told_as
from .depth import checked_depth_values, checked_finite, default_depth_units, read_depth_values
from .depth_doubts import DepthReading, are_8_bits
from .encodings import (
    ENCODINGS,
    DepthEncoding,
    EncodingSpec,
    beyond_sensor_range,
    encoding_of,
    is_name,
    packed_channels,
)
from .float_images import KINECT_V2_SUFFIXES, is_kinect_v2
from .heic import HEIC_SUFFIXES

_SAYS_RELATIVE = re.compile(rb"depthData:Accuracy(>|=[\"'])\s*relative")
"""What Apple's photos say, see AVDepthData.Accuracy.relative."""


def read_depth(
    file: FileContent,
    given: EncodingSpec | None = None,
    stated: EncodingSpec | None = None,
    invalid: float | None = None,
    dataset: str | None = None,
) -> DepthReading:
    """Read a depth file.

    Parameters
    ----------
    file : FileContent
    given, stated : str or float, optional
        The encoding, see `encoding_of`: that given by the user precedes that stated beside the file.
    invalid : float, optional
        The file's value that marks missing depth.
    dataset : str, optional
        The dataset of an HDF5 file, see `read_depth_values`.

    Raises
    ------
    InputError, FormatError, ParameterError
        As `read_depth_values` and `encoding_of` do.
    """
    if stated is None and file.path.suffix.lower() in KINECT_V2_SUFFIXES and is_kinect_v2(file):
        stated = ENCODINGS["mm"].units
    values = read_depth_values(file, packed_channels(stated if given is None else given), dataset)
    read = interpret_depth(values, Path(with_dataset(file.path, dataset)), given, stated, invalid)
    is_photo = file.path.suffix.lower() in HEIC_SUFFIXES
    return replace(read, is_relative=is_photo and _SAYS_RELATIVE.search(file.data.tobytes()) is not None)


def interpret_depth(
    values: NDArray[Any],
    path: Path,
    given: EncodingSpec | None = None,
    stated: EncodingSpec | None = None,
    invalid: float | None = None,
) -> DepthReading:
    """Interpret the values (H, W) of a depth image from `path`, as `read_depth` does."""
    spec, usual = stated if given is None else given, default_depth_units(checked_depth_values(values, path))
    if invalid is not None:
        invalid = checked_finite(invalid, "The invalid value", ": non-finite values are always missing")
    encoding = replace(encoding_of(usual if spec is None else spec, path), invalid=invalid)
    if given is None and encoding.units == 1 and values.dtype.kind == "f" and are_8_bits(values):
        whole = "its values are whole numbers from 0 to 255, as of an 8-bit image stored as float"
        raise FormatError(f"{path}: {whole}: give raw depth, or the encoding or units of these values.")
    seen = values[np.isfinite(values) & (values != 0)]
    if values.dtype.kind in "if" and seen.size and seen.min() < seen.max() < 0:  # a single value marks missing depth
        told = f"{path}: all values are negative, as where a camera looks along -z (Isaac Gym)"
        raise FormatError(f"{told}: store them with the other sign.")
    with told_as(FormatError, f"{path}: {{error}}", FormatError):
        metres, left_out = decoded(values, encoding)
    return DepthReading(values, metres, encoding, spec is None, is_name(spec), left_out, path)


def decoded(values: NDArray[Any], encoding: DepthEncoding) -> tuple[NDArray[np.float32], str]:
    """Convert values to depth [m], NaN = missing, with a note on depth left out beyond the range of sensors, or ""."""
    metres = encoding.metres(values)
    far = beyond_sensor_range(metres, encoding.farthest)
    if far is None:
        return metres, ""
    metres[far] = np.nan
    pixels = f"{counted(int(np.count_nonzero(far)), 'pixel')} ({far.mean():.1%})"
    return metres, f"Depth beyond {encoding.farthest:g} m, out of range of any sensor, counts as missing: {pixels}."
