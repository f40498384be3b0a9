"""Termination of a command by signals: Ctrl+C, a request to terminate, or a closed terminal."""

from __future__ import annotations

import atexit
import faulthandler
import gc
import os
import platform
import signal
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import TextIO

import platformdirs

from ..errors import cause
from .installation import __version__
from .temporary_files import discard_unfinished, private_file, tighten

LIMIT_S = 0.2
"""Time after a signal until the process is ended by force [s]: a library may be busy for longer without noticing the
signal."""

_allowed: list[float] = []
"""Time limits that `allowing` has set at present [s]."""

_ASKING = tuple(signal.Signals[name] for name in ("SIGINT", "SIGTERM", "SIGHUP") if name in signal.Signals.__members__)

# at exit, skip the search for reference cycles, which takes half a second
atexit.register(gc.freeze)


class Interrupted(KeyboardInterrupt):
    """A signal has requested the end of the command."""

    def __init__(self, number: int) -> None:
        super().__init__("interrupted" if number == signal.SIGINT else f"ended by {signal.Signals(number).name}")
        self.status = status_of(number)


def status_of(number: int) -> int:
    """Return the exit status of a command ended by a signal."""
    return 128 + number


@contextmanager
def ending_when_asked() -> Iterator[None]:
    """Raise `Interrupted` in the block on a signal. If the block has not ended within `LIMIT_S`, or on a second signal,
    end the process by force, without leaving partly written files.

    Outside the main thread, where no signal arrives, this does nothing.
    """
    asked = threading.Event()

    def ask(number: int, _: FrameType | None) -> None:
        if not asked.is_set():
            asked.set()
            raise Interrupted(number)

    with _heard(ask, "ilf", LIMIT_S):
        yield


@contextmanager
def allowing(limit_s: float) -> Iterator[None]:
    """Within the block, allow the command this much time [s] to end after a signal, in place of `LIMIT_S`, so that it
    can write finished results. A second signal still ends it by force."""
    _allowed.append(limit_s)
    try:
        yield
    finally:
        _allowed.remove(limit_s)


@contextmanager
def ending_at_once(program: str) -> Iterator[None]:
    """Within the block, end the process immediately on a signal: for code that no exception should interrupt, such as
    imports and Qt.

    Parameters
    ----------
    program : str
        Name of the program in its last line.
    """
    with _heard(lambda number, _: None, program, 0.0):
        yield


@contextmanager
def _heard(ask: Callable[[int, FrameType | None], None], program: str, limit_s: float) -> Iterator[None]:
    """Within the block, call `ask` on a signal and end the process this many seconds later."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    # a process started to survive its terminal, as by nohup, does
    heard = [number for number in _ASKING if signal.getsignal(number) is not signal.SIG_IGN]
    # a signal arrives here at once, even while the main thread is busy in a library
    watching, told = socket.socketpair()
    told.setblocking(False)
    woken = signal.set_wakeup_fd(told.fileno(), warn_on_full_buffer=False)
    before = {number: signal.signal(number, ask) for number in heard}
    watch = threading.Thread(target=_cut_short, args=(watching, program, limit_s), name="ilf-ending", daemon=True)
    watch.start()
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(woken)
        told.close()
        watch.join()
        watching.close()


def _cut_short(watching: socket.socket, program: str, limit_s: float) -> None:
    """End the process by force if it does not end after a signal; return when the other end of the socket is closed."""
    number = 0
    while number not in _ASKING:
        told = watching.recv(1)
        if not told:
            return
        number = told[0]
    watching.settimeout(max([limit_s, *_allowed]))
    with suppress(TimeoutError, BlockingIOError):
        if not watching.recv(1):
            return
    if sys.stderr is not None:
        with suppress(OSError):
            print(f"{program}: error: {Interrupted(number)}", file=sys.stderr, flush=True)
    discard_unfinished()
    os._exit(status_of(number))


# The log of unexpected errors, to which a one-line message refers.

_LARGEST = 1_000_000
"""Size [bytes] above which a new log is started; the previous one is kept beside it."""


def fault_log() -> Path:
    """Return the path of the log: `ILF_LOG`, or a file in the user's log folder."""
    chosen = os.environ.get("ILF_LOG")
    return Path(chosen) if chosen else platformdirs.user_log_path("ilf-studio", appauthor=False) / "faults.log"


def note_fault(error: BaseException) -> str:
    """Write an unexpected error with its traceback to the log.

    Parameters
    ----------
    error : BaseException

    Returns
    -------
    str
        One line for the user: the error, and where to read more.
    """
    said = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return f"Memory has run out{f' ({said:.200})' if said else ''}. Close other programs, or use a smaller frame."
    what = f"{type(error).__name__}: {said}"
    try:
        with _opened() as file:
            file.write(f"{_head()}\n{''.join(traceback.format_exception(error))}\n")
    except OSError as unwritable:
        kept = f"the log could not be written ({cause(unwritable)})"
        return f"Unexpected error in the program ({what:.200}); {kept}."
    return f"Unexpected error in the program ({what:.200}). Please report it and attach {fault_log()}"


def note_crashes() -> None:
    """Log the stacks of all threads on a crash of native code. Do nothing if crashes are handled elsewhere, or the log
    cannot be written."""
    if not faulthandler.is_enabled():
        with suppress(OSError):
            faulthandler.enable(_opened())


def _head() -> str:
    now = time.strftime("%Y-%m-%d %H:%M:%S")
    return f"{now} ILF Studio {__version__}, Python {platform.python_version()}, {platform.platform()}"


def _opened() -> TextIO:
    path = fault_log()
    if path.exists() and path.stat().st_size > _LARGEST:
        os.replace(path, path.with_name(f"{path.name}.1"))
    private_file(path)
    tighten(path)
    return open(path, "a", encoding="utf-8", errors="backslashreplace")
