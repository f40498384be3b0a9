"""Pools of worker processes that end with the process that started them."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, as_completed, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager, suppress
from itertools import islice
from multiprocessing.context import SpawnContext, SpawnProcess
from multiprocessing.process import BaseProcess
from typing import Any, TypeVar

from ..errors import IlfError
from .cancellation import check_cancelled
from .temporary_files import remove_temporary_files

# Parent watch: a worker process notices the end of its parent because a pipe on which nothing is sent closes.


def exit_with_parent(closed: Callable[[], object]) -> None:
    """End this process, which has just started, when a function returns, or raises EOFError or OSError, as reading from
    a pipe does whose other end is only in the parent process."""
    # Ctrl+C reaches every process of a terminal; only the parent handles it
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_exit_after, args=(closed,), name="ilf-lifeline", daemon=True).start()


def _exit_after(closed: Callable[[], object]) -> None:
    with suppress(EOFError, OSError):
        closed()
    remove_temporary_files()
    os._exit(1)


_GRACE_S = 0.3
"""Time for processes to remove files that they were writing [s]."""

Result = TypeVar("Result")


class _Process(SpawnProcess):
    """A process that ignores Ctrl+C from its start, before `exit_with_parent` takes effect."""

    def start(self) -> None:
        """Start the process; it inherits the signals that are blocked here meanwhile."""
        if not hasattr(signal, "pthread_sigmask"):  # Windows
            super().start()
            return
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            super().start()
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


class ProcessContext(SpawnContext):
    """Context that spawns fresh processes, which inherit no state from this one."""

    Process = _Process


@contextmanager
def process_pool(jobs: int) -> Iterator[ProcessPoolExecutor]:
    """Provide worker processes for the duration of the block; get the values of their futures by `result_of`.

    If the block is left by an exception, pending work is abandoned at once. The processes also end if this one is
    killed. They leave no partly written files.

    Parameters
    ----------
    jobs : int
        Number of processes.
    """
    context = ProcessContext()
    # nothing is ever sent: the other end is only in this process, and closes when it ends
    parent_watch, held = context.Pipe(duplex=False)
    pool = ProcessPoolExecutor(
        jobs, mp_context=context, initializer=exit_with_parent, initargs=(parent_watch.recv_bytes,)
    )
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
        parent_watch.close()


def result_of(future: Future[Result]) -> Result:
    """Return the result of work submitted to a pool.

    Raises
    ------
    IlfError
        If the process has ended before the work was done.
    Exception
        Any exception that the work itself raised.
    """
    try:
        return future.result()
    except (BrokenProcessPool, SystemExit) as error:
        raise IlfError(
            "One of the worker processes ended unexpectedly. Memory may have run out: close other programs, or use "
            "fewer --jobs."
        ) from error


def run_units(
    function: Callable[..., Result],
    units: Sequence[tuple[Any, ...]],
    *,
    jobs: int = 1,
    on_done: Callable[[int], None] | None = None,
) -> list[Result]:
    """Apply a function to every unit and return the results in the order of the units.

    Parameters
    ----------
    function : callable
        At the top level of a module, so that other processes find it.
    units : sequence of tuple
        Its arguments, once per unit.
    jobs : int
        Number of processes; 1 runs everything in this process.
    on_done : callable, optional
        Called with the index of each finished unit, in any order. An exception that it raises ends the work at once.

    Raises
    ------
    IlfError
        If a process has ended before its work was done.
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
    """Make sure that processes end whose pipe is closed; one that is still starting does not notice by itself."""
    end = time.monotonic() + _GRACE_S
    for process in processes:
        process.join(max(end - time.monotonic(), 0))
    for process in processes:
        process.kill()


# Work on many items in worker processes: if one crashes, only the item that it was working on is lost.

_POLL_S = 0.05
"""Interval of the checks for cancellation [s]."""

Item = TypeVar("Item")


def run_in_processes(
    work: Callable[[Item], Result],
    items: Iterable[Item],
    *,
    jobs: int = 1,
    tidy: Callable[[Item], object] = lambda item: None,
) -> Generator[tuple[Item, Result | None], None, None]:
    """Yield every item with its result, in the order in which they finish; None if its process crashed.

    Items in progress when a process crashed are repeated at the end, one at a time, so that a second crash is caused by
    the item itself. When this generator ends or is closed, the processes have ended.

    Parameters
    ----------
    work : callable
        At the top level of a module, so that other processes find it; exceptions that it raises are raised here.
    items : iterable
        Only those in progress, and as many more, are held in memory.
    jobs : int
        Number of processes.
    tidy : callable
        Called in this process for every item in progress when its process ended.

    Raises
    ------
    Cancelled
        If the work of this thread is cancelled.
    """
    again: list[Item] = []
    waiting, more = deque[Item](), iter(items)
    while _refill(waiting, more, jobs):
        again += yield from _run_until_crash(work, waiting, more, jobs, tidy)
    for item in again:
        if (yield from _run_until_crash(work, deque([item]), iter(()), 1, tidy)):
            yield item, None


def _refill(waiting: deque[Item], more: Iterator[Item], count: int) -> bool:
    """Take further items until `count` are waiting; return whether any is."""
    waiting.extend(islice(more, max(count - len(waiting), 0)))
    return bool(waiting)


def _run_until_crash(
    work: Callable[[Item], Result],
    waiting: deque[Item],
    more: Iterator[Item],
    jobs: int,
    tidy: Callable[[Item], object],
) -> Generator[tuple[Item, Result], None, list[Item]]:
    """Process items until none is waiting, or a process crashes; return the items in progress at that time."""
    pending_work: dict[Future[Result], Item] = {}
    try:
        with process_pool(min(jobs, len(waiting))) as pool:
            while _refill(waiting, more, jobs) or pending_work:
                while waiting and len(pending_work) < jobs:
                    pending_work[pool.submit(work, waiting[0])] = waiting[0]
                    waiting.popleft()
                check_cancelled()
                for future in wait(pending_work, timeout=_POLL_S, return_when=FIRST_COMPLETED).done:
                    result = future.result()
                    yield pending_work.pop(future), result
    except BrokenProcessPool:
        return list(pending_work.values())
    finally:
        for item in pending_work.values():
            tidy(item)
    return []
