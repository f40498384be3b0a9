"""Neighbours: frames of the same scene whose measured depth is used where a frame has none.

A neighbour's depth is projected into the frame by the motion of the camera. It is left out beside depth jumps, where
the frame's colour shows something else, and as a whole where it does not agree with the frame's known depth.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace
from typing import Any, TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import counted
from .._runtime.long_work import check_cancelled, run_to_end
from ..data.camera import Camera
from ..data.frame import RGBDFrame, checked_frame
from ..data.neighbours import Neighbour, NeighbourDepth, agrees, beside_jumps
from ..data.open3d_images import load_open3d
from ..errors import IlfError, InputError, ParameterError
from .frame_ref import FrameRef
from .reading import read_frame
from .registration import projected_depth
from .trajectories import motion_between

Array = NDArray[np.float32]
Matrix = NDArray[np.float64]
T = TypeVar("T")

_SMOOTHING = 1.0
"""Standard deviation [px] of the Gaussian blur of colours before they are compared."""

_REACH, _MAX_DIFFERENCE = 2, 25.0
"""Colours up to this distance [px] along each axis, and the maximum difference [levels of 255] from all of them, after
the exposure is made the same: motions are not exact, and colour is not always registered."""

_MAX_DIFFERENCE_AT_PIXEL = 40.0
"""The same at the pixel itself: beside the outline of something that no frame measures, both colours occur."""

_MIN_AGREEING = 0.6
"""Minimum share of the pixels with depth in a frame and in a neighbour's view of it that agree."""

_MIN_OVERLAP = 0.05
"""Minimum share of a frame's pixels with depth in both."""

_MAX_DEPTH_DIFFERENCE = 0.07
"""Difference of depth [m] up to which the odometry matches pixels."""


def with_neighbours(
    frame: RGBDFrame,
    before: Sequence[RGBDFrame | FrameRef] | RGBDFrame = (),
    after: Sequence[RGBDFrame | FrameRef] | RGBDFrame = (),
    *,
    step: int = 1,
) -> RGBDFrame:
    """Add the depth that other frames of the same scene have measured, where a frame has none.

    The motion of the camera is known by the poses of the frames. Without them it is found by Open3D's RGB-D odometry
    from each frame to the next. Neighbours whose depth does not agree with the frame's, or that cannot be read, are
    left out.

    Parameters
    ----------
    frame : RGBDFrame
        With intrinsics.
    before, after : sequence of RGBDFrame or FrameRef
        Frames before it and after it, the nearest first, with intrinsics. Those that are not needed are not read.
    step : int
        Use the depth of every `step`-th of them; without poses, the others link the motion.

    Returns
    -------
    RGBDFrame
        Its `depth` includes that of the neighbours, in the pixels `from_neighbours`; its `measured` does not. A note
        reports the neighbours.

    Raises
    ------
    ParameterError
        If the step is not positive.
    InputError
        If the frame's intrinsics are not known.
    ExportError
        If poses are not known and Open3D is not installed (extra `app`).

    Examples
    --------
    >>> from ilf.data.camera import Camera
    >>> camera = Camera(30.0, 30.0, 15.5, 11.5)
    >>> whole = RGBDFrame(np.full((24, 32, 3), 99, np.uint8), np.full((24, 32), 2.0), camera, pose=np.eye(4))
    >>> depth = np.full((24, 32), 2.0)
    >>> depth[4:9, 10:20] = 0
    >>> frame = with_neighbours(RGBDFrame(whole.rgb, depth, camera, pose=np.eye(4)), [whole])
    >>> int(frame.from_neighbours.sum()), int(frame.missing.sum()), frame.notes
    (50, 50, ('Depth of 1 neighbour is used at 50 pixels (100% of the missing ones).',))
    """
    return run_to_end(neighbour_steps(frame, before, after, step=step))


