"""Registration: what each pixel of the colour camera has for depth."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..frame import RGBDFrame
from ..masks import fixed
from .lenses import undistorted_colour, widest
from .pair import Camera, RawPair

SAMPLES_PER_PIXEL = 1.5
"""Samples of depth for each pixel of colour, along a row and along a column, at least: closed surfaces stay closed."""

SAME_SURFACE = 0.02
"""How much farther than the nearest sample that comes to a pixel another may be and count as of the same surface."""

_MOST_SAMPLES = 16
"""Of one depth pixel, along a row and along a column."""

_AT_ONCE = 1 << 18
"""Samples that are moved at a time, so that they stay in the processor's cache."""

_LENS_STEPS, _LENS_REACH = 200, 4.0
"""Rays along a row and along a column by which the extent of a depth camera's view is found, and how much farther out
than without distortion they are looked for."""

_MOST_IN_ALL, _LONGEST = 1 << 26, (1 << 15) - 2
"""Samples of a depth image, and pixels or samples along one side of an image, above which its camera's numbers are none
of a camera's."""

_OUTLIERS = 0.01
"""Share of the known depth that is left out at both ends when it is asked what depths a frame has."""

_VIEW_STEPS = 16
"""Depths at which it is asked whether the depth camera sees what a colour pixel shows."""


def register(pair: RawPair) -> RGBDFrame:
    """Bring a raw pair together in the colour camera's image, without the distortion of either lens.

    Each depth pixel is a small square of constant depth. It is split into 2 x 2 samples or more, `SAMPLES_PER_PIXEL` of
    them for each pixel of colour, which are moved to the colour camera. Where several come to one of its pixels,
    those of the nearest surface count, and of these the one that lies closest to the pixel's centre. Nothing is
    interpolated, within surfaces or across their edges.

    Parameters
    ----------
    pair : RawPair

    Returns
    -------
    RGBDFrame
        Of the size of the pair's colour. Colour is undistorted, and enlarged just so far that every pixel has a source;
        the intrinsics are those of the new image. Depth is along the colour camera's axis [m], NaN = missing.
        `outside_view` has the missing pixels that show nothing which the depth camera could have measured: at none of
        16 depths, evenly spaced in 1 / depth from the nearest to the farthest of the registered depth (but for 1 % at
        both ends), does the point that the pixel's centre shows lie in the depth image, or its `depth_view`. What a
        nearer surface hides from the depth camera lies inside its view, and so does what it could not measure.

    Raises
    ------
    InputError
        If no depth is known or none comes to lie in the colour image, if the distortion of colour cannot be undone, or
        what `RGBDFrame` raises for.

    Examples
    --------
    >>> from ilf.camera import CameraIntrinsics
    >>> camera = Camera(CameraIntrinsics(30.0, 30.0, 15.5, 11.5), (32, 24))
    >>> shifted = np.eye(4)
    >>> shifted[0, 3] = 0.2
    >>> frame = register(RawPair(np.zeros((24, 32, 3), np.uint8), np.full((24, 32), 2.0), camera, camera, shifted))
    >>> int(frame.known[0].sum()), int(frame.outside_view[0].sum())
    (29, 3)
    """
    _check_size("colour", pair.colour_camera.size)
    rgb, intrinsics = undistorted_colour(pair.rgb, pair.colour_camera)
    colour = Camera(intrinsics, pair.colour_camera.size)
    if not np.isfinite(pair.depth).any():
        raise InputError("The depth image has no known pixel (all are zero, negative or not finite).")
    fine = _fine_view(pair.depth_camera, _samples(pair.depth_camera, colour))
    moved = _moved(pair.depth, fine, colour, pair.depth_to_colour)
    known = moved[np.isfinite(moved)]
    if known.size == 0:
        raise InputError(
            "No depth comes to lie in the colour image: the two cameras' numbers do not fit each other. "
            "Check both intrinsics, and the way from the depth to the colour camera, which is in metres."
        )
    nearest, farthest = np.quantile(known, (_OUTLIERS, 1 - _OUTLIERS))
    depths = 1 / np.linspace(1 / nearest, 1 / farthest, _VIEW_STEPS)
    outside = ~_in_view(fine, pair.depth_view, colour, pair.depth_to_colour, depths)
    return RGBDFrame(rgb, moved, intrinsics, pair.name, inputs=pair.inputs, notes=pair.notes, outside_view=outside)


