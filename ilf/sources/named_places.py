"""What a file may name: paths and addresses in files, which the user has not typed.

`named_in` decides about each before anything of it is looked at. It may be opened if it lies in the folder or the store
that has the file, if the user has opened it before on this machine (`note_opened`), or if he allows it; a file on
this machine also if the SHA-256 of its content is stated with its name by another file here, since it tells the writer
nothing then; a server would learn from the next request whether the file exists.
"""

from __future__ import annotations

import os
import posixpath
import re
import shlex
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path, PurePath, PurePosixPath
from urllib.parse import unquote

from .._runtime.addresses import Address
from .._runtime.files import MAX_FILE_BYTES, absolute, file_sha256, is_address
from .._runtime.installation import user_path
from ..errors import InputError

VARIABLE = "ILF_ALLOW_ADDRESS"
"""Environment variable with what is allowed, a line each; processes that this one starts have it, too."""

_SHARE = re.compile(r"[\\/](?:[\\/]|\?\?[\\/])")
"""Start of a network share, or of a path of Windows that may lead to one."""
_FILES = "/*"
"""End of the entry of a folder of which only the files are meant."""

_CODE = "utf-8", "surrogateescape"

_unwritten: set[str] = set()
"""What was opened and could not be written to the list."""


class NotAllowed(InputError):
    """A file names places that are not opened unasked.

    Attributes
    ----------
    places : tuple of str
        Paths and addresses.
    """

    def __init__(self, *places: str) -> None:
        self.places = tuple(dict.fromkeys(places))
        options = " ".join(f"--allow-address {shlex.quote(one)}" for one in dict.fromkeys(map(_prefix, self.places)))
        super().__init__(
            f"A file names {' and '.join(self.places)} outside its own folder or store, which was never opened here. "
            f"If you trust it, allow it by {options} (in Python: allow_address of ilf.sources)."
        )

    def __reduce__(self) -> tuple[type[NotAllowed], tuple[str, ...]]:
        return NotAllowed, self.places

    @property
    def may_exist(self) -> bool:
        """Whether there may be something at one of the places."""
        return any(_is_far(one) or os.path.lexists(one) for one in self.places)


def _prefix(place: str) -> str:
    """The folder of a place, or the address of its server."""
    return place if is_address(place) and place.count("/") == 2 else os.path.dirname(place)


def named_in(path: str, base: str | os.PathLike[str] | None, sha256: str = "") -> str:
    """A path or an address that a file names, if it may be opened.

    Parameters
    ----------
    path : str
        A relative path belongs to `base`.
    base : path-like or None
        Folder or address that the user has opened and that has the file; None if there is none.
    sha256 : str
        SHA-256 of its content, if the file states it.

    Returns
    -------
    str
        The absolute path, or the address.

    Raises
    ------
    NotAllowed
        If it lies elsewhere, and was neither opened by the user before nor allowed.
    InputError
        If it is an address that is never opened, see `Address`.
    """
    root = "" if base is None else os.fspath(base)
    if is_address(path):
        place: str = Address(path)
        inside = is_address(root) and Address(root).store == Address(path).store
    else:
        place = path if _SHARE.match(path) else os.path.abspath(path if is_address(root) else os.path.join(root, path))
        inside = bool(root) and not is_address(root) and _is_in(place, [_key(root)])
    allowed = map(_key, filter(None, os.environ.get(VARIABLE, "").split("\n")))
    if inside or _is_in(place, allowed) or _was_opened(_key(place)):
        return place
    is_stated = sha256 and not _is_far(root) and not _is_far(place) and os.path.isfile(place)
    if is_stated and os.path.getsize(place) <= MAX_FILE_BYTES and file_sha256(place) == sha256:
        return place
    raise NotAllowed(place)


def may_look_at(path: str) -> bool:
    """Whether asking for the time and the size of a file that a file names tells nobody: it is on this machine, or the
    user has opened its network share."""
    return not _is_far(path) or _was_opened(_key(path))


def _is_far(place: str) -> bool:
    """Whether a place is at an address or a network share, at which nothing is looked at unasked."""
    return is_address(place) or _SHARE.match(place) is not None


