"""Frames of a batch, shared by processes of this machine."""

from __future__ import annotations

import logging
import os
from collections.abc import Generator, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from .._runtime.files import read_json
from .._runtime.installation import optional
from .._runtime.processes import done_apart
from .._runtime.schema import Section
from .._runtime.threads import available_cores
from ..errors import IlfError, InputError
from .frame_record import FRAME_FILE, FrameOutcome, FrameStatus
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


# Frames of a batch, shared by the workers of a Dask cluster, which see the same folders.

_PATIENCE_S = 30
"""How long is waited for the scheduler."""


def outcomes_on_cluster(task: Task, frames: Sequence[BatchFrame], address: str) -> Outcomes:
    """Complete frames on a Dask cluster, and tell what came of each, in the order of their ends.

    Only frames' names and outcomes travel; files are read and written by the workers, and what one of them has written
    is not done again when it is lost. Dask gives a frame up when so many workers have died that had it, which may have
    been another's fault: such frames are completed here at the end, one after the other, each in a process of its own.

    Parameters
    ----------
    task : Task
    frames : sequence of BatchFrame
    address : str
        Of the scheduler, or the file that it has written its address to.

    Raises
    ------
    InputError
        If `distributed` is not installed (extra `cluster`), there is no scheduler, or its workers do not see the folder
        of the results.
    IlfError
        If the connection to the scheduler is lost; and as `complete_frame` does.
    """
    distributed = optional("distributed", "cluster", "A batch on several machines")
    try:
        with _without_its_log(), _client(distributed, address) as client:
            again = yield from _given_up(distributed, client, task, frames)
    except (CancelledError, distributed.comm.CommClosedError) as error:
        raise IlfError(
            f"The connection to the Dask scheduler at {address} was lost. Frames that are done stay: start the same "
            "command again to resume."
        ) from error
    yield from outcomes_here(task, again)


@contextmanager
def _without_its_log() -> Iterator[None]:
    """Within the block, Dask does not log what its exceptions tell as well."""
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
    """An address, or what the file of that name has; raises FormatError if a scheduler has not written that."""
    if not os.path.isfile(address):
        return address
    content = read_json(address)
    found: str = Section(f"file {address}", content if isinstance(content, dict) else {}).get("address", str)
    return found


def _client(distributed: Any, address: str) -> Any:
    found = scheduler_address(address)
    try:
        if "://" not in found or found.startswith(("tcp://", "tls://")):
            distributed.comm.get_address_host_port(found)  # a client of no address waits for a minute when it ends
        return distributed.Client(found, timeout=_PATIENCE_S, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(
            f"There is no Dask scheduler at {address} ({' '.join(str(error).split())}). Start one by `dask scheduler`, "
            "and give its address, or the file that --scheduler-file has it write."
        ) from error


def _given_up(
    distributed: Any, client: Any, task: Task, frames: Sequence[BatchFrame]
) -> Generator[FrameOutcome, None, list[BatchFrame]]:
    """Have frames completed; returns those that Dask has given up."""
    again = []
    futures = {client.submit(_on_worker, task, frame, pure=False): frame for frame in frames}
    try:
        for future in distributed.as_completed(list(futures), loop=client.loop):
            frame = futures.pop(future)
            try:
                outcome = future.result()
            except distributed.KilledWorker:
                again.append(frame)
                continue
            finally:
                future.release()
            _check_shared(task, outcome)
            yield outcome
    finally:
        client.cancel(list(futures))
    return again


def _check_shared(task: Task, outcome: FrameOutcome) -> None:
    """InputError if what a worker has written is not to be seen here."""
    path = Path(task.folder, outcome.folder, FRAME_FILE)
    if outcome.status is FrameStatus.COMPLETED and not path.exists():
        raise InputError(
            f"A worker has completed {outcome.frame}, but {path} is not there: the folder of the results must be one "
            "that all machines share, under the same path."
        )


def _on_worker(task: Task, frame: BatchFrame) -> FrameOutcome:
    """Done by the cluster's workers, each of whose threads has its share of the cores."""
    from distributed import get_worker

    return complete_frame(task, frame, max(available_cores() // get_worker().state.nthreads, 1))
