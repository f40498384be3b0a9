"""Camera intrinsics, presets of common depth cameras, and conversion from the formats of other programs."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError, told_as
from .arrays import frozen, plain_array

_SHORTEST, _LARGEST = 1e-3, 1e6
"""Minimum focal length and maximum of all intrinsics [px]: beyond them points and normals would exceed float32."""

REMEDY = "Give intrinsics as a preset (such as nyu-kinect-v1), as fx,fy,cx,cy, or as a file."

_UNDISTORT = "Undistort colour and depth first, and give the intrinsics of these images."

DISTORTION_NOTE = (
    "The lens distortion of colour and depth is not corrected, which bends the point cloud at its borders. Undistort "
    "the frame on reading to correct it."
)


FISHEYE_NOTE = (
    "The lens is a fisheye: clouds and normals need the camera of undistorted images. Undistort the frame on reading."
)
FISHEYE = "fisheye"
"""The model of Kannala and Brandt, as in OpenCV's module of this name; the other model is "pinhole"."""
_COEFFICIENTS = {"pinhole": (0, 4, 5, 8, 12, 14), FISHEYE: (0, 4)}
"""Supported numbers of distortion coefficients of each model, in OpenCV's order."""
ORDERS = {"pinhole": "k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 and two angles", FISHEYE: "k1 k2 k3 k4 of a fisheye"}
"""That order."""
_MAX_COEFFICIENT = 1e6


