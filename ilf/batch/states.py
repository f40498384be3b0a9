"""What there is of every frame before a batch begins, by the records in its folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from ..threads import available_cores
from .apart import done_apart
from .frame_record import FrameOutcome, FrameRecord, FrameStatus, content_now, read_frame_record
from .frames import BatchFrame
from .task import Task


class State(Enum):
    """Of a frame: not completed with these settings; completed; failed; completed, but its files have changed."""

    OPEN, FINISHED, FAILED, CHANGED = range(4)


@dataclass(frozen=True)
class FrameState:
    """A frame, what there is of it, and what came of it; None where it is open."""

    frame: BatchFrame
    state: State
    outcome: FrameOutcome | None = None


def frame_states(task: Task, frames: Sequence[BatchFrame]) -> list[FrameState]:
    """What there is of some frames. Those whose files look different are read, in processes of their own."""
    records = {frame: _record(task, frame) for frame in frames}
    same = {frame: record is not None and record.is_of(frame.source) for frame, record in records.items()}
    doubtful = [frame for frame, is_same in same.items() if is_same is None and _is_completed(records[frame])]
    for frame, content in done_apart(_content_now, doubtful, jobs=available_cores()):
        record = records[frame]
        same[frame] = record is not None and content is not None and content == record.content
    return [_state(frame, record, bool(same[frame])) for frame, record in records.items()]


def _record(task: Task, frame: BatchFrame) -> FrameRecord | None:
    """Of a frame that failed, or whose set is whole, with these settings."""
    folder = task.folder_of(frame)
    record = read_frame_record(folder)
    if record is None or record.settings != task.sha256:
        return None
    return record if not _is_completed(record) or record.is_whole(folder) else None


def _is_completed(record: FrameRecord | None) -> bool:
    return record is not None and record.outcome.status is FrameStatus.COMPLETED


def _state(frame: BatchFrame, record: FrameRecord | None, same: bool) -> FrameState:
    if record is None:
        return FrameState(frame, State.OPEN)
    if _is_completed(record):
        return FrameState(frame, State.FINISHED if same else State.CHANGED, record.outcome)
    return FrameState(frame, State.FAILED, record.outcome) if same else FrameState(frame, State.OPEN)


def _content_now(frame: BatchFrame) -> str | None:
    return content_now(frame.source)
