"""Sources: frames with keys, read one by one."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._runtime.addresses import Address
from .._runtime.files import is_address
from .._runtime.formatting import counted
from ..data.camera import Cameras
from ..data.frame import RGBDFrame
from ..data.guide import Gives
from ..errors import InputError, PathKind, check_kind
from ..io.cameras import IntrinsicsSpec, depth_place, frame_camera, intrinsics_from
from ..io.encodings import EncodingSpec
from .copies import copied
from .frame_folder import frame_folder
from .frame_ref import AS_STATED, FrameRef, ReadingOptions
from .listing import list_frames
from .neighbours import around, with_neighbours
from .opening import opened
from .pairing import MAX_TIME_GAP_S
from .read_images import pose_of_files
from .reading import files_of, read_frame, read_raw_pair
from .recording import Topics
from .registration import RawPair


class Source:
    """Frames of a folder, a data set or a recording. Opening it lists the frames; they are decoded when read.

    `open_source` opens one by keywords; here, the reading options are one object. `len` gives the number of frames,
    iterating reads one after the other, and `source[0]` or `source["key"]` reads one.

    Attributes
    ----------
    path : Path or Address
        Absolute path, or the address: text with the attribute `name`.
    keys : tuple of str
        One for each frame, in the order of time or of names: the path of its colour file in the source, without
        extension, or that of its folder; in a recording, the time of its colour. They do not change unless the files
        do.
    timestamps : tuple of float or None
        Times of the frames [s]; None if not known.
    notes : tuple of str
        Notes for the user, a sentence each.
    is_registered : bool
        Whether colour and depth have the same pixels. Where they do not, recordings are registered on reading, and so
        are image files whose depth intrinsics are known; others are read as they are.
    layout : str
        What the source was recognised as: a layout, a kind of recording, or the way in which its files are matched.

    Examples
    --------
    >>> import ilf
    >>> from ilf._runtime.installation import asset_path
    >>> source = ilf.open_source(asset_path("samples"))
    >>> len(source), source.keys, source[0].shape
    (1, ('room',), (480, 640))
    """

    def __init__(self, path: str | os.PathLike[str], options: ReadingOptions = AS_STATED) -> None:
        self.path = Address(path) if is_address(path) else Path(path).absolute()
        listing = list_frames(path, options)
        self._frames = _by_key(self.path, listing.sources)
        self.keys = tuple(self._frames)
        self.timestamps = listing.times or None
        self.notes = listing.notes
        self.is_registered = listing.is_registered
        self.layout = listing.layout

    def __len__(self) -> int:
        return len(self.keys)

    def __iter__(self) -> Iterator[RGBDFrame]:
        return map(self.read, self.keys)

    def __contains__(self, key: object) -> bool:
        return key in self._frames

    def __getitem__(self, place: int | str) -> RGBDFrame:
        if isinstance(place, str):
            return self.read(place)
        number = operator.index(place)
        if not -len(self) <= number < len(self):
            raise IndexError(f"{self.path} has no frame {number}: it has {len(self)}, from 0 to {len(self) - 1}.")
        return self.read(self.keys[number])

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {str(self.path)!r}: {counted(len(self), 'frame')}>"

    def find(self, name: str) -> str:
        """The key that equals a name, or the only one that ends in it.

        Raises
        ------
        InputError
            If there is none, or more than one.
        """
        if name in self._frames:
            return name
        ending = [key for key in self.keys if key.endswith(f"/{name}")]
        if len(ending) == 1:
            return ending[0]
        if ending:
            raise InputError(f"{len(ending)} frames of {self.path} end in {name!r:.60}: {', '.join(ending[:3])}, ...")
        there = f"It has {len(self)}, from {self.keys[0]} to {self.keys[-1]}."
        raise InputError(f"{self.path} has no frame {name!r:.60}. {there}")

    def ref(self, key: str) -> FrameRef:
        """The location of a frame and its reading options; raises InputError as `find`."""
        return self._frames[self.find(key)]

    def around(self, key: str, reach: int) -> tuple[tuple[FrameRef, ...], tuple[FrameRef, ...]]:
        """The locations of up to `reach` frames before a frame and of as many after it, the nearest first; raises
        InputError as `find`."""
        return around([*self._frames.values()], self.keys.index(self.find(key)), reach)

    def calibration(self, key: str) -> Cameras:
        """The cameras of a frame, without decoding it, unless it is undistorted.

        Raises
        ------
        InputError
            If there is no such frame, or the file with its calibration cannot be read.
        """
        ref = self.ref(key)
        if ref.options.undistort and (ref.frame is None or self.is_registered):
            return Cameras.registered(read_frame(ref).intrinsics)
        camera, depth_camera = (
            frame_camera(given, None)[0] for given in (ref.options.intrinsics, ref.options.depth_intrinsics)
        )
        if depth_camera is not None and ref.frame is None:
            return Cameras(camera, depth_camera, depth_place(ref.options.intrinsics, ref.options.depth_intrinsics)[0])
        if ref.frame is not None and (camera is None or not self.is_registered):
            with opened(ref.rgb) as recording:
                return recording.cameras(ref.frame)
        if camera is None and ref.depth is None:
            with copied(ref) as here:
                camera = intrinsics_from(frame_folder(here.rgb).options.intrinsics)
        return Cameras.registered(camera) if self.is_registered else Cameras(None, camera, None)

    def pose(self, key: str) -> NDArray[np.float64] | None:
        """The pose of a frame's colour camera, (4, 4), from its points [m] to the world; None if not known."""
        ref = self.ref(key)
        if ref.frame is not None:
            with opened(ref.rgb) as recording:
                return recording.pose(ref.frame)
        with copied(ref) as here:
            files = files_of(here)
            return pose_of_files(files, here.options.or_else(files.options))

    def read(self, key: str, *, neighbours: int = 0, neighbour_step: int = 1) -> RGBDFrame:
        """Read a frame; unregistered depth is registered.

        Parameters
        ----------
        key : str
            One of `keys`, or an ending that only one of them has.
        neighbours : int
            Number of frames before it and after it whose depth is added (`with_neighbours`).
        neighbour_step : int
            Their distance: every so many frames.

        Returns
        -------
        RGBDFrame
            Depth [m], NaN = missing; plausibility warnings are in its `notes`, and issued as `DepthWarning`.

        Raises
        ------
        InputError
            If there is no such frame, and as `ilf.load_frame`.
        ExportError
            As `with_neighbours`.
        """
        frame = read_frame(self.ref(key), warn=True)
        if not neighbours:
            return frame
        return with_neighbours(frame, *self.around(key, neighbours * neighbour_step), step=neighbour_step)

    def read_pair(self, key: str) -> RawPair:
        """Read colour and depth of a frame as captured by its two cameras; raises as `read`, and InputError if the
        cameras are not known."""
        return read_raw_pair(self.ref(key))