class _FineView:
    """The depth camera's view without distortion, on a grid of samples.

    Attributes
    ----------
    matrix : ndarray of float64, shape (3, 3)
        Camera matrix of the grid.
    columns, rows : ndarray of float32, shape (H, W)
        Where in the depth image a sample has its depth from; its nearest pixel counts.
    seen : ndarray of uint8, shape (H, W)
        1 where that is in the depth image, else 0.
    """

    def __init__(self, camera: Camera, samples: int) -> None:
        left, right, top, bottom = _extent(camera)
        fx, fy = samples * camera.intrinsics.fx, samples * camera.intrinsics.fy
        # the outermost samples lie half a sample inside the outer pixels' outer sides
        size = max(round((right - left) * fx), 1), max(round((bottom - top) * fy), 1)
        _check_size("depth", size)
        self.matrix = np.array([[fx, 0.0, -left * fx - 0.5], [0.0, fy, -top * fy - 0.5], [0.0, 0.0, 1.0]])
        columns, rows = cv2.initUndistortRectifyMap(
            camera.matrix, camera.coefficients, None, self.matrix, size, cv2.CV_32FC1
        )
        x, y = (np.arange(size[0]) + 0.5) / fx + left, (np.arange(size[1]) + 0.5) / fy + top
        folded = np.hypot(x[None], y[:, None]) > widest(camera.distortion)
        width, height = camera.size
        seen = (columns >= -0.5) & (columns < width - 0.5) & (rows >= -0.5) & (rows < height - 0.5) & ~folded
        columns[~seen] = -2.0
        self.columns, self.rows, self.seen = fixed(columns), fixed(rows), fixed(seen.astype(np.uint8))


@lru_cache(maxsize=2)
def _fine_view(camera: Camera, samples: int) -> _FineView:
    return _FineView(camera, samples)


def _check_size(what: str, size: tuple[int, int]) -> None:
    if max(size) > _LONGEST or size[0] * size[1] > _MOST_IN_ALL:
        raise InputError(
            f"The {what} image would have {size[0]} x {size[1]} samples without its lens's distortion. Check the "
            "intrinsics and the distortion of both cameras, which are in pixels."
        )


def _samples(depth: Camera, colour: Camera) -> int:
    """Into how many samples a depth pixel is split, along a row and along a column."""
    scale = max(colour.intrinsics.fx / depth.intrinsics.fx, colour.intrinsics.fy / depth.intrinsics.fy)
    return min(max(math.ceil(SAMPLES_PER_PIXEL * scale), 2), _MOST_SAMPLES)


def _extent(camera: Camera) -> tuple[float, float, float, float]:
    """The rectangle on the plane at depth 1 in which all lies that a camera sees: left, right, top, bottom."""
    own, (width, height) = camera.intrinsics, camera.size
    sides = (-0.5 - own.cx) / own.fx, (width - 0.5 - own.cx) / own.fx
    ends = (-0.5 - own.cy) / own.fy, (height - 0.5 - own.cy) / own.fy
    if camera.coefficients is None:
        return *sides, *ends
    widest_ray = math.hypot(max(map(abs, sides)), max(map(abs, ends)))
    reach = min(widest(camera.distortion), _LENS_REACH * widest_ray)
    line = np.linspace(-reach, reach, _LENS_STEPS)
    x, y = (plane.ravel() for plane in np.meshgrid(line, line))
    points = np.stack([x, y, np.ones_like(x)], axis=1)
    seen, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, camera.coefficients)
    columns, rows = seen[:, 0].T
    inside = (columns >= -0.5) & (columns < width - 0.5) & (rows >= -0.5) & (rows < height - 0.5)
    inside &= np.hypot(x, y) <= reach
    step = line[1] - line[0]
    if not inside.any():
        return *sides, *ends
    return x[inside].min() - step, x[inside].max() + step, y[inside].min() - step, y[inside].max() + step


