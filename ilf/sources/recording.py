"""The base class of recordings: files or folders from which frames are extracted one by one."""

from __future__ import annotations

import hashlib
import os
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent
from ..data.camera import Cameras
from ..errors import InputError
from ..io.encodings import EncodingSpec
from ..io.frame_additions import read_confidence
from .pairing import MAX_TIME_GAP_S, TimedPairs

Topics = tuple[str, str]
"""Names of the colour and the depth topic of one camera, in a recording with several."""

RecordingIndex = tuple[tuple[str, ...], tuple[float, ...], tuple[str, ...]]
"""The frames of a recording: a key for each, in the order of time, which alone identifies it; the times of their colour
[s], empty if not known; and notes for the user, a sentence each."""


@dataclass(frozen=True, eq=False)
class RecordedFrame:
    """A frame as stored in the recording.

    Attributes
    ----------
    rgb : ndarray of uint8, shape (h, w, 3)
        Colour, RGB. For a registered frame it has the size of depth, or another one of the same aspect ratio.
    depth : ndarray, shape (hd, wd)
        Values as stored, of any type and size.
    rgb_sha256, depth_sha256 : str
        Hashes of the bytes with colour and depth of this frame, see `sha256_of`, not of the whole recording: a single
        frame of a large recording is read quickly.
    encoding : str, float or None
        Conversion of values to metres, see `ilf.load_frame`; None if not in the recording.
    invalid : float or None
        The value for missing depth, besides those that always stand for it.
    time : float or None
        Time of its colour [s].
    confidence : ndarray or None
        The sensor's confidence of its depth, shape (hd, wd), for registered frames; larger is more confident.
    depth_view : ndarray of bool or None
        Depth pixels, shape (hd, wd), in which the camera can measure at all; None if in all of them.
    """

    rgb: NDArray[np.uint8]
    depth: NDArray[Any]
    rgb_sha256: str
    depth_sha256: str
    encoding: EncodingSpec | None = None
    invalid: float | None = None
    time: float | None = None
    confidence: NDArray[Any] | None = None
    depth_view: NDArray[np.bool_] | None = None


class Recording(ABC):
    """An open recording. Only one thread at a time uses it: see `opened`.

    All methods report errors in the file as InputError or FormatError with `path` in the message. Any other error of a
    kind that is read `in_child` says that the file is damaged.

    Parameters
    ----------
    path : Path
        Absolute path of a file or a folder.

    Attributes
    ----------
    frames : mapping
        Key -> what its class needs to read the frame, in the order of time.
    times : tuple of float
        Times of the frames' colour [s]; empty if not known.
    notes : tuple of str
        Notes for the user, a sentence each.
    """

    kind: str
    """Name of this kind of recording in messages."""
    suffixes: ClassVar[tuple[str, ...]] = ()
    """Extensions of its files, in lower case."""
    has_topics: bool = False
    """Whether one of several cameras is selected by its topics."""
    in_child: ClassVar[bool] = False
    """Whether a damaged file may crash, exhaust or block its reader, which a child process does then."""

    frames: Mapping[str, Any]
    times: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def fits(cls, path: Path) -> bool:
        """Whether a path looks like this kind of recording, by file names alone."""
        return path.suffix.lower() in cls.suffixes and os.path.isfile(path)

    @classmethod
    def state(cls, path: Path) -> tuple[int, ...]:
        """Modification time and size: a recording is reopened when they change."""
        found = path.stat()
        return found.st_mtime_ns, found.st_size

    def index(self, max_gap: float = MAX_TIME_GAP_S, topics: Topics | None = None) -> RecordingIndex:
        """List the frames. No image is decoded.

        Parameters
        ----------
        max_gap : float
            Maximum time difference [s] of colour and depth of one frame, where they are matched by time; each image is
            used once.
        topics : tuple of str, optional
            Topics of one of several cameras; None selects the most suitable one.
        """
        return tuple(self.frames), self.times, self.notes

    def at(self, key: str) -> Any:
        """What `frames` has for a key; raises InputError if there is no such frame."""
        if key not in self.frames:
            raise self.unknown(key)
        return self.frames[key]

    @abstractmethod
    def frame(self, key: str) -> RecordedFrame:
        """Read a frame; raises InputError if there is none with that key."""

    @abstractmethod
    def cameras(self, key: str) -> Cameras:
        """The cameras of a frame, without decoding it."""

    def pose(self, key: str) -> NDArray[np.float64] | None:
        """The pose of a frame's colour camera, (4, 4), from its points [m] to the world; None if not known."""
        return None

    def colour(self, key: str) -> NDArray[np.uint8]:
        """Read the colour of a frame alone, uint8 (h, w, 3)."""
        return self.frame(key).rgb

    def close(self) -> None:  # noqa: B027 - not all keep files open
        """Close its files."""

    def unknown(self, key: str) -> InputError:
        """The error to raise for a key that no frame has."""
        keys, *_ = self.index()
        there = f"It has {len(keys)}, from {keys[0]} to {keys[-1]}."
        return InputError(f"{self.path} has no frame {key!r:.60}. {there}")


class PairedRecording(Recording):
    """A recording whose colour is paired with depth by time."""

    pairs: TimedPairs[Any]

    def index(self, max_gap: float = MAX_TIME_GAP_S, topics: Topics | None = None) -> RecordingIndex:
        return self.pairs.index(max_gap, self.path)

    def at(self, key: str) -> Any:
        found = self.pairs.find(key)
        if found is None:
            raise self.unknown(key)
        return found


def sha256_of(*parts: bytes) -> str:
    """SHA-256 of concatenated bytes."""
    return hashlib.sha256(b"".join(parts)).hexdigest()


def part_of(name: str, data: bytes) -> FileContent:
    """An image in a recording, with the name that messages have for it."""
    return FileContent(Path(name), np.frombuffer(data, np.uint8))


def confidence_beside(path: Path, shape: tuple[int, int]) -> NDArray[Any] | None:
    """The confidence map of a file; None if there is no such file."""
    return read_confidence(path, shape) if path.is_file() else None
