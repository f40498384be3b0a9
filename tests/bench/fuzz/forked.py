"""The program's sandbox with a forked process in place of a new one: a thousand times faster, so that thousands of
cases can be run."""

from __future__ import annotations

import faulthandler
import os
import select
import signal
import subprocess
import warnings

import ilf._runtime.sandbox


def run_forked(work: bytes, seconds: float) -> tuple[int, bytes]:
    """As `ilf._runtime.sandbox.run_in_child`."""
    reading, writing = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # the child needs no other thread
        child = os.fork()
    if child == 0:
        status = 1
        try:
            faulthandler.disable()  # the tests' handler; the parent reports a crash
            os.close(reading)
            answer = ilf._runtime.sandbox.run_work(work)
            while answer:
                answer = answer[os.write(writing, answer) :]
            status = 0
        finally:
            os._exit(status)
    os.close(writing)
    answer = b""
    try:
        while True:
            if not select.select([reading], [], [], seconds)[0]:
                os.kill(child, signal.SIGKILL)
                raise subprocess.TimeoutExpired("forked", seconds)
            piece = os.read(reading, 2**16)
            if not piece:
                break
            answer += piece
    finally:
        os.close(reading)
        _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status), answer
