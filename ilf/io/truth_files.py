"""True depth of a frame, from a file like that of its depth."""

from __future__ import annotations

import os

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, ParameterError
from ..frame import COMMON_DEPTH_UNITS, RGBDFrame, TruthFile, check_depth_scale
from .depth_files import checked_units, default_depth_units, read_depth_values
from .depth_reading import decoded
from .encodings import DepthEncoding
from .files import FileSource, read_file

_FARTHEST = 1.5
"""Median ratio of truth and known depth, or its inverse, above which their units do not fit each other."""


def load_truth(path: str | os.PathLike[str], shape: tuple[int, int], units: float | None = None) -> NDArray[np.float32]:
    """Read true depth.

    Parameters
    ----------
    path : path-like
        PNG, TIFF, PGM or NPY, as for depth.
    shape : (int, int)
        Height and width of the frame.
    units : float, optional
        File units per metre; None takes 1000 if the file holds integers and 1 if it holds floats.

    Returns
    -------
    ndarray of float32, shape (H, W)
        [m], NaN = unknown, which what lies beyond all sensors (see `ilf.io.encodings`) is, too.

    Raises
    ------
    InputError
        If there is no such file, its size is not the frame's, nothing is known, or the scale is absurd.
    FormatError
        If it is damaged or holds something other than depth.
    ParameterError
        If `units` is not a positive number.

    Examples
    --------
    >>> from ilf.assets import asset_path
    >>> truth = load_truth(asset_path("samples/room/gt.png"), (480, 640))
    >>> truth.dtype, bool(np.isfinite(truth).all())
    (dtype('float32'), True)
    """
    return read_truth(path, shape, units)[0]


def with_truth_file(frame: RGBDFrame, path: str | os.PathLike[str], units: float | None = None) -> RGBDFrame:
    """The same frame with the truth of a file, which its scale must fit.

    Parameters
    ----------
    frame : RGBDFrame
    path : path-like
        As for `load_truth`.
    units : float, optional
        File units per metre. None takes those of the frame's depth file if both hold integers; otherwise as there.

    Returns
    -------
    RGBDFrame
        Its `inputs`, if it has any, name the file, too.

    Raises
    ------
    InputError, FormatError, ParameterError
        As `load_truth` does, and if truth and known depth cannot be in the same unit.

    Examples
    --------
    >>> import ilf
    >>> from ilf.assets import asset_path
    >>> room = asset_path("samples/room")
    >>> frame = ilf.load_frame(room / "rgb.jpg", room / "depth.png")
    >>> frame = with_truth_file(frame, room / "gt.png", units=1000)
    >>> frame.inputs.truth.units
    1000.0
    """
    usual = None if frame.inputs is None else frame.inputs.depth_units
    truth, file = read_truth(path, frame.shape, units, usual)
    problem = scale_misfit(truth, frame.measured, file.units)
    if problem:
        raise InputError(f"{file.path}: {problem}")
    return frame.with_truth(truth, file)


def scale_misfit(truth: NDArray[np.floating], depth: NDArray[np.floating], units: float) -> str:
    """Why truth [m], read with some file units per metre, cannot be of the same scene as depth [m]; "" if it can."""
    both = np.isfinite(truth) & np.isfinite(depth)
    if not both.any():
        return ""
    ratio = float(np.median(truth[both] / depth[both]))
    if 1 / _FARTHEST <= ratio <= _FARTHEST:
        return ""
    fitting = [other for other in COMMON_DEPTH_UNITS if 1 / _FARTHEST <= ratio * units / other <= _FARTHEST]
    way_out = f"give {fitting[0]:g} as its units" if fitting else "check that it belongs to this frame"
    return (
        f"With {units:g} units per metre, this truth would be {ratio:.3g} times the measured depth: {way_out}, "
        "or correct those of the depth."
    )


def read_truth(
    path: FileSource, shape: tuple[int, int], units: float | None = None, usual: float | None = None
) -> tuple[NDArray[np.float32], TruthFile]:
    """`load_truth`, and what was read; integers are in `usual` file units per metre, if that is known."""
    content = read_file(path)
    values = read_depth_values(content)
    if values.shape != shape:
        raise InputError(
            f"{content} is {values.shape[1]} x {values.shape[0]}, but the frame is {shape[1]} x {shape[0]}: a truth "
            "must show the same pixels."
        )
    if units is None:
        default = default_depth_units(values)
        # depth in floats has 1 unit per metre, which says nothing of integers
        units = usual if usual not in {None, 1.0} and default != 1 else default
    try:
        scale = checked_units(units)
    except ParameterError as error:
        raise ParameterError(f"{content}: {error}") from error
    metres = decoded(values, DepthEncoding(None, scale))[0]
    try:
        check_depth_scale(metres)
    except InputError as error:
        raise InputError(f"{content} cannot be a truth: {error}") from error
    return metres, TruthFile(str(content.path), content.sha256, scale)


def is_truth(worth: object) -> bool:
    """Whether the words of meta.json, or their lack, let its frame's gt.* count as a truth. Depth that an algorithm has
    filled in is none."""
    if worth is None:
        return True
    words = str(worth).lower()
    return bool(words) and "fill" not in words and "not measured" not in words
