"""Registration: depth for each pixel of the colour camera, or colour for each pixel of the depth camera."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from ..data.camera import Camera, checked_transform
from ..data.frame import (
    BroughtColour,
    FrameInputs,
    RGBDFrame,
    checked_colour,
    checked_depth,
    checked_mask,
    read_only,
)
from ..data.lenses import max_ray_tangent, places_in_image, seen_at, undistorted_view
from ..errors import InputError
from .frame_ref import COLOUR_VIEW, DEPTH_VIEW

# A raw pair: colour and depth of two cameras, and the transform between them.

_MAX_CAMERA_DISTANCE = 1000.0
"""Maximum distance [m] between the two cameras of a pair."""


@dataclass(frozen=True, eq=False)
class RawPair:
    """Colour and depth of one moment, not registered: each image as captured by its camera. Immutable.

    Parameters
    ----------
    rgb : array_like
        Colour, uint8, shape (h, w, 3), red first.
    depth : array_like
        Depth along the depth camera's axis [m], shape (hd, wd), any real type; what is not finite and positive is
        missing and becomes NaN.
    colour_camera, depth_camera : Camera
        A camera without a size is for images of the size of its own.
    depth_to_colour : array_like
        Transform of points [m] from the depth camera to the colour camera, shape (4, 4): a rotation and a translation.
    name : str
        Name of the frame.
    inputs : FrameInputs, optional
        The files it was read from; set by the readers.
    notes : tuple of str
        Notes for the user, a sentence or two each.
    depth_view : array_like of bool, optional
        Pixels of the depth image in which its camera can measure, shape (hd, wd); None if in all of them. An Azure
        Kinect illuminates a hexagon or a circle of its image; outside, its infrared image is black.

    Raises
    ------
    InputError
        If an image or mask does not have its camera's size, or `depth_to_colour` is not a rigid transform, or its
        translation is implausibly large.

    Examples
    --------
    >>> camera = Camera(30.0, 30.0, 15.5, 11.5)
    >>> pair = RawPair(np.zeros((24, 32, 3), np.uint8), np.full((24, 32), 2.0), camera, camera, np.eye(4))
    >>> pair.depth.dtype, pair.depth_to_colour.shape
    (dtype('float32'), (4, 4))
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    colour_camera: Camera
    depth_camera: Camera
    depth_to_colour: NDArray[np.float64]
    name: str = "frame"
    inputs: FrameInputs | None = None
    notes: tuple[str, ...] = field(default=(), repr=False)
    depth_view: NDArray[np.bool_] | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "rgb", checked_colour(self.rgb))
        object.__setattr__(self, "depth", checked_depth(self.depth))
        object.__setattr__(
            self, "depth_to_colour", checked_transform(self.depth_to_colour, "The depth-to-colour transform")
        )
        apart = math.hypot(*self.depth_to_colour[:3, 3])
        if apart > _MAX_CAMERA_DISTANCE:
            raise InputError(f"The two cameras cannot be {apart:.3g} m apart. Give their distance in metres.")
        for what, image, name in (
            ("Colour", self.rgb, "colour_camera"),
            ("Depth", self.depth, "depth_camera"),
        ):
            camera, size = getattr(self, name), (image.shape[1], image.shape[0])
            if camera.size is None:
                object.__setattr__(self, name, replace(camera, size=size))
            elif camera.size != size:
                given, wanted = (f"{width} x {height}" for width, height in (size, camera.size))
                raise InputError(f"{what} is {given}, but its camera's intrinsics are for {wanted} pixels.")
        if self.depth_view is not None:
            view = checked_mask(self.depth_view, self.depth.shape, "the depth camera's view")
            object.__setattr__(self, "depth_view", view)


SAMPLES_PER_PIXEL = 1.5
"""Minimum number of depth samples per colour pixel, along a row and along a column, to keep surfaces closed."""

SAME_SURFACE_TOLERANCE = 0.02
"""How much farther a sample may be than the nearest one of a pixel to count as the same surface, relative."""

_MAX_SAMPLES_PER_PIXEL = 16
"""Maximum number of samples per depth pixel, along a row and along a column."""

_CHUNK_SAMPLES = 1 << 18
"""Samples that are transformed at a time, so that they stay in the processor's cache."""

_LENS_STEPS, _LENS_MAX_EXTENT = 200, 4.0
"""Rays along a row and along a column for finding the extent of a depth camera's view, and their maximum extent
relative to the view without distortion."""

