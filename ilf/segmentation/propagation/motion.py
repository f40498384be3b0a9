"""Motion of pixels between two frames: by a known pose and by optical flow; and pixels that do not move."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.long_work import check_cancelled
from ...data.blocks import nearest_of_block
from ...data.frame import RGBDFrame
from ...data.pixel_grids import connected_regions, nearest_values

Pose = NDArray[np.float64]
Labels = NDArray[np.int32]

Mask = NDArray[np.bool_]
Field = NDArray[np.float32]

_CRACK = 0.5
"""A pixel without a source gets that of a neighbour if more than this fraction of its 3 x 3 neighbourhood has sources:
stretched surfaces get thin cracks, while disoccluded areas are open to one side."""

_JUMP, _JUMP_SHARE = 0.05, 0.04
"""Maximum difference of depth from the propagated depth: the larger of a distance [m] and a fraction of the depth."""

_AROUND, _ENOUGH = 31, 0.05
"""Side [px] of the squares over which the change of depth is averaged, and their minimum fraction of valid pixels."""

_NEARBY, _NEARBY_SHARE = 0.2, 0.1
"""Pixels are valid for it if their change differs from the median by less than this [m], or this fraction of depth."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Position of every pixel of the frame before in the frame after.

    Attributes
    ----------
    columns, rows : ndarray of float32, shape (H, W)
        Position [px]; NaN if not known.
    depth : ndarray of float32, shape (H, W)
        Depth at that position [m]; NaN if not known.
    sure : ndarray of bool, shape (H, W)
        Where the motion is reliable.
    """

    columns: Field
    rows: Field
    depth: Field
    sure: Mask


@dataclass(frozen=True, eq=False)
class Sources:
    """For every pixel of the frame after, the pixel before that shows the same point, and its reliability.

    Attributes
    ----------
    pixel : ndarray of intp, shape (H, W)
        Index of the pixel in the frame before; that of a nearby source where `seen` is False.
    seen : ndarray of bool, shape (H, W)
        False where the point is not visible in the frame before: outside it, or occluded.
    sure : ndarray of bool, shape (H, W)
        Subset of `seen`: reliable pixels.
    still : ndarray of bool, shape (H, W)
        Subset of `sure`: unchanged pixels, whose blocks are copied.
    """

    pixel: NDArray[np.intp]
    seen: Mask
    sure: Mask
    still: Mask


def sources_of(motion: Motion, after: RGBDFrame, still: Mask) -> Sources:
    """The source of every pixel: the one nearest in depth that moved there, unless it contradicts the depth there.

    Parameters
    ----------
    motion : Motion
    after : RGBDFrame
    still : ndarray of bool, shape (H, W)
        Pixels whose source is their own position, regardless of the motion.
    """
    height, width = after.shape
    columns, rows = motion.columns, motion.rows
    with np.errstate(invalid="ignore"):
        inside = (columns > -0.5) & (columns < width - 0.5) & (rows > -0.5) & (rows < height - 0.5)
    moved = np.flatnonzero(inside)
    # of several that move to a pixel, the last one stays: the nearest; known depth comes before unknown
    moved = moved[np.argsort(-np.nan_to_num(motion.depth.ravel()[moved], nan=np.inf), kind="stable")]
    target = np.rint(rows.ravel()[moved]).astype(np.intp) * width
    target += np.rint(columns.ravel()[moved]).astype(np.intp)
    pixel = np.full((height, width), -1, np.intp)
    pixel.flat[target] = moved
    seen = pixel >= 0
    if seen.any() and not seen.all():
        around = cv2.blur(seen.astype(np.float32), (3, 3), borderType=cv2.BORDER_CONSTANT)
        pixel = nearest_values(pixel, seen)[1]
        seen = seen | (around > _CRACK)
    pixel = np.maximum(pixel, 0)
    seen &= ~_other_surface(motion.depth.ravel()[pixel], np.where(seen, after.depth, np.float32(np.nan)))
    sure = seen & motion.sure.ravel()[pixel]
    own = np.arange(height * width).reshape(height, width)
    return Sources(np.where(still, own, pixel), seen | still, sure | still, still)


def _other_surface(expected: Field, depth: Field) -> Mask:
    """Where the depth contradicts the propagated depth, so that another surface is visible."""
    off = depth - expected
    known = np.isfinite(off)
    if not known.any():
        return known
    # the change of depth by the camera's motion is similar for neighbours
    usual = np.float32(np.median(off[known]))
    near = known & (np.abs(off - usual) <= np.maximum(_NEARBY, _NEARBY_SHARE * np.nan_to_num(depth)))
    weight = cv2.blur(near.astype(np.float32), (_AROUND, _AROUND))
    local = cv2.blur(np.where(near, off, np.float32(0)), (_AROUND, _AROUND)) / np.maximum(weight, np.float32(1e-6))
    with np.errstate(invalid="ignore"):
        off = np.abs(off - np.where(weight > _ENOUGH, local, usual))
        found = off > np.maximum(_JUMP, _JUMP_SHARE * np.fmin(expected, depth))
    return cv2.morphologyEx(found.astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0


_MIN_MOTION = 8.0
"""Smaller motions [px] cannot be distinguished from errors of the flow."""

_MIN_CELLS = 16
"""Minimum number of cells, out of 64: the flow along a single edge is ambiguous."""


def motion_by_pose(before: RGBDFrame, after: RGBDFrame, pose: Pose, depth: Field, flow: Motion) -> Motion:
    """Motion of points with depth by the camera pose; pixels without depth follow the flow.

    Parameters
    ----------
    before, after : RGBDFrame
        Both with intrinsics.
    pose : ndarray of float64, shape (4, 4)
        Transform of points [m] from the camera before to the camera after.
    depth : ndarray of float32, shape (H, W)
        Depth of the parts before [m], NaN if not known.
    flow : Motion
        Motion of pixels without depth.
    """
    assert before.intrinsics is not None
    assert after.intrinsics is not None
    rows, columns = np.indices(before.shape)
    points = before.intrinsics.points(columns, rows, depth) @ pose[:3, :3].T + pose[:3, 3]
    camera = after.intrinsics
    with np.errstate(invalid="ignore", divide="ignore"):
        z = np.where(points[..., 2] > 1e-3, points[..., 2], np.nan)
        x = camera.fx * points[..., 0] / z + camera.cx
        y = camera.fy * points[..., 1] / z + camera.cy
    known = np.isfinite(depth)
    return Motion(
        np.where(known, x, flow.columns).astype(np.float32),
        np.where(known, y, flow.rows).astype(np.float32),
        z.astype(np.float32),
        np.where(known, np.isfinite(z), flow.sure),
    )


def difference_from_flow(motion: Motion, flow: Field, told: Mask) -> float:
    """Difference of the motion by a pose from the flow, as a fraction of the flow's length: median over image cells.

    Parameters
    ----------
    motion : Motion
    flow : ndarray of float32, shape (H, W, 2)
        Offsets x, y [px].
    told : ndarray of bool, shape (H, W)
        Where the flow is reliable. If that is in too few cells, the result is 0.
    """
    rows, columns = np.indices(told.shape)
    off = np.hypot(motion.columns - columns - flow[..., 0], motion.rows - rows - flow[..., 1])
    share = off / np.maximum(np.hypot(flow[..., 0], flow[..., 1]), _MIN_MOTION)
    shares = [float(np.median(cell)) for cell in in_cells(share, told & ~np.isnan(off))]
    return float(np.median(shares)) if len(shares) >= _MIN_CELLS else 0.0


@dataclass(frozen=True, eq=False)
class BlockParts:
    """Connected parts of a label map's blocks, and of the pixels without block.

    Attributes
    ----------
    map : ndarray of int32, shape (H, W)
        Parts 1, 2, ...
    label : ndarray of int32, shape (N + 1,)
        Part -> its block; 0 for no block, and for index 0, which is unused.
    reach : ndarray of float32, shape (H, W)
        Distance [px] to the nearest pixel of another part.
    """

    map: Labels
    label: NDArray[np.int32]
    reach: Field


def parts_of(labels: Labels) -> BlockParts:
    """The parts of a label map, int32 (H, W)."""
    parts = connected_regions(labels, background=-1)
    label_of = np.zeros(int(parts.max()) + 1, np.int32)
    label_of[parts] = labels
    return BlockParts(parts, label_of, reach_of(parts))


def reach_of(parts: Labels) -> Field:
    """Distance [px] of every pixel to the nearest pixel of another part."""
    number = parts.astype(np.float32)
    square = np.ones((3, 3), np.uint8)
    inner = cv2.erode(number, square) == cv2.dilate(number, square)
    return np.asarray(cv2.distanceTransform(inner.astype(np.uint8), cv2.DIST_L2, 5), np.float32) + 1


def ridge(reach: Field) -> Mask:
    """Pixels on the medial axis of parts, including thin ones."""
    return (reach >= cv2.dilate(reach, np.ones((3, 3), np.uint8))) & (reach > 1)


# Motion by optical flow.

_SIDE = 24
"""Minimum height and width [px] of images for flow, which needs room for its patches."""

_MAX_ROUND_TRIP_ERROR, _BACK_SHARE = 1.0, 0.05
"""Maximum forward-backward error of the flow [px], plus a fraction of the motion."""

_FAR = 0.5
"""Minimum fraction of the image with consistent flow; below it, a large motion is assumed."""

_INSIDE = 4.0
"""Distance [px] inside a part from which the flow's patches contain only that part."""

