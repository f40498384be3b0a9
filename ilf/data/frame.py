"""The RGB-D frame: the one form in which colour and depth travel through the library."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from .camera import CameraIntrinsics, as_camera, checked_motion
from .guide import Guide, as_guide
from .open3d_images import arrays_of, camera_of_open3d, image_of, pinhole_of
from .pictures import html_row, plot_row

# Masks that go with a frame, and arrays that stay as they are.

Array = TypeVar("Array", bound=NDArray[Any])


def fixed(array: Array) -> Array:
    """An array that nobody can write to: this very one if it is so already, as another frame's or run's, so that they
    share it; else a copy.

    Examples
    --------
    >>> mask = np.zeros((2, 3), bool)
    >>> once = fixed(mask)
    >>> once is mask, fixed(once) is once, once.flags.writeable
    (False, True, False)
    """
    if not array.flags.writeable and array.base is None and array.flags.c_contiguous:
        return array
    copied: Array = array.copy()
    copied.setflags(write=False)
    return copied


def checked_mask(mask: ArrayLike, shape: tuple[int, ...], what: str) -> NDArray[np.bool_]:
    """A mask of `what` that nobody can write to, of bool or of whole numbers that are all 0 and 1, or 0 and 255; raises
    InputError if it is another, or does not fit a frame of this shape (H, W)."""
    array = np.asarray(mask)
    if array.dtype.kind in "iu" and any(set(np.unique(array).tolist()) <= pair for pair in ({0, 1}, {0, 255})):
        array = array != 0
    if array.dtype != np.bool_ or array.shape != shape:
        raise InputError(
            f"A mask of {what} must be bool with the frame's shape {shape}, or hold only 0 and 1, or 0 and 255; not "
            f"{array.dtype} with shape {array.shape}."
        )
    return fixed(array)


DEPTH_LIMITS = (1e-9, 1e6)
"""Least and largest depth [m] of any pixel."""

MEDIAN_DEPTH_RANGE = (0.1, 50.0)
"""Median depth [m] outside which a frame's depth scale is taken for a mistake."""

USUAL_MEDIAN_DEPTH = (0.3, 6.0)
"""Median depth [m] of nearly all frames of depth cameras."""

COMMON_DEPTH_UNITS = (1000.0, 5000.0, 10_000.0, 4000.0, 1.0)
"""File units per metre that are in use, the most common first."""


@dataclass(frozen=True)
class InputFile:
    """A file that was read: where it was, and the SHA-256 of the very bytes that were read."""

    path: str
    sha256: str


@dataclass(frozen=True)
class TruthFile(InputFile):
    """The file of a frame's truth, and its units per metre."""

    units: float


@dataclass(frozen=True)
class FrameInputs:
    """The files of a frame and how they were read: file units per metre, and fx, fy, cx, cy [px] or None.

    `encoding` names the depth encoding where no number of units says it; `depth_units` are then those of what it
    decodes to. `invalid` is the depth file's value that stands for missing, if there is one beside zero. `frame` is the
    key of a frame of a recording: `rgb` and `depth` are then the recording, with the SHA-256 of the bytes in it that
    hold the frame's colour and depth.
    """

    rgb: InputFile
    depth: InputFile
    depth_units: float
    intrinsics: tuple[float, float, float, float] | None
    truth: TruthFile | None = None
    encoding: str | None = None
    invalid: float | None = None
    frame: str | None = None


