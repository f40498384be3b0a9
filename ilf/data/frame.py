"""The RGB-D frame: the data type for colour and depth throughout the library."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.files import is_address
from .._runtime.formatting import size_text
from ..errors import InputError, check_kind, told_as, warn_of_reading
from .arrays import Array, check_shape, frozen, plain_array, real_image, without_mask
from .camera import CAMERA_DOUBT, Camera, as_camera, camera_doubt, checked_transform
from .guide import Guide, as_guide
from .neighbours import NeighbourDepth, agrees
from .open3d_images import arrays_of, camera_of_open3d, image_of, load_open3d
from .pictures import html_row, plot_row

# Masks of a frame, and read-only arrays.


def read_only(array: Array) -> Array:
    """Return a read-only array: the same object if it is read-only already, so that frames and runs can share it; else
    a copy.

    Examples
    --------
    >>> mask = np.zeros((2, 3), bool)
    >>> once = read_only(mask)
    >>> once is mask, read_only(once) is once, once.flags.writeable
    (False, True, False)
    """
    if not array.flags.writeable and array.base is None and array.flags.c_contiguous:
        return array
    return frozen(array.copy())


def checked_mask(mask: ArrayLike, shape: tuple[int, ...], what: str, masked: bool = False) -> NDArray[np.bool_]:
    """Return a read-only mask of `what`, from bool or from integers that are all 0 and 1, or 0 and 255; raise
    InputError for other values, or if it does not have this shape (H, W). `masked` is the value where a numpy masked
    array has none."""
    array = plain_array(mask)
    if array.dtype.kind in "iu" and any(set(np.unique(array).tolist()) <= pair for pair in ({0, 1}, {0, 255})):
        array = array != 0
    if array.dtype != np.bool_ or array.shape != shape:
        given = f"{array.dtype} with shape {array.shape}"
        raise InputError(f"A mask of {what} must be bool with the frame's shape {shape}, or of 0 and 255, not {given}.")
    if masked and isinstance(mask, np.ma.MaskedArray):
        array = array | np.ma.getmaskarray(mask)
    return read_only(array)


DEPTH_LIMITS = (1e-9, 1e6)
"""Minimum and maximum depth [m] of any pixel."""

FARTHEST_DEPTH = 300.0
"""Depth [m] beyond the range of any sensor; invalid markers such as FLT_MAX and 1000 m are larger."""

MEDIAN_DEPTH_RANGE = (0.1, 50.0)
"""Range of the median depth [m] outside which a frame's depth scale is considered wrong."""

USUAL_MEDIAN_DEPTH = (0.3, 6.0)
"""Range of the median depth [m] of nearly all frames of depth cameras."""

COMMON_DEPTH_UNITS = (1000.0, 5000.0, 10_000.0, 4000.0, 6553.5, 1.0)
"""File units per metre in common use, the most common first."""

_USUAL_NEAREST = (0.15, 3.1)
"""Range of the depth [m] that 99 % of the pixels of nearly all frames exceed."""

_LARGE_UNITS = (256.0, 100.0)
"""File units per metre as of KITTI, and centimetres."""


@dataclass(frozen=True)
class InputFile:
    """A file that was read: its path, and the SHA-256 of the bytes that were read."""

    path: str
    sha256: str


@dataclass(frozen=True)
class GroundTruthFile(InputFile):
    """The file of a frame's ground truth, its units per metre, and its dataset, if that was named."""

    units: float
    dataset: str | None = field(default=None, metadata={"optional": True})

    @property
    def named(self) -> str:
        """The path, with the dataset behind it."""
        return f"{self.path}:{self.dataset}" if self.dataset else self.path


