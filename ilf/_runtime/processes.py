"""Work shared by processes, none of which outlives whoever began it."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Generator, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, as_completed, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from typing import Any, TypeVar

from ..errors import IlfError
from .cancellation import check_stopped
from .temporary_files import discard_unfinished

# How a process notices that whoever began it has ended: a pipe on which nothing is sent closes then.


def live_by(closed: Callable[[], object]) -> None:
    """Called in a process that has just begun: it ends when something returns, or raises EOFError or OSError, as
    reading from a pipe does whose other end is only in the process that began this one."""
    # Ctrl+C reaches every process of a terminal; it is answered once, by whoever began them
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with, args=(closed,), name="ilf-lifeline", daemon=True).start()


def _end_with(closed: Callable[[], object]) -> None:
    with suppress(EOFError, OSError):
        closed()
    discard_unfinished()
    os._exit(1)


_GRACE_S = 0.3
"""What processes are given to take away what they were writing."""

Result = TypeVar("Result")


class _Process(SpawnProcess):
    """A process that does not hear Ctrl+C, as `live_by` has it, from its first moment on."""

    def start(self) -> None:
        """As any process is started; what is blocked here meanwhile stays so there."""
        if not hasattr(signal, "pthread_sigmask"):  # Windows
            super().start()
            return
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class ProcessContext(SpawnContext):
    """How this program has other processes made: anew, with nothing of this one in them."""

    Process = _Process


@contextmanager
def process_pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Processes that take work as long as the block lasts; the values of their futures are had by `result_of`.

    A block that is left by an exception gives up at once what has not been done by then. The processes end, too, if
    this one is killed. What they were writing, they do not leave half done.

    Parameters
    ----------
    jobs : int
        How many there are.
    """
    context = ProcessContext()
    # nothing is ever sent: its other end is only in this process, and closes with it
    lifeline, held = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(jobs, mp_context=context, initializer=live_by, initargs=(lifeline.recv_bytes,))
    others = set(multiprocessing.active_children())
    try:
        yield pool
    except BaseException:
        held.close()
        _end(set(multiprocessing.active_children()) - others)
        raise
    finally:
        held.close()
        pool.shutdown(cancel_futures=True)
        lifeline.close()


def result_of(future: Future[Result]) -> Result:
    """What came of some work that a process of a pool was given.

    Raises
    ------
    IlfError
        If the process has ended instead of doing it.
    Exception
        What the work itself raised.
    """
    try:
        return future.result()
    except (BrokenProcessPool, SystemExit) as error:
        raise IlfError(
            "One of the processes that share the work has ended before its time. Memory may have run out: close other "
            "programs, or take fewer --jobs."
        ) from error


def run_units(
    function: Callable[..., Result],
    units: Sequence[tuple[Any, ...]],
    *,
    jobs: int = 1,
    on_done: Callable[[int], None] | None = None,
) -> list[Result]:
    """What a function makes of every unit, in the units' order.

    Parameters
    ----------
    function : callable
        At the top level of a module, so that other processes find it.
    units : sequence of tuple
        Its arguments, once per unit.
    jobs : int
        Processes that share the units; with 1 all is done in this one.
    on_done : callable, optional
        Called with a unit's number whenever one is done, in any order. What it raises ends the work at once.

    Raises
    ------
    IlfError
        If a process has ended instead of doing its work.
    """
    report = on_done or (lambda number: None)
    results: dict[int, Result] = {}
    if jobs == 1:
        for number, unit in enumerate(units):
            results[number] = function(*unit)
            report(number)
    else:
        with process_pool(jobs) as pool:
            numbers = {pool.submit(function, *unit): number for number, unit in enumerate(units)}
            for done in as_completed(numbers):
                results[numbers[done]] = result_of(done)
                report(numbers[done])
    return [results[number] for number in range(len(units))]


def _end(processes: Collection[BaseProcess]) -> None:
    """See to it that processes end which have lost their lifeline; one that is still being started does not notice."""
    end = time.monotonic() + _GRACE_S
    for process in processes:
        process.join(max(end - time.monotonic(), 0))
    for process in processes:
        process.kill()


# Work on many things in processes of their own, of which one that dies costs only what it was working on.

_POLL_S = 0.05
"""How often is asked whether to go on."""

Item = TypeVar("Item")


def done_apart(
    work: Callable[[Item], Result],
    items: Sequence[Item],
    *,
    jobs: int = 1,
    tidy: Callable[[Item], object] = lambda item: None,
) -> Generator[tuple[Item, Result | None], None, None]:
    """Every thing and what came of it, in the order of their ends; None if its process died.

    What was under way when a process died is begun once more at the end, one thing at a time: what dies then has none
    but itself to blame. When this generator ends or is closed, so have the processes.

    Parameters
    ----------
    work : callable
        At the top level of a module, so that other processes find it; what it raises comes out here.
    items : sequence
    jobs : int
        Processes at a time.
    tidy : callable
        Called here for everything that was under way when its process ended.

    Raises
    ------
    Cancelled
        If the work of this thread is to stop.
    """
    again: list[Item] = []
    waiting = deque(items)
    while waiting:
        again += yield from _until_one_dies(work, waiting, jobs, tidy)
    for item in again:
        if (yield from _until_one_dies(work, deque([item]), 1, tidy)):
            yield item, None


def _until_one_dies(
    work: Callable[[Item], Result], waiting: deque[Item], jobs: int, tidy: Callable[[Item], object]
) -> Generator[tuple[Item, Result], None, list[Item]]:
    """Take things until none is waiting, or a process has died; returns those that were under way then."""
    under_way: dict[Future[Result], Item] = {}
    try:
        with process_pool(min(jobs, len(waiting))) as pool:
            while waiting or under_way:
                while waiting and len(under_way) < jobs:
                    under_way[pool.submit(work, waiting[0])] = waiting[0]
                    waiting.popleft()
                check_stopped()
                for future in wait(under_way, timeout=_POLL_S, return_when=FIRST_COMPLETED).done:
                    result = future.result()
                    yield under_way.pop(future), result
    except BrokenProcessPool:
        return list(under_way.values())
    finally:
        for item in under_way.values():
            tidy(item)
    return []
