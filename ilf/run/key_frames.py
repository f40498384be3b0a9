"""Key frames: the depth of blocks at earlier iterations, within a memory budget."""

from __future__ import annotations

import threading
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..completion.block import Watch, block_depth
from ..completion.stepper import Snapshot, Stepper
from ..data.blocks import Block
from ..data.frame import RGBDFrame
from ..data.parameters import Parameters
from ..data.results import IterationRecord
from .run import Run

BUDGET = 64 * 2**20
"""Maximum memory [bytes] of the key frames of one frame."""

MAX_KEY_FRAMES = 64
"""Maximum number of key frames of a block in one run."""


class KeyFrame(NamedTuple):
    """The state of a block after an iteration."""

    record: IterationRecord
    snapshot: Snapshot


class Track:
    """The key frames of one block in one run: of the first iteration, and of every `stride`-th after it.

    The last iteration may be missing: it is the block's result.

    Attributes
    ----------
    block : Block
        The block as it was run.
    stride : int
    nbytes : int
        Memory of all key frames.
    """

    def __init__(self, frame: RGBDFrame, block: Block, parameters: Parameters) -> None:
        self.block = block
        self.stride = 1
        self.nbytes = 0
        self._frame = frame
        self._parameters = parameters
        self._frames: list[KeyFrame] = []

    @property
    def kept(self) -> list[int]:
        """The iterations with key frames, in increasing order."""
        return [record.i for record, _ in self._frames]

    def belongs_to(self, records: Sequence[IterationRecord]) -> bool:
        """Whether it belongs to the iterations with these records."""
        return bool(self._frames) and self._frames[0].record is records[0]

    def add(self, record: IterationRecord, snapshot: Snapshot) -> None:
        """Store an iteration; if there are more than `MAX_KEY_FRAMES`, keep every second."""
        self.nbytes += snapshot.nbytes if self._frames else snapshot.nbytes + snapshot.shared
        self._frames.append(KeyFrame(record, snapshot))
        if len(self._frames) > MAX_KEY_FRAMES:
            self.thin()

    @property
    def can_thin(self) -> bool:
        """Whether there are key frames after the first."""
        return len(self._frames) > 1

    def thin(self) -> None:
        """Drop every second key frame."""
        self.stride *= 2
        # one assignment, since another thread may be reading
        self._frames = [one for one in self._frames if (one.record.i - 1) % self.stride == 0]
        self.nbytes = sum(snapshot.nbytes for _, snapshot in self._frames) + self._frames[0].snapshot.shared

    def at(self, i: int) -> KeyFrame:
        """The key frame of an iteration, or the last one before it."""
        frames = self._frames
        return next((one for one in reversed(frames) if one.record.i <= i), frames[0])

    def depth(self, key_frame: KeyFrame) -> NDArray[np.float32]:
        """The block's depth [m] at a key frame, in the order of `block.mask`'s True values; NaN = missing."""
        return block_depth(self._frame, self.block, key_frame.snapshot.surface(), self._parameters)


class KeyFrames:
    """The key frames of a frame's runs. Thread-safe.

    Snapshots store the filter's internal state and are converted to pixels on demand, so they hardly slow down a run.
    If they exceed the budget, key frames of blocks that have been run again are dropped first; then every second one of
    the blocks with the smallest stride; and last the blocks that were run first.

    Parameters
    ----------
    budget : int
        Maximum memory [bytes].

    Examples
    --------
    >>> import numpy as np
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
    >>> run = ilf.Run(frame, np.ones((20, 30), np.int32))
    >>> key_frames = KeyFrames()
    >>> with run.steps(watch=key_frames.watch(run)) as steps:
    ...     history = [progress.record for progress in steps if progress.record is not None]
    >>> track = key_frames.track(history)
    >>> track.depth(track.at(1)).shape
    (600,)
    """

    def __init__(self, budget: int = BUDGET) -> None:
        self.budget = budget
        self.nbytes = 0
        """Memory of all key frames."""
        self._tracks: list[Track] = []
        self._lock = threading.Lock()

    def watch(self, run: Run) -> Watch:
        """A callback for `Run.steps` that stores the key frames of a run."""
        tracks: dict[int, Track] = {}

        def take(block: Block, record: IterationRecord, stepper: Stepper) -> None:
            track = tracks.get(block.label)
            if track is None:
                track = tracks[block.label] = Track(run.frame, block, run.parameters_of(block.label))
                with self._lock:
                    self._tracks.append(track)
            elif track not in self._tracks or (record.i - 1) % track.stride:
                return
            self._take(track, record, stepper.snapshot())

        return take

    def clear(self) -> None:
        """Drop all."""
        with self._lock:
            self._tracks.clear()
            self.nbytes = 0

    def _take(self, track: Track, record: IterationRecord, snapshot: Snapshot) -> None:
        with self._lock:
            before = track.nbytes
            track.add(record, snapshot)
            self.nbytes += track.nbytes - before
            if self.nbytes > self.budget:
                self._make_room()

    def track(self, records: Sequence[IterationRecord]) -> Track | None:
        """The key frames of the iterations with exactly these records; None if there are none."""
        with self._lock:
            return next((track for track in self._tracks if records and track.belongs_to(records)), None)

    def _make_room(self) -> None:
        """Drop blocks that have been run again since; then thin those with the smallest stride; then drop the blocks
        that were run first, except the last one."""
        while self.nbytes > self.budget:
            latest = {track.block.label: track for track in self._tracks}
            older = [track for track in self._tracks if latest[track.block.label] is not track]
            thick = [track for track in self._tracks if track.can_thin]
            if older:
                self._tracks.remove(older[0])
            elif thick:
                stride = min(track.stride for track in thick)
                for track in thick:
                    if track.stride == stride:
                        track.thin()
            elif len(self._tracks) > 1:
                del self._tracks[0]
            else:
                return
            self.nbytes = sum(track.nbytes for track in self._tracks)


def depth_at_key_frames(
    present: NDArray[np.float32], block_states: Iterable[tuple[Track, KeyFrame]]
) -> NDArray[np.float32]:
    """The depth of a frame with some blocks at a key frame.

    Parameters
    ----------
    present : ndarray of float32, shape (H, W)
        Depth [m] of all other pixels, NaN = missing.
    block_states : iterable of (Track, KeyFrame)
        The blocks' tracks, and their key frames.

    Returns
    -------
    ndarray of float32, shape (H, W)
    """
    depth = present.copy()
    for track, key_frame in block_states:
        depth[track.block.box][track.block.mask] = track.depth(key_frame)
    return depth
