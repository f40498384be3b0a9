"""Depth images: reading in file units and by their encoding, and writing."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.files import FileContent, FileSource, read_file, with_dataset
from .._runtime.formatting import counted
from .._runtime.writing import write_bytes
from ..data.arrays import plain_array
from ..errors import ExportError, FormatError, IlfError, check_path, told_as
from .cameras import CAMERA_FILE, camera_of_image
from .depth_doubts import DepthReading, are_8_bits
from .encodings import (
    ENCODINGS,
    UINT16_MAX,
    DepthEncoding,
    EncodingSpec,
    beyond_sensor_range,
    checked_finite,
    checked_units,
    default_depth_units,
    encoding_of,
    is_name,
    packed_channels,
)
from .float_images import (
    COLMAP_SUFFIX,
    KINECT_V2_SUFFIXES,
    PFM_SUFFIX,
    encode_exr,
    is_kinect_v2,
    npz_scales,
    read_bin,
    read_exr,
    read_kinect_v2,
    read_npy,
    read_npz,
    read_pfm,
    read_viewer_raw,
)
from .hdf5 import HDF5_SUFFIXES, hdf5_scales, read_hdf5
from .heic import HEIC_SUFFIXES, read_heic_depth
from .images import encode_image, is_common_image, read_image
from .kinds import wrong_kind
from .pcl_files import PCD_SUFFIX, PCLZF_SUFFIX, read_pcd_depth, read_pclzf_depth

DEPTH_SUFFIXES = (".png", ".tif", ".tiff", ".npy", ".exr")
"""Suffixes that `write_depth` supports."""

_DEPTH_ARRAYS = "depth", "depths"
"""Names of depth in an NPZ with several arrays."""

DEPTH_READERS: dict[str, Callable[[FileContent], NDArray[Any]]] = {
    ".npy": read_npy,
    ".npz": lambda file: read_npz(file, _DEPTH_ARRAYS),
    ".exr": read_exr,
    PFM_SUFFIX: read_pfm,
    COLMAP_SUFFIX: read_bin,
    ".raw": lambda file: read_kinect_v2(file) if is_kinect_v2(file) else read_viewer_raw(file),
    **dict.fromkeys(HDF5_SUFFIXES, read_hdf5),
    PCD_SUFFIX: read_pcd_depth,
    PCLZF_SUFFIX: read_pclzf_depth,
    **dict.fromkeys(HEIC_SUFFIXES, read_heic_depth),
}
"""Suffix -> reader of depth files that are not common image formats."""

_DEPTH_FORMATS = "a PNG, TIFF, PGM, NPY, NPZ, EXR, PFM, HDF5, MATLAB 7.3, PCD, PCLZF or HEIC file"


def read_depth_values(path: FileSource, channels: str = "", dataset: str | None = None) -> NDArray[Any]:
    """Read depth in file units, without marking missing values.

    Parameters
    ----------
    path : path-like
        16-bit PNG or PGM, integer or floating-point TIFF, NPY or NPZ, EXR, PFM, HDF5, a depth map of COLMAP (.bin),
        512 x 424 float32 of a Kinect v2 without a header (.bin, .raw), a snapshot of the RealSense Viewer (.raw, with
        its _metadata.csv beside it), an organised cloud (.pcd, its z), depth of PCL's
        grabbers (.pclzf), or a phone's photo with depth (.heic). One channel may be an axis of its own, (H, W, 1) or
        (1, H, W).
    channels : str
        The channels of an 8-bit image that contain a value, from its lowest bits to its highest, as in "rgb"; "" for
        depth in one channel.
    dataset : str, optional
        Name of the dataset of an HDF5 file with several, such as "/left/depth".

    Returns
    -------
    ndarray
        (H, W), integer of at least 16 bits or floating-point.

    Raises
    ------
    InputError
        If the file does not exist, or the package that reads EXR is not installed.
    FormatError
        If it is damaged or contains something other than depth, such as a rendered depth image.
    """
    content = read_file(path)
    if dataset is not None:
        if content.path.suffix.lower() not in HDF5_SUFFIXES:
            raise FormatError(f"{content} is no HDF5 file, so it has no dataset {dataset}. Leave the dataset out.")
        return checked_depth_values(without_channel(read_hdf5(content, dataset)), path)
    if channels:
        return _joined_channels(content, channels)
    reader = DEPTH_READERS.get(content.path.suffix.lower())
    if reader is None and not is_common_image(content.data[:64].tobytes()):
        raise wrong_kind(content, content.data, _DEPTH_FORMATS)
    return checked_depth_values(without_channel((reader or read_image)(content)), path)


def _joined_channels(file: FileContent, channels: str) -> NDArray[np.uint32]:
    """Values of 24 or 32 bits, (H, W), from the channels of an 8-bit image; others are ignored."""
    if file.data[:2].tobytes() == b"\xff\xd8":
        raise FormatError(f"{file}: JPEG compression has changed the bits of its values. Export depth as PNG.")
    image = read_image(file)
    if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] < len(channels):
        expected = f"depth in {len(channels)} channels of 8 bits was expected"
        told = f"{file}: {expected}, not {image.dtype} of shape {image.shape}"
        raise FormatError(f"{told}. Give the encoding of this file, or export it without conversion.")
    values = np.zeros(image.shape[:2], np.uint32)
    for at, channel in enumerate(channels):
        values |= image[..., "bgra".index(channel)].astype(np.uint32) << np.uint32(8 * at)  # the decoder's order
    return values


def without_channel(values: NDArray[Any]) -> NDArray[Any]:
    """Values (H, W) from an array (H, W, 1) or (1, H, W); others unchanged."""
    if values.ndim != 3 or 1 not in (values.shape[0], values.shape[2]):
        return values
    return values[..., 0] if values.shape[2] == 1 else values[0]


def checked_depth_values(values: NDArray[Any], path: object) -> NDArray[Any]:
    """Return an image unchanged if it can be depth, as described in `read_depth_values`; otherwise raise FormatError
    with the name of its file or recording."""
    if values.dtype.kind in "iu" and values.dtype.itemsize == 1:
        raise eight_bit_error(path, values.shape[2] if values.ndim == 3 else 1)
    if values.ndim != 2 or values.size == 0:
        raise FormatError(
            f"{path}: depth must have the shape (H, W), not {values.shape}. Export one channel of raw depth."
        )
    if values.dtype.kind not in "iuf":
        raise FormatError(f"{path}: depth must be real numbers, not {values.dtype}. Save it as float32 metres.")
    return values


def eight_bit_error(path: object, channels: int = 1) -> FormatError:
    """The error to raise for an image of 8 bits in place of depth."""
    what = "an 8-bit image" if channels == 1 else f"an 8-bit image, {channels} channels"
    bits = "rgb24:METRES as encoding (CARLA: rgb24:1000)" if channels == 3 else "float32 as encoding (TartanAir V2)"
    simulated = f" If a simulator put the bits of depth into them, give {bits}."
    told = f"{path}: this is {what}, not depth: export the raw 16-bit or float depth with one channel"
    return FormatError(f"{told}. If it is the colour image, the two were swapped.{simulated if channels > 2 else ''}")


def _scene_scale(file: FileContent, _dataset: str | None) -> dict[str, tuple[float, ...]]:
    """The scale that a scene of BOP states beside an image; none elsewhere."""
    with suppress(IlfError):
        scale = camera_of_image(file.path)[1]
        return {f"depth_scale {scale:g} in {CAMERA_FILE}": (1000 / scale,)}
    return {}


_SCALES: dict[str, Callable[[FileContent, str | None], dict[str, tuple[float, ...]]]] = {
    ".npz": lambda file, _dataset: npz_scales(file),
    **dict.fromkeys(HDF5_SUFFIXES, hdf5_scales),
}
"""Suffix -> what finds the scales that such files state beside depth; those of images are stated in other files."""

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
    if given is None and stated is None:
        read = replace(read, scales=_SCALES.get(file.path.suffix.lower(), _scene_scale)(file, dataset))
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


def write_depth(path: str | os.PathLike[str], depth: ArrayLike, units: float = 1000.0) -> list[str]:
    """Write depth atomically, in the format given by the suffix.

    Parameters
    ----------
    path : path-like
        .png: uint16 in file units, rounded, 0 = missing. .tif, .tiff, .npy, .exr: float32 [m], NaN = missing.
    depth : array_like
        Depth [m], (H, W); values that are not finite and positive are missing. A frame or completion stands for its
        depth.
    units : float
        File units per metre, for .png only.

    Returns
    -------
    list of str
        Warnings about depth that did not fit into 16 bits, and what to do about it; may be empty.

    Raises
    ------
    ExportError
        For another suffix or shape, or if the file cannot be written.
    InputError
        If the package that writes EXR is not installed.
    ParameterError
        If `units` is not a positive number.

    Examples
    --------
    >>> write_depth("depth.png", np.array([[1.5, np.nan]]), units=1000)
    []
    >>> read_depth_values("depth.png").tolist()
    [[1500, 0]]
    """
    check_path(path)
    content, warnings = encode_depth(path, getattr(depth, "depth", depth), units)
    write_bytes(path, content)
    return warnings


def encode_depth(path: str | os.PathLike[str], depth: ArrayLike, units: float = 1000.0) -> tuple[bytes, list[str]]:
    """Return the content of the file that `write_depth` writes, and its warnings; raises as it does."""
    suffix = Path(path).suffix.lower()
    if suffix not in DEPTH_SUFFIXES:
        raise ExportError(f"Depth cannot be written as {str(path)!r}: use one of {', '.join(DEPTH_SUFFIXES)}.")
    metres = np.array(plain_array(depth), np.float32)
    metres[~(np.isfinite(metres) & (metres > 0))] = np.nan
    if metres.ndim != 2 or metres.size == 0:
        raise ExportError(f"Depth must have shape (H, W) to be written, not {metres.shape}.")
    if suffix == ".png":
        image, warnings = _as_uint16(metres, checked_units(units))
        return encode_image(suffix, image), warnings
    if suffix == ".npy":
        return encode_npy(metres), []
    return encode_exr(metres) if suffix == ".exr" else encode_image(suffix, metres), []


def encode_npy(array: NDArray[np.float32]) -> bytes:
    """Return values as NPY, without loss."""
    content = io.BytesIO()
    np.save(content, array.astype("<f4"))
    return content.getvalue()


def png_losses(depth: NDArray[np.floating], units: float) -> list[str]:
    """Describe what a 16-bit PNG of depth loses, a sentence each: depth that is too far, or too near.

    Parameters
    ----------
    depth : ndarray
        [m], of any shape, NaN = missing.
    units : float
        File units per metre, positive.
    """
    known = depth[np.isfinite(depth)]
    values, losses = _in_units(known, units), []
    if clipped := int(np.count_nonzero(values > UINT16_MAX)):
        deepest = float(known.max())
        largest = UINT16_MAX / deepest if deepest > UINT16_MAX else UINT16_MAX // deepest
        most = f"Depth beyond {UINT16_MAX / units:.4g} m, the maximum of 16 bits at {units:g} units per metre"
        remedy = f"Use at most {largest:.6g} units per metre for {deepest:.4g} m, or write TIFF or NPY."
        losses.append(f"{most}, is clipped: {counted(clipped, 'pixel')}. {remedy}")
    if rounded_to_zero := int(np.count_nonzero(values == 0)):
        least = f"Depth below half a unit at {units:g} units per metre is rounded to 0, which means missing"
        remedy = "Use more units per metre, or write TIFF or NPY."
        losses.append(f"{least}: {counted(rounded_to_zero, 'pixel')}. {remedy}")
    return losses


def precision_loss(given: float, written: float) -> str:
    """Describe in one sentence the precision that a PNG loses relative to the input; "" if it loses none.

    Parameters
    ----------
    given, written : float
        File units per metre of the input's depth and of the PNG. Float depth, in metres, has 1 and counts as no loss:
        its steps are unknown.
    """
    if written >= given:
        return ""
    steps = f"The PNG has steps of {1000 / written:.4g} mm, the input has {1000 / given:.4g} mm"
    return f"{steps}: write {given:g} units per metre to keep its precision, or TIFF or NPY, which are lossless."


def encode_expected_error(
    path: str | os.PathLike[str], error: ArrayLike, units: float = 1000.0
) -> tuple[bytes, list[str]]:
    """Return expected errors as a file, as `encode_depth` does depth.

    Parameters
    ----------
    path : path-like
        Its suffix is the format. In a PNG the minimum error is one unit, because 0 means not filled.
    error : array_like
        Expected error [m], (H, W), NaN where not filled.
    units : float
        File units per metre, for .png only.

    Raises
    ------
    ExportError, ParameterError
        As `write_depth` does.
    """
    values = np.asarray(plain_array(error), np.float32)
    if Path(path).suffix.lower() == ".png":
        values = np.maximum(values, np.float32(1 / checked_units(units)))
    return encode_depth(path, values, units)


def _as_uint16(metres: NDArray[np.float32], units: float) -> tuple[NDArray[np.uint16], list[str]]:
    losses, values = png_losses(metres, units), _in_units(metres, units)
    np.minimum(values, UINT16_MAX, out=values)
    return np.nan_to_num(values, copy=False, nan=0.0).astype(np.uint16), losses


def _in_units(metres: NDArray[np.floating], units: float) -> NDArray[np.float64]:
    values = metres.astype(np.float64)
    values *= units
    return np.rint(values, out=values)
