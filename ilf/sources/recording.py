"""What a recording is: frames that lie inside a file or a folder and have to be taken out of it one by one."""

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

from ..data.camera import fitted
from ..errors import InputError
from ..io.encodings import EncodingSpec
from .registration import Camera
from .times import MOST_APART_S, associated

Topics = tuple[str, str]
"""Names of the colour and of the depth images of one camera, in a recording that has several."""


@dataclass(frozen=True)
class RecordingIndex:
    """Which frames a recording has.

    Attributes
    ----------
    keys : tuple of str
        One for each frame, in the order of time. A key alone is enough to find its frame again.
    times : tuple of float
        Of the frames' colour [s]; empty where they are not known.
    notes : tuple of str
        What the user should know, a sentence each.
    """

    keys: tuple[str, ...]
    times: tuple[float, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Cameras:
    """The two cameras of a frame.

    Attributes
    ----------
    colour, depth : Camera or None
        None where it is not known. Of registered frames, `depth` is that of `colour`, in another size perhaps.
    depth_to_colour : ndarray of float64, shape (4, 4), or None
        Takes points [m] of the depth camera to the colour camera; None where it is not known.
    is_registered : bool
        Whether colour and depth show the same pixels, or the same view in two sizes: colour is then brought to the
        pixels of depth.
    """

    colour: Camera | None
    depth: Camera | None
    depth_to_colour: NDArray[np.float64] | None
    is_registered: bool


def scaled_cameras(colour: Camera, size: tuple[int, int]) -> Cameras:
    """Those of a frame whose depth shows the view of its colour, in another size (width, height).

    Raises
    ------
    InputError
        If the two sizes differ in their aspect.
    """
    depth = fitted(colour.intrinsics, colour.size, (size[1], size[0]))
    return Cameras(colour, Camera(depth, size, colour.distortion), np.eye(4), is_registered=True)


def registered_cameras(camera: Camera | None) -> Cameras:
    """Those of a frame whose depth shows the pixels of its colour."""
    return Cameras(camera, camera, np.eye(4), is_registered=True)


@dataclass(frozen=True, eq=False)
class RecordedFrame:
    """A frame as the recording has it.

    Attributes
    ----------
    rgb : ndarray of uint8, shape (h, w, 3)
        Red first. Of a registered frame it has the size of depth, or another of the same aspect.
    depth : ndarray, shape (hd, wd)
        Values as they are stored, whatever type and size they have.
    rgb_sha256, depth_sha256 : str
        Of the very bytes that hold colour and depth of this frame, see `sha256_of`: not of the whole recording, so that
        one frame of a large one is read in no time.
    encoding : str, float or None
        How values become metres, see `ilf.load_frame`; None if the recording does not say.
    invalid : float or None
        The value that stands for missing, beside those that always do.
    time : float or None
        Of its colour [s].
    notes : tuple of str
        What the user should know, a sentence each.
    confidence : ndarray or None
        How sure the sensor was of its depth, shape (hd, wd), of registered frames; the larger, the surer.
    depth_view : ndarray of bool or None
        Pixels of depth, shape (hd, wd), in which the camera can measure at all; None if in all of them.
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
    """A recording that is open. One thread at a time uses it: see `opened`.

    Whatever is wrong with the file is an InputError or a FormatError that names `path`, in all of its methods.

    Parameters
    ----------
    path : Path
        Absolute; a file or a folder.
    """

    kind: ClassVar[str]
    """What such a recording is called in messages."""
    suffixes: ClassVar[tuple[str, ...]] = ()
    """Endings of its files, in lower case."""
    has_topics: ClassVar[bool] = False
    """Whether one of several cameras is chosen by its topics."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @classmethod
    def fits(cls, path: Path) -> bool:
        """Whether what lies at a path looks like such a recording, by names alone."""
        return path.suffix.lower() in cls.suffixes and os.path.isfile(path)

    @classmethod
    def state(cls, path: Path) -> tuple[int, ...]:
        """What is another one once the recording has changed, so that it is opened anew."""
        found = path.stat()
        return found.st_mtime_ns, found.st_size

    @abstractmethod
    def index(self, max_gap: float = MOST_APART_S, topics: Topics | None = None) -> RecordingIndex:
        """Which frames there are. No image is decoded.

        Parameters
        ----------
        max_gap : float
            How far apart in time [s] colour and depth of one frame may be; each is used once.
        topics : tuple of str, optional
            Which of several cameras; None takes the one that suits best.
        """

    @abstractmethod
    def frame(self, key: str) -> RecordedFrame:
        """A frame; raises InputError if there is none of that key."""

    @abstractmethod
    def cameras(self, key: str) -> Cameras:
        """The cameras of a frame, without decoding it."""

    def pose(self, key: str) -> NDArray[np.float64] | None:
        """Where the colour camera of a frame was, (4, 4), from its points [m] to the world's; None if it is not
        known."""
        return None

    def colour(self, key: str) -> NDArray[np.uint8]:
        """The colour of a frame alone, uint8 (h, w, 3)."""
        return self.frame(key).rgb

    def close(self) -> None:  # noqa: B027 - not all keep files open
        """Let go of its files."""

    def unknown(self, key: str) -> InputError:
        """What to raise for a key that no frame has."""
        keys = self.index().keys
        return InputError(f"{self.path} has no frame {key!r:.60}. It has {len(keys)}, from {keys[0]} to {keys[-1]}.")


def sha256_of(*parts: bytes) -> str:
    """SHA-256 of bytes that follow one another."""
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part)
    return digest.hexdigest()


