"""What there is of every frame before a batch begins, by the records in its folder."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from ..threads import available_cores
from .apart import done_apart
from .frame_record import FrameOutcome, FrameRecord
from .frames import BatchFrame
from .reading import content_now
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
    records = {frame: task.record_of(frame) for frame in frames}
    same = {frame: record is not None and record.is_of(frame) for frame, record in records.items()}
    doubtful = [frame for frame, record in records.items() if record and record.is_completed and same[frame] is None]
    for frame, content in done_apart(content_now, doubtful, jobs=available_cores()):
        record = records[frame]
        same[frame] = record is not None and content is not None and content == record.content
    return [_state(frame, record, bool(same[frame])) for frame, record in records.items()]


def _state(frame: BatchFrame, record: FrameRecord | None, same: bool) -> FrameState:
    if record is None:
        return FrameState(frame, State.OPEN)
    if record.is_completed:
        return FrameState(frame, State.FINISHED if same else State.CHANGED, record.outcome)
    return FrameState(frame, State.FAILED, record.outcome) if same else FrameState(frame, State.OPEN)
