"""Child processes of this program: what may crash, hang or swell is done in one, and long work is shared among them.

A child ends when the process that started it ends, however that happens: its standard input closes then.
"""

from __future__ import annotations

import atexit
import math
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import traceback
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import ExitStack, contextmanager, suppress
from itertools import islice
from queue import SimpleQueue
from typing import Any, BinaryIO, TypeVar

from ..errors import FormatError, IlfError, InputError, told_as
from .installation import child_command
from .long_work import check_cancelled, run_aside, set_cancel_events
from .writing import remove_temporary_files

SECONDS, MEMORY = 60.0, 4 * 2**30
"""Limits of reading a file in a child: processor time [s], and memory [bytes] beyond what it uses before."""

_WAITING = 8
"""How many times as long a child may take by the clock: it may wait for others, on a busy machine, or for a disk."""

_GRACE_S = 0.3
"""Time for a child to remove files that it is writing [s]."""

_OUT_OF_TIME = -signal.SIGXCPU if hasattr(signal, "SIGXCPU") else None
"""Exit status of a child that has had its processor time."""

_POLL_S = 0.05
"""Interval of the checks for cancellation [s]."""

_LENGTH = 8
"""Size [bytes] of the number of bytes before work."""

_REMEDY = "Copy or export it again."

Item = TypeVar("Item")
Result = TypeVar("Result")


class ChildEnded(Exception):
    """A child has ended before its work was done."""

    def __init__(self, status: int) -> None:
        with suppress(ValueError):
            super().__init__(signal.Signals(-status).name)
            return
        super().__init__(f"exit status {status}")