def first_allowed(
    paths: Iterable[str],
    base: str | os.PathLike[str] | None,
    is_wanted: Callable[[str], bool] = os.path.isfile,
    sha256: str = "",
) -> str | None:
    """The first of the possible places of a file that is there and may be opened; None if it is at none of them.

    Raises
    ------
    NotAllowed
        If it may be at one that is not opened unasked.
    InputError
        As `named_in`.
    """
    refused: NotAllowed | None = None
    for path in paths:
        try:
            place = named_in(path, base, sha256)
        except NotAllowed as error:
            refused = refused or (error if error.may_exist else None)
        else:
            if is_wanted(place):
                return place
    if refused is not None:
        raise refused
    return None


@contextmanager
def allow_address(*prefixes: str | os.PathLike[str]) -> Iterator[None]:
    """Within the block, open what files name at and below these paths and addresses.

    Projects, run records, shards and lists of frames name files. Those outside the folder or the store of such a file
    are opened only if you have opened them before, or allow them.

    Examples
    --------
    >>> from ilf.sources import allow_address
    >>> with allow_address("s3://bucket/rgb", "/data"):
    ...     pass
    """
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = "\n".join(filter(None, (before, *(absolute(os.fspath(prefix)) for prefix in prefixes))))
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(VARIABLE, None)
        else:
            os.environ[VARIABLE] = before


def note_opened(*paths: str | os.PathLike[str] | None, beside: bool = False) -> None:
    """Remember what the user has opened: a file, a folder or a recording with all in it; with `beside`, which he must
    have been told, also the files beside a file."""
    new = dict.fromkeys(entry for path in paths if path is not None for entry in _entries(os.fspath(path), beside))
    known = [entry for entry in new if entry in _known() or _was_opened(entry.removesuffix(_FILES))]
    missing = [entry for entry in new if entry not in known and "\n" not in entry]  # which would be two entries
    if not missing:
        return
    try:
        file = _list_file()
        file.parent.mkdir(parents=True, exist_ok=True)
        with open(file, "ab") as stream:
            stream.write("".join(f"{entry}\n" for entry in missing).encode(*_CODE))
    except OSError:  # remembered as long as this process runs
        _unwritten.update(missing)


def _entries(path: str, beside: bool) -> Iterable[str]:
    key = _key(path if is_address(path) else os.path.abspath(path))
    is_file = posixpath.splitext(key)[1] != "" if is_address(path) else not os.path.isdir(key)
    return [key, os.path.dirname(key) + _FILES] if beside and is_file else [key]


def _key(path: str | os.PathLike[str]) -> str:
    """A place as places are compared: without links, dots and escaped letters; nothing at a network share is looked
    at."""
    text = os.fspath(path)
    if is_address(text):
        address = Address(text)
        host, slash, name = address.partition("://")[2].partition("/")
        return f"{address.protocol}:/{host.lower()}{posixpath.normpath(slash + unquote(name)) if name else ''}"
    if _SHARE.match(text):
        return posixpath.normpath(text.replace("\\", "/")).casefold()
    try:
        return os.path.realpath(text)
    except (OSError, ValueError):  # no file can have that name
        return os.path.normpath(text)


def _around(key: str) -> list[str]:
    """A place and all that it is in."""
    kind = PurePath if os.path.isabs(key) and not _SHARE.match(key) else PurePosixPath
    return [key, *map(str, kind(key).parents)]


def _is_in(place: str, others: Iterable[str]) -> bool:
    return not set(_around(_key(place))).isdisjoint(others)


def _was_opened(key: str) -> bool:
    return not _known().isdisjoint([*_around(key), os.path.dirname(key) + _FILES])


def _list_file() -> Path:
    return user_path("state", "opened.txt")


def _known() -> frozenset[str] | set[str]:
    """The entries of what was opened."""
    file = _list_file()
    try:
        status = file.stat()
        known = _read(file, status.st_mtime_ns, status.st_size)
    except OSError:
        return _unwritten
    return known | _unwritten if _unwritten else known


@lru_cache(1)
def _read(file: Path, time: int, size: int) -> frozenset[str]:
    return frozenset(file.read_bytes().decode(*_CODE).split("\n"))
