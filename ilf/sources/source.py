"""A source: frames that have keys, and are read one by one."""

from __future__ import annotations

import operator
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, Self, overload

import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import counted
from ..data.camera import CameraIntrinsics
from ..data.frame import RGBDFrame
from ..errors import InputError
from ..io.cameras import IntrinsicsSpec, intrinsics_from
from ..io.encodings import EncodingSpec
from .frame_source import FrameSource
from .frames import frame_folder
from .listing import Listing, list_frames
from .opening import opened
from .recording import Cameras, Topics
from .registration import RawPair
from .times import MOST_APART_S

_ONE_CAMERA_NOTE = (
    "How the depth camera stands to the colour camera is not known: both are taken for one, and edges of both may lie "
    "some pixels apart."
)


@dataclass(frozen=True, eq=False)
class Calibration:
    """The two cameras of a frame.

    Attributes
    ----------
    colour, depth : CameraIntrinsics or None
        None where it is not known. Where depth is registered to colour, both are the same.
    depth_to_colour : ndarray of float64, shape (4, 4), or None
        Takes points [m] of the depth camera to the colour camera; None where it is not known.
    colour_distortion, depth_distortion : tuple of float
        Of the lenses, as `ilf.registration.Camera` has it; none where there is none, or it is not known.
    """

    colour: CameraIntrinsics | None
    depth: CameraIntrinsics | None
    depth_to_colour: NDArray[np.float64] | None
    colour_distortion: tuple[float, ...] = ()
    depth_distortion: tuple[float, ...] = ()

    @classmethod
    def of(cls, cameras: Cameras) -> Self:
        """The same of the cameras that a recording tells of."""
        colour, depth = cameras.colour, cameras.depth
        return cls(
            None if colour is None else colour.intrinsics,
            None if depth is None else depth.intrinsics,
            cameras.depth_to_colour,
            () if colour is None else colour.distortion,
            () if depth is None else depth.distortion,
        )


class Source:
    """Frames of a folder, a data set or a recording. Opening it lists them; nothing is decoded until it is read.

    `len` counts the frames, iterating reads one after the other, and `source[0]` or `source["key"]` reads one.

    Attributes
    ----------
    path : Path
        Absolute.
    keys : tuple of str
        One for each frame, in the order of time or of names: the path of its colour file in the source, without ending,
        or that of its folder; in a recording, the time of its colour. They stay the same as long as the files do.
    timestamps : tuple of float or None
        [s]; None where they are not known.
    notes : tuple of str
        What the user should know, a sentence each.
    is_registered : bool
        Whether colour and depth show the same pixels. Where they do not, recordings are registered as they are read;
        images in files are read as they are.
    """

    def __init__(self, path: Path, listing: Listing) -> None:
        self.path = path
        self._frames = _by_key(path, listing.sources)
        self.keys = tuple(self._frames)
        self.timestamps = listing.times or None
        self.notes = listing.notes
        self.is_registered = listing.is_registered

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
        """The key that is called so, or alone ends so.

        Raises
        ------
        InputError
            If there is none, or several.
        """
        if name in self._frames:
            return name
        ending = [key for key in self.keys if key.endswith(f"/{name}")]
        if len(ending) == 1:
            return ending[0]
        if ending:
            raise InputError(f"{len(ending)} frames of {self.path} end in {name!r:.60}: {', '.join(ending[:3])}, ...")
        raise InputError(
            f"{self.path} has no frame {name!r:.60}. It has {len(self)}, from {self.keys[0]} to {self.keys[-1]}."
        )

    def frame_source(self, key: str) -> FrameSource:
        """Where a frame is and how it is read; raises InputError as `find`."""
        return self._frames[self.find(key)]

    def calibration(self, key: str) -> Calibration:
        """The cameras of a frame, without decoding it.

        Raises
        ------
        InputError
            If there is no such frame, or what holds its calibration cannot be read.
        """
        source = self.frame_source(key)
        camera = intrinsics_from(source.intrinsics)
        if source.frame is not None and (camera is None or not self.is_registered):
            with opened(source.rgb) as recording:
                return Calibration.of(recording.cameras(source.frame))
        if camera is None and source.depth is None:
            camera = frame_folder(source.rgb).intrinsics
        return Calibration(camera, camera, np.eye(4)) if self.is_registered else Calibration(None, camera, None)

    def pose(self, key: str) -> NDArray[np.float64] | None:
        """Where the camera of a frame was, (4, 4), from its points [m] to the world's; None where it is not known."""
        source = self.frame_source(key)
        if source.frame is not None:
            with opened(source.rgb) as recording:
                return recording.pose(source.frame)
        return source.files().camera_pose

    @overload
    def read(self, key: str, registered: Literal[True] = True) -> RGBDFrame: ...

    @overload
    def read(self, key: str, registered: Literal[False]) -> RawPair: ...

    def read(self, key: str, registered: bool = True) -> RGBDFrame | RawPair:
        """Read a frame.

        Parameters
        ----------
        key : str
            One of `keys`, or what only one of them ends in.
        registered : bool
            Whether depth is brought to the pixels of colour where it is not there. False gives both as their cameras
            have seen them.

        Returns
        -------
        RGBDFrame, or RawPair if not `registered`
            Depth [m], NaN = missing; what is doubtful about it is in its `notes`, and told by `DepthWarning`.

        Raises
        ------
        InputError
            If there is no such frame, or as `ilf.load_frame` does; of a raw pair, also if its cameras are not known.
        """
        source = self.frame_source(key)
        if registered:
            return source.load(warn=True)
        pair = source.load_pair(warn=True)
        if self.is_registered or source.frame is not None:
            return pair
        return replace(pair, notes=(*pair.notes, _ONE_CAMERA_NOTE))