@dataclass(frozen=True)
class FrameInputs:
    """The files of a frame and how they were read: file units per metre, and fx, fy, cx, cy [px] or None.

    `encoding` is the name of the depth encoding if it is not given by units per metre; `depth_units` are then those
    of the decoded depth. `invalid` is the depth file's value that marks missing depth, if there is one besides
    zero. `frame` is the key of a frame of a recording: `rgb` and `depth` are then the recording, with the SHA-256
    of the bytes in it that contain the frame's colour and depth. `depth_intrinsics` are fx, fy, cx, cy [px] of a
    depth file of a camera of its own, by which its depth was registered, and `depth_to_colour` the rows of the
    matrix that transforms points [m] of that camera to the colour camera, if they are apart. `lenses` are the
    cameras of colour and depth by whose distortion both were undistorted; `intrinsics` are then those of the
    undistorted image. `view` is "depth" for a frame in the depth camera's view; `intrinsics` of two files are then
    still those of colour. `orientations` are the tags (EXIF) by which colour and depth were turned; None if both
    are as stored. `dataset` is that of an HDF5 depth file, if it was named.
    """

    rgb: InputFile
    depth: InputFile
    depth_units: float
    intrinsics: tuple[float, float, float, float] | None
    ground_truth: GroundTruthFile | None = None
    encoding: str | None = None
    invalid: float | None = None
    frame: str | None = None
    depth_intrinsics: tuple[float, float, float, float] | None = field(default=None, metadata={"optional": True})
    orientations: tuple[int, int] | None = field(default=None, metadata={"optional": True})
    lenses: tuple[Camera, Camera] | None = field(default=None, metadata={"optional": True})
    dataset: str | None = field(default=None, metadata={"optional": True})
    view: str | None = field(default=None, metadata={"optional": True})
    depth_to_colour: tuple[float, ...] | None = field(default=None, metadata={"optional": True})

    def __post_init__(self) -> None:
        if self.depth_to_colour is not None and self.depth_intrinsics is None and self.lenses is None:
            raise InputError("depth_to_colour needs depth_intrinsics: the record is damaged.")

    @property
    def has_colour_file(self) -> bool:
        """Whether colour is a file of its own on a disk, as stored: neither in a recording nor at an address, nor
        turned, undistorted or brought to the depth camera."""
        is_changed = (self.orientations, self.lenses, self.view) != (None, None, None)
        return self.frame is None and not is_changed and not is_address(self.rgb.path)

    @property
    def cameras_to_ask_for(self) -> tuple[Any, Any]:
        """Intrinsics of colour and of depth with which `ilf.load_frame` reads the files as they were, ready for
        JSON."""
        numbers = self.intrinsics, self.depth_intrinsics
        cameras: list[Any] = [None if camera is None else list(camera) for camera in numbers]
        colour, depth = cameras if self.lenses is None else [lens.to_json() for lens in self.lenses]
        if self.depth_to_colour is not None:
            stated = depth if isinstance(depth, dict) else dict(zip(("fx", "fy", "cx", "cy"), depth, strict=True))
            depth = stated | {"depth_to_colour": list(self.depth_to_colour)}
        return colour, depth

    @property
    def arguments(self) -> dict[str, Any]:
        """Arguments of `ilf.load_frame` to read the same files again, ready for JSON."""
        truth, stated = self.ground_truth, self.cameras_to_ask_for
        optional = {
            "frame": self.frame,
            "encoding": self.encoding,
            "invalid": self.invalid,
            "dataset": self.dataset,
            "depth_intrinsics": stated[1],
            "undistort": self.lenses is not None or None,
            "view": "colour" if self.view is None and self.depth_intrinsics is not None else self.view,
            "ground_truth": None if truth is None else truth.named,
            "ground_truth_units": None if truth is None else truth.units,
        }
        return {
            "rgb": self.rgb.path,
            "depth": self.depth.path if self.frame is None else None,
            "depth_units": self.depth_units if self.encoding is None else None,
            "intrinsics": stated[0],
            **{name: value for name, value in optional.items() if value is not None},
        }