_MAX_SAMPLES, _MAX_SIDE = 1 << 26, (1 << 15) - 2
"""Maximum number of samples of a depth image, and of pixels or samples along one side of an image; above, the camera's
intrinsics are invalid."""

_OUTLIERS = 0.01
"""Fraction of the known depth that is ignored at both ends of a frame's depth range."""

_VIEW_STEPS = 16
"""Number of depths at which the visibility of a colour pixel to the depth camera is tested."""


def register(pair: RawPair, view: str = COLOUR_VIEW) -> RGBDFrame:
    """Register a raw pair, with both lenses undistorted: its depth to the colour camera, or its colour to the depth
    camera.

    Each depth pixel is a small square of constant depth. It is split into 2 x 2 samples or more, `SAMPLES_PER_PIXEL` of
    them for each pixel of colour, which are projected to the colour camera. Of several samples in a pixel, those of
    the nearest surface count, and of these the one closest to the pixel's centre. Nothing is interpolated, neither
    within surfaces nor across their edges.

    In the depth camera's view, depth stays as it was measured, and the projected depth tells which surfaces hide others
    from the colour camera (`colour_by_depth`). What is completed there is brought to the colour camera by `aligned`.

    Parameters
    ----------
    pair : RawPair
    view : str
        "colour" or "depth": the camera whose pixels are those of the frame.

    Returns
    -------
    RGBDFrame
        In the colour camera's view it has the size of the pair's colour. Colour is undistorted and scaled up just
        enough that no pixel is empty; the intrinsics are those of the new image. Depth is along the colour camera's
        axis [m], NaN = missing. `outside_view` contains the missing pixels that the depth camera could not see: at none
        of 16 depths, evenly spaced in 1 / depth from the nearest to the farthest registered depth (without 1 % at both
        ends), does the point at the pixel's centre lie in the depth image, or in its `depth_view`. Points that a nearer
        surface occludes from the depth camera are inside its view, and so are points that it could not measure.

        In the depth camera's view it has the size of the pair's depth, which is undistorted as colour is otherwise, but
        moved, not interpolated. `outside_view` contains the pixels that are not in the `depth_view`, and `brought` says
        where colour is from.

    Raises
    ------
    InputError
        If no depth is known or none falls into the colour image, if the distortion of colour cannot be inverted, and as
        `RGBDFrame`.

    Examples
    --------
    >>> from ilf.data.camera import Camera
    >>> camera = Camera(30.0, 30.0, 15.5, 11.5)
    >>> shifted = np.eye(4)
    >>> shifted[0, 3] = 0.2
    >>> frame = register(RawPair(np.zeros((24, 32, 3), np.uint8), np.full((24, 32), 2.0), camera, camera, shifted))
    >>> int(frame.known[0].sum()), int(frame.outside_view[0].sum())
    (29, 3)
    """
    _check_size("colour", pair.colour_camera.shape[::-1])
    rgb, colour = pair.rgb, pair.colour_camera
    if colour.is_bent:
        colour, columns, rows = undistorted_view(colour)
        rgb = np.asarray(cv2.remap(rgb, columns, rows, cv2.INTER_LINEAR), np.uint8)
    if not np.isfinite(pair.depth).any():
        raise InputError("The depth image has no known pixel (all are zero, negative or not finite).")
    moved = projected_depth(pair.depth, pair.depth_camera, colour, pair.depth_to_colour)
    known = moved[np.isfinite(moved)]
    if known.size == 0:
        raise InputError("No depth falls into the colour image. Check both intrinsics, and the transform in metres.")
    if view == DEPTH_VIEW:
        return _in_depth_view(pair, rgb, colour, moved)
    nearest, farthest = np.quantile(known, (_OUTLIERS, 1 - _OUTLIERS))
    depths = 1 / np.linspace(1 / nearest, 1 / farthest, _VIEW_STEPS)
    grid = _sample_grid(pair.depth_camera, _samples(pair.depth_camera, colour))
    outside = ~_in_view(grid, pair.depth_view, colour, pair.depth_to_colour, depths)
    inputs = None if pair.inputs is None else replace(pair.inputs, view=None)
    return RGBDFrame(rgb, moved, colour, pair.name, inputs=inputs, notes=pair.notes, outside_view=outside)