def open_source(
    path: str | os.PathLike[str],
    *,
    depth_units: float | None = None,
    encoding: EncodingSpec | None = None,
    invalid: float | None = None,
    intrinsics: IntrinsicsSpec | None = None,
    min_confidence: float | None = None,
    max_gap: float = MOST_APART_S,
    topics: Topics | None = None,
) -> Source:
    """Open a folder of frames, a data set or a recording.

    Paired folders and files, matched by name, number or time; a folder per frame; sequences of TUM, Bonn and ICL-NUIM;
    scenes of BOP; frames of SUN RGB-D; sequences of 7-Scenes; raw folders of NYU Depth. Recordings of ROS 1 (.bag) and
    ROS 2 (a folder, .db3, .mcap), of Azure Kinect and Femto (.mkv) and of RealSense cameras (.bag, .db3); captures of
    Record3D (.r3d), Stray Scanner and ARKitScenes; ScanNet (.sens); the labelled file of NYU Depth (.mat); folders of
    raw pairs with a calibration.json.

    Parameters
    ----------
    path : path-like
        See `ilf.io.list_frames`.
    depth_units, encoding, invalid, intrinsics, min_confidence : optional
        How depth is read, which camera has seen it, and how sure it must be, as for `ilf.load_frame`, for all frames.
        None takes what the layout of the source says.
    max_gap : float
        How far apart in time [s] colour and depth of one frame may be, where they are matched by time. Each is used
        once.
    topics : tuple of str, optional
        Those of colour and depth, in a recording of ROS that has several cameras. None takes those that suit best,
        aligned depth first, and says so in `notes`.

    Raises
    ------
    InputError
        If there is no such folder, or it holds no frames.
    FormatError
        If its lists or calibrations are damaged.
    ParameterError
        If there are both units and an encoding, the least confidence is no number, `max_gap` is no length of time, or
        there are `topics` of what has none.

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
    listing = list_frames(
        path,
        depth_units=depth_units,
        encoding=encoding,
        invalid=invalid,
        intrinsics=intrinsics,
        min_confidence=min_confidence,
        max_gap=max_gap,
        topics=topics,
    )
    return Source(Path(path).absolute(), listing)


def _by_key(root: Path, sources: Sequence[FrameSource]) -> dict[str, FrameSource]:
    """Frames by their keys; one whose key is another's already keeps its ending, or has that of its depth file."""
    found: dict[str, FrameSource] = {}
    for source in sources:
        if source.frame is not None:
            found[source.frame] = source
            continue
        files = (Path(os.path.relpath(file, root)).as_posix() for file in (source.rgb, source.depth or source.rgb))
        key = next((name for name in (_key(root, source), *files) if name not in found), None)
        if key is None:
            raise InputError(f"{root} has {source.name} twice, with one and the same depth. Leave one of them out.")
        found[key] = source
    return found


def _key(root: Path, source: FrameSource) -> str:
    path = Path(os.path.relpath(source.rgb, root))
    if source.depth is not None:
        path = path.with_suffix("")
    return root.name if path == Path(".") else path.as_posix()
