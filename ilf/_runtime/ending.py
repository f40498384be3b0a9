"""How a command ends that is asked to: by Ctrl+C, a request to terminate, or a terminal that closes."""

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
"""What has not ended so long after it was asked to is cut short: a library may be busy for longer, and hears nothing
meanwhile."""

_allowed: list[float] = []
"""What `allowing` grants at present [s]."""

_ASKING = tuple(signal.Signals[name] for name in ("SIGINT", "SIGTERM", "SIGHUP") if name in signal.Signals.__members__)

# at the end of a command, and of the window, what is in memory need not be searched for circles, for half a second
atexit.register(gc.freeze)


class Interrupted(KeyboardInterrupt):
    """Somebody wants the command to end."""

    def __init__(self, number: int) -> None:
        super().__init__("interrupted" if number == signal.SIGINT else f"ended by {signal.Signals(number).name}")
        self.status = status_of(number)


def status_of(number: int) -> int:
    """Exit status of a command that a signal has ended."""
    return 128 + number


@contextmanager
def ending_when_asked() -> Iterator[None]:
    """The block is left by `Interrupted` when the process is asked to end; what is not through with that within
    `LIMIT_S`, or is asked a second time, is cut short, with nothing half written left behind.

    Outside the main thread, where no signal arrives, it does nothing.
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
    """A command that is asked to end within the block has so long for it [s], in place of `LIMIT_S`: to write down what
    is done. A second request cuts it short all the same."""
    _allowed.append(limit_s)
    try:
        yield
    finally:
        _allowed.remove(limit_s)


@contextmanager
def ending_at_once(program: str) -> Iterator[None]:
    """The same, but the process ends where it is: for what no exception should go through, as imports and Qt.

    Parameters
    ----------
    program : str
        What it is called in its last line.
    """
    with _heard(lambda number, _: None, program, 0.0):
        yield


@contextmanager
def _heard(ask: Callable[[int, FrameType | None], None], program: str, limit_s: float) -> Iterator[None]:
    """Within the block, signals call `ask`, and end the process so many seconds [s] later."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    # who was told to survive its terminal, as by nohup, does
    heard = [number for number in _ASKING if signal.getsignal(number) is not signal.SIG_IGN]
    # a signal is told of here at once, even while the main thread is busy in a library
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
    """End the process if it has been asked to and does not do it; until the other end is closed."""
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


# Where unexpected errors are written down in full, so that one line can tell of them.

_LARGEST = 1_000_000
"""Bytes from which on the log begins anew; the one before is kept beside it."""


def fault_log() -> Path:
    """The log's file: `ILF_LOG`, or one in the user's folder for logs."""
    chosen = os.environ.get("ILF_LOG")
    return Path(chosen) if chosen else platformdirs.user_log_path("ilf-studio", appauthor=False) / "faults.log"


def note_fault(error: BaseException) -> str:
    """Write an unexpected error down with its traceback.

    Parameters
    ----------
    error : BaseException

    Returns
    -------
    str
        One line for the user: what it was, and where to read more.
    """
    said = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        return f"Memory has run out{f' ({said:.200})' if said else ''}. Close other programs, or take a smaller frame."
    what = f"{type(error).__name__}: {said}"
    try:
        with _opened() as file:
            file.write(f"{_head()}\n{''.join(traceback.format_exception(error))}\n")
    except OSError as unwritable:
        kept = f"its log could not be written ({cause(unwritable)})"
        return f"An error that is a fault of the program ({what:.200}); {kept}."
    return f"An error that is a fault of the program ({what:.200}). To report it, add {fault_log()}"


def note_crashes() -> None:
    """Have a crash of native code write down there where all threads were; if something else looks after crashes, or
    the log cannot be written, nothing is done."""
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
