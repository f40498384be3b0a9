"""frame.json: what came of a frame of a batch. It is written last, and says whether the set beside it is whole."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

from ..errors import IlfError
from ..frame import RGBDFrame
from ..io import META_NAME
from ..io.atomic import write_bytes
from ..io.files import file_sha256, read_json
from ..io.frame_source import FrameSource
from ..run.options import RECORD_FILE
from ..run.record import PROGRAM, array_sha256
from ..sections import Section

FRAME_FILE = "frame.json"

_PATHS = ("rgb", "depth", "truth", "guide")
"""What a FrameSource has that says where and not how: it may change when a data set is moved."""


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
        Pixels without depth, in the frame and in its completion.
    outside_view : int or None
        Those of them before that the depth camera could not see.
    expected_error_median, expected_error_p90 : float or None
        Of the filled pixels' expected errors, half and 90 % are at most so large [m].
    hidden_mae, hidden_rmse : float or None
        Errors [m] on known depth that was hidden, where the batch was asked for it.
    truth_mae, truth_rmse : float or None
        Errors [m] of the filled depth against the frame's truth, where it has one.
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


@dataclass(frozen=True)
class FrameRecord:
    """An outcome with all that it follows from.

    Attributes
    ----------
    outcome : FrameOutcome
    settings : str
        `sha256_of` the settings' facts.
    reading : str
        `reading_of` its source.
    content : str or None
        `content_of` the frame; None where it could not be read.
    files : dict
        Path of every file that the frame was read from -> size and time of change [ns], as long as which stay the same
        its content need not be looked at.
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

    def is_whole(self, folder: Path) -> bool:
        """Whether the set is there that it speaks of."""
        there = all((folder / name).exists() for name in self.outputs)
        if self.outcome.status is not FrameStatus.COMPLETED or not there:
            return False
        return self.run is None or file_sha256(folder / RECORD_FILE) == self.run

    def is_of(self, source: FrameSource) -> bool | None:
        """Whether a frame is read as it was, and from the same files; None if only their `content_now` can tell."""
        if self.reading != reading_of(source):
            return False
        return True if self.files == watched(self.files) else None


def read_frame_record(folder: Path) -> FrameRecord | None:
    """The record in a frame's folder; None if there is none that can be read: the frame is completed again then."""
    try:
        data = Section("frame record", read_json(folder / FRAME_FILE))
        outcome = data.get("outcome", dict)
        return FrameRecord(
            FrameOutcome(**{**outcome, "status": FrameStatus(outcome["status"])}),
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
    data = {"program": PROGRAM, **dataclasses.asdict(record)}
    write_bytes(folder / FRAME_FILE, f"{json.dumps(data, indent=2)}\n".encode())


def reading_of(source: FrameSource) -> str:
    """Tells ways to read a frame apart: SHA-256 of all that its source says but for paths."""
    how = {name: value for name, value in vars(source).items() if name not in _PATHS}
    return _sha256(sorted((name, repr(value)) for name, value in how.items()))


def content_of(frame: RGBDFrame) -> str:
    """Tells what was read apart: SHA-256 of the content of a frame's files, and of what was stated of them."""
    inputs, guide = frame.inputs, frame.guide
    facts: list[Any] = [None if guide is None else array_sha256(guide.array), repr(frame.intrinsics)]
    if inputs is not None:
        files = inputs.rgb, inputs.depth, inputs.truth
        facts += [None if file is None else file.sha256 for file in files]
        facts += [inputs.depth_units, inputs.encoding, inputs.invalid]
    return _sha256(facts)


def content_now(source: FrameSource) -> str | None:
    """`content_of` a frame as its files are now; None if it cannot be read."""
    try:
        return content_of(source.load())
    except IlfError:
        return None


def files_of(source: FrameSource, frame: RGBDFrame | None) -> list[str]:
    """Paths of all that a frame is read from; of one that could not be read, those that its source names."""
    paths = [source.rgb, source.depth, source.truth, source.guide]
    if source.depth is None:
        paths.append(os.path.join(source.rgb, META_NAME))
    if frame is not None and frame.inputs is not None:
        inputs = frame.inputs.rgb, frame.inputs.depth, frame.inputs.truth
        paths += [None if file is None else file.path for file in inputs]
    if frame is not None and frame.guide is not None:
        paths.append(frame.guide.path)
    return list(dict.fromkeys(path for path in paths if path is not None))


def watched(paths: Iterable[str]) -> dict[str, list[int]]:
    """Path -> size and time of change [ns], of those that are there."""
    found = {}
    for path in paths:
        try:
            state = os.stat(path)
        except OSError:
            continue
        found[path] = [state.st_size, state.st_mtime_ns]
    return found


def _sha256(facts: Any) -> str:
    return hashlib.sha256(json.dumps(facts).encode()).hexdigest()
