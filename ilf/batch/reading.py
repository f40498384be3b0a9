"""What a frame of a batch is read from: how, from which files, and of what content."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import IlfError
from ..frame import RGBDFrame
from ..io import META_NAME
from ..io.frame_source import FrameSource
from ..run.record import array_sha256
from .frames import BatchFrame

_PATHS = ("rgb", "depth", "truth", "guide")
"""What a FrameSource has that says where and not how: it may change when a data set is moved."""


@dataclass(frozen=True, eq=False)
class Reading:
    """A frame as it was read.

    Attributes
    ----------
    frame : RGBDFrame
    neighbours : tuple of RGBDFrame
        Those that could be read.
    content : str
        Tells what was read apart: SHA-256 of the content of all files, and of what was stated of them.
    files : dict
        Path of every file -> size and time of change [ns], as long as which stay the same its content need not be
        looked at.
    """

    frame: RGBDFrame
    neighbours: tuple[RGBDFrame, ...]
    content: str
    files: dict[str, list[int]]


def read_frame(frame: BatchFrame) -> Reading:
    """Read a frame and its neighbours; raises what `FrameSource.load` does for the frame itself."""
    before = named_files(frame)  # what changes meanwhile is looked at again
    read = frame.source.load()
    neighbours = [_read_or_none(source) for source in frame.neighbours]
    there = [neighbour for neighbour in neighbours if neighbour is not None]
    files = {**watched(path for one in (read, *there) for path in _files_of(one)), **before}
    return Reading(read, tuple(there), _content_of([read, *neighbours]), files)


def content_now(frame: BatchFrame) -> str | None:
    """`Reading.content` as the files are now; None if the frame cannot be read."""
    try:
        return read_frame(frame).content
    except IlfError:
        return None


def reading_of(frame: BatchFrame) -> str:
    """Tells ways to read a frame apart: SHA-256 of all that its sources say but for paths."""
    return _sha256(
        [
            sorted((name, repr(value)) for name, value in vars(source).items() if name not in _PATHS)
            for source in (frame.source, *frame.neighbours)
        ]
    )


def named_files(frame: BatchFrame) -> dict[str, list[int]]:
    """The files that a frame's sources name, as in `Reading.files`."""
    paths: list[str | None] = []
    for source in (frame.source, *frame.neighbours):
        paths += [source.rgb, source.depth, source.truth, source.guide]
        if source.depth is None:
            paths.append(os.path.join(source.rgb, META_NAME))
    return watched(path for path in paths if path is not None)


def watched(paths: Iterable[str]) -> dict[str, list[int]]:
    """Path -> size and time of change [ns], of those that are there."""
    found = {}
    for path in paths:
        try:
            state = os.stat(path)
        except (OSError, ValueError):  # nothing of that name can be there
            continue
        found[path] = [state.st_size, state.st_mtime_ns]
    return found


def _read_or_none(source: FrameSource) -> RGBDFrame | None:
    """A neighbour; a damaged one has no say."""
    try:
        return source.load()
    except IlfError:
        return None


def _content_of(frames: Sequence[RGBDFrame | None]) -> str:
    return _sha256([None if frame is None else _facts(frame) for frame in frames])


def _facts(frame: RGBDFrame) -> list[Any]:
    inputs, guide = frame.inputs, frame.guide
    facts: list[Any] = [None if guide is None else array_sha256(guide.array), repr(frame.intrinsics)]
    if inputs is not None:
        files = inputs.rgb, inputs.depth, inputs.truth
        facts += [None if file is None else file.sha256 for file in files]
        facts += [inputs.depth_units, inputs.encoding, inputs.invalid]
    return facts


def _files_of(frame: RGBDFrame) -> list[str]:
    inputs, guide = frame.inputs, frame.guide
    paths = [] if guide is None or guide.path is None else [guide.path]
    if inputs is not None:
        files = inputs.rgb, inputs.depth, inputs.truth
        paths += [file.path for file in files if file is not None]
    return paths


def _sha256(facts: Any) -> str:
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()
