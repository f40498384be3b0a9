"""Ground truth, guides, confidence maps and depth by hand of a frame, read from files."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent, FileSource, existing_file, read_file, split_dataset
from .._runtime.formatting import counted
from .._runtime.plugins import GUIDES, call, entry_of_file, entry_points, load
from ..data.arrays import check_shape
from ..data.by_hand import DepthByHand, as_by_hand
from ..data.frame import COMMON_DEPTH_UNITS, GroundTruthFile, RGBDFrame, check_depth_scale
from ..data.guide import Gives, Guide
from ..data.lenses import undistorted
from ..errors import FormatError, InputError, ParameterError, told_as
from .depth import DEPTH_READERS, decoded, read_depth_values, without_channel
from .depth_doubts import marker_doubt
from .encodings import ENCODINGS, DepthEncoding, checked_units, default_depth_units, encoding_of_inputs
from .float_images import read_npy, read_npz
from .guide_models import is_guide_name, predict_by_name, predict_guide, ready_guide
from .hdf5 import HDF5_SUFFIXES
from .images import read_image, read_indices

_MAX_SCALE_RATIO = 1.5
"""Median ratio of ground truth and known depth, or its inverse, above which their units do not match."""


_EXCHANGED_SHARE = 0.2
"""Maximum ratio of the differences of ground truth and depth, with rows and columns exchanged and without."""


def with_ground_truth_file(frame: RGBDFrame, path: str | os.PathLike[str], units: float | None = None) -> RGBDFrame:
    """Return the frame with the ground truth from a file, whose scale must match the known depth.

    Parameters
    ----------
    frame : RGBDFrame
    path : path-like
        As for `read_ground_truth`.
    units : float, optional
        File units per metre. None means those of the frame's depth file if both contain integers; otherwise as for
        `read_ground_truth`.

    Returns
    -------
    RGBDFrame
        Its `inputs`, if it has any, include the file; a note tells of a value that was left out as by
        `read_ground_truth`. None is left out if the invalid value of the frame's depth was given as 0.

    Raises
    ------
    InputError, FormatError, ParameterError
        As `read_ground_truth` does, and if ground truth and known depth cannot be in the same unit.

    Examples
    --------
    >>> import ilf
    >>> from ilf._runtime.installation import asset_path
    >>> room = asset_path("samples/room")
    >>> frame = ilf.load_frame(room / "rgb.jpg", room / "depth.png")
    >>> frame = with_ground_truth_file(frame, room / "gt.png", units=1000)
    >>> frame.inputs.ground_truth.units
    1000.0
    """
    ground_truth, file, note = ground_truth_of(frame, path, units)
    problem = scale_misfit(ground_truth, frame.measured, file.units)
    if problem:
        raise InputError(f"{file.path}: {problem}")
    found = frame.with_ground_truth(ground_truth, file)
    return found.changed(notes=(*found.notes, note)) if note else found


def scale_misfit(ground_truth: NDArray[np.floating], depth: NDArray[np.floating], units: float) -> str:
    """Describe why ground truth [m], read with these file units per metre, does not match depth [m]; "" if it does."""
    both = np.isfinite(ground_truth) & np.isfinite(depth)
    if not both.any():
        return ""
    ratio = float(np.median(ground_truth[both] / depth[both]))
    is_square = depth.shape[0] == depth.shape[1]
    if is_square and _apart(ground_truth.T, depth) < _EXCHANGED_SHARE * _apart(ground_truth, depth):
        return "This ground truth fits depth only with rows and columns exchanged, as MATLAB stores them. Transpose it."
    if 1 / _MAX_SCALE_RATIO <= ratio <= _MAX_SCALE_RATIO:
        return ""
    ratios = ((other, ratio * units / other) for other in COMMON_DEPTH_UNITS)
    fitting = next((other for other, of in ratios if 1 / _MAX_SCALE_RATIO <= of <= _MAX_SCALE_RATIO), None)
    remedy = "check that it belongs to this frame" if fitting is None else f"give {fitting:g} as its units"
    would_be = f"With {units:g} units per metre, this ground truth would be {ratio:.3g} times the measured depth"
    return f"{would_be}: {remedy}, or correct the units of the depth."


def _apart(ground_truth: NDArray[np.floating], depth: NDArray[np.floating]) -> float:
    """Mean difference of ground truth and depth [m] where both are known; infinite if that is nowhere."""
    differences = np.abs(ground_truth - depth)
    known = np.isfinite(differences)
    return float(differences[known].mean()) if known.any() else math.inf


def ground_truth_of(
    frame: RGBDFrame, path: FileSource, units: float | None = None, dataset: str | None = None
) -> tuple[NDArray[np.float32], GroundTruthFile, str]:
    """What `read_ground_truth` gives, in the pixels of a frame; integers are in the units of its depth by default."""
    inputs = frame.inputs
    usual, invalid = (None, None) if inputs is None else (inputs.depth_units, inputs.invalid)
    ground_truth, file, note = read_ground_truth(path, frame.shape, units, usual, invalid, dataset)
    if inputs is not None and inputs.lenses is not None:
        ground_truth = undistorted(ground_truth, frame)
    return ground_truth, file, note


def read_ground_truth(
    path: FileSource,
    shape: tuple[int, int],
    units: float | None = None,
    default_units: float | None = None,
    invalid: float | None = None,
    dataset: str | None = None,
) -> tuple[NDArray[np.float32], GroundTruthFile, str]:
    """Read ground truth depth from an image file, as depth is read.

    Parameters
    ----------
    path : path-like or FileContent
        The dataset of an HDF5 file may be part of the path.
    shape : (int, int)
        Height and width of the frame.
    units : float, optional
        File units per metre; None means 1 if the file contains floats, and `default_units`, or else 1000, if it
        contains integers.
    default_units : float, optional
        Units of the frame's depth file, if known.
    invalid : float, optional
        The invalid value of the depth file; with 0, no value is left out.
    dataset : str, optional

    Returns
    -------
    ndarray of float32, shape (H, W)
        [m], NaN = unknown, including values beyond the range of all sensors (see `ilf.io.encodings`), and one far value
        that most likely marks missing depth.
    GroundTruthFile
    str
        A note on the value that was left out, or "".

    Raises
    ------
    InputError
        If the file does not exist, its size is not the frame's, no depth is known, or the scale is implausible.
    FormatError
        If it is damaged or contains something other than depth.
    ParameterError
        If `units` is not a positive number.

    Examples
    --------
    >>> from ilf._runtime.installation import asset_path
    >>> ground_truth, file, note = read_ground_truth(asset_path("samples/room/gt.png"), (480, 640))
    >>> ground_truth.dtype, round(float(np.isfinite(ground_truth).mean()), 2)
    (dtype('float32'), 0.96)
    """
    if not isinstance(path, FileContent):
        path, named = split_dataset(os.fspath(path))
        dataset = named or dataset
    content = read_file(path)
    values = read_depth_values(content, dataset=dataset)
    if values.shape != shape and values.shape == shape[::-1] and content.path.suffix.lower() in HDF5_SUFFIXES:
        values = values.T  # as MATLAB's h5write stores it
    check_shape(str(content), values.shape, shape, remedy="Ground truth must have the same pixels.")
    if units is None:
        default = default_depth_units(values)
        # depth in floats has 1 unit per metre, which does not apply to integers
        units = default_units if default_units not in {None, 1.0} and default != 1 else default
    with told_as(ParameterError, f"{content}: {{error}}", ParameterError):
        scale = checked_units(units)
    metres = decoded(values, DepthEncoding(None, scale))[0]
    with told_as(InputError, f"{content} cannot be ground truth: {{error}}", InputError):
        check_depth_scale(metres)
    doubt, note = None if invalid == 0 else marker_doubt(values, metres), ""
    if doubt is not None:
        is_marker = metres == doubt.invalid_depth
        constant = f"{content}: a constant {doubt.invalid_depth:.3f} m in {is_marker.mean():.1%} of the pixels"
        note = f"{constant} most likely marks missing depth, not counted. Give 0 as the invalid value if it is depth."
        metres[is_marker] = np.nan
    return metres, GroundTruthFile(str(content.path), content.sha256, scale, dataset), note


def is_ground_truth(description: object) -> bool:
    """Whether a frame's gt.* counts as ground truth by the text in meta.json, or without one. Depth filled in by an
    algorithm does not."""
    if description is None:
        return True
    words = str(description).lower()
    return bool(words) and "fill" not in words and "not measured" not in words


# Reading and writing guides.

GUIDE_SUFFIXES = (".png", ".npy", ".npz", ".tif", ".tiff", ".pgm", ".pfm", ".exr")
"""Suffixes of files that a guide can be read from."""

_USUAL_NAMES = ("guide", "depth", "disparity", "prediction")
"""Names of the guide in an NPZ with several arrays; the first that exists is read."""

_READERS = DEPTH_READERS | {".npz": lambda file: read_npz(file, _USUAL_NAMES)}


NETWORK_SUFFIX = ".onnx"
"""Suffix of a network that predicts a guide without a plugin."""


def load_guide(
    path: FileSource,
    shape: tuple[int, int] | None = None,
    rgb: NDArray[np.uint8] | None = None,
    gives: Gives | None = None,
) -> Guide:
    """Read a guide: depth or inverse depth of a frame, metric or relative; or predict it by a network.

    Parameters
    ----------
    path : path-like
        PNG or PGM with 8 or 16 bits, TIFF, PFM, EXR, NPY, or NPZ with one array, or one named guide, depth,
        disparity or prediction. NPY and NPZ of shape (2, H, W) contain values and their confidence, 0 to 1. Or a
        network that predicts depth or inverse depth from colour: ONNX, see `GuideNetwork`, the format of a plugin
        (entry points `ilf.guides`), or the name of one that was fetched or added (`ilf models list`).
    shape : (int, int), optional
        Height and width of the frame, to which it is resized; it must have the same aspect ratio.
    rgb : ndarray of uint8, shape (H, W, 3), optional
        The frame's colour, for a network.
    gives : str, optional
        What the values are, see `Guide`. None: what the card of a network with a name states.

    Raises
    ------
    InputError
        If the file does not exist, has no usable values, or its aspect ratio is not the frame's; or the card states
        another kind of values.
    FormatError
        If it is damaged or contains something else, such as a colour-mapped depth image.

    Examples
    --------
    >>> np.save("guide.npy", np.array([[0.5, 0.25], [0.5, np.nan]]))
    >>> load_guide("guide.npy").values.tolist()
    [[0.5, 0.25], [0.5, nan]]
    """
    if isinstance(path, str | os.PathLike) and (predict := guide_network(path, gives)) is not None:
        if rgb is None:
            raise InputError(f"{path}: a network predicts a guide from the frame's colour. Give it, too (rgb=).")
        guide = predict(Path(path), rgb)
        return guide if gives is None else replace(guide, gives=gives)
    content = read_file(path)
    suffix = content.path.suffix.lower()
    array = _READERS[suffix](content) if suffix in _READERS else _one_channel(content, read_image(content))
    with told_as(InputError, f"{content}: {{error}}", InputError):
        guide = replace(Guide.from_array(array, str(content.path)), gives=gives)
        return guide if shape is None else guide.resized_to(shape)


def guide_network(
    path: str | os.PathLike[str], gives: Gives | None = None
) -> Callable[[Path, NDArray[np.uint8]], Guide] | None:
    """What predicts a guide from colour by a network: one with a name, an ONNX file, or a file in the format of a
    plugin; None for others.

    Raises
    ------
    InputError
        If two plugins read the file, or one cannot be imported; or as `ready_guide`.
    """
    suffix = Path(path).suffix.lower()
    if is_guide_name(path):
        ready_guide(str(path), gives)
        return lambda name, rgb: predict_by_name(str(name), rgb)
    if suffix == NETWORK_SUFFIX:
        return lambda file, rgb: Guide(predict_guide(file, rgb), path=str(file))
    entry = None if suffix in GUIDE_SUFFIXES else entry_of_file(path, entry_points(GUIDES))
    if entry is None:
        return None
    predict = load(entry)
    return lambda file, rgb: Guide.from_array(np.asarray(call(entry, predict, existing_file(file), rgb)), str(file))


def guide_suffixes() -> tuple[str, ...]:
    """Suffixes of files that a guide can be read from or predicted by, with those of plugins."""
    return (*GUIDE_SUFFIXES, NETWORK_SUFFIX, *(f".{entry.name}" for entry in entry_points(GUIDES)))


def _one_channel(file: FileContent, image: NDArray[Any]) -> NDArray[Any]:
    """Return grey values, which many programs write in three channels; ignore alpha."""
    if image.ndim == 2:
        return image
    colours = image[..., :3] if image.shape[2] >= 3 else image[..., :1]
    if (colours != colours[..., :1]).any():
        raise FormatError(f"{file} is a colour-mapped depth image. Export the values themselves, in grey or as NPY.")
    return colours[..., 0]


# Confidence maps: depth below the minimum confidence is marked invalid.

CONFIDENCE_SUFFIXES = (".png", ".tif", ".tiff", ".pgm", ".npy")

UNUSED_CONFIDENCE = (
    "There is a confidence map, but all depth is used: set a min. confidence (in the open dialog, --min-confidence, "
    "min_confidence=; 2 is ARKit's high, in maps of 0 to 2) to mark depth below it as missing."
)
"""Note if a confidence map is not used."""

NO_GUIDE = "There is no guide, so what the guide gives has no effect."
"""Note if there is no guide, but it is said what it gives."""

NO_CONFIDENCE_MAP = "There is no confidence map, so the min. confidence has no effect."
"""Note if there is no confidence map."""


def read_confidence(path: FileSource, shape: tuple[int, int]) -> NDArray[Any]:
    """Read a confidence map.

    Parameters
    ----------
    path : path-like
        PNG, TIFF, PGM or NPY with one channel; larger values mean higher confidence.
    shape : (int, int)
        Height and width of the frame's depth.

    Returns
    -------
    ndarray, shape (H, W)
        Real numbers of any type, as stored.

    Raises
    ------
    InputError
        If the file does not exist, or its size is not that of the depth.
    FormatError
        If it is damaged or has several channels.
    """
    content = read_file(path)
    values = without_channel(read_npy(content) if content.path.suffix.lower() == ".npy" else read_indices(content))
    if values.ndim != 2 or values.dtype.kind not in "biuf":
        given = f"{values.dtype} of shape {values.shape}"
        raise FormatError(f"{content}: a confidence map must have one number per pixel, not {given}.")
    remedy = "A confidence map must have the same pixels: of depth that is registered, its own (--view depth)."
    check_shape(str(content), values.shape, shape, "the depth", remedy)
    return values


def low_confidence(
    confidence: NDArray[Any], least: float, depth: NDArray[np.floating]
) -> tuple[NDArray[np.bool_], str]:
    """Return known depth below a minimum confidence, as a mask (H, W), and a note about it.

    Parameters
    ----------
    confidence : ndarray
        (H, W); NaN counts as no confidence.
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
        told = f"the map ranges from {confidence.min():g} to {confidence.max():g}. Set a lower min. confidence."
        raise InputError(f"No depth has a confidence of {least:g} or more: {told}")
    text = f"{counted(count, 'pixel')}, {count / whole:.1%} of the known pixels"
    return low, f"Depth with a confidence below {least:g} counts as missing: {text}."


