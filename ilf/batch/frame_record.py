"""frame.json: what came of a frame of a batch. It is written last, and says whether the set beside it is whole."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

from .._runtime.files import file_sha256, read_json, write_bytes
from .._runtime.schema import Section, check_schema
from ..data.frame import RGBDFrame
from ..errors import IlfError
from ..run.options import RECORD_FILE
from ..run.record import PROGRAM, array_sha256
from ..sources.frame_source import FrameSource
from ..sources.frames import META_NAME
from .frames import BatchFrame
from .settings import SCHEMA

# What a frame of a batch is read from: how, from which files, and of what content.

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


FRAME_FILE = "frame.json"


class FrameStatus(StrEnum):
    """What came of a frame."""

    COMPLETED = "completed"
    FAILED = "failed"


@dataclass(frozen=True)
class FrameOutcome:
    """What came of a frame of a batch, in numbers; None where there is none.

    Attributes
    ----------
    frame : str
        Its key.
    folder : str
        Name of the folder with its results.
    time : float or None
        When it was taken [s].
    status : FrameStatus
    message : str
        Why it failed, or what there is to know of the result.
    seconds : float or None
        How long it took.
    blocks : int or None
    pixels : int or None
        Of the frame.
    missing_before, missing_after : int or None
        Pixels without depth, in the frame and in its completion, without those outside the view.
    outside_view : int or None
        Pixels that the depth camera could not see.
    expected_error_median, expected_error_p90 : float or None
        Of the expected errors of the pixels that blocks have filled, half and 90 % are at most so large [m]: `median`
        and `p90` of `ilf.completion.confidence.expected_error.error_summary`.
    hidden_mae, hidden_rmse : float or None
        Errors [m] on known depth that was hidden, where the batch was asked for it.
    truth_mae, truth_rmse : float or None
        Errors [m] of the filled depth against the frame's truth, where it has one.
    doubts : str
        What speaks against the way that its files are read; "" where nothing does.
    """

    frame: str
    folder: str
    time: float | None
    status: FrameStatus
    message: str = ""
    seconds: float | None = None
    blocks: int | None = None
    pixels: int | None = None
    missing_before: int | None = None
    missing_after: int | None = None
    outside_view: int | None = None
    expected_error_median: float | None = None
    expected_error_p90: float | None = None
    hidden_mae: float | None = None
    hidden_rmse: float | None = None
    truth_mae: float | None = None
    truth_rmse: float | None = None
    doubts: str = ""


@dataclass(frozen=True)
class FrameRecord:
    """An outcome with all that it follows from.

    Attributes
    ----------
    outcome : FrameOutcome
    settings : str
        `sha256_of` the settings' facts.
    reading : str
        `reading_of` the frame.
    content : str or None
        `Reading.content`; None where it failed.
    files : dict
        `Reading.files`.
    run : str or None
        SHA-256 of the set's run.json.
    outputs : tuple of str
        Names of all files of the set.
    """

    outcome: FrameOutcome
    settings: str
    reading: str
    content: str | None = None
    files: dict[str, list[int]] = field(default_factory=dict)
    run: str | None = None
    outputs: tuple[str, ...] = ()

    @property
    def is_completed(self) -> bool:
        """Whether there is a set that it speaks of; otherwise the frame failed."""
        return self.outcome.status is FrameStatus.COMPLETED

    def is_whole(self, folder: Path) -> bool:
        """Whether the set is there that it speaks of."""
        there = all(os.path.exists(folder / name) for name in self.outputs)
        if not self.is_completed or not there:
            return False
        return self.run is None or file_sha256(folder / RECORD_FILE) == self.run

    def is_of(self, frame: BatchFrame) -> bool | None:
        """Whether a frame is read as it was, and from the same files; None if only their `content_now` can tell."""
        if self.reading != reading_of(frame):
            return False
        return True if self.files == watched(self.files) else None


def read_frame_record(folder: Path) -> FrameRecord | None:
    """The record in a frame's folder; None if there is none that can be read: the frame is completed again then."""
    try:
        values = read_json(folder / FRAME_FILE)
        check_schema(values, SCHEMA, "frame record")
        data = Section("frame record", values)
        return FrameRecord(
            FrameOutcome(**data.section("outcome").fields(FrameOutcome)),
            data.get("settings", str),
            data.get("reading", str),
            data.get("content", str, type(None)),
            data.get("files", dict),
            data.get("run", str, type(None)),
            tuple(data.items("outputs", str)),
        )
    except (IlfError, AttributeError, KeyError, TypeError, ValueError):
        return None


def write_frame_record(folder: Path, record: FrameRecord) -> None:
    """Write it into the frame's folder, which is made if need be; raises ExportError as `write_bytes` does."""
    data = {"program": PROGRAM, "schema": SCHEMA, **dataclasses.asdict(record)}
    write_bytes(folder / FRAME_FILE, f"{json.dumps(data, indent=2)}\n".encode())