_BESIDE = 2.0
"""Distance [px] from the border of a part up to which depth may belong to another part."""


def motion_by_flow(flow: Field, agrees: Mask, parts: BlockParts, depth: Field) -> Motion:
    """Motion along the flow. The rims of parts get the motion of their inside, where the flow is consistent.

    Parameters
    ----------
    flow : ndarray of float32, shape (H, W, 2)
        From the frame before to the one after.
    agrees : ndarray of bool, shape (H, W)
        Where the flow is consistent.
    parts : BlockParts
        Parts of the frame before.
    depth : ndarray of float32, shape (H, W)
        Depth of the parts [m]: of two that move to the same position, the nearer one is visible.
    """
    source = _nearest_inside(parts, agrees, _INSIDE)
    rows, columns = np.indices(depth.shape, dtype=np.float32)
    own = np.arange(source.size).reshape(source.shape)
    inner = flow.reshape(-1, 2)[np.where(source < 0, own, source)]
    return Motion(columns + inner[..., 0], rows + inner[..., 1], depth, source >= 0)


def consistent_flow(before: RGBDFrame, after: RGBDFrame) -> tuple[Field, Mask]:
    """Optical flow from the frame before to the one after, and where it is consistent with the backward flow.

    Returns
    -------
    ndarray of float32, shape (H, W, 2)
        Offsets x, y [px].
    ndarray of bool, shape (H, W)
    """
    start, end = (cv2.cvtColor(frame.edge_rgb, cv2.COLOR_RGB2GRAY) for frame in (before, after))
    return flow_between(start, end)


