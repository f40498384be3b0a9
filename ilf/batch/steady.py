"""Depth of a camera that stands still: what neighbouring frames have measured where their colour is the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ..frame import RGBDFrame
from ..io import load_frame, write_depth
from ..io.atomic import write_bytes
from ..io.folders import made_folder
from ..number_words import counted
from .reading import Reading

DEPTH_FILE, COLOUR_FILE = "steady/depth.npy", "steady/rgb.png"
"""What a frame is completed from, in its folder; the colour only if it has no file of its own."""

_BLUR = 2.0
"""Standard deviation [px] with which colours are smoothed before they are compared: noise goes, things stay."""

_LEAST, _TIMES, _MOST = 2.5, 6.0, 8.0
"""Colours differ from so many levels on, or from so many deviations of their noise, but from so many in any case."""

_MARGIN = 6
"""What lies so many pixels from a change has changed: depth is not as sharp as colour."""

_MOVED = 0.4
"""A frame of which a larger share has changed is one of another view."""


def steadied(reading: Reading, folder: Path) -> tuple[RGBDFrame, tuple[str, ...]]:
    """A frame with `steady_depth`, read from files in a folder, so that its run can be made again.

    Returns
    -------
    (RGBDFrame, tuple of str)
        And the paths of these files in the folder.

    Raises
    ------
    ExportError
        If they cannot be written.
    """
    frame = reading.frame
    layers = _layers(frame, reading.neighbours)
    depth = _median(layers)
    made_folder((folder / DEPTH_FILE).parent)
    write_depth(folder / DEPTH_FILE, depth)
    inputs, files = frame.inputs, [DEPTH_FILE]
    if inputs is None or inputs.frame is not None:  # its colour has no file of its own
        _, encoded = cv2.imencode(".png", frame.rgb[..., ::-1])
        write_bytes(folder / COLOUR_FILE, encoded.tobytes())
        files.append(COLOUR_FILE)
    truth = None if inputs is None else inputs.truth
    read = load_frame(
        folder / COLOUR_FILE if COLOUR_FILE in files or inputs is None else inputs.rgb.path,
        folder / DEPTH_FILE,
        intrinsics=frame.intrinsics,
        name=frame.name,
        truth=None if truth is None else truth.path,
        truth_units=None if truth is None else truth.units,
        beside=False,
        warn=False,
    )
    told = _told(frame, depth, len(layers), len(reading.neighbours))
    steady = replace(read, outside_view=frame.outside_view, pose=frame.pose, notes=(*frame.notes, told))
    return steady.with_guide(frame.guide), tuple(files)


def steady_depth(frame: RGBDFrame, others: Sequence[RGBDFrame]) -> NDArray[np.float32]:
    """The median of what a frame and its neighbours have measured, pixel by pixel, where colour has not changed.

    A pixel is known where any of the frames knows it that show the same there.

    Parameters
    ----------
    frame : RGBDFrame
    others : sequence of RGBDFrame
        Of the same camera, taken shortly before and after. Those of another size, and those that show something else
        nearly everywhere, have no say.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.

    Examples
    --------
    >>> rgb = np.zeros((20, 30, 3), np.uint8)
    >>> frames = [RGBDFrame(rgb, np.full((20, 30), depth)) for depth in (2.0, 2.03, 1.99)]
    >>> float(steady_depth(frames[1], [frames[0], frames[2]])[0, 0])
    2.0
    """
    return _median(_layers(frame, others))


def _layers(frame: RGBDFrame, others: Sequence[RGBDFrame]) -> NDArray[np.float32]:
    """Depth [m] of a frame and of those of the others that show the same view, (N, H, W), NaN where they have
    changed."""
    smooth = _smooth(frame.rgb)
    depths = [frame.depth]
    for other in others:
        if other.shape != frame.shape:
            continue
        changed = _changed(smooth, _smooth(other.rgb))
        if changed.mean() <= _MOVED:
            depths.append(np.where(changed, np.float32(np.nan), other.depth))
    return np.stack(depths)


def _told(frame: RGBDFrame, depth: NDArray[np.float32], used: int, neighbours: int) -> str:
    """What the frames around have changed of a frame's depth [m], (H, W)."""
    changed = np.count_nonzero(np.isfinite(depth) & (depth != frame.depth))
    if used == 1:
        return f"Depth is as measured: of {counted(neighbours, 'frame')} around it, none shows the same view."
    return (
        f"Depth is the median of up to {used} frames where nothing has changed: it differs from the measured depth at "
        f"{changed} of {depth.size} pixels ({changed / depth.size:.0%})."
    )


def _smooth(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    return np.asarray(cv2.GaussianBlur(rgb.astype(np.float32), (0, 0), _BLUR))


def _changed(here: NDArray[np.float32], there: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Pixels, bool (H, W), whose smooth colours differ by more than noise and exposure do."""
    exposure = np.median((here + 1) / (there + 1), axis=(0, 1))
    difference = np.abs(here - (there + 1) * exposure + 1).max(axis=2)
    limit = np.clip(_TIMES * 1.4826 * np.median(difference), _LEAST, _MOST)
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * _MARGIN + 1, 2 * _MARGIN + 1))
    return cv2.dilate((difference > limit).astype(np.uint8), disk).astype(bool)


def _median(depths: NDArray[np.float32]) -> NDArray[np.float32]:
    """Median of the known ones of depths, (N, H, W), along the first axis."""
    ordered = np.sort(depths, axis=0)  # NaN comes last
    known = np.count_nonzero(np.isfinite(depths), axis=0)
    low, high = (
        np.take_along_axis(ordered, place[None], axis=0)[0] for place in (np.maximum(known - 1, 0) // 2, known // 2)
    )
    return np.where(known % 2 == 1, low, (low + high) / 2).astype(np.float32)
