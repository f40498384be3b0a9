"""Stored results: completed frames as exports and batches have written them, in folders or in shards."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.addresses import Address
from .._runtime.files import FileContent, is_address, read_file
from .._runtime.folders import folder_at
from .._runtime.formatting import natural
from ..data.camera import Camera
from ..errors import FormatError, InputError, told_as
from ..io.cameras import intrinsics_from
from ..io.depth import read_depth_values
from ..io.encodings import encoding_of
from ..io.images import read_colour, read_mask
from ..sources.copies import spelled
from ..sources.frame_folder import FrameFiles, frame_folder
from ..sources.frame_ref import RECORD_FILE, is_shards
from ..sources.named_places import named_in
from ..sources.opening import is_recording, opened
from ..sources.shards import Shards
from ..sources.trajectories import stated_pose
from . import files
from .record import RunRecord, modes_in, read_record

_CHANGED = "has another size than its depth: it was changed. Complete the frame again."


class StoredResult:
    """A completed frame in a folder, as `write` has written it. Its files are read when they are asked for, once.

    Reading any of them raises InputError if a file is missing, and FormatError if it is damaged, has another size than
    the depth, or is incomplete.

    Parameters
    ----------
    folder : Path

    Attributes
    ----------
    key : str
        The name of its folder, or its key in the shards.
    """

    def __init__(self, folder: Path) -> None:
        self.key, self._folder = folder.name, folder

    def __str__(self) -> str:
        return str(self._folder)

    @property
    def name(self) -> str:
        """Name of the frame."""
        return self.record.name

    @cached_property
    def record(self) -> RunRecord:
        """The record of its run, which a result in a shard does not have."""
        return read_record(self._folder / RECORD_FILE)

    @property
    def intrinsics(self) -> Camera | None:
        """The camera of colour and depth; None if not known."""
        return intrinsics_from(self._files.options.intrinsics)

    @property
    def pose(self) -> NDArray[np.float64] | None:
        """Camera-to-world transform as in `RGBDFrame`, (4, 4); None if not known."""
        return None if self._files.options.pose is None else stated_pose(self._files.options.pose)

    @property
    def keeps_measured(self) -> bool:
        """Whether measured depth was left unchanged: all was completed in the mode "fill"."""
        return modes_in(self._folder / RECORD_FILE) == {"fill"}

    @cached_property
    def rgb(self) -> NDArray[np.uint8]:
        """Colour, uint8 (H, W, 3)."""
        return self._checked("its colour", self._colour())

    @cached_property
    def depth(self) -> NDArray[np.float32]:
        """Completed depth [m], (H, W), NaN = missing."""
        name, units = self._depth_file()
        file = self._file(name)
        if file is None:
            raise InputError(f"{self} has no {name}. Complete the frame again.")
        return encoding_of(units).metres(read_depth_values(file))

    @cached_property
    def expected_error(self) -> NDArray[np.float32] | None:
        """Expected error [m], (H, W), NaN where depth was measured or is missing; None if it was not written."""
        name, units = self._depth_file()
        file = self._file(name.replace("depth", "expected_error"))
        if file is None:
            return None
        return self._checked(file.path.name, encoding_of(units).metres(read_depth_values(file)))

    @cached_property
    def unsupported(self) -> NDArray[np.bool_] | None:
        """Filled pixels that are unsupported by measurements, bool (H, W); None if they were not written."""
        file = self._file(files.UNSUPPORTED)
        return None if file is None else self._checked(file.path.name, read_mask(file))

    @cached_property
    def measured(self) -> NDArray[np.bool_] | None:
        """Pixels whose depth was measured, bool (H, W): those without an expected error; None if that was not
        written."""
        return None if self.expected_error is None else np.isfinite(self.depth) & np.isnan(self.expected_error)

    @property
    def measured_depth(self) -> NDArray[np.float32] | None:
        """Depth [m] before completion, (H, W), NaN = missing; None if it is not known from the result, because the mode
        was fill+denoise or expected errors were not written."""
        if self.measured is None or not self.keeps_measured:
            return None
        return np.where(self.measured, self.depth, np.float32(np.nan))

    def recorded_colour(self, camera: Camera) -> tuple[NDArray[np.uint8], Camera]:
        """Colour at the recorded resolution, which may be larger than that of depth, and its camera.

        Parameters
        ----------
        camera : Camera
            That of depth.
        """
        inputs = self.record.inputs
        if inputs is None or inputs.frame is None:
            return self.rgb, camera
        path = named_in(inputs.rgb.path, self._folder)
        if is_recording(path):
            with opened(path) as recording:
                cameras = recording.cameras(inputs.frame)
                colour = cameras.colour
                if cameras.is_registered and colour is not None and colour.shape != self.depth.shape:
                    return recording.colour(inputs.frame), colour.pinhole
        return self.rgb, camera

    @cached_property
    def _files(self) -> FrameFiles:
        return frame_folder(self._folder)

    def _depth_file(self) -> tuple[str, float]:
        """Name of the file with depth, and its units per metre."""
        return self._files.depth.name, self._files.options.depth_units or 1.0

    def _file(self, name: str) -> FileContent | None:
        """A file of the result; None if it was not written."""
        path = self._folder / name
        return read_file(path) if path.is_file() else None

    def _colour(self) -> NDArray[np.uint8]:
        return read_colour(self._files.rgb)

    def _checked(self, what: str, image: NDArray[Any]) -> NDArray[Any]:
        if image.shape[:2] != self.depth.shape:
            raise FormatError(f"{self}: {what} {_CHANGED}")
        return image


class _ShardResult(StoredResult):
    """A completed frame in a shard."""

    def __init__(self, shards: Shards, key: str) -> None:
        self.key, self._shards = key, shards

    def __str__(self) -> str:
        return f"{self._shards.path}: {self.key}"

    @property
    def name(self) -> str:
        return self.key

    @property
    def intrinsics(self) -> Camera | None:
        camera = self._shards.cameras(self.key).depth
        return None if camera is None else camera.pinhole

    @property
    def pose(self) -> NDArray[np.float64] | None:
        return self._shards.pose(self.key)

    @property
    def keeps_measured(self) -> bool:
        return self._shards.mode == "fill"

    def recorded_colour(self, camera: Camera) -> tuple[NDArray[np.uint8], Camera]:
        return self.rgb, camera

    def _depth_file(self) -> tuple[str, float]:
        return self._shards.depth_file(self.key)

    def _file(self, name: str) -> FileContent | None:
        return self._shards.file(self.key, name)

    def _colour(self) -> NDArray[np.uint8]:
        return self._shards.colour(self.key)


class StoredResults:
    """The results in a folder or in shards: `len` gives their number, `results[0]` one of them. Listing them reads no
    images; no file stays open. They can be pickled.

    Parameters
    ----------
    path : path-like
        A folder written by `ilf complete`; one that contains such folders, as `ilf batch --out` writes it; or one of
        `ilf batch --shards`.

    Attributes
    ----------
    path : Path or Address
        Absolute path, or the address of shards.
    keys : tuple of str
        The names of the folders, in natural order, or the keys of the completed frames in the shards.

    Raises
    ------
    InputError
        If there are no results.
    FormatError
        If the tables of shards are damaged.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Address(path) if is_address(path) else Path(path).absolute()
        if isinstance(self.path, Address):
            self._shards: Shards | None = Shards(spelled(self.path), folder_at(self.path))
        else:
            self._shards = Shards(self.path) if is_shards(self.path) else None
        self._folders = () if self._shards is not None else tuple(map(str, result_folders(path)))
        self.keys = tuple(map(os.path.basename, self._folders) if self._shards is None else self._shards.frames)

    def __len__(self) -> int:
        return len(self.keys)

    def __getitem__(self, number: int) -> StoredResult:
        if self._shards is None:
            return StoredResult(Path(self._folders[number]))
        return _ShardResult(self._shards, self.keys[number])


def has_results(path: str | os.PathLike[str]) -> bool:
    """Whether a folder has shards, a result, or folders with results."""
    try:
        return is_shards(path) or next(_result_folders(Path(path)), None) is not None
    except OSError:
        return False


def result_folders(path: str | os.PathLike[str]) -> list[Path]:
    """The folder itself if it has a result, or the folders with results in it, by name; InputError without any."""
    root = Path(path).absolute()
    with told_as(InputError, f"{root}: cannot be read ({{error}}). Give a folder with results.", OSError):
        found = sorted(_result_folders(root), key=lambda inner: natural(inner.name))
    if not found:
        raise InputError(f"{root} contains no results: no {RECORD_FILE} in it or its folders. Give another folder.")
    return found


def _result_folders(root: Path) -> Iterator[Path]:
    if (root / RECORD_FILE).is_file():
        yield root
        return
    with os.scandir(root) as entries:
        yield from (root / one.name for one in entries if one.is_dir() and (root / one.name / RECORD_FILE).is_file())