@dataclass(frozen=True)
class Camera:
    """A pinhole camera, with or without distortion, or a fisheye; lengths are in pixels.

    Parameters
    ----------
    fx, fy : float
        Focal lengths [px].
    cx, cy : float
        Principal point [px], measured from the centre of the top left pixel.
    name : str
        Preset or file that the numbers come from; for display only.
    size : tuple of int, optional
        Width and height [px] of the images that the numbers are for: they are scaled to a frame of another size. None
        stands for those of the frame.
    distortion : tuple of float
        Coefficients in OpenCV's order: k1 k2 p1 p2, then k3, then k4 k5 k6 of the rational model, then s1 s2 s3 s4 of
        thin prisms, then the two angles of a tilted sensor; none for a camera without distortion. Of a fisheye: k1 k2
        k3 k4.
    model : str
        "pinhole" or "fisheye".

    Raises
    ------
    InputError
        If the numbers are no valid camera, or the number of coefficients is not supported.

    Examples
    --------
    >>> Camera(525.0, 525.0, 319.5, 239.5).fx
    525.0
    >>> INTRINSICS["kinect-v2"].size
    (512, 424)
    """

    fx: float
    fy: float
    cx: float
    cy: float
    name: str = ""
    size: tuple[int, int] | None = field(default=None, metadata={"optional": True})
    distortion: tuple[float, ...] = field(default=(), metadata={"optional": True})
    model: str = field(default="pinhole", metadata={"optional": True})

    def __post_init__(self) -> None:
        numbers = (self.fx, self.fy, self.cx, self.cy)
        if not all(np.isfinite(numbers)):
            raise InputError(f"Camera intrinsics must be finite numbers, not {numbers}.")
        if self.fx <= 0 or self.fy <= 0:
            raise InputError(f"Focal lengths must be positive pixels, not fx={self.fx:g}, fy={self.fy:g}. {REMEDY}")
        if min(self.fx, self.fy) < _SHORTEST or max(map(abs, numbers)) > _LARGEST:
            raise InputError(f"Intrinsics must be {_SHORTEST:g} (focal lengths) to {_LARGEST:g} px, not {numbers}.")
        if self.size is not None and (len(self.size) != 2 or min(self.size) < 1):
            raise InputError(f"A camera's size must be a width and a height in pixels, not {self.size}.")
        object.__setattr__(self, "distortion", tuple(map(float, self.distortion)))
        if self.model not in _COEFFICIENTS:
            raise InputError(f"A camera's model must be {' or '.join(_COEFFICIENTS)}, not {self.model!r:.40}.")
        *counts, most = _COEFFICIENTS[self.model]
        if len(self.distortion) not in {*counts, most}:
            wanted = f"{', '.join(map(str, counts))} or {most} coefficients, {ORDERS[self.model]}"
            raise InputError(f"A camera's distortion must have {wanted}, not {len(self.distortion)}.")
        if not np.all(np.abs(self.distortion) <= _MAX_COEFFICIENT):
            raise InputError(f"A camera's distortion must be finite numbers, not {self.distortion}.")

    @property
    def pinhole(self) -> Camera:
        """The same camera without size and distortion, as a frame has it; raises InputError for a fisheye."""
        if self.model == FISHEYE:
            raise InputError(FISHEYE_NOTE)
        is_plain = self.size is None and not self.distortion
        return self if is_plain else Camera(self.fx, self.fy, self.cx, self.cy, self.name)

    @property
    def numbers(self) -> tuple[float, float, float, float]:
        """fx, fy, cx, cy."""
        return self.fx, self.fy, self.cx, self.cy

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of its images in pixels; raises InputError if they are not known."""
        if self.size is None:
            raise InputError("The size of a camera's images is not known. Give it as size=(width, height).")
        return self.size[1], self.size[0]

    @property
    def matrix(self) -> NDArray[np.float64]:
        """The camera matrix, float64 (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def is_bent(self) -> bool:
        """Whether straight lines are curved in its images."""
        return any(self.distortion) or self.model == FISHEYE

    @property
    def coefficients(self) -> NDArray[np.float64] | None:
        """The distortion in OpenCV's form; None if a pinhole camera has none."""
        if self.model == FISHEYE:
            return np.array(self.distortion or (0.0,) * 4)
        return np.array(self.distortion) if any(self.distortion) else None

    def to_json(self) -> dict[str, Any]:
        """The camera as an object of a JSON file, with size, distortion and model only where they are known."""
        model = self.model if self.model == FISHEYE else None
        known = {"size": self.size and list(self.size), "distortion": list(self.distortion), "model": model}
        stated = {"name": self.name} | {name: value for name, value in known.items() if value}
        return dict(zip(("fx", "fy", "cx", "cy"), self.numbers, strict=True)) | stated

    def has(self, columns: NDArray[Any], rows: NDArray[Any]) -> NDArray[np.bool_]:
        """Whether positions [px] lie in its images."""
        height, width = self.shape
        return (columns >= -0.5) & (columns < width - 0.5) & (rows >= -0.5) & (rows < height - 0.5)

    def points(self, columns: ArrayLike, rows: ArrayLike, depth: ArrayLike) -> NDArray[np.float64]:
        """Back-project pixels with depth to 3-D points.

        Parameters
        ----------
        columns, rows : array_like, shape (N,)
            Pixel coordinates; integers are pixel centres.
        depth : array_like, shape (N,)
            Depth along the optical axis [m]; where it is NaN, so is the point.

        Returns
        -------
        ndarray of float64, shape (N, 3)
            x to the right, y down, z forward [m].

        Examples
        --------
        >>> Camera(100.0, 100.0, 50.0, 40.0).points([0], [40], [2.0]).tolist()
        [[-1.0, 0.0, 2.0]]
        """
        z = np.asarray(plain_array(depth), np.float64)
        x = (np.asarray(columns) - self.cx) / self.fx * z
        y = (np.asarray(rows) - self.cy) / self.fy * z
        return np.stack([x, y, z], axis=-1)


# name -> fx, fy, cx, cy and the (width, height) that they apply to
_PUBLISHED: dict[str, tuple[float, float, float, float, tuple[int, int]]] = {
    # colour camera of NYU Depth V2 (toolbox, camera_params.m), onto which its depth is registered
    "nyu-kinect-v1": (518.8579, 519.4696, 325.5824, 253.7362, (640, 480)),
    # infrared camera of a typical device, read by libfreenect2
    "kinect-v2": (365.456, 365.456, 254.878, 205.395, (512, 424)),
    # depth aligned to colour, as in RGB-D frames: nominal, from the colour camera's field of view (69.4 degrees at
    # 16:9, cropped to 4:3)
    "realsense-d435": (616.1, 616.1, 319.5, 239.5, (640, 480)),
    # native depth stream of a factory-calibrated device, for depth that is not aligned to colour
    "realsense-d435-depth": (385.134, 385.134, 321.635, 241.618, (640, 480)),
    # colour camera of the freiburg1 sequences
    "tum-fr1": (517.3, 516.5, 318.6, 255.3, (640, 480)),
    # colour cameras of the other TUM sequences, and of Bonn's dynamic ones
    "tum-fr2": (520.9, 521.0, 325.1, 249.7, (640, 480)),
    "tum-fr3": (535.4, 539.2, 320.1, 247.6, (640, 480)),
    "bonn": (542.822841, 542.57687, 315.59352, 237.756098, (640, 480)),
    # depth camera of a factory-calibrated device, mode NFOV unbinned
    "azure-kinect": (503.9276, 503.9787, 332.0643, 325.8806, (640, 576)),
}

INTRINSICS: dict[str, Camera] = {name: Camera(*numbers[:4], name, numbers[4]) for name, numbers in _PUBLISHED.items()}
"""Preset name -> camera, with the image size that its numbers are for."""


@dataclass(frozen=True, eq=False)
class Cameras:
    """The two cameras of a frame.

    Attributes
    ----------
    colour, depth : Camera or None
        None if not known. For registered frames, `depth` is the same camera as `colour`, possibly at another size.
    depth_to_colour : ndarray of float64, shape (4, 4), or None
        Transform of points [m] from the depth camera to the colour camera; None if not known.
    is_registered : bool
        Whether colour and depth have the same pixels, or the same view at two sizes: colour is then resized to the
        size of depth.
    note : str
        A sentence for the user about the cameras; "" for none.
    """

    colour: Camera | None
    depth: Camera | None
    depth_to_colour: NDArray[np.float64] | None
    is_registered: bool = False
    note: str = ""

    @classmethod
    def registered(cls, camera: Camera | None, note: str = "") -> Self:
        """The cameras of a frame whose depth has the pixels of its colour."""
        return cls(camera, camera, np.eye(4), True, note)

    @classmethod
    def of_one_view(cls, colour: Camera, size: tuple[int, int]) -> Self:
        """The cameras of a frame whose depth has the view of its colour at another size (width, height); raises
        InputError if the aspect ratios of the two sizes differ."""
        return cls(colour, fitted(colour, (size[1], size[0])), np.eye(4), is_registered=True)


def checked_transform(matrix: ArrayLike, what: str) -> NDArray[np.float64]:
    """Return a rigid transform as a read-only matrix (4, 4); raise InputError, whose message begins with `what`, if it
    is not a rotation and a translation."""
    with told_as(InputError, f"{what} must be a 4 x 4 matrix of numbers.", (TypeError, ValueError, OverflowError)):
        motion = np.array(matrix, np.float64)
    if motion.shape != (4, 4) or not np.isfinite(motion).all() or not np.allclose(motion[3], [0, 0, 0, 1], atol=1e-6):
        raise InputError(f"{what} must be a 4 x 4 matrix of finite numbers that ends in 0 0 0 1.")
    motion[3] = 0, 0, 0, 1
    turn = motion[:3, :3]
    is_small = np.abs(turn).max() < 2  # products of larger values could overflow
    if not is_small or not np.allclose(turn @ turn.T, np.eye(3), atol=0.01) or np.linalg.det(turn) < 0:
        raise InputError(f"{what} must be a rotation and a translation, without scale or reflection.")
    return frozen(motion)


def rigid_transform(rotation: ArrayLike, translation: ArrayLike) -> NDArray[np.float64]:
    """The matrix (4, 4) of a rotation, nine numbers row by row, and a translation."""
    motion = np.eye(4)
    motion[:3, :3], motion[:3, 3] = np.reshape(rotation, (3, 3)), translation
    return motion


def camera_text(camera: Camera | None) -> str:
    """Format intrinsics as text."""
    if camera is None:
        return "unknown"
    name = f" ({camera.name})" if camera.name else ""
    return f"fx {camera.fx:g}, fy {camera.fy:g}, cx {camera.cx:g}, cy {camera.cy:g}{name}"


# Doubts about the camera of a frame.

CAMERA_DOUBT = "The intrinsics may be wrong: "
"""Beginning of the doubt about the camera of a frame."""
_NORMALISED = 10.0
"""Focal length [px] that no camera has; below it, numbers are relative to the image size."""
_OFF_CENTRE, _AT_CENTRE = 0.08, 0.03
"""Distance of a principal point from the centre of its image, relative to the image, from which on it may be that of
another size; largest distance from the centre of that size."""
_FIELDS_OF_VIEW = 10.0, 150.0
_SIZES = (
    (160, 120), (240, 180), (256, 192), (320, 180), (320, 240), (424, 240), (480, 270), (480, 360), (512, 424),
    (512, 512), (640, 360), (640, 400), (640, 480), (640, 576), (752, 480), (800, 600), (848, 480), (960, 540),
    (960, 720), (1024, 768), (1024, 1024), (1242, 375), (1280, 720), (1280, 800), (1280, 960), (1280, 1024),
    (1296, 968), (1440, 1080), (1600, 1200), (1920, 1080), (1920, 1200), (1920, 1440), (2048, 1536), (2560, 1440),
    (3840, 2160), (4032, 3024), (4096, 3072),
)  # fmt: skip
"""Common widths and heights [px] of images."""
_FACTORS = 1 / 4, 1 / 3, 1 / 2, 2 / 3, 3 / 4, 4 / 5, 5 / 4, 4 / 3, 3 / 2, 2, 3, 4
"""Factors by which images are made smaller or larger."""


def camera_doubt(camera: Camera, shape: tuple[int, int]) -> str:
    """Return why intrinsics are implausible for an image, and what to do; "" if they are plausible.

    Parameters
    ----------
    camera : Camera
    shape : (int, int)
        (H, W) of the image.

    Examples
    --------
    >>> camera_doubt(Camera(0.82, 1.09, 0.5, 0.5), (120, 160))[:96]
    'The intrinsics may be wrong: fx 0.82 is no focal length in pixels. If it is relative to the imag'
    >>> camera_doubt(Camera(525.0, 525.0, 319.5, 239.5), (480, 640))
    ''
    """
    height, width = shape
    fx, fy, cx, cy = camera.fx, camera.fy, camera.cx, camera.cy
    if is_normalised(camera):
        return (
            f"{CAMERA_DOUBT}fx {fx:g} is no focal length in pixels. If it is relative to the image's width, {fx:g} * "
            f"{width} = {fx * width:.1f} px is meant: give fx and cx times the width, fy and cy times the height."
        )
    off_centre = max(abs((cx + 0.5) / width - 0.5), abs((cy + 0.5) / height - 0.5))
    if off_centre > _OFF_CENTRE and (other := _size_around(camera, shape)) is not None:
        scaled = f": fx {fx:g} * {width} / {other[0]} = {fx * width / other[0]:.1f} px may be meant"
        return (
            f"{CAMERA_DOUBT}the principal point ({cx:g}, {cy:g}) is about the centre of {other[0]} x {other[1]} "
            f"pixels, but the image has {width} x {height}{scaled if other[0] * height == other[1] * width else ''}. "
            "Give the intrinsics of this image, or a file that also states the width and height that they are for."
        )
    if off_centre > 0.25:
        return (
            f"{CAMERA_DOUBT}the principal point ({cx:g}, {cy:g}) lies outside the middle half of the image, which has "
            f"{width} x {height} pixels. Give the intrinsics of this image, in pixels."
        )
    view = 2 * math.degrees(math.atan(max(width / fx, height / fy) / 2))
    if not _FIELDS_OF_VIEW[0] <= view <= _FIELDS_OF_VIEW[1]:
        return (
            f"{CAMERA_DOUBT}with fx {fx:g} and fy {fy:g} px, an image of {width} x {height} pixels has a field of view "
            f"of {view:.3g} degrees. Give the focal lengths of this image, in pixels."
        )
    return ""


def is_normalised(camera: Camera) -> bool:
    """Whether the numbers cannot be pixels, but may be relative to the image size."""
    return max(camera.fx, camera.fy) < _NORMALISED and max(camera.cx, camera.cy) <= 1


def _size_around(camera: Camera, shape: tuple[int, int]) -> tuple[int, int] | None:
    """The image size whose centre is nearest to the principal point, of common ones, upright or turned, and of simple
    parts and multiples of this one; None if none is near."""

    def distance(size: tuple[int, int]) -> float:
        return max(abs((camera.cx + 0.5) / size[0] - 0.5), abs((camera.cy + 0.5) / size[1] - 0.5))

    scaled = [(max(round(factor * shape[1]), 1), max(round(factor * shape[0]), 1)) for factor in _FACTORS]
    nearest = min((*_SIZES, *(size[::-1] for size in _SIZES), *scaled), key=distance)
    return nearest if distance(nearest) <= _AT_CENTRE else None


def is_preset(text: str) -> bool:
    """Whether a text is the name of a preset, in upper or lower case."""
    return text.strip().lower() in INTRINSICS


def as_camera(given: Any, shape: tuple[int, int] | None) -> Camera:
    """Convert what a caller passes as intrinsics to the camera of a frame; raise InputError if that is not possible.

    Parameters
    ----------
    given : Camera, str, sequence, mapping or ndarray
        A camera; the name of a preset; or anything else that `camera_of` accepts.
    shape : (int, int), optional
        (H, W) of the frame, to which a camera with a known image size is scaled.

    Examples
    --------
    >>> as_camera([[525, 0, 319.5], [0, 525, 239.5], [0, 0, 1]], None).numbers
    (525.0, 525.0, 319.5, 239.5)
    """
    return fitted(camera_of(given, shape), shape).pinhole


def camera_of(given: Any, shape: tuple[int, int] | None, name: str = "") -> Camera:
    """Convert a preset's name, numbers, also as text, or an object as in JSON to a camera, with the image size and the
    model that are stated, but no distortion; raise InputError if it is invalid, or of another model. An angle of view
    may need `shape`."""
    if isinstance(given, Camera):
        return given
    if isinstance(given, str):
        if "," in given:
            return _from_text(given)
        if not is_preset(given):
            remedy = "Give one, fx,fy,cx,cy, or a file to ilf.load_frame."
            raise InputError(f"There is no intrinsics preset {given!r:.60}. Known: {', '.join(INTRINSICS)}. {remedy}")
        return INTRINSICS[given.strip().lower()]
    if not isinstance(given, Mapping):
        return camera_from_numbers(given, name)
    name = given.get("name", name)
    if problem := lens_problem(given):
        raise InputError(problem)
    size, names = stated_size(given), ("fx", "fy", "cx", "cy")
    if matrix := {"K", "intrinsic_matrix"} & given.keys():
        found = camera_from_numbers(given[matrix.pop()], name)
    elif "angle_x" in given and not given.keys() >= {*names}:
        size = size or (shape and (shape[1], shape[0]))
        found = _from_angles(given, size, name)
    else:
        missing = [key for key in names if key not in given]
        if missing:
            raise InputError(f"Intrinsics lack {', '.join(missing)}. Give fx, fy, cx and cy, or a camera matrix K.")
        found = camera_from_numbers([given[key] for key in names], name)
    return replace(found, size=size, model=FISHEYE if _told_lens(given, _FISHEYE) else "pinhole")


def _from_text(text: str) -> Camera:
    with told_as(InputError, f"{text!r} is not fx,fy,cx,cy[,width,height]. {REMEDY}", ValueError):
        fx, fy, cx, cy, *more = (float(part) for part in text.split(","))
        width, height = (int(number) if number.is_integer() else 0 for number in more or (0.0, 0.0))
        return Camera(fx, fy, cx, cy, size=(width, height) if more else None)


def stated_size(data: Mapping[str, Any]) -> tuple[int, int] | None:
    """The width and height that intrinsics are for, if stated; raise InputError if they are no image size."""
    if "width" not in data or "height" not in data:
        return None
    size = _array([data["width"], data["height"]])
    if size.shape != (2,) or not (np.isfinite(size).all() and (size >= 1).all()):
        raise InputError("The width and height of the intrinsics must be positive integers.")
    return int(size[0]), int(size[1])


def _from_angles(data: Mapping[str, Any], size: tuple[int, int] | None, name: str) -> Camera:
    """Intrinsics from the angles of view [rad] of an image; its principal point is the centre if not stated."""
    if size is None:
        raise InputError("Intrinsics by camera_angle_x need the width of the image. Give fx, fy, cx and cy.")
    angles = _array([data["angle_x"], data.get("angle_y", data["angle_x"])]).astype(float)
    if not ((angles > 0) & (angles < math.pi)).all():
        raise InputError("camera_angle_x and camera_angle_y must be angles of view in radians, from 0 to pi.")
    fx = data.get("fx", size[0] / 2 / math.tan(angles[0] / 2))
    fy = size[1] / 2 / math.tan(angles[1] / 2) if "angle_y" in data else fx
    centre = ((length - 1) / 2 for length in size)
    numbers = {"fx": fx, "fy": fy, **dict(zip(("cx", "cy"), centre, strict=True))}
    return camera_from_numbers([data.get(key, number) for key, number in numbers.items()], name)


_OTHER_LENS = re.compile(
    r"equirect|equisolid|omni(?!vision)|\bmei\b|ucm|unified|ocam|\batan\b|(^|\s)ds(\s|$)|double.?sphere|\bfov|theta|spher|"
    r"panoram|ortho|scaramuzza|cylind|fisheye\d|prism.?fisheye|division|stereographic",
    re.I,
)
"""What the names of lens models contain that are neither those of pinhole cameras nor the fisheye of OpenCV."""
_FISHEYE = re.compile(r"fish.?eye|equi(dist|$|\s)|kannala|\bkb\d?\b", re.I)
"""What the names of that fisheye contain."""


def lens_of(data: Mapping[str, Any], shape: tuple[int, int] | None = None) -> Camera:
    """As `camera_of`, with the coefficients of a stated distortion, by name or in OpenCV's order; raise InputError if
    the model has not as many. The inverse Brown-Conrady model of RealSense is Brown: its library distorts in
    projection."""
    camera, stated = camera_of(data, shape), data.get("distortion", ())
    if isinstance(stated, Mapping):
        if camera.model != FISHEYE and stated.get("k4") and not {"k5", "k6"} & stated.keys():  # r^8 of nerfstudio
            raise InputError(f"The lens has k4, but neither k5 nor k6: four terms are not supported. {_UNDISTORT}")
        names = "k1 k2 k3 k4" if camera.model == FISHEYE else "k1 k2 p1 p2 k3 k4 k5 k6"
        stated = [stated.get(name, 0.0) for name in names.split()]
    if camera.model == FISHEYE and not any(stated[4:]):  # DepthAI and librealsense fill up with zeros
        stated = stated[:4]
    return replace(camera, distortion=tuple(stated))


def lens_problem(data: Mapping[str, Any]) -> str:
    """A sentence that the stated lens model is not supported; "" if it may be."""
    lens = _told_lens(data, _OTHER_LENS)
    return lens and f"The lens model {lens!r:.40} is not supported. {_UNDISTORT}"


def _told_lens(data: Mapping[str, Any], names: re.Pattern[str]) -> str:
    told = [str(data[key]) for key in ("lens", "camera_model", "distortion_model", "model") if key in data]
    return next(filter(names.search, told), "")


def camera_from_numbers(numbers: Any, name: str) -> Camera:
    """Convert fx, fy, cx, cy or a 3 x 3 camera matrix, row by row or (as Open3D, ARKit and MATLAB have it) column by
    column, to intrinsics; raise InputError if they are invalid."""
    array = _array(numbers).astype(float)
    if array.shape == (4,):
        fx, fy, cx, cy = array.tolist()
    elif array.shape in {(9,), (3, 3)}:
        matrix = array.reshape(3, 3)
        (fx, skew, cx), (below, fy, cy), last = (matrix.T if matrix[2, :2].any() else matrix).tolist()
        if skew or below or last != [0, 0, 1]:
            raise InputError(f"A camera matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], or transposed. {REMEDY}")
    else:
        raise InputError(f"Intrinsics must be four numbers or a 3 x 3 matrix, not {array.size} numbers. {REMEDY}")
    return Camera(fx, fy, cx, cy, name)


def _array(numbers: Any) -> NDArray[Any]:
    with told_as(InputError, f"Intrinsics must be plain numbers. {REMEDY}", ValueError):
        array = np.asarray(numbers)
    if array.dtype.kind not in "iuf":
        raise InputError(f"Intrinsics must be plain numbers, not {numbers!r:.60}. {REMEDY}")
    return array


def fitted(camera: Camera, shape: tuple[int, int] | None) -> Camera:
    """Scale a camera of a known size to images of `shape` (H, W).

    Examples
    --------
    >>> fitted(Camera(500.0, 500.0, 319.5, 239.5, size=(640, 480)), (240, 320)).numbers
    (250.0, 250.0, 159.5, 119.5)
    """
    size = camera.size
    if size is None or shape is None or size == (shape[1], shape[0]):
        return camera
    if is_normalised(camera):
        return replace(camera, size=(shape[1], shape[0]))
    scale = shape[1] / size[0]
    if not math.isclose(shape[0], scale * size[1], abs_tol=1.0):
        raise InputError(
            f"The intrinsics {camera.name or 'given'} are for {size[0]} x {size[1]} pixels, and the frame has "
            f"{shape[1]} x {shape[0]}, another aspect ratio. Give the intrinsics of this frame as fx,fy,cx,cy."
        )
    # the principal point is measured from a pixel's centre, but the image scales about a pixel's corner
    return Camera(
        camera.fx * scale,
        camera.fy * scale,
        (camera.cx + 0.5) * scale - 0.5,
        (camera.cy + 0.5) * scale - 0.5,
        camera.name,
        (shape[1], shape[0]),
        camera.distortion,
        camera.model,
    )