@dataclass(frozen=True, eq=False)
class BroughtColour:
    """How the colour of a frame in the depth camera's view was brought there (`ilf.sources.registration.register`).

    Attributes
    ----------
    seen : ndarray of bool, shape (H, W)
        Pixels that the colour camera sees; the frame's `rgb` is black elsewhere.
    edge_rgb : ndarray of uint8, shape (H, W, 3)
        The frame's `rgb` with the other pixels filled smoothly, so that their outline is no evidence of an edge.
    camera : Camera
        The colour camera, without distortion and with its size.
    depth_to_colour : ndarray of float64, shape (4, 4)
        Transform of points [m] from the depth camera to the colour camera.
    """

    seen: NDArray[np.bool_]
    edge_rgb: NDArray[np.uint8]
    camera: Camera
    depth_to_colour: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class RGBDFrame:
    """Registered colour and depth of one moment. Immutable: its arrays are read-only copies, except for colour that is
    read-only already. In numpy masked arrays, here and in all functions, what is masked is missing; colour cannot be.

    Parameters
    ----------
    rgb : array_like
        Colour, shape (H, W, 3), RGB, or grey, shape (H, W) or (H, W, 1): uint8, or float from 0 to 1, which is
        converted to uint8.
    depth : array_like
        Depth [m], shape (H, W), any real type. NaN, infinite, zero and negative values all mean
        *missing* and become NaN, and so does invalid depth.
    intrinsics : Camera, optional
        Needed for point clouds only. Also four numbers fx, fy, cx, cy [px], also as text "fx,fy,cx,cy", a 3 x 3 camera
        matrix, a mapping of either, or the name of a preset (`ilf.data.camera.INTRINSICS`).
    name : str
        Name of the frame in lists and reports.
    inputs : FrameInputs, optional
        The files that it was read from; set by the readers.
    invalid_mask : array_like of bool, optional
        Invalid mask, shape (H, W): pixels whose measured depth is known to be wrong (the wall behind a glass, flying
        pixels, glare) and counts as missing. It has no effect where nothing was measured. Masks may also be integers
        that are all 0 and 1, or 0 and 255, as in files. To change a frame, use `changed` or
        `with_invalid_mask`: `dataclasses.replace` would treat the masked `depth` as the measured depth.
    ground_truth : array_like, optional
        Ground truth depth [m] of the same pixels, shape (H, W), any real type; values that are not finite and positive
        are unknown and become NaN. It is used only to evaluate results, never to compute them.
    guide : Guide or array_like, optional
        Depth or inverse depth from another source, in any unit; the edge-aware filter follows it as far as it agrees
        with the known depth. A guide of another size but the same aspect ratio is resized.
    notes : tuple of str
        Values left out on reading, what its camera lacks, and plausibility warnings, a sentence or two each.
    outside_view : array_like of bool, optional
        Pixels, shape (H, W), that the depth camera could not see at any depth: those of registered depth that lie
        outside its image (`ilf.sources.registration`). It has no effect where depth was measured. They stay missing
        unless `Parameters.outside_view` is set, and are counted separately.
    pose : array_like, optional
        Camera-to-world transform of its points [m], shape (4, 4): x to the right, y down, z forward.
    plausibility_warnings : tuple of str
        Those of the notes that are plausibility warnings: about its camera, and how its files were read.
    neighbours : NeighbourDepth, optional
        Depth that other frames have measured (`ilf.with_neighbours`): known depth of less weight where the frame has
        none of its own, except outside the view. It never counts as measured.
    invalid_marker : float, optional
        Depth [m] of which a plausibility warning says that it most likely marks missing depth. It counts as measured,
        but not as ground truth: see `trusted`.
    brought : BroughtColour, optional
        How colour was brought to the pixels of the depth camera, for a frame in the depth camera's view.

    Attributes
    ----------
    measured : ndarray of float32, shape (H, W)
        Depth [m] as given, including invalid depth, without that of neighbours.
    from_neighbours : ndarray of bool, shape (H, W), or None
        Pixels whose depth is that of neighbours; None without any.

    Raises
    ------
    InputError
        If shapes or types do not fit, the intrinsics are invalid, no depth is known, or the median depth is outside
        0.1-50 m.

    Examples
    --------
    >>> frame = RGBDFrame(rgb=np.zeros((2, 2, 3), np.uint8), depth=[[1.5, 2], [0, 2]])
    >>> frame.depth
    array([[1.5, 2. ],
           [nan, 2. ]], dtype=float32)
    >>> frame.with_invalid_mask([[False, True], [False, False]]).depth
    array([[1.5, nan],
           [nan, 2. ]], dtype=float32)
    >>> frame
    <RGBDFrame 'frame': 2 x 2 pixels, depth 1.5 to 2 m, 25.0% missing>
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[np.float32]
    intrinsics: Camera | None = None
    name: str = "frame"
    inputs: FrameInputs | None = None
    invalid_mask: NDArray[np.bool_] | None = None
    ground_truth: NDArray[np.float32] | None = field(default=None, repr=False)
    guide: Guide | None = field(default=None, repr=False)
    notes: tuple[str, ...] = field(default=(), repr=False)
    outside_view: NDArray[np.bool_] | None = field(default=None, repr=False)
    pose: NDArray[np.float64] | None = field(default=None, repr=False)
    plausibility_warnings: tuple[str, ...] = field(default=(), repr=False)
    neighbours: NeighbourDepth | None = field(default=None, repr=False)
    invalid_marker: float | None = field(default=None, repr=False)
    brought: BroughtColour | None = field(default=None, repr=False)
    measured: NDArray[np.float32] = field(init=False, repr=False)
    from_neighbours: NDArray[np.bool_] | None = field(init=False, repr=False, default=None)

    if TYPE_CHECKING:  # what is accepted is wider than the types of the fields, from which a dataclass makes its own

        def __init__(
            self,
            rgb: ArrayLike,
            depth: ArrayLike,
            intrinsics: Camera | ArrayLike | Mapping[str, Any] | None = None,
            name: str = "frame",
            inputs: FrameInputs | None = None,
            invalid_mask: ArrayLike | None = None,
            ground_truth: ArrayLike | None = None,
            guide: ArrayLike | Guide | None = None,
            notes: tuple[str, ...] = (),
            outside_view: ArrayLike | None = None,
            pose: ArrayLike | None = None,
            plausibility_warnings: tuple[str, ...] = (),
            neighbours: NeighbourDepth | None = None,
            invalid_marker: float | None = None,
            brought: BroughtColour | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        check_kind(self.name, str, "The name of a frame must be text", "give it as str(name).")
        if np.ndim(self.rgb) == 2 and np.shape(self.depth)[2:] == (3,):  # depth was given first
            given: tuple[Any, Any] = self.rgb, self.depth
            object.__setattr__(self, "depth", given[0])
            object.__setattr__(self, "rgb", given[1])
        object.__setattr__(self, "rgb", checked_colour(self.rgb))
        measured = depth = checked_depth(self.depth)
        if self.invalid_mask is not None:
            invalid_mask = checked_mask(self.invalid_mask, depth.shape, "invalid depth", masked=True)
            object.__setattr__(self, "invalid_mask", invalid_mask)
            depth = frozen(np.where(invalid_mask, np.float32(np.nan), depth))
        object.__setattr__(self, "measured", measured)
        object.__setattr__(self, "depth", depth)
        check_same_size(self.rgb, self.depth)
        if self.invalid_mask is not None and not self.known.any() and np.isfinite(self.measured).any():
            raise InputError("All depth of the frame is marked invalid: no known depth is left. Unmark some of it.")
        if self.outside_view is not None:
            outside = checked_mask(self.outside_view, depth.shape, "pixels outside the view")
            if np.isfinite(measured[outside]).any():
                outside = frozen(outside & np.isnan(measured))
            object.__setattr__(self, "outside_view", outside if outside.any() else None)
        if self.neighbours is not None:
            self._add_neighbours(self.neighbours)
        if self.intrinsics is not None:
            self._add_camera(as_camera(self.intrinsics, self.shape))
        if self.pose is not None:
            object.__setattr__(self, "pose", checked_transform(self.pose, "The pose of a frame"))
        if self.ground_truth is not None:
            object.__setattr__(self, "ground_truth", _checked_ground_truth(self.ground_truth, self.shape))
        if self.guide is not None:
            object.__setattr__(self, "guide", as_guide(self.guide).resized_to(self.shape))
        check_depth_scale(self.depth, in_file=self.inputs is not None)

    def _add_camera(self, camera: Camera) -> None:
        """Set the camera, with a doubt in place of that about an earlier camera; readers issue those of files."""
        object.__setattr__(self, "intrinsics", camera)
        doubt = camera_doubt(camera, self.shape)
        is_new = bool(doubt) and doubt not in self.notes
        for name in ("notes", "plausibility_warnings"):
            kept = (text for text in getattr(self, name) if not text.startswith(CAMERA_DOUBT))
            object.__setattr__(self, name, (*kept, *([doubt] if doubt else [])))
        if is_new and self.inputs is None:
            warn_of_reading(doubt)

    def _add_neighbours(self, neighbours: NeighbourDepth) -> None:
        """Add the neighbours' depth where the frame has none of its own, unless it repeats invalid depth."""
        check_shape("The depth of neighbours", neighbours.layers.shape[1:], self.shape)
        depth = neighbours.fused(self.depth)
        added = self.missing & np.isfinite(depth) & ~agrees(depth, self.measured)
        if added.any():
            object.__setattr__(self, "depth", frozen(np.where(added, depth, self.depth)))
            vars(self).pop("known", None)  # of the frame's own depth
            object.__setattr__(self, "from_neighbours", frozen(added))

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.summary()}>"

    def summary(self) -> str:
        """Return name, size, depth range and share of missing pixels in one line."""
        low, high = np.nanmin(self.depth), np.nanmax(self.depth)
        return (
            f"{self.name!r}: {size_text(self.shape)} pixels, depth {low:.3g} to {high:.3g} m, "
            f"{self.missing_share:.1%} missing"
        )

    def _repr_html_(self) -> str:
        return html_row(self.summary(), {"Colour": self.rgb, "Depth": self.depth})

    def plot(self) -> NDArray[Any]:
        """Plot colour and depth by matplotlib.

        Returns
        -------
        ndarray of matplotlib.axes.Axes
            Axes of colour and depth; `axes[0].figure` is the figure.

        Raises
        ------
        InputError
            If matplotlib is not installed (extra `plot`).
        """
        return plot_row({"Colour": self.rgb, "Depth": self.depth})

    @property
    def files(self) -> list[str]:
        """Paths of the files that it was read from, with those of its guide and its ground truth."""
        paths = [] if self.guide is None or self.guide.path is None else [self.guide.path]
        if self.inputs is not None:
            files = self.inputs.rgb, self.inputs.depth, self.inputs.ground_truth
            paths += [file.path for file in files if file is not None]
        return paths

    @property
    def sources(self) -> dict[str, object]:
        """Arguments of `ilf.load_frame` to read the same files again, ready for JSON; empty if there are no files."""
        return {} if self.inputs is None else self.inputs.arguments

    def changed(self, **values: Any) -> Self:
        """Return the frame with other values of its parameters; its depth stays as measured."""
        return replace(self, **{"depth": self.measured, **values})

    def with_invalid_mask(self, mask: ArrayLike | None) -> Self:
        """Return the frame with another invalid mask, bool (H, W), or with none."""
        wanted = mask if mask is not None and (np.ma.is_masked(mask) or np.any(mask)) else None
        if wanted is None and self.invalid_mask is None:
            return self
        return self.changed(invalid_mask=wanted)

    def with_more_invalid(self, mask: NDArray[np.bool_]) -> Self:
        """Return the frame with the pixels of a mask, bool (H, W), added to its invalid mask."""
        return self.with_invalid_mask(mask if self.invalid_mask is None else mask | self.invalid_mask)

    def with_ground_truth(self, ground_truth: ArrayLike | None, file: GroundTruthFile | None = None) -> Self:
        """Return the frame with another ground truth [m], shape (H, W), and the file it comes from; or with none."""
        inputs = None if self.inputs is None else replace(self.inputs, ground_truth=file)
        return self.changed(ground_truth=ground_truth, inputs=inputs)

    def with_neighbours(self, neighbours: NeighbourDepth | None) -> Self:
        """Return the frame with depth of other neighbours, or of none."""
        return self if neighbours is self.neighbours else self.changed(neighbours=neighbours)

    def with_guide(self, guide: ArrayLike | Guide | None) -> Self:
        """Return the frame with another guide, or with none."""
        return self if guide is self.guide else self.changed(guide=None if guide is None else as_guide(guide))

    def to_open3d(self) -> Any:
        """Return colour and depth [m] as an `open3d.geometry.RGBDImage`, with 0 for missing depth.

        Raises
        ------
        ExportError
            If Open3D is not installed (extra `app`).
        """
        return image_of(self.rgb, self.depth)

    def open3d_camera(self) -> Any:
        """Return the intrinsics as an `open3d.camera.PinholeCameraIntrinsic`.

        Raises
        ------
        InputError
            If they are unknown.
        ExportError
            If Open3D is not installed (extra `app`).
        """
        if self.intrinsics is None:
            raise InputError("The camera's intrinsics are unknown: create the frame with intrinsics=.")
        height, width = self.shape
        return load_open3d().camera.PinholeCameraIntrinsic(width, height, *self.intrinsics.numbers)

    @classmethod
    def from_open3d(
        cls, image: Any, intrinsics: Any = None, *, depth_units: float | None = None, name: str = "frame"
    ) -> Self:
        """Create a frame from an RGBDImage of `open3d.geometry` or `open3d.t.geometry`.

        Parameters
        ----------
        image : RGBDImage
            With uint8 colour, and depth.
        intrinsics : PinholeCameraIntrinsic, Camera or array_like, optional
            An array is a 3 x 3 camera matrix.
        depth_units : float, optional
            Units per metre of the image's depth; required for integers, 1 (metres) by default for floats.
        name : str
            Name of the frame.

        Raises
        ------
        InputError
            If the image has no colour, the units of its depth are missing, or as `RGBDFrame` does.
        """
        rgb, depth = arrays_of(image, depth_units)
        return cls(rgb, depth, camera_of_open3d(intrinsics), name)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width [px]."""
        return self.depth.shape[0], self.depth.shape[1]

    @cached_property
    def known(self) -> NDArray[np.bool_]:
        """Pixels with depth, measured or from neighbours, bool (H, W)."""
        return frozen(np.isfinite(self.depth))

    @property
    def edge_rgb(self) -> NDArray[np.uint8]:
        """Colour for whatever looks for edges in it, uint8 (H, W, 3): `rgb`, smooth where colour sees nothing."""
        return self.rgb if self.brought is None else self.brought.edge_rgb

    @property
    def own(self) -> NDArray[np.bool_]:
        """Pixels with depth that the frame itself has measured, without invalid depth, bool (H, W)."""
        return self.known if self.from_neighbours is None else self.known & ~self.from_neighbours

    @property
    def trusted(self) -> NDArray[np.bool_]:
        """Pixels whose own depth can serve as ground truth, bool (H, W): all but those of the invalid marker."""
        if self.invalid_marker is None:
            return self.own
        return self.own & ~np.isclose(self.measured, self.invalid_marker, rtol=1e-6, atol=0)

    @property
    def own_depth(self) -> NDArray[np.float32]:
        """Depth [m] that the frame itself has measured, without invalid depth, (H, W); NaN = missing."""
        if self.from_neighbours is None:
            return self.depth
        return np.where(self.from_neighbours, np.float32(np.nan), self.depth)

    @property
    def missing(self) -> NDArray[np.bool_]:
        """Pixels without measured depth that the depth camera could see, bool (H, W): all without measured depth if its
        view is unknown."""
        return ~self.own if self.outside_view is None else ~(self.own | self.outside_view)

    def unfilled_mask(self, outside_view: bool = False) -> NDArray[np.bool_] | None:
        """Return the pixels, bool (H, W), that stay missing: those outside the depth camera's view, unless requested.

        This is decided only here. None if there are no such pixels.
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
    """Return the frame passed by a caller; raise InputError for other types, such as an array of colour."""
    remedy = "make one by ilf.RGBDFrame(rgb, depth), or read one by ilf.load_frame."
    check_kind(frame, RGBDFrame, "The first argument must be an ilf.RGBDFrame", remedy)
    return frame


