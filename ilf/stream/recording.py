"""Recording completed frames: into one MCAP file, or into a folder with a folder for each frame."""

from __future__ import annotations

import os
from contextlib import AbstractContextManager
from pathlib import Path

from ..completion.confidence.expected_error import expected_error
from ..data.frame import RGBDFrame
from ..data.results import Completion
from ..errors import ExportError, InputError
from ..io.depth import write_depth
from ..io.ros_output import DepthRecorder, StampedDepth
from ..run.options import ERROR_FILES
from ..sources.frame_folder import write_frame

MCAP = ".mcap"


def stamped(completion: Completion, stamp: int, *, with_error: bool = True) -> StampedDepth:
    """What is recorded of a completed frame: with its time [ns] and, if wanted, its expected error."""
    frame, error = completion.frame, expected_error(completion) if with_error else None
    return StampedDepth(completion.depth, frame.intrinsics, stamp, frame.rgb, error, frame.pose, frame.name)


class StreamRecorder(AbstractContextManager["StreamRecorder"]):
    """Writes completed frames as they come: after each, the output is complete up to it.

    Parameters
    ----------
    path : path-like
        A file *.mcap, which must not exist, or a folder without frames, created if missing.
    encoding, frame_id : str
        Of an MCAP file, as for `DepthRecorder`.

    Raises
    ------
    ExportError
        If the file exists, the folder is not empty, or it cannot be written.
    InputError
        If the packages rosbags and mcap are missing for an MCAP file.
    """

    def __init__(self, path: str | os.PathLike[str], *, encoding: str = "32FC1", frame_id: str = "camera") -> None:
        self.path = Path(path)
        self.count = 0
        """Number of frames written."""
        self._file: DepthRecorder | None = None
        if self.path.suffix.lower() == MCAP:
            self._file = DepthRecorder(self.path, encoding=encoding, frame_id=frame_id)
        elif self.path.exists() and (not self.path.is_dir() or any(self.path.iterdir())):
            raise ExportError(f"{self.path} already exists and is not an empty folder. Choose another name.")

    def write(self, frame: StampedDepth) -> None:
        """Write a frame; a folder has neither times nor frames without colour. Raises ExportError."""
        if self._file is not None:
            self._file.write(frame)
        elif frame.rgb is None:
            raise InputError(f"{frame.name} has no colour: write it into a recording, not into a folder.")
        else:
            folder = self.path / f"{self.count:06d}"
            write_frame(folder, RGBDFrame(frame.rgb, frame.depth, frame.intrinsics, frame.name, pose=frame.pose))
            if frame.expected_error is not None:
                write_depth(folder / ERROR_FILES["tiff"], frame.expected_error)
        self.count += 1

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; one without frames is removed."""
        if self._file is not None:
            self._file.close()
            if not self.count:
                self.path.unlink()
