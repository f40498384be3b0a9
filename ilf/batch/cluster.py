"""Work on many items on the workers of a Dask cluster."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import CancelledError
from typing import Any, TypeVar

from .._runtime.files import read_json
from .._runtime.installation import optional
from .._runtime.long_work import available_cores
from .._runtime.schema import Section
from ..errors import IlfError, InputError

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
    for name in ("distributed", "distributed.client"):  # what Dask logs is in its exceptions, too
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        with _client(distributed, address) as client:
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
        raise IlfError(f"The Dask scheduler at {address} was lost. What is done is kept: run it again.") from error


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
        why = " ".join(str(error).split())
        remedy = "Start one with `dask scheduler`, or give its scheduler file."
        raise InputError(f"There is no Dask scheduler at {address} ({why}). {remedy}") from error
