"""frame.json: what came of a frame of a batch. It is written last, and says whether the set beside it is whole."""

from __future__ import annotations

import dataclasses
import json
import os
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from ..errors import IlfError
from ..io.atomic import write_bytes
from ..io.files import file_sha256, read_json
from ..run.options import RECORD_FILE
from ..run.record import PROGRAM
from ..sections import Section
from .frames import BatchFrame
from .reading import reading_of, watched

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
        and `p90` of `ilf.confidence.error_summary`.
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
        data = Section("frame record", read_json(folder / FRAME_FILE))
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
    data = {"program": PROGRAM, **dataclasses.asdict(record)}
    write_bytes(folder / FRAME_FILE, f"{json.dumps(data, indent=2)}\n".encode())