def check_same_size(rgb: NDArray[np.generic], depth: NDArray[np.generic]) -> None:
    """Raise InputError if colour and depth have different heights or widths."""
    remedy = (
        "Both must have the same pixels: register and resize one to the other first; files are registered if the "
        "intrinsics of both are given (--depth-intrinsics)."
    )
    check_shape("Colour", rgb.shape[:2], depth.shape, "depth", remedy)


def check_depth_scale(depth: NDArray[np.floating], *, in_file: bool = True) -> float:
    """Return the median of the known depth [m]; raise InputError if there is none or it cannot be in metres.

    Parameters
    ----------
    depth : ndarray
        Depth [m], NaN = missing.
    in_file : bool
        Whether it was read from a file, whose units per metre may be wrong; else it is an array of the caller.
    """
    known = depth[np.isfinite(depth)]
    if known.size == 0:
        raise InputError("The depth image has no known pixel. Check that this is the raw depth file.")
    median = float(np.median(known))
    low, high = MEDIAN_DEPTH_RANGE
    if not low <= median <= high:
        outside = f"The median depth would be {median:.4g} m, outside {low:g}-{high:g} m. "
        if not in_file:
            raise InputError(f"{outside}Depth must be in metres: divide it, such as depth / 1000.0 for millimetres.")
        direction, other = ("larger", " Estimates of MiDaS are inverse depth.") if median > high else ("smaller", "")
        raise InputError(
            f"{outside}The depth units or the encoding are probably wrong: try a {direction} number of file units per "
            f"metre (1000 for millimetres, 100 for centimetres, 5000 for TUM, 10000 for 0.1 mm, 1 for metres).{other}"
        )
    _check_extremes(known)
    return median