class Child:
    """A separate process that calls functions, one after the other.

    Parameters
    ----------
    quiet : bool
        Whether to discard what its libraries print; then they use one thread, too.

    Raises
    ------
    OSError
        If no process can be started.
    """

    def __init__(self, *, quiet: bool = False) -> None:
        # the same module path as here, without the current folder
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path))}
        environment |= {"OMP_NUM_THREADS": "1"} if quiet else {}
        self._process = subprocess.Popen(
            child_command(),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL if quiet else None,
            bufsize=0,  # closing the input, which ends the child, waits for nothing
            pipesize=2**20,  # images pass
            env=environment,
            start_new_session=True,  # Ctrl+C reaches every process of a terminal's session; only this one handles it
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._work = self._process.stdin
        self._answers = os.fdopen(self._process.stdout.fileno(), "rb", closefd=False)

    def call(
        self, function: Callable[..., Result], *arguments: Any, seconds: float = math.inf, memory: int | None = None
    ) -> Result:
        """Call a function at the top level of a module, or a class method, in the child, and return its result.

        Raises
        ------
        Exception
            Any that the function raises.
        ChildEnded
            If the child ends before.
        TimeoutError, MemoryError
            If it needs more than `seconds` of processor time (not on Windows), many times as long by the clock, or
            more memory [bytes] (only on Linux); then the child has ended.
        Cancelled
            If the work was cancelled; likewise.
        """
        work = pickle.dumps((dict(os.environ), function, arguments, seconds, memory), 5)

        def converse() -> Any:
            for part in (len(work).to_bytes(_LENGTH), work):
                left = memoryview(part)
                while left:
                    left = left[self._work.write(left) :]
            return pickle.load(self._answers)

        try:
            is_result, found = run_aside(converse, self.end, _WAITING * seconds)
        except TimeoutError:
            raise
        except (EOFError, OSError, ValueError, pickle.UnpicklingError):
            self.end()
            if self._process.returncode == _OUT_OF_TIME:
                raise TimeoutError from None
            raise ChildEnded(self._process.returncode) from None
        if isinstance(found, MemoryError):
            self.end()
        if not is_result:
            raise found
        result: Result = found
        return result

    @property
    def has_ended(self) -> bool:
        """Whether it was ended, or has ended by itself."""
        return self._process.poll() is not None

    def end(self) -> None:
        """End it, whatever it is doing; it removes what it is writing."""
        with suppress(OSError):
            self._work.close()
        try:
            self._process.wait(_GRACE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def close(self) -> None:
        """End it, when no thread waits for its answer any more."""
        self.end()
        assert self._process.stdout is not None
        self._process.stdout.close()


# Reading strangers' files.


def run_in_child(
    function: Callable[..., Result],
    *arguments: Any,
    file: str,
    seconds: float = SECONDS,
    memory: int = MEMORY,
    doing: str = "reading it",
    own: list[Child] | None = None,
) -> Result:
    """Call a function in a child, which it may crash, exhaust or block, and return its result.

    Parameters
    ----------
    function : callable
        At the top level of a module, or a class method.
    *arguments
        Arguments of the function; anything that can be pickled.
    file : str
        The file that it reads, for messages.
    seconds, memory : float, int
        Limits [s, bytes] as for `Child.call`.
    doing : str
        What the function does with the file, for messages.
    own : list of Child, optional
        Where the child waits for the next call, instead of among those of all files: it may keep the file open. They
        are ended, or given back, by `release`.

    Raises
    ------
    IlfError
        If the function raises one.
    FormatError
        If the function raises any other exception, crashes, or exceeds a limit.
    InputError
        If no process can be started.
    Cancelled
        If the work was cancelled; the child has ended then.

    Examples
    --------
    >>> run_in_child(divmod, 7, 2, file="seven")
    (3, 1)
    """
    try:
        with _borrowed(_idle if own is None else own, quiet=True) as child:
            return child.call(function, *arguments, seconds=seconds, memory=memory)
    except IlfError:
        raise
    except TimeoutError:
        problem = f"takes longer than {seconds:g} s"
    except MemoryError:
        problem = f"needs more than {memory / 2**30:.2g} GiB"
    except ChildEnded as error:
        problem = f"crashes ({error})"
    except Exception as error:
        text = f"{type(error).__name__}: {error}".rstrip(": ")
        problem = f"fails ({text:.200})"
    raise FormatError(f"{file} is damaged: {doing} {problem}. {_REMEDY}")


@contextmanager
def _borrowed(waiting: list[Child], *, quiet: bool = False) -> Iterator[Child]:
    """Take one of the children that wait, a quiet one also of those of all files, or start one; it waits again after
    the block, unless it has ended."""
    try:
        while (child := (waiting or (_idle if quiet else waiting)).pop()).has_ended:
            child.close()  # it was killed while it waited, as when memory runs out
    except IndexError:
        with told_as(InputError, "No process can be started ({error}). Try again.", OSError):
            child = Child(quiet=quiet)
    try:
        yield child
    finally:
        if child.has_ended:
            child.close()
        else:
            waiting.append(child)


_idle: list[Child] = []
"""Children that have read a file and wait for the next."""


def release(own: list[Child]) -> None:
    """Give back children that keep no file open any more."""
    while own:
        _idle.append(own.pop())


def end(children: list[Child]) -> None:
    """End children that wait."""
    while children:
        children.pop().close()


atexit.register(end, _idle)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_idle.clear)  # they are children of the other process


# Work on many items.


def run_in_processes(
    work: Callable[[Item], Result],
    items: Iterable[Item],
    *,
    jobs: int = 1,
    tidy: Callable[[Item], object] = lambda item: None,
) -> Generator[tuple[Item, Result | None], None, None]:
    """Yield every item with its result, in the order in which they finish; None if its process crashed twice.

    An item whose process crashed is repeated at the end, while no other is in progress. When this generator ends or is
    closed, the processes have ended.

    Parameters
    ----------
    work : callable
        At the top level of a module, so that other processes find it; exceptions that it raises are raised here.
    items : iterable
        Only those in progress are held in memory.
    jobs : int
        Number of processes.
    tidy : callable
        Called in this process for every item in progress when its process ended.

    Raises
    ------
    Cancelled
        If the work of this thread is cancelled.
    """
    crashed: list[Item] = []
    for item, result in _once(work, items, jobs, tidy):
        if result is None:
            crashed.append(item)
        else:
            yield item, result[0]
    for item in crashed:
        for _, result in _once(work, [item], 1, tidy):
            yield item, None if result is None else result[0]


def _once(
    work: Callable[[Item], Result], items: Iterable[Item], jobs: int, tidy: Callable[[Item], object]
) -> Generator[tuple[Item, tuple[Result] | None], None, None]:
    """Yield every item with its result, None if its process crashed."""
    more, waiting, stopped = iter(items), list[Child](), threading.Event()
    under_way: dict[Future[Result], Item] = {}

    def call(item: Item) -> Result:
        with _borrowed(waiting) as child:
            return child.call(work, item)

    try:
        with ThreadPoolExecutor(jobs, "ilf-child", set_cancel_events, (stopped,)) as threads, ExitStack() as at_end:
            at_end.callback(stopped.set)  # ends the children that are busy
            under_way |= {threads.submit(call, item): item for item in islice(more, jobs)}
            while under_way:
                check_cancelled()
                for future in wait(under_way, _POLL_S, FIRST_COMPLETED).done:
                    item = under_way[future]
                    try:
                        result = (future.result(),)
                    except ChildEnded:
                        tidy(item)
                        result = None
                    del under_way[future]
                    under_way |= {threads.submit(call, item): item for item in islice(more, 1)}
                    yield item, result
    finally:
        end(waiting)
        for item in under_way.values():
            tidy(item)


# The child's side.


def main() -> None:
    """Do the work that comes by standard input; output that libraries print is not taken for results."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    waiting = SimpleQueue[bytes]()  # unpickled in this thread: the other one must notice the end of the parent
    threading.Thread(target=_listen, args=(sys.stdin.buffer, waiting), name="ilf-lifeline", daemon=True).start()
    while True:
        answers.write(_answer(waiting.get()))
        answers.flush()


def _listen(stream: BinaryIO, waiting: SimpleQueue[bytes]) -> None:
    """Take work, until the parent closes the stream or ends: then end this process."""
    with suppress(OSError):
        while size := int.from_bytes(stream.read(_LENGTH)):
            waiting.put(stream.read(size))
    remove_temporary_files()
    os._exit(1)


def _answer(work: bytes) -> bytes:
    """Do work within its limits and return the answer, pickled."""
    try:
        environment, function, arguments, seconds, memory = pickle.loads(work)
        os.environ.update(environment)
        if memory is not None:
            set_process_limits(seconds, memory)
        return pickle.dumps((True, function(*arguments)), 5)
    except Exception as error:
        if not isinstance(error, IlfError | MemoryError):
            error.add_note("".join(traceback.format_exception(error)))
        error.__cause__ = error.__context__ = error.__traceback__ = None
        try:
            answer = pickle.dumps((False, error))
            pickle.loads(answer)
        except Exception:  # some errors of libraries cannot be sent
            answer = pickle.dumps((False, RuntimeError(f"{type(error).__name__}: {error}")))
        return answer


def set_process_limits(seconds: float, memory: int) -> None:
    """Set the limits of this process from now on, as far as the platform supports them; a crash leaves no core file."""
    try:
        import resource
    except ImportError:  # on Windows
        return
    processor_time = int(time.process_time() + seconds) + 1
    limits = {resource.RLIMIT_CORE: 0, resource.RLIMIT_CPU: processor_time, resource.RLIMIT_AS: memory + _in_use()}
    for limit, wanted in limits.items():
        maximum = resource.getrlimit(limit)[1]
        allowed = wanted if maximum == resource.RLIM_INFINITY else min(wanted, maximum)
        with suppress(OSError, ValueError):  # macOS refuses the memory limit
            resource.setrlimit(limit, (allowed, maximum))


def _in_use() -> int:
    """Return the address space [bytes] that this process uses already."""
    try:
        with open("/proc/self/statm", "rb") as stream:
            return int(stream.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 0
