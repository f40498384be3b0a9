"""Sequences of ARKitScenes: folders of colour, depth and confidence, named by time, with cameras and a trajectory."""

from __future__ import annotations

import bisect
import os
import re
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent, read_file
from .._runtime.formatting import counted
from ..data.camera import Camera, Cameras
from ..errors import FormatError, InputError
from ..io.depth import read_depth_values
from ..io.images import image_header, read_colour
from .poses import checked_pose, rows_of
from .recording import RecordedFrame, Recording, RecordingIndex, Topics, confidence_beside
from .times import MAX_TIME_GAP_S, associated, gap_text

_DEPTH, _CONFIDENCE, _TRAJECTORY = "lowres_depth", "confidence", "lowres_wide.traj"
_COLOURS = "lowres_wide", "vga_wide", "wide"
_NAME = re.compile(r"(?:\w{1,40}_)?(\d{1,10}\.\d{1,9})")
_MAX_POSE_GAP_S = 0.002
"""Maximum time difference [s] of a frame and its pose: file names are rounded to milliseconds."""

_Timed = list[tuple[float, str]]


class ARKitScenes(Recording):
    """A sequence of ARKitScenes. Keys are the names of its depth images without extension; confidence is 0 to 2."""

    kind = "a sequence of ARKitScenes"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._colour_folder = next(name for name in _COLOURS if (path / name).is_dir())
        colours, depths = _timed(path / self._colour_folder, ".png"), _timed(path / _DEPTH, ".png")
        if not colours or not depths:
            raise InputError(
                f"{path}: {self._colour_folder} contains {len(colours)} and {_DEPTH} {len(depths)} images with times "
                "as names. Unpack both."
            )
        self._colours, self._depths = colours, depths
        self.frames = {Path(name).stem: time for time, name in depths}
        self._cameras = _timed(path / f"{self._colour_folder}_intrinsics", ".pincam")

    @classmethod
    def fits(cls, path: Path) -> bool:
        return (path / _DEPTH).is_dir() and any((path / name).is_dir() for name in _COLOURS)

    def index(self, max_gap: float = MAX_TIME_GAP_S, topics: Topics | None = None) -> RecordingIndex:
        pairs = associated(self._colours, self._depths, max_gap)
        if not pairs:
            raise InputError(f"{self.path}: {gap_text(self._colours, self._depths, max_gap)}")
        keys = tuple(Path(depth).stem for _, depth in pairs)
        unmatched = len(self._depths) - len(pairs)
        notes = (f"{counted(unmatched, 'depth image')} left out: no colour within {max_gap:g} s.",) if unmatched else ()
        return RecordingIndex(keys, tuple(self.frames[key] for key in keys), notes)

    def frame(self, key: str) -> RecordedFrame:
        colour, depth = self._colour_file(key), read_file(self.path / _DEPTH / f"{key}.png")
        values = read_depth_values(depth)
        return RecordedFrame(
            read_colour(colour),
            values,
            colour.sha256,
            depth.sha256,
            "mm",
            time=self.at(key),
            confidence=confidence_beside(self.path / _CONFIDENCE / f"{key}.png", values.shape),
        )

    def colour(self, key: str) -> NDArray[np.uint8]:
        return read_colour(self._colour_file(key))

    def cameras(self, key: str) -> Cameras:
        colour, depth = self._colour_file(key), read_file(self.path / _DEPTH / f"{key}.png")
        sizes = [image_header(file, file.data.tobytes()) for file in (colour, depth)]
        size, depth_size = ((header.width, header.height) for header in sizes)
        if not self._cameras:
            return Cameras(None, None, np.eye(4), is_registered=True)
        path = self.path / f"{self._colour_folder}_intrinsics" / _nearest(self._cameras, self.at(key))[1]
        try:
            width, height, fx, fy, cx, cy = map(float, read_file(path).data.tobytes().split())
            if (width, height) != size:
                raise ValueError(f"colour is {size[0]} x {size[1]}")
            return Cameras.of_one_view(Camera(fx, fy, cx, cy, size=size), depth_size)
        except (ValueError, InputError) as error:
            raise FormatError(
                f"{path} must contain width height fx fy cx cy of the colour images ({error!s:.200})."
            ) from error

    def pose(self, key: str) -> NDArray[np.float64] | None:
        rows = self._trajectory
        near = np.abs(rows[:, 0] - self.at(key))
        if not rows.size or near.min() > _MAX_POSE_GAP_S:
            return None
        row = rows[near.argmin()]
        to_camera = np.eye(4)
        to_camera[:3, :3], to_camera[:3, 3] = cv2.Rodrigues(row[1:4])[0], row[4:]
        return checked_pose(np.linalg.inv(to_camera).astype(np.float64))

    @cached_property
    def _trajectory(self) -> NDArray[np.float64]:
        """Rows of time, rotation (axis times angle) and translation, world to camera; empty if there is no such
        file."""
        path = self.path / _TRAJECTORY
        if not path.is_file():
            return np.empty((0, 7))
        found = rows_of(path)
        if found.shape[1:] != (7,) or not np.isfinite(found).all():
            raise FormatError(f"{path} must contain seven numbers per line. Download it again.")
        return found

    def _colour_file(self, key: str) -> FileContent:
        return read_file(self.path / self._colour_folder / _nearest(self._colours, self.at(key))[1])


def _timed(folder: Path, suffix: str) -> _Timed:
    """Times [s] and names of a folder's files that have times as names, sorted; empty if there is no such folder."""
    try:
        names = os.listdir(folder)
    except OSError:
        return []
    return sorted(
        (float(found[1]), name)
        for name in names
        if name.endswith(suffix) and (found := _NAME.fullmatch(name.removesuffix(suffix)))
    )


def _nearest(timed: _Timed, time: float) -> tuple[float, str]:
    at = bisect.bisect_left(timed, (time, ""))
    return min(timed[max(at - 1, 0) : at + 1], key=lambda one: abs(one[0] - time))
