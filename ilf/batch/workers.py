"""Completing the frames of a batch in processes of this machine or on a Dask cluster."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from .._runtime.children import run_in_processes
from .._runtime.files import read_json
from .._runtime.installation import optional
from .._runtime.schema import Section
from .._runtime.threads import available_cores
from ..errors import IlfError, InputError
from .frame_record import FRAME_FILE, FrameOutcome, FrameStatus
from .frames import BatchFrame
from .task import Task, complete_frame, failure, tidy, write_record

Outcomes = Generator[FrameOutcome, None, None]

CRASHED = (
    "The process crashed twice, the second time with no other frame in parallel. Memory may have run out, or the frame "
    "makes a library crash."
)
"""Message of a frame whose process has crashed repeatedly."""


def complete_locally(task: Task, frames: Sequence[BatchFrame], jobs: int = 1) -> Outcomes:
    """Complete frames in separate processes, and yield their outcomes in order of completion.

    A frame whose process crashes is tried once more at the end, alone; if it crashes again, the frame has failed. When
    this generator ends or is closed, the processes have ended, and unfinished frames have left no files.

    Parameters
    ----------
    task : Task
    frames : sequence of BatchFrame
    jobs : int
        Number of processes, which share the cores.

    Raises
    ------
    IlfError
        As `complete_frame`, for errors that affect all frames.
    """
    work = partial(complete_frame, task, threads=max(available_cores() // jobs, 1))
    for frame, outcome in run_in_processes(work, frames, jobs=jobs, tidy=partial(tidy, task)):
        yield record_crash(task, frame) if outcome is None else outcome


def record_crash(task: Task, frame: BatchFrame) -> FrameOutcome:
    """Record that the process of a frame has crashed repeatedly."""
    record = failure(task, frame, CRASHED)
    write_record(task, frame, record)
    return record.outcome


def complete_on_cluster(task: Task, frames: Sequence[BatchFrame], address: str) -> Outcomes:
    """Complete frames on a Dask cluster, and yield their outcomes in order of completion.

    Only frames' names and outcomes are sent; the workers read and write the files, and written frames are not
    completed again if a worker is lost. Frames that Dask gives up are completed here at the end, one after the other,
    each in its own process.

    Parameters
    ----------
    task : Task
    frames : sequence of BatchFrame
    address : str
        Address of the scheduler, or its scheduler file.

    Raises
    ------
    InputError
        As `run_on_cluster`, or if its workers do not share the folder of the results.
    IlfError
        As `run_on_cluster` and `complete_frame`.
    """
    again = []
    for frame, outcome in run_on_cluster(partial(_on_worker, task), frames, address):
        if outcome is None:
            again.append(frame)
            continue
        _check_shared(task, outcome)
        yield outcome
    yield from complete_locally(task, again)


def _check_shared(task: Task, outcome: FrameOutcome) -> None:
    """Raise InputError if the files that a worker has written are not visible here."""
    path = Path(task.folder, outcome.folder, FRAME_FILE)
    if outcome.status is FrameStatus.COMPLETED and not path.exists():
        raise InputError(f"A worker has completed {outcome.frame}, but {path} is missing here. {SHARED_FOLDER}")


def _on_worker(task: Task, frame: BatchFrame) -> FrameOutcome:
    return complete_frame(task, frame, threads_of_worker())


# Work on many items on the workers of a Dask cluster.

SHARED_FOLDER = "Use an output folder that all machines share under the same path."
"""What the user can do if a worker does not see the folder."""

_CONNECT_TIMEOUT_S = 30
"""Timeout of the connection to the scheduler [s]."""

Item = TypeVar("Item")
Result = TypeVar("Result")


def run_on_cluster(
    work: Callable[[Item], Result], items: Sequence[Item], address: str
) -> Generator[tuple[Item, Result | None], None, None]:
    """Yield every item with its result, in the order in which they finish; None for items that Dask gives up because
    several of their workers have crashed, which another item may have caused.

    When this generator is closed, items that no worker has started are cancelled.

    Parameters
    ----------
    work : callable
        At the top level of a module, so that workers find it; exceptions that it raises are raised here.
    items : sequence
    address : str
        Address of the scheduler, or its scheduler file.

    Raises
    ------
    InputError
        If `distributed` is not installed (extra `cluster`), or there is no scheduler.
    IlfError
        If the connection to the scheduler is lost.
    """
    distributed = optional("distributed", "ilf-studio[cluster]", "A batch on several machines")
    try:
        with _without_dask_log(), _client(distributed, address) as client:
            futures = {client.submit(work, item, pure=False): item for item in items}
            try:
                for future in distributed.as_completed(list(futures), loop=client.loop):
                    item = futures.pop(future)
                    try:
                        result = future.result()
                    except distributed.KilledWorker:
                        result = None
                    finally:
                        future.release()
                    yield item, result
            finally:
                client.cancel(list(futures))
    except (CancelledError, distributed.comm.CommClosedError) as error:
        raise IlfError(
            f"The connection to the Dask scheduler at {address} was lost. What is finished is kept: start the same "
            "command again to resume."
        ) from error


def threads_of_worker() -> int:
    """Return the number of cores for a task on a worker of a cluster, which shares them among its threads."""
    from distributed import get_worker

    return max(available_cores() // get_worker().state.nthreads, 1)


def check_wanted() -> None:
    """End the task of this worker without a result if nobody waits for it any more, or the worker is to end."""
    from distributed import Reschedule, get_worker
    from distributed.core import Status

    worker = get_worker()
    state = worker.state.tasks.get(worker.get_current_task())
    if state is None or state.state == "cancelled" or worker.status in (Status.closing_gracefully, Status.closing):
        raise Reschedule


@contextmanager
def _without_dask_log() -> Iterator[None]:
    """Suppress Dask's log within the block; its exceptions contain the same messages."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    levels = [logger.level for logger in loggers]
    try:
        for logger in loggers:
            logger.setLevel(logging.CRITICAL + 1)
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


def scheduler_address(address: str) -> str:
    """Return an address, read from the scheduler file if it is one; raises FormatError for any other file."""
    if not os.path.isfile(address):
        return address
    content = read_json(address)
    found: str = Section(f"file {address}", content if isinstance(content, dict) else {}).get("address", str)
    return found


def _client(distributed: Any, address: str) -> Any:
    found = scheduler_address(address)
    try:
        if "://" not in found or found.startswith(("tcp://", "tls://")):
            distributed.comm.get_address_host_port(found)  # a client with an invalid address takes a minute to close
        return distributed.Client(found, timeout=_CONNECT_TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"There is no Dask scheduler at {address} ({' '.join(str(error).split())}). Start one with `dask "
            "scheduler`, and give its address or its scheduler file (--scheduler-file)."
        ) from error
