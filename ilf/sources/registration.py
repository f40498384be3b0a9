"""Registration: what each pixel of the colour camera has for depth."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from ..data.camera import CameraIntrinsics, checked_motion
from ..data.frame import FrameInputs, RGBDFrame, checked_colour, checked_depth, checked_mask, fixed
from ..errors import InputError

# A raw pair: colour and depth as two cameras have seen them, and how the two stand to each other.

_COEFFICIENTS = (0, 4, 5, 8)
"""How many coefficients of distortion there may be, as OpenCV counts them."""

_LARGEST_COEFFICIENT = 1e6

_FARTHEST_APART = 1000.0
"""How far apart [m] two cameras may be that see the same."""


@dataclass(frozen=True)
class Camera:
    """A camera with its distortion.

    Parameters
    ----------
    intrinsics : CameraIntrinsics
    size : tuple of int
        Width and height [px] of its images.
    distortion : tuple of float
        Coefficients in OpenCV's order: k1 k2 p1 p2, then k3, then k4 k5 k6 of the rational model; none for a camera
        without distortion.

    Raises
    ------
    InputError
        If there are other numbers of coefficients, or numbers that make no camera.

    Examples
    --------
    >>> Camera(CameraIntrinsics(525.0, 525.0, 319.5, 239.5), (640, 480)).matrix.tolist()
    [[525.0, 0.0, 319.5], [0.0, 525.0, 239.5], [0.0, 0.0, 1.0]]
    """

    intrinsics: CameraIntrinsics
    size: tuple[int, int]
    distortion: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(self.size) != 2 or min(self.size) < 1:
            raise InputError(f"A camera's size must be a width and a height in pixels, not {self.size}.")
        object.__setattr__(self, "distortion", tuple(map(float, self.distortion)))
        if len(self.distortion) not in _COEFFICIENTS:
            raise InputError(
                f"A camera's distortion must have {', '.join(map(str, _COEFFICIENTS[:-1]))} or {_COEFFICIENTS[-1]} "
                f"coefficients, k1 k2 p1 p2 k3 k4 k5 k6, not {len(self.distortion)}."
            )
        if not np.all(np.abs(self.distortion) <= _LARGEST_COEFFICIENT):
            raise InputError(f"A camera's distortion must be finite numbers, not {self.distortion}.")

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of its images in pixels."""
        return self.size[1], self.size[0]

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The camera matrix, float64 (3, 3)."""
        camera = self.intrinsics
        return np.array([[camera.fx, 0.0, camera.cx], [0.0, camera.fy, camera.cy], [0.0, 0.0, 1.0]])

    @property
    def coefficients(self) -> NDArray[np.float64] | None:
        """The distortion as OpenCV takes it; None if there is none."""
        return np.array(self.distortion) if any(self.distortion) else None


@dataclass(frozen=True, eq=False)
class RawPair:
    """Colour and depth of one moment that do not show the same pixels: each is as its camera has seen it. Immutable.

    Parameters
    ----------
    rgb : array_like
        Colour, uint8, shape (h, w, 3), red first.
    depth : array_like
        Depth along the depth camera's axis [m], shape (hd, wd), any real type; what is not finite and positive is
        missing and becomes NaN.
    colour_camera, depth_camera : Camera
    depth_to_colour : array_like
        Takes points [m] of the depth camera to the colour camera, shape (4, 4): a rotation and a shift.
    name : str
        What to call the frame.
    inputs : FrameInputs, optional
        What it was read from; filled by the readers.
    notes : tuple of str
        What the user should know of it, a sentence or two each.
    depth_view : array_like of bool, optional
        Pixels of the depth image in which its camera can measure anything, shape (hd, wd), where that are not all: an
        Azure Kinect lights a hexagon or a circle of its image, and beyond it its infrared image is black.

    Raises
    ------
    InputError
        If an image or mask is not of its camera's size, or `depth_to_colour` does not move rigid things, or moves them
        beyond all sense.

    Examples
    --------
    >>> camera = Camera(CameraIntrinsics(30.0, 30.0, 15.5, 11.5), (32, 24))
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
            self, "depth_to_colour", checked_motion(self.depth_to_colour, "The way from the depth to the colour camera")
        )
        apart = math.hypot(*self.depth_to_colour[:3, 3])
        if apart > _FARTHEST_APART:
            raise InputError(
                f"The depth and the colour camera cannot be {apart:.3g} m apart. Give their distance in metres."
            )
        for what, image, camera in (
            ("Colour", self.rgb, self.colour_camera),
            ("Depth", self.depth, self.depth_camera),
        ):
            if image.shape[:2] != camera.shape:
                raise InputError(
                    f"{what} is {image.shape[1]} x {image.shape[0]}, but its camera's numbers are for "
                    f"{camera.size[0]} x {camera.size[1]} pixels."
                )
        if self.depth_view is not None:
            view = checked_mask(self.depth_view, self.depth.shape, "the depth camera's view")
            object.__setattr__(self, "depth_view", view)


# What lenses do to images, and images as a lens without distortion would give them.