def _moved(
    depth: NDArray[np.float32], fine: _FineView, colour: Camera, motion: NDArray[np.float64]
) -> NDArray[np.float32]:
    """The depth [m] of the nearest surface that comes to each pixel of the colour camera, NaN where none does."""
    split = cv2.remap(depth, fine.columns, fine.rows, cv2.INTER_NEAREST, None, cv2.BORDER_CONSTANT, np.nan)
    samples = np.asarray(split, np.float32)
    turned = (colour.matrix @ motion[:3, :3] @ np.linalg.inv(fine.matrix)).astype(np.float32)
    shift = (colour.matrix @ motion[:3, 3]).astype(np.float32)
    across = np.arange(samples.shape[1], dtype=np.float32)
    step = max(_AT_ONCE // samples.shape[1], 1)
    parts = [
        _hits(samples[start : start + step], across, start, turned, shift, colour.size)
        for start in range(0, samples.shape[0], step)
    ]
    pixels = colour.size[0] * colour.size[1]
    front = np.full(pixels, np.inf, np.float32)
    for place, away, _ in parts:
        np.minimum.at(front, place, away)
    front *= 1 + SAME_SURFACE
    closest, depth = np.full(pixels, np.inf, np.float32), np.full(pixels, np.nan, np.float32)
    for place, away, off in parts:
        off[away > front[place]] = np.inf
        np.minimum.at(closest, place, off)
    for place, away, off in parts:
        chosen = (off == closest[place]) & np.isfinite(off)
        depth[place[chosen]] = away[chosen]
    return depth.reshape(colour.shape)


def _hits(
    samples: NDArray[np.float32],
    across: NDArray[np.float32],
    first: int,
    turned: NDArray[np.float32],
    shift: NDArray[np.float32],
    size: tuple[int, int],
) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float32]]:
    """Of the samples in some rows that come to lie in the colour image: the pixel, the depth [m], and the square of the
    distance to the pixel's centre [px]."""
    down = np.arange(first, first + len(samples), dtype=np.float32)[:, None]
    known = np.isfinite(samples)
    z = samples[known]
    x, y, away = (
        (row[0] * across + (row[1] * down + row[2]))[known] * z + along
        for row, along in zip(turned, shift, strict=True)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        x /= away
        y /= away
    column, line = np.rint(x), np.rint(y)
    hits = (away > 0) & (column >= 0) & (column < size[0]) & (line >= 0) & (line < size[1])
    column, line = column[hits], line[hits]
    off = np.square(x[hits] - column) + np.square(y[hits] - line)
    return line.astype(np.int32) * np.int32(size[0]) + column.astype(np.int32), away[hits], off


def _in_view(
    fine: _FineView,
    depth_view: NDArray[np.bool_] | None,
    colour: Camera,
    motion: NDArray[np.float64],
    depths: NDArray[np.float64],
) -> NDArray[np.bool_]:
    """Pixels of the colour camera that show the depth camera's view at one of these depths [m], which are its own."""
    seen = fine.seen
    if depth_view is not None:
        seen = cv2.remap(depth_view.astype(np.uint8), fine.columns, fine.rows, cv2.INTER_NEAREST)
    back = np.linalg.inv(motion)
    found = np.zeros(colour.shape, np.uint8)
    for depth in depths:
        plane = back[:3, :3] + back[:3, 3:] @ np.array([[0.0, 0.0, 1 / depth]])
        to_fine = fine.matrix @ plane @ np.linalg.inv(colour.matrix)
        flags = cv2.INTER_NEAREST | cv2.WARP_INVERSE_MAP
        found |= cv2.warpPerspective(seen, to_fine, colour.size, flags=flags)
    return found.astype(bool)
