"""The user's own files and folders, which no other user of the computer may read."""

from __future__ import annotations

import stat
from contextlib import suppress
from pathlib import Path


def private_file(path: Path) -> None:
    """Make an empty file, and its folder, for the user alone; what is there already stays as it is.

    Raises
    ------
    OSError
        If it cannot be made.

    Examples
    --------
    >>> private_file(Path("notes/own.txt"))
    >>> Path("notes/own.txt").read_text()
    ''
    """
    path.parent.mkdir(0o700, parents=True, exist_ok=True)
    with suppress(FileExistsError):
        path.touch(0o600, exist_ok=False)


def tighten(path: Path) -> None:
    """Leave a file or folder to its owner alone, if it is there and the file system can."""
    with suppress(OSError):
        mode = path.stat().st_mode
        if mode & 0o077 and (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            path.chmod(stat.S_IMODE(mode) & 0o700)
