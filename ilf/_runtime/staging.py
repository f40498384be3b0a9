"""Atomic export of a set of files into a folder: all of them or none, even if the process is killed.

The files are written to a temporary folder inside the target and then moved into place one after the other. The last
file is the seal of the set. Replaced files are kept in the temporary folder and restored if a move fails.
A process killed during the export leaves this folder behind; the next process that writes to the target first restores
the old files, if the folder belongs to the same user, and only files of the set.
"""

from __future__ import annotations

import os
import re
import shutil
import stat
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from ..errors import ExportError, cause
from .schema import is_plain
from .temporary_files import (
    CREATOR_PATTERN,
    creator_has_ended,
    is_own,
    moving_into_place,
    remove_empty,
    removed_on_exit,
    unique_tag,
)

_PREFIX = ".ilf-export-"
_TEMPORARY_NAME = re.compile(rf"{re.escape(_PREFIX)}{CREATOR_PATTERN}")
_BEFORE, _NAMES = "before", ".names"
"""In the temporary folder: a folder with the replaced files, and a file with the names of the set, the seal last."""

_LONGEST_NAME = 255
"""Maximum length of file names in most file systems [bytes]."""


@contextmanager
def staging(target: Path) -> Iterator[Path]:
    """Provide a temporary folder inside `target`, which is created if needed and removed again if the block fails.

    Raises
    ------
    ExportError
        For every OSError, in the block or here.
    """
    missing = tuple(path for path in (target, *target.parents) if not os.path.exists(path))
    try:
        target.mkdir(parents=True, exist_ok=True)
        restore_interrupted(target)
        folder = target / f"{_PREFIX}{unique_tag()}"
        folder.mkdir()
        try:
            with removed_on_exit(folder, *missing), _with_final_paths(folder, target):
                yield folder
        except BaseException:
            if not _replaced_files(folder):  # otherwise they could not be restored: kept for `restore_interrupted`
                _discard(folder)
            raise
        _discard(folder)
    except BaseException as error:
        remove_empty(missing)
        if isinstance(error, FileExistsError | NotADirectoryError):
            raise ExportError(f"Could not write into {target}: it is not a folder, or lies inside a file.") from error
        if isinstance(error, OSError):
            raise ExportError(f"Could not write into {target}: {cause(error)}.") from error
        raise


def move_into_place(folder: Path, target: Path, names: Sequence[str]) -> None:
    """Move staged files into place in this order; if a move fails, undo those before it.

    The old file of the last name is removed first, so that an old seal never exists beside new files.

    Raises
    ------
    Cancelled
        If the work was cancelled before the first move.
    """
    before = folder / _BEFORE
    before.mkdir()
    *others, seal = names
    (folder / _NAMES).write_text("\n".join(names), encoding="utf-8")
    with moving_into_place():
        try:
            for name in (seal, *others):
                if (target / name).exists():
                    os.replace(target / name, before / name)
            for name in (*others, seal):
                os.replace(folder / name, target / name)
        except BaseException:
            _roll_back(folder, target)
            raise


def interrupted(target: Path) -> list[Path]:
    """Return temporary folders left behind in a folder by ended processes of this user."""
    return [path for path in sorted(target.glob(f"{_PREFIX}*")) if _is_abandoned(path) and _is_trusted(path)]


def restore_interrupted(target: Path) -> None:
    """Undo unfinished exports of ended processes in a folder: restore the files that they had replaced.

    If the seal exists, all files had been moved, or another set has been written since, and nothing is restored. Files
    that are not in the list of names stay where they are.
    """
    for folder in interrupted(target):
        is_sealed = _is_sealed(folder, target)
        if not is_sealed:
            _roll_back(folder, target)
        if is_sealed or not any((folder / _BEFORE).glob("*")):
            _discard(folder)


def _roll_back(folder: Path, target: Path) -> None:
    """Remove new files from their places, then restore the old ones, the seal last. If this is interrupted, the next
    process can continue it."""
    names = _names(folder)
    for name in names:
        if (target / name).exists() and not (folder / name).exists():
            os.replace(target / name, folder / name)
    for path in _replaced_files(folder):
        os.replace(path, target / path.name)


def _discard(folder: Path) -> None:
    """Remove a temporary folder, the replaced files first: beside a list of names they would be restored."""
    shutil.rmtree(folder / _BEFORE, ignore_errors=True)
    shutil.rmtree(folder, ignore_errors=True)


def _names(folder: Path) -> list[str]:
    """Return the names of the set in a temporary folder; none before it is complete, or if `move_into_place` did not
    write them."""
    try:
        names = (folder / _NAMES).read_text(encoding="utf-8").split("\n")
    except (FileNotFoundError, UnicodeDecodeError):
        return []
    plain = all(is_plain(name) and len(name.encode()) <= _LONGEST_NAME for name in names)
    return names if plain and len(set(names)) == len(names) else []


def _replaced_files(folder: Path) -> list[Path]:
    """Return the replaced files of the set that are still in a temporary folder, the seal last."""
    before = folder / _BEFORE
    return [before / name for name in _names(folder) if os.path.lexists(before / name)]


def _is_sealed(folder: Path, target: Path) -> bool:
    names = _names(folder)
    return bool(names) and (target / names[-1]).exists()


def _is_abandoned(folder: Path) -> bool:
    """Whether the process that created a temporary folder has ended."""
    match = _TEMPORARY_NAME.fullmatch(folder.name)
    return match is not None and creator_has_ended(match)


def _is_trusted(folder: Path) -> bool:
    """Whether a temporary folder and that of the replaced files belong to this user and are not links."""
    for path in (folder, folder / _BEFORE):
        with suppress(FileNotFoundError):
            status = path.lstat()
            if not (stat.S_ISDIR(status.st_mode) and is_own(status)):
                return False
    return True


@contextmanager
def _with_final_paths(folder: Path, target: Path) -> Iterator[None]:
    """Replace the temporary path by the final one in errors of the writers."""
    try:
        yield
    except ExportError as error:
        raise ExportError(str(error).replace(str(folder), str(target))) from error