def open_source(
    path: str | os.PathLike[str],
    *,
    depth_units: float | None = None,
    encoding: EncodingSpec | None = None,
    invalid: float | None = None,
    dataset: str | None = None,
    intrinsics: IntrinsicsSpec | None = None,
    depth_intrinsics: IntrinsicsSpec | None = None,
    undistort: bool | None = None,
    view: str | None = None,
    min_confidence: float | None = None,
    guide_gives: Gives | None = None,
    max_gap: float = MAX_TIME_GAP_S,
    topics: Topics | None = None,
    layout: str | os.PathLike[str] | None = None,
) -> Source:
    """Open a folder of frames, a data set or a recording.

    Paired folders and files, matched by name, number or time; a folder per frame; sequences of TUM, Bonn and ICL-NUIM;
    frames of SUN RGB-D; raw folders of NYU Depth; data sets whose layout is in a table, which TOML files extend: scenes
    of BOP, 7-Scenes, ScanNet, KITTI, VOID, Matterport3D, Hypersim, DREDS, DIODE, TransCG, ClearGrasp, Replica, folders
    of nerfstudio, COLMAP and Open3D. Recordings of ROS 1 (.bag) and
    ROS 2 (a folder, .db3, .mcap), of Azure Kinect and Femto (.mkv) and of RealSense cameras (.bag, .db3); captures of
    Record3D (.r3d), Stray Scanner and ARKitScenes; ScanNet (.sens); the labelled file of NYU Depth (.mat); folders of
    raw pairs with a calibration.json; shards of `ilf batch --shards`, with completed depth.

    Parameters
    ----------
    path : path-like
        Or an address (s3://, gs://, https://, hf://), by fsspec and its driver, which are installed separately: frames
        are read when they are asked for, a recording is copied to the cache as a whole.
    depth_units, encoding, invalid, dataset, intrinsics, depth_intrinsics : optional
    undistort, view, min_confidence, guide_gives : optional
        How the depth of all frames is read, its cameras, the one whose pixels the frames have, its minimum confidence,
        and what the frames' guides give, as for `ilf.load_frame`. None uses the options of the source's layout.
    max_gap : float
        Maximum time difference [s] of colour and depth of one frame, where they are matched by time. Each image is used
        once.
    topics : tuple of str, optional
        Topics of colour and depth, in a ROS recording with several cameras. None selects the most suitable ones,
        aligned depth first, and reports them in `notes`.
    layout : str or path-like, optional
        How the files of a folder are named and read: a text such as "rgb=color/*.jpg depth=depth/*.png units=1000", the
        name of a layout of the table, or a TOML file; see `ilf.sources.layout.Layout`. None recognises the layout.

    Raises
    ------
    InputError
        If there is no such folder, or it contains no frames.
    FormatError
        If its lists, its calibrations or the layout are damaged.
    ParameterError
        If both units and an encoding are given, the minimum confidence is not a number, `max_gap` is not a duration, or
        `topics` are given for a source without topics.
    ExportError
        If a recording at an address cannot be copied to this machine.

    Examples
    --------
    >>> from ilf._runtime.installation import asset_path
    >>> source = open_source(asset_path("samples"))
    >>> len(source), source.keys, source.calibration("room").colour.fx, source.read("room").shape
    (1, ('room',), 525.0, (480, 640))
    >>> for frame in source:
    ...     print(frame)
    <RGBDFrame 'room': 640 x 480 pixels, ...>
    >>> source[0].name == source["room"].name
    True
    """
    check_kind(path, PathKind, "A source is opened by its path", "give a folder of frames, data set or recording.")
    return Source(path, ReadingOptions.from_arguments(locals()))  # the keywords that are reading options


def _by_key(root: Path | Address, sources: Sequence[FrameRef]) -> dict[str, FrameRef]:
    """Frames by key. If a key is taken, it is the colour file's path with extension, or else the depth file's path."""
    found: dict[str, FrameRef] = {}
    for source in sources:
        if source.frame is not None:
            found[source.frame] = source
            continue
        rgb, depth = (_below(root, file) for file in (source.rgb, source.depth or source.rgb))
        stem = rgb.with_suffix("") if source.depth is not None and rgb.name else rgb  # lists may name the folder itself
        names = (root.name if stem == Path(".") else stem.as_posix()), rgb.as_posix(), depth.as_posix()
        key = next((name for name in names if name not in found), None)
        if key is None:
            raise InputError(f"{root} has {source.name} twice, with the same depth file. Leave one of them out.")
        found[key] = source
    return found


def _below(root: Path | Address, path: str) -> Path:
    """A path relative to that of the source."""
    return Path(path[len(root) + 1 :] if isinstance(root, Address) else os.path.relpath(path, root))