# Images of two streams that belong together by their stamps.

_GAPS = (MOST_APART_S, 0.2, 2.0, 10.0)
"""Largest gaps in time [s] by which a frame is looked for. What is paired by a smaller one is so by a larger, too."""


class StampedPairs:
    """Colour with the depth that is nearest in time, each used once. The key of a pair is the stamp of its colour in
    seconds, with all of its digits.

    Parameters
    ----------
    colours, depths : iterable of int
        Stamps.
    per_second : int
        How many of their units are a second: a power of ten.

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
        """Key -> stamps of colour and depth that lie at most `max_gap` [s] apart, in the order of time."""
        known = self._paired.get(max_gap)
        if known is None:
            colours, depths = (
                [(stamp / self._per_second, str(stamp)) for stamp in stamps] for stamps in (self._colours, self._depths)
            )
            pairs = [(int(colour), int(depth)) for colour, depth in associated(colours, depths, max_gap)]
            known = self._paired[max_gap] = {self._key(colour): (colour, depth) for colour, depth in pairs}
        return known

    def find(self, key: str) -> tuple[int, int] | None:
        """The stamps of colour and depth of a key, however far apart they are; None if there is none."""
        return next((pairs[key] for gap in _GAPS if key in (pairs := self.paired(gap))), None)

    def index(self, max_gap: float, path: Path) -> RecordingIndex:
        """The frames of the recording at `path`; raises InputError if there are none."""
        pairs = self.paired(max_gap)
        if not pairs:
            raise InputError(
                f"{path}: no colour image lies within {max_gap:g} s of a depth image; there are {len(self._colours)} "
                f"and {len(self._depths)}. Allow a larger gap (--max-gap) if they belong together."
            )
        lonely = (("colour", len(self._colours) - len(pairs)), ("depth", len(self._depths) - len(pairs)))
        notes = tuple(
            f"{count} {what} image{'s' * (count != 1)} left out: nothing to go with {max_gap:g} s near."
            for what, count in lonely
            if count
        )
        times = tuple(colour / self._per_second for colour, _ in pairs.values())
        return RecordingIndex(tuple(pairs), times, notes)

    def _key(self, stamp: int) -> str:
        seconds, rest = divmod(stamp, self._per_second)
        return f"{seconds}.{rest:0{self._digits}d}"
