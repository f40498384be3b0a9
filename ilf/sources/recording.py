"""The base class of recordings: files or folders from which frames are extracted one by one."""

from __future__ import annotations

import hashlib
import os
from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import counted
from ..data.camera import Cameras
from ..errors import InputError
from ..io.encodings import EncodingSpec
from .times import MAX_TIME_GAP_S, associated, gap_text

Topics = tuple[str, str]
"""Names of the colour and the depth topic of one camera, in a recording with several."""


@dataclass(frozen=True)
class RecordingIndex:
    """The list of a recording's frames.

    Attributes
    ----------
    keys : tuple of str
        One for each frame, in the order of time. A key alone identifies its frame.
    times : tuple of float
        Times of the frames' colour [s]; empty if not known.
    notes : tuple of str
        Notes for the user, a sentence each.
    """

    keys: tuple[str, ...]
    times: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()


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
    notes : tuple of str
        Notes for the user, a sentence each.
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
    notes: tuple[str, ...] = ()
    confidence: NDArray[Any] | None = None
    depth_view: NDArray[np.bool_] | None = None


class Recording(ABC):
    """An open recording. Only one thread at a time uses it: see `opened`.

    All methods report errors in the file as InputError or FormatError with `path` in the message.

    Parameters
    ----------
    path : Path
        Absolute path of a file or a folder.
    """

    kind: ClassVar[str]
    """Name of this kind of recording in messages."""
    suffixes: ClassVar[tuple[str, ...]] = ()
    """Extensions of its files, in lower case."""
    has_topics: ClassVar[bool] = False
    """Whether one of several cameras is selected by its topics."""

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

    @abstractmethod
    def index(self, max_gap: float = MAX_TIME_GAP_S, topics: Topics | None = None) -> RecordingIndex:
        """List the frames. No image is decoded.

        Parameters
        ----------
        max_gap : float
            Maximum time difference [s] of colour and depth of one frame; each image is used once.
        topics : tuple of str, optional
            Topics of one of several cameras; None selects the most suitable one.
        """

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
        keys = self.index().keys
        there = f"It has {len(keys)}, from {keys[0]} to {keys[-1]}."
        return InputError(f"{self.path} has no frame {key!r:.60}. {there}{self.lack(key)}")

    def lack(self, key: str) -> str:
        """What an image at a key lacks to be a frame, as a sentence after a space; "" if it is not known."""
        return ""


def sha256_of(*parts: bytes) -> str:
    """SHA-256 of concatenated bytes."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return digest.hexdigest()


# Pairing the images of two streams by their time stamps.

_GAPS = (MAX_TIME_GAP_S, 0.2, 2.0, 10.0)
"""Maximum time gaps [s] for finding a frame. Images paired with a smaller gap are also paired with a larger one."""


class StampedPairs:
    """Pairs of colour and the depth nearest in time, each used once. The key of a pair is the time stamp of its colour
    in seconds, with all of its digits.

    Parameters
    ----------
    colours, depths : iterable of int
        Time stamps.
    per_second : int
        Units of the time stamps per second: a power of ten.

    Examples
    --------
    >>> StampedPairs([0, 33], [4, 41], 1000).paired(0.02)
    {'0.000': (0, 4), '0.033': (33, 41)}
    """

    def __init__(self, colours: Iterable[int], depths: Iterable[int], per_second: int) -> None:
        self._colours, self._depths, self._per_second = sorted(colours), sorted(depths), per_second
        self._digits = len(str(per_second)) - 1
        self._paired: dict[float, dict[str, tuple[int, int]]] = {}

    def paired(self, max_gap: float) -> dict[str, tuple[int, int]]:
        """Key -> time stamps of colour and depth that differ by at most `max_gap` [s], in the order of time."""
        known = self._paired.get(max_gap)
        if known is None:
            colours, depths = self._timed()
            pairs = [(int(colour), int(depth)) for colour, depth in associated(colours, depths, max_gap)]
            known = self._paired[max_gap] = {self._key(colour): (colour, depth) for colour, depth in pairs}
        return known

    def find(self, key: str) -> tuple[int, int] | None:
        """The time stamps of colour and depth for a key, with any gap of `_GAPS`; None if there are none."""
        return next((pairs[key] for gap in _GAPS if key in (pairs := self.paired(gap))), None)

    def lack(self, key: str) -> str:
        """As `Recording.lack`."""
        stamp = next((stamp for stamp in self._colours if self._key(stamp) == key), None)
        if stamp is None or not self._depths:
            return ""
        gap = min(abs(stamp - depth) for depth in self._depths) / self._per_second
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
        times = tuple(colour / self._per_second for colour, _ in pairs.values())
        return RecordingIndex(tuple(pairs), times, notes)

    def _timed(self) -> tuple[list[tuple[float, str]], list[tuple[float, str]]]:
        """Times [s] of colours and depths, with their stamps as names."""
        colours, depths = (
            [(stamp / self._per_second, str(stamp)) for stamp in stamps] for stamps in (self._colours, self._depths)
        )
        return colours, depths

    def _key(self, stamp: int) -> str:
        seconds, rest = divmod(stamp, self._per_second)
        return f"{seconds}.{rest:0{self._digits}d}"
