"""What dead writers have left: temporary files and folders have in their names who makes them, so that the next who
writes there can tell."""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import socket
from contextlib import suppress
from functools import cache
from pathlib import Path

MADE_BY = r"(?P<host>.+)-(?P<process>\d+)-[0-9a-f]{8}"
"""What `made_by` gives, as a regular expression."""
_FILE = re.compile(rf"\.ilf-(?:{MADE_BY}|[0-9a-f]{{16}})(?:\..*)?")  # the second, in earlier versions
_DAY_S = 24 * 3600.0
_cleared: set[Path] = set()


def made_by() -> str:
    """A part of a name that no other temporary file has, of this process or another."""
    return f"{_host()}-{os.getpid()}-{secrets.token_hex(4)}"


def is_dead(match: re.Match[str]) -> bool:
    """Whether who made what a name says (`MADE_BY`) has surely ended. Nothing is known of others than processes of
    this computer, since it was started, and of this container."""
    return match["host"] == _host() and not _runs(int(match["process"]))


def is_own(status: os.stat_result) -> bool:
    """Whether a file or folder belongs to the user of this process; where files have no owners, all do."""
    return not hasattr(os, "geteuid") or status.st_uid == os.geteuid()


def clear_left_files(temporary: Path) -> None:
    """Take away what this user's writers of single files have left in the folder of one that has just been made.

    That is files whose writer is dead for sure, and those that have lain untouched for a day, by the time of the
    folder's own disk, which may be another computer's. A process looks once into each folder.
    """
    folder = temporary.parent
    if folder in _cleared:
        return
    _cleared.add(folder)
    with suppress(OSError), os.scandir(folder) as entries:
        now = temporary.stat().st_mtime
        for entry in entries:
            match = _FILE.fullmatch(entry.name)
            if match is not None and entry.is_file(follow_symlinks=False):
                with suppress(OSError):  # another program has been quicker
                    status = entry.stat()
                    dead = (match["host"] and is_dead(match)) or now - status.st_mtime > _DAY_S
                    if dead and is_own(status):
                        os.unlink(entry)


@cache
def _host() -> str:
    """This computer, since it was started, and this container: who has the same sees the same processes."""
    name = re.sub(r"[^A-Za-z0-9.]+", "_", socket.gethostname()) or "host"
    facts = []
    with suppress(OSError):  # what only Linux tells
        facts = [Path("/proc/sys/kernel/random/boot_id").read_text(), str(os.stat("/proc/self/ns/pid").st_ino)]
    return f"{name}.{hashlib.sha256(' '.join(facts).encode()).hexdigest()[:8]}" if facts else name


def _runs(process: int) -> bool:
    if process >= 2**31:  # there is no such number
        return False
    if os.name == "nt":
        import ctypes

        handle = ctypes.windll.kernel32.OpenProcess(0x1000, False, process)  # type: ignore[attr-defined]
        if handle:
            ctypes.windll.kernel32.CloseHandle(handle)  # type: ignore[attr-defined]
        return bool(handle)
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True