@dataclass(frozen=True, eq=False)
class RGBDFrame:
    """Registered colour and depth of one moment. Immutable: its arrays are read-only copies, but for colour that is
    read-only already.

    Parameters
    ----------
    rgb : array_like
        Colour, shape (H, W, 3), red first, or grey, shape (H, W) or (H, W, 1): uint8, or float from 0 to 1, which is
        converted to uint8.
    depth : array_like
        Depth [m], shape (H, W), any real type. NaN, infinite, zero and negative values all mean
        *missing* and become NaN, and so does distrusted depth.
    intrinsics : CameraIntrinsics, optional
        Needed for point clouds only. Also four numbers fx, fy, cx, cy [px], a 3 x 3 camera matrix, a mapping of either,
        or the name of a preset (`ilf.data.camera.INTRINSICS`).
    name : str
        What to call the frame in lists and reports.
    inputs : FrameInputs, optional
        The files that it was read from; filled by the readers.
    distrusted : array_like of bool, optional
        Pixels, shape (H, W), whose measured depth is known to be wrong (the wall behind a glass, flying pixels, glare)
        and counts as missing. Where nothing was measured it means nothing. Masks may also be of whole numbers that are
        all 0 and 1, or 0 and 255, as in files. Of a frame that has such a mask, make others by `distrusting`:
        `dataclasses.replace` would take its `depth` for what was measured.
    truth : array_like, optional
        True depth [m] of the same pixels, shape (H, W), any real type; what is not finite and positive is unknown and
        becomes NaN. It is there to judge results by: nothing that makes them looks at it.
    guide : Guide or array_like, optional
        What something else says of the frame's depth, in whatever unit and sense; the edge-aware filter follows it as
        far as the known depth bears it out. Of another size, but the same aspect, it is resized.
    notes : tuple of str
        What the reader has left out, and what it doubts, a sentence or two each.
    outside_view : array_like of bool, optional
        Pixels, shape (H, W), that the depth camera could not see, whatever stands there: those of registered depth that
        lie outside its picture (`ilf.registration`). Where depth was measured it means nothing. They stay missing
        unless they are asked for (`Parameters.outside_view`), and are counted apart.
    pose : array_like, optional
        Where its camera was, shape (4, 4): takes its points [m], x to the right, y down, z forward, to the world's.
    doubts : tuple of str
        Those of the notes that speak against the way that its files are read.

    Attributes
    ----------
    measured : ndarray of float32, shape (H, W)
        Depth [m] as it was given, distrusted depth included.

    Raises
    ------
    InputError
        If shapes or types do not fit, the intrinsics are none, no depth is known, or the median depth is outside
        0.1-50 m.

    Examples
    --------
    >>> frame = RGBDFrame(rgb=np.zeros((2, 2, 3), np.uint8), depth=[[1.5, 2], [0, 2]])
    >>> frame.depth
    array([[1.5, 2. ],
           [nan, 2. ]], dtype=float32)
    >>> frame.distrusting([[False, True], [False, False]]).depth
    array([[1.5, nan],
           [nan, 2. ]], dtype=float32)
    >>> frame
    <RGBDFrame 'frame': 2 x 2 pixels, depth 1.5 to 2 m, 25.0% missing>
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    intrinsics: CameraIntrinsics | None = None
    name: str = "frame"
    inputs: FrameInputs | None = None
    distrusted: NDArray[np.bool_] | None = None
    truth: NDArray[np.float32] | None = field(default=None, repr=False)
    guide: Guide | None = field(default=None, repr=False)
    notes: tuple[str, ...] = field(default=(), repr=False)
    outside_view: NDArray[np.bool_] | None = field(default=None, repr=False)
    pose: NDArray[np.float64] | None = field(default=None, repr=False)
    doubts: tuple[str, ...] = field(default=(), repr=False)
    measured: NDArray[np.float32] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "rgb", checked_colour(self.rgb))
        measured = depth = checked_depth(self.depth)
        if self.distrusted is not None:
            distrusted = checked_mask(self.distrusted, depth.shape, "distrusted depth")
            object.__setattr__(self, "distrusted", distrusted)
            depth = _frozen(np.where(distrusted, np.float32(np.nan), depth))
        object.__setattr__(self, "measured", measured)
        object.__setattr__(self, "depth", depth)
        check_same_size(self.rgb, self.depth)
        if self.distrusted is not None and not self.known.any() and np.isfinite(self.measured).any():
            raise InputError("All depth of the frame is distrusted: nothing is left to go by. Trust some of it.")
        if self.outside_view is not None:
            outside = checked_mask(self.outside_view, depth.shape, "what lies outside the view")
            if np.isfinite(measured[outside]).any():
                outside = _frozen(outside & np.isnan(measured))
            object.__setattr__(self, "outside_view", outside if outside.any() else None)
        if self.intrinsics is not None:
            object.__setattr__(self, "intrinsics", as_camera(self.intrinsics, self.shape))
        if self.pose is not None:
            object.__setattr__(self, "pose", checked_motion(self.pose, "The pose of a frame"))
        if self.truth is not None:
            object.__setattr__(self, "truth", _checked_truth(self.truth, self.shape))
        if self.guide is not None:
            object.__setattr__(self, "guide", as_guide(self.guide).of_size(self.shape))
        check_depth_scale(self.depth, in_file=self.inputs is not None)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.summary()}>"

    def summary(self) -> str:
        """Name, size, range of depth and share of missing pixels in a line."""
        low, high = np.nanmin(self.depth), np.nanmax(self.depth)
        return (
            f"{self.name!r}: {_size(self.depth)} pixels, depth {low:.3g} to {high:.3g} m, "
            f"{self.missing_share:.1%} missing"
        )

    def _repr_html_(self) -> str:
        return html_row(self.summary(), self.rgb, {"Depth": self.depth})

    def plot(self) -> NDArray[Any]:
        """Plot colour and depth by matplotlib.

        Returns
        -------
        ndarray of matplotlib.axes.Axes
            Of colour and depth; `axes[0].figure` is the figure.

        Raises
        ------
        InputError
            If matplotlib is not installed (extra `plot`).
        """
        return plot_row(self.rgb, {"Depth": self.depth})

    @property
    def sources(self) -> dict[str, object]:
        """What `ilf.load_frame` takes to read the same files again, ready for JSON; empty if there are none."""
        if self.inputs is None:
            return {}
        camera, truth = self.inputs.intrinsics, self.inputs.truth
        return {
            "rgb": self.inputs.rgb.path,
            "depth": self.inputs.depth.path if self.inputs.frame is None else None,
            **({} if self.inputs.frame is None else {"frame": self.inputs.frame}),
            "depth_units": self.inputs.depth_units if self.inputs.encoding is None else None,
            "intrinsics": None if camera is None else list(camera),
            **({} if self.inputs.encoding is None else {"encoding": self.inputs.encoding}),
            **({} if self.inputs.invalid is None else {"invalid": self.inputs.invalid}),
            **({} if truth is None else {"truth": truth.path, "truth_units": truth.units}),
        }

    def distrusting(self, mask: ArrayLike | None) -> Self:
        """The same frame with other depth distrusted: pixels of a mask, bool (H, W), or none at all."""
        wanted = None if mask is None or not np.any(mask) else np.asarray(mask)
        if wanted is None and self.distrusted is None:
            return self
        return replace(self, depth=self.measured, distrusted=wanted)

    def also_distrusting(self, mask: NDArray[np.bool_]) -> Self:
        """The same frame with the depth of a mask's pixels, bool (H, W), distrusted beside what is already."""
        return self.distrusting(mask if self.distrusted is None else mask | self.distrusted)

    def with_truth(self, truth: ArrayLike | None, file: TruthFile | None = None) -> Self:
        """The same frame with another truth [m], shape (H, W), and the file that it is from; or with none."""
        inputs = None if self.inputs is None else replace(self.inputs, truth=file)
        return replace(self, depth=self.measured, truth=None if truth is None else np.asarray(truth), inputs=inputs)

    def with_guide(self, guide: ArrayLike | Guide | None) -> Self:
        """The same frame with another guide, or with none."""
        if guide is self.guide:
            return self
        return replace(self, depth=self.measured, guide=None if guide is None else as_guide(guide))

    def to_open3d(self) -> Any:
        """Colour and depth [m] as an `open3d.geometry.RGBDImage`, in which missing depth is 0.

        Raises
        ------
        ExportError
            If Open3D is not installed (extra `cloud`).
        """
        return image_of(self.rgb, self.depth)

    def open3d_camera(self) -> Any:
        """The intrinsics as an `open3d.camera.PinholeCameraIntrinsic`.

        Raises
        ------
        InputError
            If they are not known.
        ExportError
            If Open3D is not installed (extra `cloud`).
        """
        if self.intrinsics is None:
            raise InputError("The camera's intrinsics are not known: make the frame with intrinsics=.")
        return pinhole_of(self.intrinsics, self.shape)

    @classmethod
    def from_open3d(
        cls, image: Any, intrinsics: Any = None, *, depth_units: float | None = None, name: str = "frame"
    ) -> Self:
        """A frame of an RGBDImage of `open3d.geometry` or `open3d.t.geometry`.

        Parameters
        ----------
        image : RGBDImage
            With colour uint8, and depth.
        intrinsics : PinholeCameraIntrinsic, CameraIntrinsics or array_like, optional
            Or a 3 x 3 camera matrix.
        depth_units : float, optional
            Of the image's depth per metre; must be given for whole numbers, others are metres by default.
        name : str
            What to call the frame.

        Raises
        ------
        InputError
            If the image has no colour, its depth no units, or what `RGBDFrame` raises for.
        """
        rgb, depth = arrays_of(image, depth_units)
        return cls(rgb, depth, camera_of_open3d(intrinsics), name)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width in pixels."""
        return self.depth.shape[0], self.depth.shape[1]

    @property
    def known(self) -> NDArray[np.bool_]:
        """Pixels with depth, bool (H, W)."""
        return np.isfinite(self.depth)

    @property
    def missing(self) -> NDArray[np.bool_]:
        """Pixels without depth that the depth camera could see, bool (H, W): all without depth if nothing is said of
        its view."""
        return ~self.known if self.outside_view is None else ~(self.known | self.outside_view)

    def left_missing(self, outside_view: bool = False) -> NDArray[np.bool_] | None:
        """Pixels, bool (H, W), that nothing fills: those outside the depth camera's view, unless they are asked for.

        The one place that decides it. None if there are no such pixels.
        """
        return None if outside_view else self.outside_view

    @property
    def outside_share(self) -> float:
        """Share of pixels that lie outside the depth camera's view, 0-1."""
        return 0.0 if self.outside_view is None else float(np.count_nonzero(self.outside_view)) / self.depth.size

    @property
    def missing_share(self) -> float:
        """Share of pixels without depth that the depth camera could see, 0-1."""
        return float(np.count_nonzero(self.missing)) / self.depth.size


