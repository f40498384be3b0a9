"""Sequences of ARKitScenes: folders of colour, depth and confidence, named by time, with cameras and a trajectory."""

from __future__ import annotations

import math
import re
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import read_file
from ..data.camera import Camera, Cameras, rigid_transform
from ..errors import FormatError, InputError, told_as
from ..io.depth import read_depth_values
from ..io.images import image_header, read_colour
from .pairing import TimedPairs
from .recording import PairedRecording, RecordedFrame, confidence_beside
from .trajectories import checked_pose

_DEPTH, _CONFIDENCE, _TRAJECTORY = "lowres_depth", "confidence", "lowres_wide.traj"
_COLOURS = "lowres_wide", "vga_wide", "wide"
_NAME = re.compile(r"(?:\w{1,40}_)?(\d{1,10}\.\d{1,9})")
_MAX_POSE_GAP_S = 0.002
"""Maximum time difference [s] of a frame and its pose: file names are rounded to milliseconds."""


class ARKitScenes(PairedRecording):
    """A sequence of ARKitScenes. Keys are the names of its colour images without extension; confidence is 0 to 2."""

    kind = "a sequence of ARKitScenes"

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        folder = next(name for name in _COLOURS if (path / name).is_dir())
        colours, depths = _timed(path / folder, ".png"), _timed(path / _DEPTH, ".png")
        if not colours or not depths:
            found = f"{folder} contains {len(colours)} and {_DEPTH} {len(depths)} images with times as names"
            raise InputError(f"{path}: {found}. Unpack both.")
        self.pairs = TimedPairs(colours, depths)
        self._cameras = _timed(path / f"{folder}_intrinsics", ".pincam")

    @classmethod
    def fits(cls, path: Path) -> bool:
        return (path / _DEPTH).is_dir() and any((path / name).is_dir() for name in _COLOURS)

    def frame(self, key: str) -> RecordedFrame:
        colour, depth = map(read_file, self.at(key))
        values = read_depth_values(depth)
        return RecordedFrame(
            read_colour(colour),
            values,
            colour.sha256,
            depth.sha256,
            "mm",
            time=_time_of(key),
            confidence=confidence_beside(self.path / _CONFIDENCE / depth.path.name, values.shape),
        )

    def cameras(self, key: str) -> Cameras:
        headers = [image_header(file, file.data.tobytes()) for file in map(read_file, self.at(key))]
        size, depth_size = ((header.width, header.height) for header in headers)
        if not self._cameras:
            return Cameras(None, None, np.eye(4), is_registered=True)
        _, path = min(self._cameras.values(), key=lambda timed: abs(timed[0] - _time_of(key)))
        told = f"{path} must contain width height fx fy cx cy of the colour images ({{error}}). Download it again."
        with told_as(FormatError, told, (ValueError, InputError)):
            width, height, fx, fy, cx, cy = map(float, read_file(path).data.tobytes().split())
            if (width, height) != size:
                raise ValueError(f"colour is {size[0]} x {size[1]}")
            return Cameras.of_one_view(Camera(fx, fy, cx, cy, size=size), depth_size)

    def pose(self, key: str) -> NDArray[np.float64] | None:
        rows = self._trajectory
        near = np.abs(rows[:, 0] - _time_of(key))
        if not rows.size or near.min() > _MAX_POSE_GAP_S:
            return None
        row = rows[near.argmin()]
        to_camera = rigid_transform(cv2.Rodrigues(row[1:4])[0], row[4:])
        return checked_pose(np.linalg.inv(to_camera).astype(np.float64))

    @cached_property
    def _trajectory(self) -> NDArray[np.float64]:
        """Rows of time, rotation (axis times angle) and translation, world to camera; empty if there is no such
        file."""
        path = self.path / _TRAJECTORY
        if not path.is_file():
            return np.empty((0, 7))
        with told_as(FormatError, f"{path} must contain seven numbers per line. Download it again.", ValueError):
            lines = read_file(path).data.tobytes().splitlines()
            rows = np.array([line.split() for line in lines if line.strip()], float)
            if rows.shape[1:] != (7,) or not np.isfinite(rows).all():
                raise ValueError
        return rows


def _time_of(key: str) -> float:
    """The time [s] in the name of a file; NaN if there is none."""
    found = _NAME.fullmatch(key)
    return float(found[1]) if found else math.nan


def _timed(folder: Path, suffix: str) -> dict[str, tuple[float, Path]]:
    """A folder's files that have times as names: times [s] and paths by their names without extension; empty if there
    is no such folder."""
    files = sorted(folder.glob(f"*{suffix}"))
    return {file.stem: (time, file) for file in files if math.isfinite(time := _time_of(file.stem))}
