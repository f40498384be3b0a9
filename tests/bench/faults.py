"""Disk failures at every single operation of a writer, with a check of the files that remain.

    python -m tests.bench.faults [--only run sample ...] [--every 1]

Every writer repeatedly writes a set of files over an older one. Each time, one more operation (opening, writing,
flushing to the disk, moving, making a folder) succeeds before the disk fails: once at a single operation, once at this
and all later ones that need space. Afterwards the folder must contain the older set or the new one, byte by byte, and
no other files, and the error message must say what to do.
"""

from __future__ import annotations

import argparse
import builtins
import contextlib
import errno
import io
import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

from ilf.errors import ExportError

from .writers import WRITERS, Writer, contents

_NEEDS_SPACE = {"open", "write", "mkdir"}


@dataclass
class Disk:
    """Operations of a failing disk.

    Attributes
    ----------
    good : int
        Number of operations that succeed.
    for_good : bool
        Whether the disk stays full afterwards.
    asked : int
        Operations so far.
    """

    good: int
    for_good: bool = False
    asked: int = 0

    def ask(self, what: str) -> None:
        """Count an operation, or fail."""
        self.asked += 1
        full = self.for_good and self.asked > self.good + 1 and what in _NEEDS_SPACE
        if self.asked == self.good + 1 or full:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


class _File:
    """A file on such a disk."""

    def __init__(self, file: Any, disk: Disk) -> None:
        self._file, self._disk = file, disk

    def write(self, content: Any) -> int:
        self._disk.ask("write")
        return self._file.write(content)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)

    def __iter__(self) -> Iterator[Any]:
        return iter(self._file)

    def __enter__(self) -> _File:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()


@contextmanager
def failing(disk: Disk, folder: Path) -> Iterator[None]:
    """Within the block, all writing below a folder goes to the failing disk."""
    real_open, inside = io.open, f"{folder}{os.sep}"

    def opened(path: Any, mode: str = "r", *arguments: Any, **more: Any) -> Any:
        ours = isinstance(path, str | os.PathLike) and os.path.abspath(path).startswith(inside)
        if not ours or not set(mode) & set("wax+"):
            return real_open(path, mode, *arguments, **more)
        disk.ask("open")
        return _File(real_open(path, mode, *arguments, **more), disk)

    def asking(function: Callable[..., Any], what: str) -> Callable[..., Any]:
        def asked(*arguments: Any, **more: Any) -> Any:
            disk.ask(what)
            return function(*arguments, **more)

        return asked

    with contextlib.ExitStack() as patched:
        patched.enter_context(patch.object(io, "open", opened))
        patched.enter_context(patch.object(builtins, "open", opened))
        for name, what in (("fsync", "fsync"), ("replace", "move"), ("rename", "move"), ("mkdir", "mkdir")):
            patched.enter_context(patch.object(os, name, asking(getattr(os, name), what)))
        yield


def faults_of(writer: Writer, folder: Path, every: int = 1, first: int = 0) -> tuple[int, list[str]]:
    """Let a writer's disk fail at every `every`-th operation; return the number of failures, and the errors found."""
    write = writer.prepare(folder)
    target = folder / "out"
    write(target, 0)
    older = contents(target)
    write(target, 1)
    newer = contents(target)
    if older.keys() - newer.keys() or older == newer:
        raise ValueError(f"{writer.name}: the two sets cannot be told apart")
    write(target, 0)
    with failing(counted := Disk(good=10**9), folder):
        write(target, 1)
    wrong, tried = [], 0
    for good in range(first, counted.asked, every):
        for for_good in (False, True):
            write(target, 0)
            older = contents(target)
            tried += 1
            disk = Disk(good, for_good)
            said: BaseException | None = None
            with failing(disk, folder):
                try:
                    write(target, 1)
                except ExportError as error:
                    said = error
                except Exception as error:
                    said = error
                    wrong.append(f"{writer.name}, operation {good}: {type(error).__name__}: {error}")
            left = contents(target)
            is_new = all(left.get(name) == newer[name] for name in writer.steady(newer))
            if not (left == older or (is_new and left.keys() == newer.keys())):
                wrong.append(f"{writer.name}, operation {good}: a mixed set: {sorted(left)}")
            elif said is None and left == older:
                wrong.append(f"{writer.name}, operation {good}: no new set, and no error message")
    return tried, wrong


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", choices=list(WRITERS), default=list(WRITERS))
    parser.add_argument("--every", type=int, default=1)
    given = parser.parse_args()
    failed = False
    for name in given.only:
        with tempfile.TemporaryDirectory() as folder:
            tried, wrong = faults_of(WRITERS[name], Path(folder).resolve(), given.every)
        print(f"{name:12} {tried:5} faults, {len(wrong)} wrong", *wrong[:10], sep="\n    ", flush=True)
        failed |= bool(wrong)
    raise SystemExit(failed)


if __name__ == "__main__":
    main()