_ARKIT_HIGH = 2


_FEWEST_MISSING = 100
"""Minimum number of pixels without depth that tell the direction of a confidence map."""


def confidence_doubt(confidence: NDArray[Any], least: float, depth: NDArray[np.floating]) -> str:
    """Describe why a minimum confidence is likely of another scale than the map of depth, or why larger values seem to
    be less sure, as ZED's are (github.com/leggedrobotics/grand_tour_dataset/issues/24); "" if all is well."""
    stated, known = np.isfinite(confidence), np.isfinite(depth)
    if (stated & known).any() and np.count_nonzero(stated & ~known) >= _FEWEST_MISSING:
        where_known, where_missing = (float(np.median(confidence[stated & where])) for where in (known, ~known))
        if where_missing > where_known:
            return (
                f"Confidence is mostly {where_missing:g} where depth is missing, and {where_known:g} where it is "
                "known: larger values seem to be less sure (as of ZED), but depth of lower ones is left out. Store the "
                "map with the other order."
            )
    largest = float(np.nanmax(confidence))
    is_highest_alone = not np.any((confidence >= least) & (confidence < largest))
    if largest <= _ARKIT_HIGH or least > _ARKIT_HIGH or is_highest_alone:
        return ""
    told = f"The confidence map ranges from {np.nanmin(confidence):g} to {largest:g}, not from 0 to {_ARKIT_HIGH}"
    remedy = f"Give one of the map's scale, such as {largest:g} for its highest values alone."
    return f"{told} as ARKit's, so a min. confidence of {least:g} also keeps depth of low confidence. {remedy}"


# Depth by hand.


def load_by_hand(path: FileSource, frame: RGBDFrame, weight: float) -> DepthByHand | None:
    """Read depth by hand, with its weight; None if it states no depth.

    Parameters
    ----------
    path : path-like
        As for depth: integers are in the encoding of the frame's depth file, or in the default for their type;
        floating-point numbers are metres.
    frame : RGBDFrame
    weight : float
        See `DepthByHand`.

    Raises
    ------
    InputError, FormatError, ParameterError
        As `read_depth_values` and `DepthByHand` do, and if it does not have the frame's size.
    """
    content = read_file(path)
    values = read_depth_values(content)
    if values.dtype.kind != "f":
        values = (ENCODINGS["mm"] if frame.inputs is None else encoding_of_inputs(frame.inputs)).metres(values)
    with told_as(InputError, f"{content}: {{error}}", InputError):
        return as_by_hand(DepthByHand(values, weight), frame.shape)