def _in_depth_view(pair: RawPair, rgb: NDArray[np.uint8], colour: Camera, front: NDArray[np.float32]) -> RGBDFrame:
    """The frame in the depth camera's view; `front` is its depth as projected into the undistorted colour."""
    camera, depth, view = pair.depth_camera, pair.depth, pair.depth_view
    if camera.is_bent:
        camera, columns, rows = undistorted_view(pair.depth_camera)
        depth = projected_depth(depth, pair.depth_camera, camera, np.eye(4))
        if view is not None:
            view = cv2.remap(view.astype(np.uint8), columns, rows, cv2.INTER_NEAREST) > 0
    rgb, brought = colour_by_depth(rgb, colour, depth, camera, pair.depth_to_colour, front)
    inputs = None if pair.inputs is None else replace(pair.inputs, view=DEPTH_VIEW)
    outside = None if view is None else ~view
    return RGBDFrame(
        rgb, depth, camera.pinhole, pair.name, inputs, notes=pair.notes, outside_view=outside, brought=brought
    )


def aligned(depth: NDArray[np.float32], frame: RGBDFrame) -> NDArray[np.float32]:
    """Bring depth that was completed in the depth camera's view to the colour camera, as `register` does.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth of the frame [m], NaN = missing.
    frame : RGBDFrame
        A frame in the depth camera's view.

    Returns
    -------
    ndarray of float32, shape (h, w)
        Depth along the axis of `frame.brought.camera` [m], whose pixels it has; NaN where there is none.

    Raises
    ------
    InputError
        If the frame is not in the depth camera's view, or has no intrinsics.
    """
    brought, camera = frame.brought, frame.intrinsics
    if brought is None or camera is None:
        raise InputError("Only depth of a frame with view='depth' and intrinsics can be brought to the colour camera.")
    height, width = frame.shape
    return projected_depth(depth, replace(camera, size=(width, height)), brought.camera, brought.depth_to_colour)


