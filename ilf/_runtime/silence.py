"""Packages that print messages which cannot be turned off."""

from __future__ import annotations

import contextlib
import io
import os
import threading
from collections.abc import Iterator

# stdout and stderr are global to the process
_silent = threading.Lock()


@contextlib.contextmanager
def silenced() -> Iterator[None]:
    """Discard what is printed during the block, by Python to stdout and by native code to stderr."""
    with _silent, contextlib.redirect_stdout(io.StringIO()), contextlib.ExitStack() as after:
        try:
            kept = os.dup(2)
        except OSError:  # a program without a terminal may have no stderr
            yield
            return
        after.callback(os.close, kept)
        nowhere = os.open(os.devnull, os.O_WRONLY)
        after.callback(os.close, nowhere)
        os.dup2(nowhere, 2)
        after.callback(os.dup2, kept, 2)
        yield
