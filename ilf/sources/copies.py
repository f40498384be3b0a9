"""Copies of what cannot be read where it lies: of files at addresses, and of recordings whose files are compressed.

Names at an address are listed once; the files of a frame are copied to a temporary folder when it is read, a recording
to the cache. Below either folder, a path spells the address: .../s3/bucket/rgb/0001.png.
"""

from __future__ import annotations

import hashlib
import math
import os
import re
import shlex
import sys
import tempfile
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields, is_dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from .._runtime.addresses import Address, RemoteFiles, cache_folder
from .._runtime.files import is_address, reading_through
from .._runtime.installation import optional
from .._runtime.long_work import check_cancelled
from .._runtime.writing import ensure_folder, left_in, remove, removed_on_exit, temporary_name, write_bytes
from ..data.frame import RGBDFrame
from ..errors import ExportError, FormatError, IlfError, InputError, told_as
from .frame_folder import pose_files
from .frame_ref import FrameRef
from .naming import META_NAME, no_frame_folder


@contextmanager
def temporary_folder(prefix: str) -> Iterator[Path]:
    """Provide a folder that is removed after the block; raises ExportError if it cannot be created."""
    _remove_stale_folders(tempfile.gettempdir(), prefix)
    folder = Path(tempfile.gettempdir(), temporary_name(prefix))
    with told_as(ExportError, f"{folder} cannot be created ({{error}}). Set TMPDIR to another folder.", OSError):
        folder.mkdir(0o700)
    try:
        with removed_on_exit(folder):
            yield folder
    finally:
        remove(folder)


@cache
def _remove_stale_folders(root: str, prefix: str) -> None:
    """Remove temporary folders that ended processes of this user have left; once in a process."""
    for folder in left_in(Path(root), prefix, math.inf):  # those in use may stay unchanged for days
        remove(folder)


# Recordings whose files are compressed, unpacked for a while.

_ZSTD = "compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd"
_CHUNK = 2**22
_LARGEST_RATIO, _LARGEST = 200, 2**26
"""What is unpacked may have so many times the size of what was packed, or so many bytes."""


def unpacking_command(path: Path) -> str:
    """The command that unpacks a file that zstd has compressed.

    Examples
    --------
    >>> unpacking_command(Path("desk.mcap.zst"))
    'zstd -d desk.mcap.zst -o desk.mcap'
    """
    return f"zstd -d {shlex.quote(str(path))} -o {shlex.quote(str(path.with_suffix('')))}"


@contextmanager
def unpacked(files: Sequence[Path]) -> Iterator[list[Path]]:
    """Provide copies of files in a temporary folder, unpacked by zstd.

    Raises
    ------
    InputError
        If the package that unpacks is not installed, or there is no room.
    ExportError
        If no folder can be created.
    FormatError
        If a file becomes too large; errors of the package if it is damaged.
    """
    if not files:
        yield []
        return
    with temporary_folder("ilf-unpacked-") as folder:
        yield [_unpacked(file, folder) for file in files]


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


# Addresses.

T = TypeVar("T")

_PREFIX, _RECORDINGS = "ilf-at-", "recordings"
_MAX_FILES = 1000
"""Maximum number of files in the folder of a single frame."""


def restored(text: str) -> str:
    """A path or a message with addresses in place of the paths of their copies."""
    sep = re.escape(os.sep)
    roots = "|".join(
        [
            rf"{re.escape(os.path.join(tempfile.gettempdir(), _PREFIX))}[^{sep}]+",
            rf"{re.escape(str(cache_folder() / _RECORDINGS))}{sep}[^{sep}]+",
        ]
    )
    return re.sub(rf"(?:{roots}){sep}([^{sep}]+){sep}", r"\1://", text)


@contextmanager
def reported() -> Iterator[None]:
    """Within the block, name addresses in errors instead of the paths of their copies."""
    try:
        yield
    except IlfError as error:
        text = restored(str(error))
        if text == str(error):
            raise
        raise type(error)(text) from error


def _copy_of(address: str, root: Path) -> Path:
    """The path of an address below a folder of copies."""
    protocol, _, rest = address.partition("://")
    parts = rest.split("/")
    if any(part in {"", ".", ".."} or os.sep in part for part in (protocol, *parts)):
        raise InputError(f"{address}: a part of it is empty or no name. Check the address.")
    return Path(root, protocol, *parts)


# Listing.


@contextmanager
def names_at(address: Address) -> Iterator[Path]:
    """Provide a temporary folder with empty files of the names at an address, whose contents are copied when they are
    read: what lists frames on a disk lists them there.

    Raises
    ------
    InputError
        If there are no files, or they cannot be listed.
    """
    files = RemoteFiles(address)
    with temporary_folder(_PREFIX) as temporary, reported():
        root = _copy_of(address, temporary)
        with told_as(ExportError, f"{temporary} cannot be written ({{error}}). Set TMPDIR to another folder.", OSError):
            for name in files.find():
                check_cancelled()
                path = root / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.touch()

        def read(path: Path) -> None:
            if path.is_relative_to(root) and path.is_file() and path.stat().st_size == 0:
                write_bytes(path, files.read(path.relative_to(root).as_posix() if path != root else ""))

        with reading_through(read):
            yield root