def _check_extremes(known: NDArray[np.floating]) -> None:
    """Raise InputError for impossible depth [m], whose squares would exceed float32."""
    low, high = DEPTH_LIMITS
    absurd = known[(known < low) | (known > high)]
    if absurd.size:
        missing = "Mark missing depth with 0 or NaN."
        raise InputError(f"Depth of {absurd[0]:g} m is impossible: it must be {low:g} to {high:g} m. {missing}")


def scale_warning(depth: NDArray[np.floating], units: float) -> str:
    """Return a plausibility warning if the depth scale is possible but unusual, and common units would make it usual.

    Parameters
    ----------
    depth : ndarray
        Depth [m] with some known pixels, NaN = missing.
    units : float
        File units per metre that it was read with.

    Returns
    -------
    str
        "" if the scale is plausible.
    """
    nearest, median = map(float, np.nanquantile(depth, (0.01, 0.5)))
    (low, high), is_far = USUAL_MEDIAN_DEPTH, nearest > _USUAL_NEAREST[1]
    what = f"Depth from {nearest:.2f} m on, with a median of {median:.2f} m,"
    if not low <= median <= high:
        what, is_far = f"A median depth of {median:.2f} m", median > high
    elif not is_far and nearest >= _USUAL_NEAREST[0]:
        return ""
    others = (*COMMON_DEPTH_UNITS, *(() if is_far else _LARGE_UNITS))
    likelier = [other for other in others if (other > units if is_far else other < units)]
    fitting = [other for other in likelier if low <= median * units / other <= high]
    if not fitting:
        return ""
    if units == 1:  # floats, which Unreal has in centimetres
        fitting = [fitting[0], *([_LARGE_UNITS[1]] if low <= median / _LARGE_UNITS[1] <= high else [])]
    (first, depth), *more = ((other, median * units / other) for other in fitting)
    told = "".join(f", with {other:g} {length:.2f} m" for other, length in more)
    return f"{what} is unusual for a depth camera; with {first:g} units per metre it would be {depth:.2f} m{told}."


