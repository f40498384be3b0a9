"""What a file may name: paths and addresses in files, which the user has not typed.

`named_in` decides about each before anything of it is looked at. It may be opened if it lies in the folder or the store
that has the file, if the user has opened it before on this machine (`note_opened`), or if he allows it.
"""

from __future__ import annotations

import os
import posixpath
import re
import shlex
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from urllib.parse import unquote

import platformdirs

from ..errors import InputError
from .addresses import Address, absolute, is_address

VARIABLE = "ILF_ALLOW_ADDRESS"
"""Environment variable with what is allowed, a line each; processes that this one starts have it, too."""

_SHARE = re.compile(r"[\\/]{2}")
_FILES = "/*"
"""End of the entry of a folder of which only the files are meant."""

_MAX_ENTRIES = 10_000


class NotAllowed(InputError):
    """A file names a place that is not opened unasked.

    Attributes
    ----------
    place : str
        The path or the address.
    """

    def __init__(self, place: str) -> None:
        self.place = place
        super().__init__(
            f"A file names {place}, which lies outside its own folder or store and was never opened here. If you trust "
            f"it, allow it by --allow-address {shlex.quote(self.prefix)} (in Python: ilf.allow_address)."
        )

    @property
    def prefix(self) -> str:
        """Its folder, or the address of its server."""
        is_server = is_address(self.place) and self.place.count("/") == 2
        return self.place if is_server else os.path.dirname(self.place)

    @property
    def may_exist(self) -> bool:
        """Whether there may be something at the place; nothing at an address or a network share is looked at."""
        return is_address(self.place) or _SHARE.match(self.place) is not None or os.path.lexists(self.place)

    def __reduce__(self) -> tuple[type[NotAllowed], tuple[str]]:
        return NotAllowed, (self.place,)


def named_in(path: str, base: str | os.PathLike[str] | None) -> str:
    """A path or an address that a file names, if it may be opened.

    Parameters
    ----------
    path : str
        A relative path belongs to `base`.
    base : path-like or None
        Folder or address that the user has opened and that has the file; None if there is none.

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
        inside = bool(root) and not is_address(root) and _is_below(_key(place), {_key(root)})
    key = _key(place)
    if not (inside or _is_below(key, map(_key, os.environ.get(VARIABLE, "").splitlines())) or _was_opened(key)):
        raise NotAllowed(place)
    return place


def first_allowed(
    paths: Iterable[str], base: str | os.PathLike[str] | None, is_wanted: Callable[[str], bool] = os.path.isfile
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
            place = named_in(path, base)
        except NotAllowed as error:
            refused = refused or error
        else:
            if is_wanted(place):
                return place
    if refused is not None and refused.may_exist:
        raise refused
    return None


@contextmanager
def allow_address(*prefixes: str | os.PathLike[str]) -> Iterator[None]:
    """Within the block, open what files name at and below these paths and addresses.

    Projects, run records, shards and lists of frames name files. Those outside the folder or the store of such a file
    are opened only if you have opened them before, or allow them.

    Examples
    --------
    >>> import ilf
    >>> with ilf.allow_address("s3://bucket/rgb", "/data"):
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


def note_opened(*paths: str | os.PathLike[str] | None) -> None:
    """Remember what the user has opened: a folder or a recording with all in it, a file with the files beside it."""
    new = {entry: None for path in paths if path is not None for entry in _entries(os.fspath(path))}
    with suppress(OSError):  # without it the user is asked again
        file = _list_file()
        if missing := [entry for entry in new if not _was_opened(entry.removesuffix(_FILES), entry)]:
            file.parent.mkdir(parents=True, exist_ok=True)
            with open(file, "a", encoding="utf-8", errors="surrogateescape") as stream:
                stream.write("".join(f"{entry}\n" for entry in missing))


def _entries(path: str) -> Iterable[str]:
    if is_address(path):
        address = _key(path)
        return [address] if address.count("/") == 2 else [address, posixpath.dirname(address) + _FILES]
    real = _key(os.path.abspath(path))
    folder = os.path.dirname(real)
    is_whole = os.path.isdir(real) or folder in {os.path.dirname(folder), _key(Path.home())}
    return [real] if is_whole else [folder + _FILES]


def _key(path: str | os.PathLike[str]) -> str:
    """A place as places are compared: without links, dots and escaped letters; nothing at a network share is looked
    at."""
    text = os.fspath(path)
    if is_address(text):
        address = Address(text)
        rest = address.partition("://")[2]
        host, slash, name = rest.partition("/")
        return f"{address.protocol}://{host.lower()}{posixpath.normpath(slash + unquote(name)) if name else ''}"
    if _SHARE.match(text):
        return posixpath.normpath(text.replace("\\", "/")).casefold()
    return os.path.realpath(text)


def _is_below(key: str, places: Iterable[str]) -> bool:
    """Whether a place is one of others or below."""
    known = places if isinstance(places, set | frozenset) else set(places)
    while key and key not in known:
        above = posixpath.dirname(key) if is_address(key) or _SHARE.match(key) else os.path.dirname(key)
        key = above if above != key and not (_SHARE.match(key) and above == "/") else ""
    return bool(key)


def _was_opened(key: str, entry: str = "") -> bool:
    file = _list_file()
    try:
        status = file.stat()
    except OSError:
        return False
    known = _read(file, status.st_mtime_ns, status.st_size)
    return entry in known or _is_below(key, known) or os.path.dirname(key) + _FILES in known


def _list_file() -> Path:
    return platformdirs.user_config_path("ilf-studio", appauthor=False) / "opened.txt"


@lru_cache(1)
def _read(file: Path, time: int, size: int) -> frozenset[str]:
    lines = file.read_text(encoding="utf-8", errors="surrogateescape").split("\n")
    return frozenset(lines[-_MAX_ENTRIES:]) - {""}