_WIDEST = 3.0
"""Tangent of the angle to the axis up to which rays are followed: 71.6 degrees."""

_RADIAL_STEPS = 3000

_BORDER_STEPS = 400
"""Points of each side of a colour image by which the undistorted image's size is found."""

_CLOSE = 0.05
"""How far a border point may come out from where it was [px] for a distortion to count as undone."""


@lru_cache(maxsize=8)
def widest(distortion: tuple[float, ...]) -> float:
    """Tangent of the largest angle to the axis up to which farther out in the scene is farther out in the image.

    Beyond it the model of the lens folds back, and would show things that the camera never saw.
    """
    k1, k2, _, _, k3, k4, k5, k6 = (*distortion, *(0.0,) * (8 - len(distortion)))
    radius = np.linspace(0.0, _WIDEST, _RADIAL_STEPS)
    square = radius**2
    below = 1 + square * (k4 + square * (k5 + square * k6))
    with np.errstate(divide="ignore", invalid="ignore"):
        seen = radius * (1 + square * (k1 + square * (k2 + square * k3))) / below
    falls = ~(np.diff(seen) > 0) | (below[1:] <= 0)
    return float(radius[np.argmax(falls)]) if falls.any() else _WIDEST


@lru_cache(maxsize=8)
def undistorted_view(camera: Camera) -> tuple[CameraIntrinsics, NDArray[np.float32], NDArray[np.float32]]:
    """How an image of the same size without distortion is made, each of whose pixels has a source in the camera's.

    Returns
    -------
    CameraIntrinsics
        Of the new image: the largest rectangle without gaps that has the same ratio of focal lengths.
    ndarray, ndarray of float32, shape (H, W)
        Column and row [px] in the camera's image that each pixel comes from.

    Raises
    ------
    InputError
        If the distortion cannot be undone over the image.
    """
    width, height = camera.size
    across, down = np.linspace(0, width - 1, _BORDER_STEPS), np.linspace(0, height - 1, _BORDER_STEPS)
    left = _rays(camera, np.zeros_like(down), down)[:, 0].max()
    right = _rays(camera, np.full_like(down, width - 1), down)[:, 0].min()
    top = _rays(camera, across, np.zeros_like(across))[:, 1].max()
    bottom = _rays(camera, across, np.full_like(across, height - 1))[:, 1].min()
    own = camera.intrinsics
    if not (left < right and top < bottom):
        raise _cannot_be_undone(camera)
    scale = float(max((width - 1) / own.fx / (right - left), (height - 1) / own.fy / (bottom - top)))
    fx, fy = scale * own.fx, scale * own.fy
    cx, cy = (width - 1 - fx * float(left + right)) / 2, (height - 1 - fy * float(top + bottom)) / 2
    new = CameraIntrinsics(fx, fy, cx, cy, own.name)
    columns, rows = cv2.initUndistortRectifyMap(
        camera.matrix, camera.coefficients, None, Camera(new, camera.size).matrix, camera.size, cv2.CV_32FC1
    )
    return new, fixed(np.clip(columns, 0, width - 1)), fixed(np.clip(rows, 0, height - 1))


def undistorted_colour(rgb: NDArray[np.uint8], camera: Camera) -> tuple[NDArray[np.uint8], CameraIntrinsics]:
    """Colour without the lens's distortion, shape (H, W, 3), and its intrinsics.

    Raises
    ------
    InputError
        If the distortion cannot be undone over the image.
    """
    if camera.coefficients is None:
        return rgb, camera.intrinsics
    intrinsics, columns, rows = undistorted_view(camera)
    return np.asarray(cv2.remap(rgb, columns, rows, cv2.INTER_LINEAR), np.uint8), intrinsics


def _rays(camera: Camera, columns: NDArray[np.float64], rows: NDArray[np.float64]) -> NDArray[np.float64]:
    """Where rays of pixels cross the plane at depth 1, (N, 2); InputError where the lens's model does not tell."""
    seen = np.stack([columns, rows], axis=1)[:, None]
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-9)
    rays = cv2.undistortPoints(seen, camera.matrix, camera.coefficients, None, None, None, criteria)
    points = np.concatenate([rays, np.ones_like(rays[..., :1])], axis=2)
    again, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), camera.matrix, camera.coefficients)
    found = rays[:, 0]
    if not (np.abs(again - seen) < _CLOSE).all() or (np.hypot(*found.T) > widest(camera.distortion)).any():
        raise _cannot_be_undone(camera)
    return np.asarray(found, np.float64)


def _cannot_be_undone(camera: Camera) -> InputError:
    numbers = ", ".join(f"{number:g}" for number in camera.distortion)
    return InputError(
        f"The colour camera's distortion ({numbers}) cannot be undone over an image of {camera.size[0]} x "
        f"{camera.size[1]}. Check that the coefficients are OpenCV's, k1 k2 p1 p2 k3 k4 k5 k6, and of this camera."
    )


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
    >>> from ilf.data.camera import CameraIntrinsics
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