def neighbour_steps(
    frame: RGBDFrame,
    before: Sequence[RGBDFrame | FrameRef] | RGBDFrame = (),
    after: Sequence[RGBDFrame | FrameRef] | RGBDFrame = (),
    *,
    step: int = 1,
) -> Generator[float, None, RGBDFrame]:
    """`with_neighbours` step by step, for progress and cancellation: yields the share done, 0-1, after each neighbour
    and returns the frame."""
    if step < 1:
        raise ParameterError(f"The step of neighbours must be at least 1, not {step}.")
    before, after = ([side] if isinstance(side, RGBDFrame | FrameRef) else side for side in (before, after))
    _camera_of(checked_frame(frame))
    count = len(before) // step + len(after) // step
    layers: list[Array] = []
    used: list[Neighbour] = []
    refused: list[str] = []
    for side in (before, after):
        for given, other, motion in _moved(frame, side, step):
            layer = None if other is None or motion is None else seen_by(frame, other, motion)
            if layer is None or other is None or motion is None or not _agrees(layer, frame.own_depth):
                refused.append(given.name)
            else:
                layers.append(layer)
                used.append(_neighbour(given, other, motion))
            yield (len(used) + len(refused)) / count
    added = frame.with_neighbours(NeighbourDepth(np.stack(layers), tuple(used)) if layers else None)
    return added.changed(notes=(*added.notes, _note(added, len(used), refused)))


def around(items: Sequence[T], place: int, reach: int) -> tuple[tuple[T, ...], tuple[T, ...]]:
    """Return up to `reach` items before a place and as many after it, the nearest first.

    Examples
    --------
    >>> around("abcdef", 2, 3)
    (('b', 'a'), ('d', 'e', 'f'))
    """
    return (*reversed(items[max(place - reach, 0) : place]),), (*items[place + 1 : place + 1 + reach],)


def seen_by(frame: RGBDFrame, other: RGBDFrame, motion: Matrix) -> Array:
    """Project the depth of another frame into a frame.

    Parameters
    ----------
    frame, other : RGBDFrame
        With intrinsics.
    motion : ndarray of float64, shape (4, 4)
        Transform of points [m] from the other frame's camera to the frame's.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth [m] in the frame's view; of several surfaces the nearest. NaN where the other frame has measured none,
        beside its depth jumps, and where the colours differ.

    Raises
    ------
    InputError
        If intrinsics are not known.
    """
    camera, there = _camera_of(frame), _camera_of(other)
    measured = np.where(beside_jumps(other.own_depth), np.float32(np.nan), other.own_depth)
    depth = projected_depth(measured, there, camera, motion)
    rows, columns = np.nonzero(np.isfinite(depth))
    back = np.linalg.inv(motion)
    points = camera.points(columns, rows, depth[rows, columns]) @ back[:3, :3].T + back[:3, 3]
    x, y = np.zeros((2, *frame.shape), np.float32)
    x[rows, columns] = there.fx * points[:, 0] / points[:, 2] + there.cx
    y[rows, columns] = there.fy * points[:, 1] / points[:, 2] + there.cy
    colour = cv2.remap(_smooth(other.rgb), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    depth[_other_colour(_smooth(frame.rgb), np.asarray(colour, np.float32), np.isfinite(depth))] = np.nan
    return depth


def _moved(
    frame: RGBDFrame, side: Sequence[RGBDFrame | FrameRef], step: int
) -> Iterator[tuple[RGBDFrame | FrameRef, RGBDFrame | None, Matrix | None]]:
    """Every `step`-th frame of a side, as given and as read, and its motion; None for a frame that cannot be read, and
    for a motion that is not known."""
    posed = frame.pose is not None
    previous = frame
    motion: Matrix | None = np.eye(4)
    for number, given in enumerate(side, 1):
        wanted = number % step == 0
        if posed and not wanted:
            continue
        check_cancelled()
        other = read_or_none(given)
        if posed or other is None:
            motion = None if other is None else motion_between(other, frame)
        elif motion is not None:
            link = odometry(other, previous)
            previous, motion = other, None if link is None else motion @ link
        if wanted:
            yield given, other, motion


def odometry(other: RGBDFrame, frame: RGBDFrame) -> Matrix | None:
    """Find the motion between two frames by Open3D's RGB-D odometry.

    Parameters
    ----------
    other, frame : RGBDFrame
        With intrinsics and of the same size.

    Returns
    -------
    ndarray of float64, shape (4, 4), or None
        Transform of points [m] from the other frame's camera to the frame's. None if it fails, or the projected depth
        does not agree with the frame's.

    Raises
    ------
    ExportError
        If Open3D is not installed (extra `app`).
    """
    o3d = load_open3d("Finding the motion of a camera without poses")
    if other.shape != frame.shape or other.intrinsics != frame.intrinsics:
        return None
    methods = o3d.pipelines.odometry
    limits = methods.OdometryOption(depth_diff_max=_MAX_DEPTH_DIFFERENCE, depth_min=0.0, depth_max=100.0)
    term = methods.RGBDOdometryJacobianFromHybridTerm()
    images = [_grey_image(o3d, one) for one in (other, frame)]
    found, motion, _ = methods.compute_rgbd_odometry(*images, frame.open3d_camera(), np.eye(4), term, limits)
    motion = np.asarray(motion, np.float64)
    if not found or not _agrees(seen_by(frame, other, motion), frame.own_depth):
        return None
    return motion


def _grey_image(o3d: Any, frame: RGBDFrame) -> Any:
    grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32) / 255
    depth = np.nan_to_num(frame.own_depth, nan=0.0)
    create = o3d.geometry.RGBDImage.create_from_color_and_depth
    return create(o3d.geometry.Image(grey), o3d.geometry.Image(depth), depth_scale=1.0, depth_trunc=100.0)


