"""Frames of a batch, shared by processes of this machine."""

from __future__ import annotations

from collections import deque
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool

from ..processes import process_pool
from ..threads import available_cores
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
    again: list[BatchFrame] = []
    waiting = deque(frames)
    while waiting:
        again += yield from _until_one_dies(task, waiting, jobs)
    for frame in again:
        if (yield from _until_one_dies(task, deque([frame]), 1)):
            yield died(task, frame)


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


def _until_one_dies(
    task: Task, waiting: deque[BatchFrame], jobs: int
) -> Generator[FrameOutcome, None, list[BatchFrame]]:
    """Take frames until none is waiting, or a process has died; returns those that were under way then."""
    threads = max(available_cores() // jobs, 1)
    under_way: dict[Future[FrameOutcome], BatchFrame] = {}
    try:
        with process_pool(min(jobs, len(waiting))) as pool:
            while waiting or under_way:
                while waiting and len(under_way) < jobs:
                    under_way[pool.submit(complete_frame, task, waiting[0], threads)] = waiting[0]
                    waiting.popleft()
                for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                    outcome = future.result()
                    del under_way[future]
                    yield outcome
    except BrokenProcessPool:
        return list(under_way.values())
    finally:
        for frame in under_way.values():
            tidy(task, frame)
    return []