def flow_between(start: NDArray[Any], end: NDArray[Any]) -> tuple[Field, Mask]:
    """Optical flow from one brightness image, uint8, to another of the same size, and where it is consistent with the
    backward flow; as `consistent_flow` returns.

    If the motion is too large for that, flow is computed again, starting from the global shift by phase correlation.
    """
    height, width = start.shape
    below, right = (max(0, _SIDE - side) for side in start.shape)
    start, end = (cv2.copyMakeBorder(grey, 0, below, 0, right, cv2.BORDER_REPLICATE) for grey in (start, end))
    found = _forward_backward_flow(start, end, (0.0, 0.0))
    if np.count_nonzero(found[1]) < _FAR * found[1].size:
        window = cv2.createHanningWindow(start.shape[::-1], cv2.CV_32F)
        shift, _ = cv2.phaseCorrelate(start.astype(np.float32), end.astype(np.float32), window)
        again = _forward_backward_flow(start, end, (float(shift[0]), float(shift[1])))
        if np.count_nonzero(again[1]) > np.count_nonzero(found[1]):
            found = again
    return found[0][:height, :width], found[1][:height, :width]


def _forward_backward_flow(start: NDArray[Any], end: NDArray[Any], shift: tuple[float, float]) -> tuple[Field, Mask]:
    """Flow from one image to another, starting from a global shift [px], and where the backward flow is consistent."""
    search = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    guess = np.empty((*start.shape, 2), np.float32)
    guess[:] = shift
    there = np.asarray(search.calc(start, end, guess.copy()), np.float32)
    check_cancelled()
    back = np.asarray(search.calc(end, start, -guess), np.float32)
    check_cancelled()
    rows, columns = np.indices(start.shape, dtype=np.float32)
    returned = cv2.remap(
        back, columns + there[..., 0], rows + there[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    off = np.hypot(there[..., 0] + returned[..., 0], there[..., 1] + returned[..., 1])
    return there, np.asarray(off <= _MAX_ROUND_TRIP_ERROR + _BACK_SHARE * np.hypot(there[..., 0], there[..., 1]), bool)


def depth_of_parts(frame: RGBDFrame, parts: BlockParts) -> Field:
    """Known depth [m]; where it is missing or close to a border, that of the nearest pixel of the same part; NaN in
    parts without known depth."""
    source = _nearest_inside(parts, frame.known, _BESIDE)
    return np.where(source < 0, np.float32(np.nan), frame.depth.ravel()[source])


def _nearest_inside(parts: BlockParts, good: Mask, beside: float) -> NDArray[np.intp]:
    """For every pixel, the index of the nearest good one of its part that is farther from the part's border; in thin
    parts, of any good one; -1 in parts without."""
    source = nearest_of_block(parts.map, good & (parts.reach > beside))
    return np.where(source < 0, nearest_of_block(parts.map, good & (source < 0)), source)


# Pixels that do not move.

_BLUR = 1.2
"""Blur [px] before colours are compared, which removes most of a sensor's noise."""

_NOISES = 5.0
"""Changes above this number of standard deviations are not noise."""

_LEAST_COLOUR = 4.0
"""Smallest change of brightness [of 255] that counts."""

_LEAST_DEPTH, _DEPTH_SHARE = 0.05, 0.03
"""Smallest change of depth that counts: the larger of a distance [m] and a fraction of the depth."""

_STILL_AROUND = 9
"""Side [px] of the squares around changed pixels that are not static either."""

_DETAIL = 8.0
"""Minimum gradient of brightness [per px] at which a motion is visible."""

_CELLS, _LEAST_DETAIL = 8, 40
"""Number of cells along each side of the image, and minimum number of pixels with detail for a cell to count."""

_MOTION, _SHARE = 0.06, 0.6
"""A cell is static if its median motion is less than this [px]; the camera is static if this fraction of the cells is.
"""

MAX_STATIC_CHANGE = 0.001
"""Maximum fraction of changed pixels for a static scene before a static camera."""


def changed(before: RGBDFrame, after: RGBDFrame) -> Mask:
    """Pixels whose colour or depth has changed, bool (H, W)."""
    off = np.abs(brightness(after) - brightness(before))
    # a drift of exposure is not motion
    off = np.abs(off - np.median(off)) if np.median(off) > 1 else off
    noise = 1.4826 * float(np.median(off))
    colour = off > max(_LEAST_COLOUR, _NOISES * noise)
    both = before.known & after.known
    with np.errstate(invalid="ignore"):
        least = np.maximum(_LEAST_DEPTH, _DEPTH_SHARE * np.minimum(before.depth, after.depth))
        depth = both & (np.abs(before.depth - after.depth) > least)
    # single pixels are noise, and depth flickers along edges
    return _opened(colour, 3) | _opened(depth, 5)


def _opened(mask: Mask, side: int) -> Mask:
    return cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, np.ones((side, side), np.uint8)) > 0


def around(mask: Mask) -> Mask:
    """A dilated mask."""
    return cv2.dilate(mask.astype(np.uint8), np.ones((_STILL_AROUND, _STILL_AROUND), np.uint8)) > 0


def camera_is_static(before: RGBDFrame, flow: Field) -> bool:
    """Whether most of the image's detail is static, by the flow to the frame after, float32 (H, W, 2)."""
    motions = [float(np.hypot(*np.median(there, axis=0))) for there in in_cells(flow, detailed(before))]
    # without any detail, there is no evidence of motion
    return not motions or float(np.quantile(motions, _SHARE)) < _MOTION


def in_cells(values: Field, mask: Mask) -> Iterator[Field]:
    """Values at the pixels of a mask, cell by cell of the image, for cells with enough of them."""
    for rows, parts in zip(np.array_split(mask, _CELLS), np.array_split(values, _CELLS), strict=True):
        cells = zip(np.array_split(rows, _CELLS, axis=1), np.array_split(parts, _CELLS, axis=1), strict=True)
        yield from (part[here] for here, part in cells if np.count_nonzero(here) >= _LEAST_DETAIL)


def detailed(frame: RGBDFrame) -> Mask:
    """Pixels with enough detail to show a motion, bool (H, W)."""
    grey = brightness(frame)
    return np.hypot(cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1)) / 8 > _DETAIL


def brightness(frame: RGBDFrame) -> NDArray[np.float32]:
    """Brightness 0-255, blurred, float32 (H, W)."""
    grey = cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(grey, (0, 0), _BLUR), np.float32)