def read_or_none(given: RGBDFrame | FrameRef) -> RGBDFrame | None:
    """A neighbour, without its own neighbours; None if it cannot be read."""
    if isinstance(given, RGBDFrame):
        return given
    try:
        return read_frame(given)
    except IlfError:
        return None


def _neighbour(given: RGBDFrame | FrameRef, read: RGBDFrame, motion: Matrix) -> Neighbour:
    files, rows = read.inputs, tuple(map(tuple, motion.tolist()))
    if files is None:
        return Neighbour(read.name, rows)
    ref = given if isinstance(given, FrameRef) else FrameRef.of(files)
    return Neighbour(read.name, rows, (files.rgb.sha256, files.depth.sha256), ref.absolute().to_json())


def _agrees(layer: Array, depth: Array) -> bool:
    overlap = int(np.count_nonzero(np.isfinite(layer) & np.isfinite(depth)))
    agreeing = int(np.count_nonzero(agrees(layer, depth)))
    return overlap >= _MIN_OVERLAP * depth.size and agreeing >= _MIN_AGREEING * overlap


def _note(frame: RGBDFrame, used: int, refused: Sequence[str]) -> str:
    added = 0 if frame.from_neighbours is None else int(np.count_nonzero(frame.from_neighbours))
    missing = max(int(np.count_nonzero(frame.missing)), 1)
    share = f"{added / missing:.0%} of the missing ones"
    text = f"Depth of {counted(used, 'neighbour')} is used at {counted(added, 'pixel')} ({share})."
    if not refused:
        return text
    names = ", ".join(refused)
    return f"{text} Left out, because depth does not agree or the camera's motion is not known: {names}."


def _camera_of(frame: RGBDFrame) -> Camera:
    if frame.intrinsics is None:
        raise InputError(f"The camera's intrinsics of {frame.name} are not known, but neighbours need them: give them.")
    return replace(frame.intrinsics, size=(frame.shape[1], frame.shape[0]))


def _smooth(rgb: NDArray[np.uint8]) -> Array:
    return np.asarray(cv2.GaussianBlur(rgb.astype(np.float32), (0, 0), _SMOOTHING))


def _other_colour(here: Array, there: Array, known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Known pixels, bool (H, W), whose colour there differs from those at and around the pixel here."""
    if not known.any():
        return known
    exposure = np.median((here[known] + 1) / (there[known] + 1), axis=0).astype(np.float32)
    scaled = (there + 1) * exposure - 1
    square = np.ones((2 * _REACH + 1,) * 2, np.uint8)
    outside = np.maximum(cv2.erode(here, square) - scaled, scaled - cv2.dilate(here, square)).max(axis=2)
    at_pixel = np.abs(scaled - here).max(axis=2)
    return known & ((outside > _MAX_DIFFERENCE) | (at_pixel > _MAX_DIFFERENCE_AT_PIXEL))