def projected_depth(
    depth: NDArray[np.float32], camera: Camera, colour: Camera, motion: NDArray[np.float64]
) -> NDArray[np.float32]:
    """Project a depth image into another camera, as `register` does.

    Parameters
    ----------
    depth : ndarray of float32, shape (h, w)
        Depth along the axis of `camera` [m], NaN = missing.
    camera, colour : Camera
        The camera of the depth image, and the other one, without distortion.
    motion : ndarray of float64, shape (4, 4)
        Transform of points [m] from `camera` to `colour`.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth along the axis of `colour` [m] of the nearest surface; NaN where there is none.
    """
    matrix, columns, rows, _ = _sample_grid(camera, _samples(camera, colour))
    split = cv2.remap(depth, columns, rows, cv2.INTER_NEAREST, None, cv2.BORDER_CONSTANT, np.nan)
    samples = np.asarray(split, np.float32)
    projection = (colour.matrix @ motion[:3, :3] @ np.linalg.inv(matrix)).astype(np.float32)
    shift = (colour.matrix @ motion[:3, 3]).astype(np.float32)
    across = np.arange(samples.shape[1], dtype=np.float32)
    height, width = colour.shape
    step = max(_CHUNK_SAMPLES // samples.shape[1], 1)
    parts = [
        _projected_samples(samples[start : start + step], across, start, projection, shift, (width, height))
        for start in range(0, samples.shape[0], step)
    ]
    pixels = height * width
    front = np.full(pixels, np.inf, np.float32)
    for place, projected, _ in parts:
        np.minimum.at(front, place, projected)
    front *= 1 + SAME_SURFACE_TOLERANCE
    closest, depth = np.full(pixels, np.inf, np.float32), np.full(pixels, np.nan, np.float32)
    for place, projected, off in parts:
        off[projected > front[place]] = np.inf
        np.minimum.at(closest, place, off)
    for place, projected, off in parts:
        chosen = (off == closest[place]) & np.isfinite(off)
        depth[place[chosen]] = projected[chosen]
    return depth.reshape(height, width)


# Colour for each pixel of the depth camera.

_HIDDEN_BEHIND = 0.04
"""How much nearer a surface must be to hide what lies behind it, relative; less moves colour by hardly a pixel."""

_BLUR_FROM, _BLUR_SHARE = 1.5, 1 / 3
"""Colour that is so many times as fine as depth, or more, is averaged by a Gaussian of this share of a depth pixel."""


def colour_by_depth(
    rgb: NDArray[np.uint8],
    colour: Camera,
    depth: NDArray[np.float32],
    camera: Camera,
    depth_to_colour: NDArray[np.float64],
    front: NDArray[np.float32],
) -> tuple[NDArray[np.uint8], BroughtColour]:
    """Look up the colour of each depth pixel where its depth puts it in the colour image.

    Where depth is missing, 1 / depth is filled smoothly for the lookup alone: along a plane it is linear in the image,
    and these pixels need colour most, to be completed by it. Such depth hides nothing. What the colour camera sees
    nothing of is black: outside its image, or behind a measured surface that is nearer by more than 4 %.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (h, w, 3)
    colour, camera : Camera
        The colour and the depth camera, without distortion.
    depth : ndarray of float32, shape (H, W)
        Depth along the axis of `camera` [m], NaN = missing.
    depth_to_colour : ndarray of float64, shape (4, 4)
        Transform of points [m].
    front : ndarray of float32, shape (h, w)
        Measured depth along the axis of `colour` [m], as `projected_depth` gives it, NaN = missing.

    Returns
    -------
    ndarray of uint8, shape (H, W, 3)
        Colour, black where nothing is seen.
    BroughtColour
    """
    guessed = np.reciprocal(smoothly_filled(np.reciprocal(depth), np.isfinite(depth)))
    columns, rows, away = _places(guessed, camera, colour, depth_to_colour)
    seen = (away > 0) & colour.has(columns, rows)
    place = np.rint(rows[seen]).astype(int), np.rint(columns[seen]).astype(int)
    seen[seen] = ~(away[seen] > (1 + _HIDDEN_BEHIND) * front[place])  # NaN: nothing was measured there
    fineness = max(colour.fx / camera.fx, colour.fy / camera.fy)
    if fineness >= _BLUR_FROM:
        rgb = np.asarray(cv2.GaussianBlur(rgb, (0, 0), _BLUR_SHARE * fineness), np.uint8)
    across, down = (np.where(seen, places, 0).astype(np.float32) for places in (columns, rows))
    brought = np.asarray(cv2.remap(rgb, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.uint8)
    brought[~seen] = 0
    edge_rgb = np.rint(smoothly_filled(brought.astype(np.float32), seen)).astype(np.uint8)
    return brought, BroughtColour(read_only(seen), read_only(edge_rgb), colour, depth_to_colour)


def smoothly_filled(values: NDArray[np.float32], known: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Values, shape (H, W) or (H, W, channels), where known; elsewhere averages of those around, over ever wider areas
    the farther away they are. Without any known value they are returned as they are."""
    if known.all() or not known.any():
        return values
    height, width = known.shape
    mask = known.reshape(height, width, *(1,) * (values.ndim - 2))
    weight = cv2.pyrDown(known.astype(np.float32))
    total = cv2.pyrDown(np.where(mask, values, np.float32(0)))
    some = weight > 0
    share = np.where(some, weight, np.float32(1)).reshape(*weight.shape, *(1,) * (values.ndim - 2))
    coarse = smoothly_filled(np.asarray(total / share, np.float32), some)
    return np.where(mask, values, cv2.pyrUp(coarse, dstsize=(width, height)))


def _places(
    depth: NDArray[np.float32], camera: Camera, colour: Camera, depth_to_colour: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Column and row [px] in the colour image, and depth [m] along the colour camera's axis, of each pixel's centre."""
    height, width = depth.shape
    down, across = np.indices((height, width), np.float64)
    turn = colour.matrix @ depth_to_colour[:3, :3] @ np.linalg.inv(camera.matrix)
    shift = colour.matrix @ depth_to_colour[:3, 3]
    x, y, away = (
        depth * (row[0] * across + row[1] * down + row[2]) + along for row, along in zip(turn, shift, strict=True)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return x / away, y / away, away


# Samples of a depth image, finer than the pixels of colour.


_Grid = tuple[NDArray[np.float64], NDArray[np.float32], NDArray[np.float32], NDArray[np.uint8]]
"""The undistorted view of the depth camera, on a grid (H, W) of samples: camera matrix of the grid, column and row of
each sample in the depth image, whose nearest pixel is used, and 1 where that is inside the image, else 0."""


@lru_cache(maxsize=2)
def _sample_grid(camera: Camera, samples: int) -> _Grid:
    left, right, top, bottom = _extent(camera)
    fx, fy = samples * camera.fx, samples * camera.fy
    # the outermost samples lie half a sample inside the outer pixels' outer sides
    size = max(round((right - left) * fx), 1), max(round((bottom - top) * fy), 1)
    _check_size("depth", size)
    matrix = np.array([[fx, 0.0, -left * fx - 0.5], [0.0, fy, -top * fy - 0.5], [0.0, 0.0, 1.0]])
    columns, rows = places_in_image(camera, matrix, size)
    x, y = (np.arange(size[0]) + 0.5) / fx + left, (np.arange(size[1]) + 0.5) / fy + top
    folded = np.hypot(x[None], y[:, None]) > max_ray_tangent(camera)
    seen = camera.has(columns, rows) & ~folded
    columns[~seen] = -2.0
    return matrix, read_only(columns), read_only(rows), read_only(seen.astype(np.uint8))


def _check_size(what: str, size: tuple[int, int]) -> None:
    if max(size) > _MAX_SIDE or size[0] * size[1] > _MAX_SAMPLES:
        raise InputError(f"The {what} image would have {size[0]} x {size[1]} samples. Check intrinsics and distortion.")


def _samples(depth: Camera, colour: Camera) -> int:
    """Number of samples per depth pixel, along a row and along a column."""
    scale = max(colour.fx / depth.fx, colour.fy / depth.fy)
    return min(max(math.ceil(SAMPLES_PER_PIXEL * scale), 2), _MAX_SAMPLES_PER_PIXEL)


def _extent(camera: Camera) -> tuple[float, float, float, float]:
    """The bounding rectangle of a camera's view on the plane at depth 1: left, right, top, bottom."""
    height, width = camera.shape
    sides = (-0.5 - camera.cx) / camera.fx, (width - 0.5 - camera.cx) / camera.fx
    ends = (-0.5 - camera.cy) / camera.fy, (height - 0.5 - camera.cy) / camera.fy
    if not camera.is_bent:
        return *sides, *ends
    widest_ray = math.hypot(max(map(abs, sides)), max(map(abs, ends)))
    reach = min(max_ray_tangent(camera), _LENS_MAX_EXTENT * widest_ray)
    line = np.linspace(-reach, reach, _LENS_STEPS)
    x, y = (plane.ravel() for plane in np.meshgrid(line, line))
    columns, rows = seen_at(camera, np.stack([x, y], axis=1)).T
    inside = camera.has(columns, rows) & (np.hypot(x, y) <= reach)
    step = line[1] - line[0]
    if not inside.any():
        return *sides, *ends
    return x[inside].min() - step, x[inside].max() + step, y[inside].min() - step, y[inside].max() + step


def _projected_samples(
    samples: NDArray[np.float32],
    across: NDArray[np.float32],
    first: int,
    projection: NDArray[np.float32],
    shift: NDArray[np.float32],
    size: tuple[int, int],
) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]]:
    """Pixel index, depth [m] and squared distance to the pixel's centre [px] of those samples of some rows that fall
    into the colour image."""
    down = np.arange(first, first + len(samples), dtype=np.float32)[:, None]
    known = np.isfinite(samples)
    z = samples[known]
    x, y, projected = (
        (row[0] * across + (row[1] * down + row[2]))[known] * z + along
        for row, along in zip(projection, shift, strict=True)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        x /= projected
        y /= projected
    column, line = np.rint(x), np.rint(y)
    hits = (projected > 0) & (column >= 0) & (column < size[0]) & (line >= 0) & (line < size[1])
    column, line = column[hits], line[hits]
    off = np.square(x[hits] - column) + np.square(y[hits] - line)
    return line.astype(np.int32) * np.int32(size[0]) + column.astype(np.int32), projected[hits], off


def _in_view(
    grid: _Grid,
    depth_view: NDArray[np.bool_] | None,
    colour: Camera,
    motion: NDArray[np.float64],
    depths: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Pixels of the colour camera that lie in the depth camera's view at one of these depths [m] along the colour
    camera's axis."""
    matrix, columns, rows, seen = grid
    if depth_view is not None:
        seen = np.asarray(cv2.remap(depth_view.astype(np.uint8), columns, rows, cv2.INTER_NEAREST), np.uint8)
    back = np.linalg.inv(motion)
    found = np.zeros(colour.shape, np.uint8)
    for depth in depths:
        plane = back[:3, :3] + back[:3, 3:] @ np.array([[0.0, 0.0, 1 / depth]])
        to_fine = matrix @ plane @ np.linalg.inv(colour.matrix)
        flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
        found |= np.asarray(cv2.warpPerspective(seen, to_fine, colour.shape[::-1], flags=flags), np.uint8)
    return found.astype(bool)