def checked_frame(frame: RGBDFrame) -> RGBDFrame:
    """The frame that a caller of the library gives; raises InputError for anything else, such as its colour alone."""
    if not isinstance(frame, RGBDFrame):
        raise InputError(
            f"The first argument must be an ilf.RGBDFrame, not {type(frame).__name__}: make one of colour and depth by "
            "ilf.RGBDFrame(rgb, depth), or read one by ilf.load_frame."
        )
    return frame


def check_same_size(rgb: NDArray[np.generic], depth: NDArray[np.generic]) -> None:
    """Raise InputError if colour and depth have other heights or widths."""
    if rgb.shape[:2] != depth.shape:
        raise InputError(
            f"Colour is {_size(rgb)} but depth is {_size(depth)}. Both must show the same pixels: register and resize "
            "one to the other first."
        )


def check_depth_scale(depth: NDArray[np.floating], *, in_file: bool = True) -> float:
    """Median of the known depth [m]; raise InputError where there is none or it cannot be metres.

    Parameters
    ----------
    depth : ndarray
        Depth [m], NaN = missing.
    in_file : bool
        Whether it was read from a file, whose units per metre may be another number; else it is an array of the
        caller's.
    """
    known = depth[np.isfinite(depth)]
    if known.size == 0:
        raise InputError(
            "The depth image has no known pixel (all are zero, negative or not finite). "
            "Check that this is the raw depth file."
        )
    median = float(np.median(known))
    low, high = MEDIAN_DEPTH_RANGE
    if not low <= median <= high:
        outside = f"The median depth would be {median:.4g} m, outside {low:g}-{high:g} m. "
        if not in_file:
            raise InputError(
                f"{outside}Depth must be in metres: divide it by its units per metre first, such as depth / 1000.0 for "
                "millimetres."
            )
        direction = "larger" if median > high else "smaller"
        raise InputError(
            f"{outside}The depth units are probably wrong: try a {direction} value of file units per metre "
            "(1000 for millimetres, 5000 for TUM, 10000 for 0.1 mm, 1 for metres)."
        )
    _check_extremes(known)
    return median


