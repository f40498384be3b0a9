"""Putting a set of files into a folder: all of them or none, whatever happens to the process meanwhile.

The files are made in a temporary folder inside the target and then moved into their places one after the other, the
last one last: it is the set's seal. Files that they replace wait in the temporary folder, and go back if a move fails.
A process that dies half way leaves that folder behind; who writes next into the target puts the old files back first,
if the folder is the same user's, and only files of the set.
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
from .temporary_files import MADE_BY, is_dead, is_own, made_by, moving, remove_empty, unfinished

_PREFIX = ".ilf-export-"
_LEFT = re.compile(rf"{re.escape(_PREFIX)}{MADE_BY}")
_BEFORE, _NAMES = "before", ".names"
"""In the temporary folder: a folder with the files that were replaced, and a file with the names of the set, the seal's
last."""

_LONGEST_NAME = 255
"""Bytes; file systems take no more."""


@contextmanager
def staging(target: Path) -> Iterator[Path]:
    """A temporary folder inside `target`, which is made if need be and unmade again if the block fails.

    Raises
    ------
    ExportError
        For every OSError, in the block or here.
    """
    missing = tuple(path for path in (target, *target.parents) if not os.path.exists(path))
    try:
        target.mkdir(parents=True, exist_ok=True)
        clear_interrupted(target)
        folder = target / f"{_PREFIX}{made_by()}"
        folder.mkdir()
        try:
            with unfinished(folder, *missing), _naming(folder, target):
                yield folder
        except BaseException:
            if not _old_files(folder):  # which could not be put back: they stay, for `clear_interrupted`
                _discard(folder)
            raise
        _discard(folder)
    except BaseException as error:
        remove_empty(missing)
        if isinstance(error, FileExistsError | NotADirectoryError):
            raise ExportError(f"Could not write into {target}: it is no folder, or lies in none.") from error
        if isinstance(error, OSError):
            raise ExportError(f"Could not write into {target}: {cause(error)}.") from error
        raise


def move_in(folder: Path, target: Path, names: Sequence[str]) -> None:
    """Put staged files into their places, the last one last; if one cannot be, those before it are taken back.

    The old file of the last name goes first, so that at no moment an old seal stands beside new files.

    Raises
    ------
    Cancelled
        If the work was to stop before the first was moved.
    """
    before = folder / _BEFORE
    before.mkdir()
    *others, seal = names
    (folder / _NAMES).write_text("\n".join(names), encoding="utf-8")
    with moving():
        try:
            for name in (seal, *others):
                if (target / name).exists():
                    os.replace(target / name, before / name)
            for name in (*others, seal):
                os.replace(folder / name, target / name)
        except BaseException:
            _take_back(folder, target)
            raise


def interrupted(target: Path) -> list[Path]:
    """Temporary folders that this user's processes which are no more have left in a folder."""
    return [path for path in sorted(target.glob(f"{_PREFIX}*")) if _is_left(path) and _is_sound(path)]


def clear_interrupted(target: Path) -> None:
    """Undo what dead processes have begun in a folder: the files that they had replaced come back.

    Unless the seal is there: then they had moved all files, or another set has been written since. Files that the list
    of names does not name stay where they are.
    """
    for folder in interrupted(target):
        is_sealed = _is_sealed(folder, target)
        if not is_sealed:
            _take_back(folder, target)
        if is_sealed or not any((folder / _BEFORE).glob("*")):
            _discard(folder)


def _take_back(folder: Path, target: Path) -> None:
    """New files come out of their places again, then old ones go into them, the seal last. Whoever dies half way
    leaves what the next one can go on with."""
    names = _names(folder)
    for name in names:
        if (target / name).exists() and not (folder / name).exists():
            os.replace(target / name, folder / name)
    for path in _old_files(folder):
        os.replace(path, target / path.name)


def _discard(folder: Path) -> None:
    """Take a temporary folder away, the names last: without them, the old files would seem to be wanted."""
    shutil.rmtree(folder / _BEFORE, ignore_errors=True)
    shutil.rmtree(folder, ignore_errors=True)


def _names(folder: Path) -> list[str]:
    """Of the set that is in a temporary folder; none before it is whole, or if they are not what `move_in` writes."""
    try:
        names = (folder / _NAMES).read_text(encoding="utf-8").split("\n")
    except (FileNotFoundError, UnicodeDecodeError):
        return []
    return names if all(is_plain(name) and len(name.encode()) <= _LONGEST_NAME for name in names) else []


def _old_files(folder: Path) -> list[Path]:
    """The replaced files of the set that still wait in a temporary folder, the seal last."""
    before = folder / _BEFORE
    return [before / name for name in _names(folder) if os.path.lexists(before / name)]


def _is_sealed(folder: Path, target: Path) -> bool:
    names = _names(folder)
    return bool(names) and (target / names[-1]).exists()


def _is_left(folder: Path) -> bool:
    """Whether the process that made a temporary folder has died."""
    match = _LEFT.fullmatch(folder.name)
    return match is not None and is_dead(match)


def _is_sound(folder: Path) -> bool:
    """Whether a temporary folder and that of the replaced files are this user's own, and no links to others."""
    for path in (folder, folder / _BEFORE):
        with suppress(FileNotFoundError):
            status = path.lstat()
            if not (stat.S_ISDIR(status.st_mode) and is_own(status)):
                return False
    return True


@contextmanager
def _naming(folder: Path, target: Path) -> Iterator[None]:
    """Have errors of the writers name the file's final place: the temporary one means nothing to anyone."""
    try:
        yield
    except ExportError as error:
        raise ExportError(str(error).replace(str(folder), str(target))) from error
