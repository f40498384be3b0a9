"""Sandbox: runs file readers in a separate process with limits of time and memory, since a file may crash them."""

from __future__ import annotations

import json
import os
import pickle
import signal
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from importlib.util import find_spec
from typing import Any

from ..errors import FormatError, IlfError, InputError, cause
from .cancellation import run_aside
from .children import child_command
from .processes import exit_with_parent

SECONDS, MEMORY = 60, 4 * 2**30
"""Time limit of a reader [s], and limit of its memory [bytes] beyond what the process uses at its start."""

_VALUE, _ERROR, _BROKEN, _MEMORY = "value", "error", "broken", "memory"
_LENGTH = 8
"""Size [bytes] of the length prefix."""
_REMEDY = "Copy or export it again."


def run_in_sandbox(
    function: Callable[..., Any],
    *arguments: Any,
    file: str,
    seconds: float = SECONDS,
    memory: int = MEMORY,
    doing: str = "reading it",
) -> Any:
    """Call a function in a separate process, which it may crash, exhaust or block, and return its result.

    Parameters
    ----------
    function : callable
        At the top level of a module, or a class method. Its result must be representable in JSON.
    *arguments
        Arguments of the function; anything that can be pickled.
    file : str
        The file that it reads, for messages.
    seconds : float
        Time limit [s].
    memory : int
        Memory limit [bytes]. Only on platforms that support it: not on Windows and macOS.
    doing : str
        What the function does with the file, for messages.

    Raises
    ------
    IlfError
        If the function raises one.
    FormatError
        If the function raises any other exception, crashes, or exceeds a limit.
    InputError
        If no process can be started.
    Cancelled
        If the work was cancelled; the process has ended then.

    Examples
    --------
    >>> run_in_sandbox(divmod, 7, 2, file="seven")
    [3, 1]
    """
    try:
        status, out = run_in_child(pickle.dumps((function, arguments, seconds, memory)), seconds)
        kind, *found = json.loads(out) if status == 0 else ("",)
    except subprocess.TimeoutExpired:
        raise FormatError(f"{file} is damaged: {doing} takes longer than {seconds:g} s. {_REMEDY}") from None
    except OSError as error:
        raise InputError(f"{file} cannot be checked: no process can be started ({cause(error)}). Try again.") from error
    except ValueError:  # a library has ended the process with status 0
        status, kind = 0, ""
    if kind == _VALUE:
        return found[0]
    if kind == _MEMORY:
        raise FormatError(f"{file} is damaged: {doing} needs more than {memory / 2**30:g} GiB. {_REMEDY}")
    if kind == _BROKEN:
        raise FormatError(f"{file} is damaged: {doing} fails ({found[0]!s:.200}). {_REMEDY}")
    if kind == _ERROR:
        raise _own_errors().get(found[0], FormatError)(found[1])
    raise FormatError(f"{file} is damaged: {doing} crashes ({_cause(status)}). {_REMEDY}")


def run_in_child(work: bytes, seconds: float) -> tuple[int, bytes]:
    """Run work in a process (`run_work`) and return its exit status and output; raise as `subprocess.run` does.

    The process ends when this one ends, for any reason: the pipe that it reads the work from stays open until it has
    finished.
    """
    # the same module path as here, without the current folder
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(map(os.path.abspath, sys.path)), "OMP_NUM_THREADS": "1"}
    reading, writing = os.pipe()
    with open(writing, "wb", buffering=0) as held, open(reading, "rb", buffering=0) as stdin:
        child = subprocess.Popen(
            child_command(__name__),
            stdin=stdin,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env=environment,
        )
        stdin.close()
        with child:
            try:
                with suppress(OSError):  # it has ended already; its status tells how
                    left = memoryview(len(work).to_bytes(_LENGTH) + work)
                    while left:
                        left = left[held.write(left) :]
                out, _ = run_aside(lambda: child.communicate(timeout=seconds), child.kill)
            except BaseException:
                child.kill()
                raise
    return child.returncode, out


def _own_errors() -> dict[str, type[IlfError]]:
    """Return the errors of this library by name; a child compromised by a file can raise no others here."""
    kinds, found = [IlfError], {}
    while kinds:
        kind = kinds.pop()
        found[kind.__name__] = kind
        kinds += kind.__subclasses__()
    return found


def _cause(status: int) -> str:
    try:
        return signal.Signals(-status).name
    except ValueError:
        return f"exit status {status}"


def set_process_limits(seconds: float, memory: int) -> None:
    """Set the limits of this process, as far as the platform supports them; a crash leaves no core file."""
    if find_spec("resource") is None:
        return
    import resource

    processor_time = int(seconds * (os.cpu_count() or 1)) + 1
    limits = {resource.RLIMIT_CORE: 0, resource.RLIMIT_CPU: processor_time, resource.RLIMIT_AS: memory + _in_use()}
    for limit, wanted in limits.items():
        maximum = resource.getrlimit(limit)[1]
        allowed = wanted if maximum == resource.RLIM_INFINITY else min(wanted, maximum)
        try:
            resource.setrlimit(limit, (allowed, maximum))
        except (OSError, ValueError):  # macOS refuses the memory limit
            continue


def _in_use() -> int:
    """Return the address space [bytes] that this process uses already."""
    try:
        with open("/proc/self/statm", "rb") as stream:
            return int(stream.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 0


def run_work(work: bytes) -> bytes:
    """Run work within its limits and return the result as JSON."""
    function, arguments, seconds, memory = pickle.loads(work)
    set_process_limits(seconds, memory)
    found: list[Any]
    try:
        found = [_VALUE, function(*arguments)]
    except MemoryError:
        found = [_MEMORY]
    except IlfError as error:
        found = [_ERROR, type(error).__name__, str(error)]
    except Exception as error:
        found = [_BROKEN, f"{type(error).__name__}: {error}"]
    return json.dumps(found).encode()


def main() -> None:
    """Run the child process; output that libraries print to stdout is discarded."""
    out = os.dup(1)
    os.dup2(2, 1)
    stdin = sys.stdin.buffer
    work = stdin.read(int.from_bytes(stdin.read(_LENGTH)))
    exit_with_parent(lambda: os.read(0, 1))
    answer = run_work(work)
    with open(out, "wb") as stream:
        stream.write(answer)
