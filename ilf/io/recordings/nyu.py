"""NYU Depth V2's labelled file (nyu_depth_v2_labeled.mat): frames by their numbers from 1."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...camera import IMAGE_SIZES, INTRINSICS
from ...registration import Camera
from ..nyu_labelled import CAMERA, MAT_SUFFIX, NyuLabelled
from ..time_lists import MOST_APART_S
from .recording import Cameras, RecordedFrame, Recording, RecordingIndex, Topics, registered_cameras, sha256_of


class NyuLabelledFrames(Recording):
    """The file as a recording. Its frames have no truth: what fills the holes of `depths` was not measured."""

    kind = "NYU Depth V2's labelled file"
    suffixes = (MAT_SUFFIX,)

    def __init__(self, path: Path) -> None:
        super().__init__(path)
        self._file = NyuLabelled(path)

    def close(self) -> None:
        self._file.close()

    def index(self, max_gap: float = MOST_APART_S, topics: Topics | None = None) -> RecordingIndex:
        return RecordingIndex(tuple(str(number) for number in range(1, len(self._file) + 1)))

    def frame(self, key: str) -> RecordedFrame:
        rgb, depth = self.colour(key), self._file.measured(self._at(key))
        return RecordedFrame(rgb, depth, sha256_of(rgb.tobytes()), sha256_of(depth.tobytes()), "m")

    def colour(self, key: str) -> NDArray[np.uint8]:
        return self._file.colour(self._at(key))

    def cameras(self, key: str) -> Cameras:
        self._at(key)
        size = IMAGE_SIZES[CAMERA]
        return registered_cameras(Camera(INTRINSICS[CAMERA], size) if size == self._file.size else None)

    def _at(self, key: str) -> int:
        if not key.isdecimal() or not 1 <= int(key) <= len(self._file) or str(int(key)) != key:
            raise self.unknown(key)
        return int(key) - 1
