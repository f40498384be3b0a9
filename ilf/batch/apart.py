"""Work on many things in processes of their own, of which one that dies costs only what it was working on."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from typing import TypeVar

from ..processes import process_pool
from ..stopping import check_stopped

_POLL_S = 0.05
"""How often is asked whether to go on."""

Item = TypeVar("Item")
Result = TypeVar("Result")


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
