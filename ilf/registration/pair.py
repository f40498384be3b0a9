"""A raw pair: colour and depth as two cameras have seen them, and how the two stand to each other."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..camera import CameraIntrinsics, checked_motion
from ..errors import InputError
from ..frame import FrameInputs, checked_colour, checked_depth
from ..masks import checked_mask

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
