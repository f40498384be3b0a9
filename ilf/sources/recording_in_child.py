"""A recording that is open in a child process, which a damaged file may crash, exhaust or block."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, TypeVar

import numpy as np
from numpy.typing import NDArray

from .._runtime.children import MEMORY, Child, end, release, run_in_child
from .._runtime.long_work import not_cancelled
from ..data.camera import Cameras
from ..errors import IlfError
from .pairing import MAX_TIME_GAP_S
from .recording import RecordedFrame, Recording, RecordingIndex, Topics

SECONDS, BYTES_PER_SECOND = 7.5, 2**25
"""Limit of the processor time of each answer [s], and what a second more is allowed for."""
LEAST_MEMORY, MEMORY_PER_BYTE = 640 * 2**20, 2
"""Limit of the memory of each answer [bytes], and what a byte of the files adds to it, up to the limit of children."""

P = ParamSpec("P")
T = TypeVar("T")


class RecordingInChild(Recording):
    """A recording that a child opens at the first question, and keeps open. Only listing the frames, which may take
    long, ends the child when the work is cancelled.

    Parameters
    ----------
    kind : type of Recording
        What opens it there.
    path : Path
    """

    def __init__(self, kind: type[Recording], path: Path) -> None:
        super().__init__(path)
        self.kind, self.has_topics, self._type = kind.kind, kind.has_topics, kind
        self._children: list[Child] = []
        weakref.finalize(self, end, self._children)
        files = path.iterdir() if path.is_dir() else [path]
        size = sum(file.stat().st_size for file in files if file.is_file())  # not of links that lead nowhere
        self._seconds = SECONDS + size // BYTES_PER_SECOND
        self._memory = min(LEAST_MEMORY + size * MEMORY_PER_BYTE, MEMORY)

    def index(self, max_gap: float = MAX_TIME_GAP_S, topics: Topics | None = None) -> RecordingIndex:
        return self._answer(Recording.index, max_gap, topics)

    def frame(self, key: str) -> RecordedFrame:
        return self._answer(Recording.frame, key)

    def cameras(self, key: str) -> Cameras:
        return self._answer(Recording.cameras, key)

    def pose(self, key: str) -> NDArray[np.float64] | None:
        return self._answer(Recording.pose, key)

    def colour(self, key: str) -> NDArray[np.uint8]:
        return self._answer(Recording.colour, key)

    def close(self) -> None:
        with suppress(IlfError), not_cancelled():
            if self._children:
                self._call(_close)
        release(self._children)

    def _answer(self, question: Callable[Concatenate[Recording, P], T], *given: P.args, **_: P.kwargs) -> T:
        """What the recording answers to one of its methods."""
        with nullcontext() if question is Recording.index else not_cancelled():
            return self._call(_answered, self._type, self.path, question, *given)

    def _call(self, function: Callable[..., T], *arguments: Any) -> T:
        return run_in_child(
            function,
            *arguments,
            file=str(self.path),
            seconds=self._seconds,
            memory=self._memory,
            own=self._children,
        )


# The child's side.

_open: dict[Path, Recording] = {}
"""The recording that this process keeps open for its parent."""


def _answered(kind: type[Recording], path: Path, question: Callable[..., T], *arguments: Any) -> T:
    """Open the recording, unless it is open, and ask it."""
    if path not in _open:
        _close()
        _open[path] = kind(path)
    answer: T = getattr(_open[path], question.__name__)(*arguments)
    return answer


def _close() -> None:
    while _open:
        _open.popitem()[1].close()
