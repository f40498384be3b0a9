"""The base class of recordings: files or folders from which frames are extracted one by one."""

from __future__ import annotations

import hashlib
import math
import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent
from .._runtime.formatting import counted
from ..data.camera import Cameras
from ..errors import InputError
from ..io.encodings import EncodingSpec
from ..io.frame_additions import read_confidence
from .times import MAX_TIME_GAP_S, associated, gap_text

Topics = tuple[str, str]
"""Names of the colour and the depth topic of one camera, in a recording with several."""

T = TypeVar("T")


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
        return InputError(f"{self.path} has no frame {key!r:.60}. {there}{self.lack(key)}")

    def lack(self, key: str) -> str:
        """What an image at a key lacks to be a frame, as a sentence after a space; "" if it is not known."""
        return ""


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

    def lack(self, key: str) -> str:
        return self.pairs.lack(key)


def sha256_of(*parts: bytes) -> str:
    """SHA-256 of concatenated bytes."""
    return hashlib.sha256(b"".join(parts)).hexdigest()


def part_of(name: str, data: bytes) -> FileContent:
    """An image in a recording, with the name that messages have for it."""
    return FileContent(Path(name), np.frombuffer(data, np.uint8))


def confidence_beside(path: Path, shape: tuple[int, int]) -> NDArray[Any] | None:
    """The confidence map of a file; None if there is no such file."""
    return read_confidence(path, shape) if path.is_file() else None


# Pairing the images of two streams by their time stamps.

_LARGEST_GAP_S = 10.0
"""Maximum time difference [s] of a frame that is asked for by its key."""


class TimedPairs(Generic[T]):
    """Pairs of colour and the depth nearest in time, each used once.

    Parameters
    ----------
    colours, depths : mapping
        Name -> time [s] and what it stands for. The name of a colour is the key of its frame.

    Examples
    --------
    >>> TimedPairs(stamped([0, 33], 1000), stamped([4, 41], 1000)).paired(0.02)
    {'0.000': (0, 4), '0.033': (33, 41)}
    """

    def __init__(self, colours: Mapping[str, tuple[float, T]], depths: Mapping[str, tuple[float, T]]) -> None:
        self._colours, self._depths = colours, depths

    @cached_property
    def _nearest(self) -> dict[str, tuple[float, str]]:
        """Key -> time [s] from the colour to its depth, and the name of that, in the order of time. A limit of the time
        leaves some out, and changes no other."""
        pairs = associated(*self._timed(), math.inf)
        return {colour: (abs(self._colours[colour][0] - self._depths[depth][0]), depth) for colour, depth in pairs}

    def paired(self, max_gap: float) -> dict[str, tuple[T, T]]:
        """Key -> colour and depth whose times differ by at most `max_gap` [s], in the order of time."""
        return {key: pair for key in self._nearest if (pair := self.find(key, max_gap))}

    def find(self, key: str, max_gap: float = _LARGEST_GAP_S) -> tuple[T, T] | None:
        """Colour and depth for a key; None if there are none."""
        apart, depth = self._nearest.get(key, (math.inf, ""))
        return (self._colours[key][1], self._depths[depth][1]) if apart <= max_gap else None

    def lack(self, key: str) -> str:
        """As `Recording.lack`."""
        if key not in self._colours or not self._depths:
            return ""
        gap = min(abs(self._colours[key][0] - time) for time, _ in self._depths.values())
        return f" Its colour lacks depth: the nearest is {gap:.4g} s away (--max-gap), unless another frame has it."

    def index(self, max_gap: float, path: Path) -> RecordingIndex:
        """List the frames of the recording at `path`; raises InputError if there are none."""
        pairs = self.paired(max_gap)
        if not pairs:
            raise InputError(f"{path}: {gap_text(*self._timed(), max_gap)}")
        unmatched = (("colour", len(self._colours) - len(pairs)), ("depth", len(self._depths) - len(pairs)))
        notes = tuple(
            f"{counted(count, f'{what} image')} left out: no match within {max_gap:g} s."
            for what, count in unmatched
            if count
        )
        return tuple(pairs), tuple(self._colours[key][0] for key in pairs), notes

    def _timed(self) -> tuple[list[tuple[float, str]], list[tuple[float, str]]]:
        """Times [s] and names of colours and depths."""
        colours, depths = ([(time, name) for name, (time, _) in some.items()] for some in (self._colours, self._depths))
        return colours, depths


def stamped(stamps: Iterable[int], per_second: int) -> dict[str, tuple[float, int]]:
    """Images by their time stamps, as `TimedPairs` takes them. A name is the stamp in seconds, with all of its digits.

    Parameters
    ----------
    stamps : iterable of int
    per_second : int
        Units of the time stamps per second: a power of ten.
    """
    digits = len(str(per_second)) - 1
    parts = ((stamp, *divmod(stamp, per_second)) for stamp in stamps)
    return {f"{seconds}.{rest:0{digits}d}": (stamp / per_second, stamp) for stamp, seconds, rest in parts}