def _check_extremes(known: NDArray[np.floating]) -> None:
    """Raise InputError for depth [m] that cannot be, whose squares are beyond what float32 holds."""
    low, high = DEPTH_LIMITS
    absurd = known[(known < low) | (known > high)]
    if absurd.size:
        raise InputError(
            f"Depth of {absurd[0]:g} m cannot be: all must be within {low:g} and {high:g} m. Mark missing depth with 0 "
            "or NaN."
        )


def doubtful_scale(depth: NDArray[np.floating], units: float) -> str:
    """A sentence of doubt if the depth's scale is possible but unusual, and common units would make it usual.

    Parameters
    ----------
    depth : ndarray
        Depth [m] with some known pixels, NaN = missing.
    units : float
        File units per metre that it was read with.

    Returns
    -------
    str
        "" where there is nothing to doubt.
    """
    median = float(np.nanmedian(depth))
    low, high = USUAL_MEDIAN_DEPTH
    if low <= median <= high:
        return ""
    for other in COMMON_DEPTH_UNITS:
        if low <= median * units / other <= high:
            return (
                f"A median depth of {median:.2f} m is unusual for a depth camera; with {other:g} units per metre "
                f"it would be {median * units / other:.2f} m."
            )
    return ""


def checked_colour(rgb: ArrayLike) -> NDArray[np.uint8]:
    """Colour, uint8 (H, W, 3), that nobody can write to; raises InputError if it is not colour or grey, of uint8 or of
    float from 0 to 1.

    Examples
    --------
    >>> checked_colour([[0.0, 0.5, 1.0]])[0].tolist()
    [[0, 0, 0], [128, 128, 128], [255, 255, 255]]
    """
    array = np.asarray(rgb)
    if array.ndim == 2:
        array = array[..., None]
    if array.ndim != 3 or array.shape[2] not in (1, 3) or (array.dtype != np.uint8 and array.dtype.kind != "f"):
        raise InputError(
            "Colour must be uint8, or float from 0 to 1, with shape (H, W, 3), or (H, W) for grey, not "
            f"{array.dtype} with shape {np.shape(rgb)}."
        )
    if array.dtype.kind == "f":
        if array.size and not (array.min() >= 0 and array.max() <= 1):
            raise InputError(
                f"Colour of {array.dtype} must lie between 0 and 1, not {array.min():g} and {array.max():g}: divide it "
                "by its largest possible value, or make it uint8."
            )
        array = np.round(255 * array).astype(np.uint8)
    if array.shape[2] == 1:
        array = np.repeat(array, 3, axis=2)
    return fixed(array)  # what depends on it alone is then found once for all frames that share it