def checked_colour(rgb: ArrayLike) -> NDArray[np.uint8]:
    """Return read-only colour, uint8 (H, W, 3); raise InputError if it is not colour or grey, of uint8 or of float from
    0 to 1.

    Examples
    --------
    >>> checked_colour([[0.0, 0.5, 1.0]])[0].tolist()
    [[0, 0, 0], [128, 128, 128], [255, 255, 255]]
    """
    array = without_mask(rgb)
    if array.ndim == 2:
        array = array[..., None]
    if array.ndim != 3 or array.shape[2] not in (1, 3) or (array.dtype != np.uint8 and array.dtype.kind != "f"):
        given = f"{array.dtype} with shape {np.shape(rgb)}"
        raise InputError(f"Colour must be uint8, or float from 0 to 1, with shape (H, W, 3) or (H, W), not {given}.")
    if array.dtype.kind == "f":
        if array.size and not (array.min() >= 0 and array.max() <= 1):
            given = f"{array.min():g} and {array.max():g}"
            raise InputError(f"Float colour must lie between 0 and 1, not {given}: divide it by its possible maximum.")
        array = np.round(255 * array).astype(np.uint8)
    if array.shape[2] == 1:
        array = np.repeat(array, 3, axis=2)
    return read_only(array)  # results that depend on it alone are then computed once for all frames that share it


def checked_depth(depth: ArrayLike) -> NDArray[np.float32]:
    """Return read-only depth [m], NaN = missing; raise InputError if it is not an image of real numbers."""
    with np.errstate(over="ignore"):
        metres = real_image(depth, "Depth").astype(np.float32)
    metres[~(np.isfinite(metres) & (metres > 0))] = np.nan
    return frozen(metres)


def _checked_ground_truth(ground_truth: ArrayLike, shape: tuple[int, int]) -> NDArray[np.float32]:
    with told_as(InputError, "The ground truth cannot be used: {error}", InputError):
        metres = checked_depth(ground_truth)
    check_shape("The ground truth", metres.shape, shape)
    if not np.isfinite(metres).any():
        raise InputError("The ground truth has no known pixel (all are zero, negative or not finite).")
    with told_as(InputError, "The ground truth cannot be used: {error}", InputError):
        check_depth_scale(metres, in_file=False)
    return metres
