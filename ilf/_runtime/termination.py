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

from ..errors import cause, without_credentials
from .installation import __version__, user_path
from .writing import private_file, remove_temporary_files

LIMIT_S = 0.2
"""Time after a signal until the process is ended by force [s]: a library may be busy for longer without noticing the
signal."""

_extended_limits: list[float] = []
"""Time limits that `extended_time_limit` has set at present [s]."""

_SIGNALS = tuple(signal.Signals[name] for name in ("SIGINT", "SIGTERM", "SIGHUP") if name in signal.Signals.__members__)

# at exit, skip the search for reference cycles, which takes half a second
atexit.register(gc.freeze)


class Interrupted(KeyboardInterrupt):
    """A signal has requested the end of the command."""

    def __init__(self, number: int) -> None:
        super().__init__("interrupted" if number == signal.SIGINT else f"ended by {signal.Signals(number).name}")
        self.status = 128 + number
        """The exit status of the command."""


@contextmanager
def terminating_on_signal() -> Iterator[None]:
    """Raise `Interrupted` in the block on a signal. If the block has not ended within `LIMIT_S`, or on a second signal,
    end the process by force, without leaving partly written files.

    Outside the main thread, where no signal arrives, this does nothing.
    """
    requested = threading.Event()

    def on_signal(number: int, _: FrameType | None) -> None:
        if not requested.is_set():
            requested.set()
            raise Interrupted(number)

    with _handling_signals(on_signal, "ilf", LIMIT_S):
        yield


@contextmanager
def extended_time_limit(limit_s: float) -> Iterator[None]:
    """Within the block, allow the command this much time [s] to end after a signal, in place of `LIMIT_S`, so that it
    can write finished results. A second signal still ends it by force."""
    _extended_limits.append(limit_s)
    try:
        yield
    finally:
        _extended_limits.remove(limit_s)


@contextmanager
def terminating_immediately(program: str) -> Iterator[None]:
    """Within the block, end the process immediately on a signal: for code that no exception should interrupt, such as
    imports and Qt.

    Parameters
    ----------
    program : str
        Name of the program in its last line.
    """
    with _handling_signals(lambda number, _: None, program, 0.0):
        yield


@contextmanager
def _handling_signals(
    on_signal: Callable[[int, FrameType | None], None], program: str, limit_s: float
) -> Iterator[None]:
    """Within the block, call `on_signal` on a signal and end the process this many seconds later."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    # a process started to survive its terminal, as by nohup, does
    handled = [number for number in _SIGNALS if signal.getsignal(number) is not signal.SIG_IGN]
    # a signal arrives here at once, even while the main thread is busy in a library
    receiver, sender = socket.socketpair()
    sender.setblocking(False)
    woken = signal.set_wakeup_fd(sender.fileno(), warn_on_full_buffer=False)
    before = {number: signal.signal(number, on_signal) for number in handled}
    watch = threading.Thread(target=_force_exit, args=(receiver, program, limit_s), name="ilf-ending", daemon=True)
    watch.start()
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        signal.set_wakeup_fd(woken)
        sender.close()
        watch.join()
        receiver.close()


def _force_exit(receiver: socket.socket, program: str, limit_s: float) -> None:
    """End the process by force if it does not end after a signal; return when the other end of the socket is closed."""
    number = 0
    while number not in _SIGNALS:
        sender = receiver.recv(1)
        if not sender:
            return
        number = sender[0]
    receiver.settimeout(max([limit_s, *_extended_limits]))
    with suppress(TimeoutError, BlockingIOError):
        if not receiver.recv(1):
            return
    end = Interrupted(number)
    if sys.stderr is not None:
        with suppress(OSError):
            print(f"{program}: error: {end}", file=sys.stderr, flush=True)
    remove_temporary_files()
    os._exit(end.status)


# The log of unexpected errors, to which a one-line message refers.

_MAX_LOG_BYTES = 1_000_000
"""Size [bytes] above which a new log is started; the previous one is kept beside it."""


def error_log_path() -> Path:
    """Return the path of the log: `ILF_LOG`, or a file in the user's log folder."""
    return user_path("log", "faults.log", "ILF_LOG")


def log_error(error: BaseException) -> str:
    """Write an unexpected error with its traceback to the log.

    Parameters
    ----------
    error : BaseException

    Returns
    -------
    str
        One line for the user: the error, and where to read more.
    """
    message = " ".join(without_credentials(str(error)).split())
    if isinstance(error, MemoryError):
        what = f" ({message:.200})" if message else ""
        return f"Memory has run out{what}. Close other programs, or use a smaller frame."
    what = f"{type(error).__name__}: {message}"
    try:
        with _opened() as file:
            now, told = time.strftime("%Y-%m-%d %H:%M:%S"), "".join(traceback.format_exception(error))
            file.write(f"{now} ILF Studio {__version__}, Python {platform.python_version()}, {platform.platform()}\n")
            file.write(f"{without_credentials(told)}\n")
    except OSError as unwritable:
        return f"Unexpected error in the program ({what:.200}); the log cannot be written ({cause(unwritable)})."
    return f"Unexpected error in the program ({what:.200}). Please report it and attach {error_log_path()}"


def log_crashes() -> None:
    """Log the stacks of all threads on a crash of native code. Do nothing if crashes are handled elsewhere, or the log
    cannot be written."""
    if not faulthandler.is_enabled():
        with suppress(OSError):
            faulthandler.enable(_opened())


def _opened() -> TextIO:
    path = error_log_path()
    if path.exists() and path.stat().st_size > _MAX_LOG_BYTES:
        os.replace(path, path.with_name(f"{path.name}.1"))
    private_file(path)
    return open(path, "a", encoding="utf-8", errors="backslashreplace")