def checked_depth(depth: ArrayLike) -> NDArray[np.float32]:
    """Depth [m] that nobody can write to, NaN = missing; raises InputError if it is no image of real numbers."""
    array = np.asarray(depth)
    if array.ndim != 2 or array.size == 0 or array.dtype.kind not in "iuf":
        raise InputError(
            f"Depth must be one real number per pixel with shape (H, W), not {array.dtype} with shape {array.shape}."
        )
    with np.errstate(over="ignore"):
        metres = array.astype(np.float32)
    metres[~(np.isfinite(metres) & (metres > 0))] = np.nan
    return _frozen(metres)


def _checked_truth(truth: ArrayLike, shape: tuple[int, int]) -> NDArray[np.float32]:
    try:
        metres = checked_depth(truth)
    except InputError as error:
        raise InputError(f"The truth cannot be used: {error}") from error
    if metres.shape != shape:
        raise InputError(
            f"The truth is {_size(metres)} but the frame is {shape[1]} x {shape[0]}: both must show the same pixels."
        )
    if not np.isfinite(metres).any():
        raise InputError("The truth has no known pixel (all are zero, negative or not finite).")
    try:
        _check_extremes(metres[np.isfinite(metres)])
    except InputError as error:
        raise InputError(f"The truth cannot be used: {error}") from error
    return metres


def _frozen(array: NDArray[Any]) -> NDArray[Any]:
    array.setflags(write=False)
    return array


def _size(array: NDArray[np.generic]) -> str:
    return f"{array.shape[1]} x {array.shape[0]}"
