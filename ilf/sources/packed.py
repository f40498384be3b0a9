"""Recordings whose files are compressed: unpacked for a while, or the command that unpacks them for good."""

from __future__ import annotations

import shlex
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path, PurePath

from .._runtime.cancellation import check_cancelled
from .._runtime.installation import optional
from .._runtime.writing import remove, removed_on_exit
from ..errors import FormatError, InputError, told_as

_COMMANDS = {
    **dict.fromkeys((".zst", ".zstd"), "zstd -d {} -o {}"),
    ".lz4": "lz4 -d {} {}",
    **{f".{name}": program + " -dk {}" for name, program in (("gz", "gzip"), ("bz2", "bzip2"), ("xz", "xz"))},
    ".zip": "unzip {}",
}
_ZSTD = "compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd"
_CHUNK = 2**22
_LARGEST_RATIO, _LARGEST = 200, 2**26
"""What is unpacked may have so many times the size of what was packed, or so many bytes."""


def unpacking_command(path: PurePath | str) -> str:
    """The command that unpacks a compressed file; "" for others.

    Examples
    --------
    >>> unpacking_command("desk.mcap.zst"), unpacking_command("desk.mcap")
    ('zstd -d desk.mcap.zst -o desk.mcap', '')
    """
    stem, dot, suffix = str(path).rpartition(".")
    return _COMMANDS.get(f"{dot}{suffix.lower()}", "").format(shlex.quote(str(path)), shlex.quote(stem))


@contextmanager
def unpacked(files: Sequence[Path]) -> Iterator[list[Path]]:
    """Provide copies of files in a temporary folder, unpacked by zstd.

    Raises
    ------
    InputError
        If the package that unpacks is not installed, or there is no room.
    FormatError
        If a file becomes too large; errors of the package if it is damaged.
    """
    if not files:
        yield []
        return
    folder = Path(tempfile.mkdtemp(prefix="ilf-unpacked-"))
    try:
        with removed_on_exit(folder):
            yield [_unpacked(file, folder) for file in files]
    finally:
        remove(folder)


def _unpacked(file: Path, folder: Path) -> Path:
    zstd = optional(_ZSTD, "sequences", "A compressed ROS bag")
    target, left = folder / file.stem, max(_LARGEST_RATIO * file.stat().st_size, _LARGEST)
    told = f"{file} cannot be unpacked in {folder.parent} ({{error}}). Set TMPDIR, or run: {unpacking_command(file)}"
    with told_as(InputError, told, OSError), zstd.open(file, "rb") as packed, target.open("xb") as plain:
        while chunk := packed.read(_CHUNK):
            check_cancelled()
            left -= len(chunk)
            if left < 0:
                raise FormatError(f"{file} is {_LARGEST_RATIO} times as large when unpacked: it is damaged.")
            plain.write(chunk)
    return target