def address_of(path: str) -> str:
    """The address of a path listed below `names_at`; raises InputError for a path elsewhere."""
    found = restored(os.path.normpath(path)).replace(os.sep, "/")
    if not is_address(found):
        raise InputError(f"A file of the source refers to {path}, which is not at its address. Correct that file.")
    return found


# Recordings, which are copied as a whole.

_recordings: dict[Address, Path] = {}
"""Copies that this process uses."""


def recording_copy(address: Address, is_file: bool) -> Path:
    """The copy of a recording in the cache, copied there if it is not yet, or has changed; a process looks once.

    Raises
    ------
    InputError
        If it cannot be read.
    ExportError
        If it cannot be written.
    """
    if has_copy(address):
        return _recordings[address]
    files = RemoteFiles(address)
    states = files.states("" if is_file else None)
    digest = hashlib.sha256(repr((address, sorted(states.items()))).encode()).hexdigest()[:16]
    path = _copy_of(address, cache_folder() / _RECORDINGS / digest)
    for name in states:
        target = path / name if name else path
        if not target.exists():
            ensure_folder(target.parent)
            files.download(name, target)
    _recordings[address] = path
    return path


def has_copy(address: Address) -> bool:
    """Whether this process uses a copy of a recording."""
    return address in _recordings and _recordings[address].exists()


def spelled(address: Address) -> Path:
    """A path that `restored` turns into an address, for what is read without a copy."""
    return _copy_of(address, cache_folder() / _RECORDINGS / "none")


def forget_recording(address: Address) -> None:
    """Look again whether the recording has changed when it is used next."""
    _recordings.pop(address, None)


# Frames in files.


@contextmanager
def copied(ref: FrameRef) -> Iterator[FrameRef]:
    """Provide a frame on this machine: itself, or with copies of its files at addresses and of what lies beside them,
    meta.json and poses; a recording stays where it is. Within the block, errors name the addresses.

    Raises
    ------
    InputError
        If a file does not exist, or cannot be read, and as `FrameRef.allowed`.
    """
    own = ref.allowed()
    if not any(map(is_address, own.paths)):
        yield own
        return
    files = own.paths if own.depth is not None else own.paths[1:]
    given = [Address(path) for path in files if is_address(path)]
    with temporary_folder(_PREFIX) as temporary, reported():

        def local(path: str) -> str:
            return str(_copy_of(Address(path), temporary)) if is_address(path) else path

        here, folder, beside = own.with_paths(local), "", list[str]()
        if own.frame is not None:
            here = replace(here, rgb=own.rgb)
        elif own.depth is None and is_address(own.rgb):
            _copy_folder(Address(own.rgb), temporary)
        elif own.depth is not None and is_address(own.depth):
            host = "/".join(own.depth.split("/", 3)[:3]) + "/"
            places = (restored(str(path)) for path in pose_files(local(own.depth)))
            beside = [place for place in places if place.startswith(host)]  # a file at its root has no folder above
            if is_address(own.rgb) and own.rgb.rpartition("/")[0] == own.depth.rpartition("/")[0]:
                folder = own.rgb.rpartition("/")[0]
                beside.append(f"{folder}/{META_NAME}")
        _copy_files(given, beside, temporary)
        if folder and Path(local(f"{folder}/{META_NAME}")).exists():
            _copy_folder(Address(folder), temporary)
        yield here


def _copy_files(addresses: Collection[str], wanted: Iterable[str], root: Path) -> None:
    """Copy files, and those wanted that exist; those of a store are read at the same time."""
    by_store: dict[str, tuple[list[str], list[str]]] = defaultdict(lambda: ([], []))
    for number, group in enumerate((addresses, wanted)):
        for address in group:
            protocol, _, rest = address.partition("://")
            store, _, name = rest.partition("/")
            by_store[f"{protocol}://{store}"][number].append(name)
    for store, (names, others) in by_store.items():
        for name, content in zip((*names, *others), RemoteFiles(store).read_all(names, others), strict=True):
            if content is not None:
                path = _copy_of(f"{store}/{name}", root)
                ensure_folder(path.parent)
                write_bytes(path, content)


def _copy_folder(address: Address, root: Path) -> None:
    """Copy the folder of a single frame."""
    names = [*RemoteFiles(address).sizes()]
    if META_NAME not in names and not {"rgb", "depth"} <= {name.partition(".")[0] for name in names}:
        raise no_frame_folder(address)
    if len(names) > _MAX_FILES:
        raise FormatError(f"{address} has more than {_MAX_FILES} files. Give the colour and the depth file.")
    _copy_files([f"{address}/{name}" for name in names], (), root)


def with_addresses(read: T) -> T:
    """What was read from copies, with addresses in its texts: a record with those of all that it holds."""
    made: Any = read
    if isinstance(read, str):
        made = restored(read)
    elif isinstance(read, tuple):
        made = tuple(map(with_addresses, read))
    elif is_dataclass(read):
        held = {one.name: with_addresses(getattr(read, one.name)) for one in fields(read) if one.init}
        made = replace(made, **held | ({"depth": read.measured} if isinstance(read, RGBDFrame) else {}))
    found: T = made
    return found
