"""Depth of a static camera: the temporal median of neighbouring frames where colour is unchanged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import counted, grouped
from .._runtime.writing import ensure_folder, write_bytes
from ..data.frame import RGBDFrame
from ..data.neighbours import median_of_known
from ..io.depth import write_depth
from ..sources.reading import load_frame
from .frame_record import LoadedFrame

DEPTH_FILE, COLOUR_FILE, TRUTH_FILE = "steady/depth.npy", "steady/rgb.png", "steady/gt.npy"
"""Files in a frame's folder that it is completed from; the colour only if the frame has no colour file, the ground
truth only if it was undistorted."""

_BLUR_SIGMA = 2.0
"""Standard deviation [px] of the Gaussian blur of colours before they are compared; it removes noise."""

_MIN_DIFFERENCE, _NOISE_FACTOR, _MAX_DIFFERENCE = 2.5, 6.0, 8.0
"""Threshold of changed colours: at least `_MIN_DIFFERENCE` grey levels, `_NOISE_FACTOR` deviations of the noise, at
most `_MAX_DIFFERENCE`."""

_MARGIN = 6
"""Pixels around a change that count as changed: depth is less sharp than colour."""

_MAX_CHANGED_SHARE = 0.4
"""Neighbours with a larger changed share show another view and are left out."""


def files_of(frame: RGBDFrame) -> tuple[str, ...]:
    """Return the files that `with_temporal_median` writes for a frame."""
    inputs = frame.inputs
    colour = () if inputs is not None and inputs.has_colour_file else (COLOUR_FILE,)
    is_undistorted = frame.ground_truth is not None and inputs is not None and inputs.lenses is not None
    return (DEPTH_FILE, *colour, *((TRUTH_FILE,) if is_undistorted else ()))


def with_temporal_median(reading: LoadedFrame, folder: Path) -> RGBDFrame:
    """Return a frame with the temporal median of its depth, written to and read from files in a folder, so that its run
    can be replayed: per pixel, the median over the frame and its neighbours with unchanged colour. Neighbours of
    another size, and those whose colour has changed nearly everywhere, are ignored.

    Raises
    ------
    ExportError
        If the files cannot be written.
    """
    frame = reading.frame
    layers = _layers(frame, reading.neighbours)
    depth = median_of_known(layers)
    ensure_folder((folder / DEPTH_FILE).parent)
    write_depth(folder / DEPTH_FILE, depth)
    if COLOUR_FILE in files_of(frame):
        _, encoded = cv2.imencode(".png", frame.edge_rgb[..., ::-1])
        write_bytes(folder / COLOUR_FILE, encoded.tobytes())
    inputs = frame.inputs
    truth = None if inputs is None else inputs.ground_truth
    truth_path, truth_units = (None, None) if truth is None else (truth.named, truth.units)
    if frame.ground_truth is not None and TRUTH_FILE in files_of(frame):
        truth_path, truth_units = str(folder / TRUTH_FILE), 1.0
        write_depth(truth_path, frame.ground_truth)
    read = load_frame(
        inputs.rgb.path if inputs is not None and inputs.has_colour_file else folder / COLOUR_FILE,
        folder / DEPTH_FILE,
        intrinsics=frame.intrinsics,
        name=frame.name,
        ground_truth=truth_path,
        ground_truth_units=truth_units,
        beside=False,
        warn=False,
    )
    note = _median_note(frame, depth, len(layers), len(reading.neighbours))
    steady = replace(read, outside_view=frame.outside_view, pose=frame.pose, notes=(*frame.notes, note))
    return steady.with_guide(frame.guide)


def _layers(frame: RGBDFrame, others: Sequence[RGBDFrame]) -> NDArray[np.float32]:
    """Stack the depth [m] of a frame and of the others that show the same view, (N, H, W); NaN where they have
    changed."""
    smooth = _smooth(frame.rgb)
    depths = [frame.depth]
    for other in others:
        if other.shape != frame.shape:
            continue
        changed = _changed(smooth, _smooth(other.rgb))
        if changed.mean() <= _MAX_CHANGED_SHARE:
            depths.append(np.where(changed, np.float32(np.nan), other.depth))
    return np.stack(depths)


def _median_note(frame: RGBDFrame, depth: NDArray[np.float32], used: int, neighbours: int) -> str:
    """Return a note on how the temporal median has changed a frame's depth [m], (H, W)."""
    changed = np.count_nonzero(np.isfinite(depth) & (depth != frame.depth))
    if used == 1:
        return f"Depth is unchanged: none of {counted(neighbours, 'neighbouring frame')} shows the same view."
    return (
        f"Depth is the median of up to {used} frames where colour is unchanged: it differs from the measured depth at "
        f"{grouped(changed)} of {counted(depth.size, 'pixel')} ({changed / depth.size:.0%})."
    )


def _smooth(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    return np.asarray(cv2.GaussianBlur(rgb.astype(np.float32), (0, 0), _BLUR_SIGMA))


def _changed(here: NDArray[np.float32], there: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return the pixels, bool (H, W), whose smoothed colours differ by more than noise and exposure."""
    exposure = np.median((here + 1) / (there + 1), axis=(0, 1))
    difference = np.abs(here - (there + 1) * exposure + 1).max(axis=2)
    limit = np.clip(_NOISE_FACTOR * 1.4826 * np.median(difference), _MIN_DIFFERENCE, _MAX_DIFFERENCE)
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * _MARGIN + 1, 2 * _MARGIN + 1))
    return cv2.dilate((difference > limit).astype(np.uint8), disk).astype(bool)
