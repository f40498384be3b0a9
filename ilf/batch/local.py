"""Frames of a batch, shared by processes of this machine."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from functools import partial

from ..threads import available_cores
from .apart import done_apart
from .frame_record import FrameOutcome
from .frames import BatchFrame
from .task import Task, complete_frame, failure, tidy, write_record

Outcomes = Generator[FrameOutcome, None, None]


def outcomes_here(task: Task, frames: Sequence[BatchFrame], jobs: int = 1) -> Outcomes:
    """Complete frames in processes of their own, and tell what came of each, in the order of their ends.

    A frame whose process dies is begun once more at the end, with no other beside it; if it dies again, the frame has
    failed. When this generator ends or is closed, so have the processes, and what was under way has left nothing.

    Parameters
    ----------
    task : Task
    frames : sequence of BatchFrame
    jobs : int
        Processes, which share the cores.

    Raises
    ------
    IlfError
        As `complete_frame` does: what keeps all frames from being completed.
    """
    work = partial(complete_frame, task, threads=max(available_cores() // jobs, 1))
    for frame, outcome in done_apart(work, frames, jobs=jobs, tidy=partial(tidy, task)):
        yield died(task, frame) if outcome is None else outcome


def died(task: Task, frame: BatchFrame) -> FrameOutcome:
    """Record that a frame ends whatever process works on it."""
    record = failure(
        task,
        frame,
        "The process that worked on it died, twice, the second time with no other frame beside it. Memory may have run "
        "out, or the frame makes a library crash.",
    )
    write_record(task, frame, record)
    return record.outcome
