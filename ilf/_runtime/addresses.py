"""Files at addresses (s3://, gs://, https://, hf://), through fsspec and the drivers that the user has installed.

Credentials never come from an address, only from the driver's own configuration, and no message contains any.
"""

from __future__ import annotations

import errno
import io
import os
import posixpath
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO
from urllib.parse import unquote, urlsplit

from ..errors import CREDENTIALS, ExportError, FormatError, IlfError, InputError, one_line, told_as, without_credentials
from .files import MAX_FILE_BYTES, LimitedReader
from .installation import optional, user_path
from .long_work import check_cancelled
from .writing import atomic_path

_PROTOCOLS = "http", "https", "s3", "gs", "hf", "memory"
"""What is opened; memory is that of this process, for tests. Other protocols of fsspec run programs, unpack archives or
read lists that lead elsewhere."""

_BLOCK = 2**22
"""Size of the pieces in which large files are read [bytes]."""

_LONGEST_CAUSE = 200

_WEB = "http", "https"


class Address(str):
    """An address without a slash at its end, its protocol in small letters.

    Raises
    ------
    InputError
        If it is not valid, a chain, of a protocol that is never opened, or contains a user, a password or a query,
        which would be stored with the results.
    """

    __slots__ = ()

    def __new__(cls, text: str) -> Address:
        shown = without_credentials(text)
        if CREDENTIALS.search(text) or re.search(r"[?#].", text):
            raise InputError(
                f"{shown} has a user, a password or a query, which would be stored with the results. Leave them out: "
                "credentials come from the driver's own settings (environment variables, configuration files)."
            )
        if "::" in re.sub(r"\[[^/]*", "", text):  # but for the numbers of a server
            raise InputError(f"{shown} is a chain of addresses, which is never opened. Give the address of the files.")
        protocol, _, rest = text.partition("://")
        with told_as(InputError, f"{shown} is no valid address ({{error}}). Correct it.", ValueError):
            parts = urlsplit(text)
            parts.port  # noqa: B018 - raises ValueError
        if protocol.lower() not in _PROTOCOLS:
            known = ", ".join(f"{name}://" for name in _PROTOCOLS[:-1])
            raise InputError(f"{shown}: this protocol is never opened. Give a path, or one that begins with {known}.")
        if not text.isprintable() or not parts.netloc or re.search(r"[\s\\]", parts.netloc):
            raise InputError(f"{shown} is no valid address. Correct it.")
        return super().__new__(cls, f"{protocol.lower()}://{rest.rstrip('/')}")

    @property
    def name(self) -> str:
        """The last part."""
        return self.rpartition("/")[2]

    @property
    def suffix(self) -> str:
        """The suffix of its name."""
        return Path(self.name).suffix

    @property
    def protocol(self) -> str:
        """What precedes ://."""
        return self.partition("://")[0]

    @property
    def store(self) -> str:
        """The server or the bucket; of hf://, the repository."""
        parts = posixpath.normpath(unquote(self.partition("://")[2])).split("/")
        count = 1 if self.protocol != "hf" else 3 if parts[0] in {"datasets", "spaces"} else 2
        return f"{self.protocol}://{parts[0].lower()}{''.join(f'/{part}' for part in parts[1:count])}"

    def __truediv__(self, name: str) -> Address:
        return type(self)(f"{self}/{name}") if name else self


class RemoteFiles:
    """The files at and below an address.

    Parameters
    ----------
    address : str

    Raises
    ------
    InputError
        If the address is not valid, or its driver is not installed.
    """

    def __init__(self, address: str) -> None:
        self.address = Address(address)
        self._process = 0
        self._own: tuple[Any, str] = None, ""

    def __reduce__(self) -> tuple[type[RemoteFiles], tuple[str]]:
        return type(self), (str(self.address),)

    @property
    def _opened(self) -> tuple[Any, str]:
        """The driver, and the address as it writes it; a process does not use that of another."""
        if self._process != os.getpid():
            self._own, self._process = self._open_driver(), os.getpid()
        return self._own

    def _open_driver(self) -> tuple[Any, str]:
        core = optional("fsspec.core", "ilf-studio[cluster]", f"{self.address.protocol}://")
        try:  # not by url_to_fs, which takes chains
            if self.address.protocol in _WEB:
                from .web import WebFiles

                return WebFiles(), str(self.address)
            driver = core.get_filesystem_class(self.address.protocol)
            given = driver._get_kwargs_from_urls(str(self.address))
            files = driver(**{**given, "use_listings_cache": False})
            root = driver._strip_protocol(str(self.address))
        except ImportError as error:
            package = getattr(error.__cause__ or error, "name", None) or str(error)
            raise InputError(f"{self.address.protocol}:// needs {package}: run pip install {package}.") from error
        except ValueError as error:
            raise InputError(f"{self.address}: {one_line(str(error)):.{_LONGEST_CAUSE}}. Check the address.") from error
        return files, root.rstrip("/")

    @property
    def _driver(self) -> Any:
        return self._opened[0]

    def _path(self, name: str) -> str:
        root = self._opened[1]
        return f"{root}/{name}" if name else root

    # Reading. The name "" is the address itself.

    def sizes(self) -> dict[str, int]:
        """The names of the files directly in the folder, with their sizes [bytes]; empty if there is no such folder."""
        with self._reported(self.address):
            try:
                listed = self._driver.ls(self._path(""), detail=True)
            except FileNotFoundError:
                return {}
            found = {one["name"]: one.get("size") for one in listed if one["type"] == "file"}
            unknown = [path for path, size in found.items() if size is None]  # pages of links state no sizes
            found |= zip(unknown, self._driver.sizes(unknown), strict=True)
        return {path.rpartition("/")[2]: size or 0 for path, size in found.items()}

    def find(self) -> list[str]:
        """The names of all files below, relative to the address, or [""] if it is a file; hidden ones are left out, and
        so are names that could leave a folder.

        Raises
        ------
        InputError
            If there are none, or they cannot be listed.
        """
        with self._reported(self.address):
            return self._below(self._driver.find(self._path("")))

    def states(self, name: str | None = None) -> dict[str, str]:
        """A file, or all files below as by `find`, each with a text that changes with its content."""
        with self._reported(self.address):
            if name is not None:
                return {name: _state(self._driver.info(self._path(name)))}
            found = self._driver.find(self._path(""), detail=True)
            return {name: _state(found[self._path(name)]) for name in self._below(found)}

    def _below(self, paths: Iterable[str]) -> list[str]:
        start = len(self._path("")) + 1
        names = [name for path in paths if _is_plain(name := path[start:])]
        if not names:
            with suppress(FileNotFoundError):  # drivers take some failures for an empty folder
                self._driver.info(self._path(""))
            raise InputError(f"{self.address}: there is no such folder or file. Check the address.")
        return names

    def size(self, name: str = "") -> int:
        """The size of a file [bytes]; raises InputError if there is none."""
        with self._reported(self.address / name):
            return int(self._driver.info(self._path(name))["size"] or 0)

    def exists(self, name: str) -> bool:
        """Whether there is such a file."""
        with self._reported(self.address / name):
            try:
                return bool(self._driver.info(self._path(name))["type"] == "file")
            except FileNotFoundError:
                return False

    def read(self, name: str = "") -> bytes:
        """The content of a file of up to 1 GiB."""
        (content,) = self.read_all([name])
        assert content is not None
        return content

    def read_all(self, names: Sequence[str], wanted: Sequence[str] = ()) -> list[bytes | None]:
        """The contents of files of up to 1 GiB in all, read at the same time; None for those of `wanted` that do not
        exist.

        Raises
        ------
        InputError
            If one of `names` does not exist, or any cannot be read.
        FormatError
            If they are larger.
        """
        every = [*names, *wanted]
        paths, most = [self._path(name) for name in every], MAX_FILE_BYTES + 1  # of a larger one, no more is taken
        with self._reported(self.address):
            found = self._driver.cat_ranges(paths, [0] * len(paths), [most] * len(paths), on_error="return")
        contents: list[bytes | None] = []
        for number, (name, content) in enumerate(zip(every, found, strict=True)):
            if number >= len(names) and isinstance(content, FileNotFoundError | PermissionError):
                contents.append(None)  # some stores deny what does not exist
                continue
            with self._reported(self.address / name):
                if isinstance(content, BaseException):
                    is_final = isinstance(content, FileNotFoundError | PermissionError | TimeoutError)
                    if is_final or self._driver.info(self._path(name))["size"] != 0:
                        raise content
                    content = b""  # stores have no pieces of an empty file
            contents.append(content)
        if sum(len(content or b"") for content in contents) > MAX_FILE_BYTES:
            raise FormatError(f"{self.address} has more than 1 GiB to be read at a time. Is this the right file?")
        return contents

    def read_ranges(self, names: Sequence[str], starts: Sequence[int], ends: Sequence[int]) -> list[bytes]:
        """Pieces of files from start to before end, read at the same time; raises FormatError beyond 1 GiB in all."""
        if sum(ends) - sum(starts) > MAX_FILE_BYTES:
            raise FormatError(f"{self.address}: more than 1 GiB is to be read at a time. Is this the right file?")
        with self._reported(self.address):
            found: list[bytes] = self._driver.cat_ranges(
                [self._path(name) for name in names], list(starts), list(ends), on_error="return"
            )
        for name, content in zip(names, found, strict=True):
            if isinstance(content, BaseException):
                with self._reported(self.address / name):
                    raise content
        return found

    def open(self, name: str) -> BinaryIO:
        """Open a file for reading in sequence. If it has another size than stated, or more than 1 GiB where none is
        stated, reading it raises InputError."""
        with self._reported(self.address / name):
            size = self._driver.info(self._path(name))["size"]
            raw = self._driver.open(self._path(name), "rb", block_size=_BLOCK)
            return LimitedReader(_Reported(self, self.address / name, raw, size), _BLOCK)

    def download(self, name: str, target: Path) -> None:
        """Copy a file of any size; raises as `read`, ExportError, or Cancelled."""
        with atomic_path(target) as temporary, open(temporary, "wb") as file, self.open(name) as stream:
            while block := stream.read(_BLOCK):
                check_cancelled()
                file.write(block)

    # Writing.

    def upload(self, source: Path, name: str) -> None:
        """Write a file, once and whole; raises ExportError if that fails, or the store has another size then."""
        with self._reported(self.address / name, writing=True):
            self._driver.put_file(str(source), self._path(name))
            size = int(self._driver.info(self._path(name))["size"])
        if size != (whole := source.stat().st_size):
            raise ExportError(
                f"Could not write {self.address / name}: it has {size} bytes instead of {whole}. Try again."
            )

    def remove(self, name: str) -> None:
        """Remove a file; raises ExportError if that fails."""
        with self._reported(self.address / name, writing=True):
            self._driver.rm_file(self._path(name))

    @contextmanager
    def _reported(self, address: str, *, writing: bool = False) -> Iterator[None]:
        """Within the block, turn errors of the driver into errors that name the address and contain no credentials."""
        try:
            yield
        except (IlfError, MemoryError):
            raise
        except Exception as error:  # drivers raise errors of many packages
            raise self._described(address, error, writing) from None

    def _described(self, address: str, error: BaseException, writing: bool) -> IlfError:
        """The error to raise for an error of the driver."""
        if isinstance(error.__cause__, OSError) and not isinstance(error, OSError):
            error = error.__cause__  # the failure of the network
        status = getattr(error, "status", None)
        text = str(error) or type(error).__name__ if status is None else f"status {status}"
        reason = without_credentials(one_line(text))[:_LONGEST_CAUSE].rstrip(".")
        if writing:
            return ExportError(
                f"Could not write {address} ({reason}). Check credentials, network and the space there, and try again."
            )
        if isinstance(error, FileNotFoundError):
            why = "there is no such file or folder. Check the address."
        elif isinstance(error, PermissionError) or status in {401, 403}:
            why = f"access is denied ({reason}). Check the address, and the credentials in the driver's settings."
        elif getattr(error, "errno", None) == errno.ECONNREFUSED:
            why = "the server refuses the connection. Check the address, and that the server runs."
        elif isinstance(error, TimeoutError):
            why = "the server does not answer, or too slowly. Check the connection, and try again."
        else:
            why = f"cannot be read ({reason}). Check the address, the credentials and the network, and try again."
        return InputError(f"{address}: {why}")


class _Reported(io.RawIOBase):
    """A stream of a driver whose errors are reported as those of `RemoteFiles`, as are too few bytes or too many."""

    def __init__(self, files: RemoteFiles, address: str, stream: BinaryIO, size: int | None) -> None:
        self.name = address
        self._files, self._stream, self._size, self._read = files, stream, size, 0

    def readable(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int:
        check_cancelled()
        with self._files._reported(self.name):
            data = self._stream.read(len(buffer))
        self._read += len(data)
        if self._size is None:
            if self._read > MAX_FILE_BYTES:
                raise FormatError(f"{self.name}: the server states no size and sends more than 1 GiB.")
        elif self._read > self._size or (not data and self._read < self._size):
            raise InputError(f"{self.name}: the server sends {self._read} bytes instead of {self._size}. Try again.")
        buffer[: len(data)] = data
        return len(data)

    def close(self) -> None:
        self._stream.close()
        super().close()


_STATES = ("size", "ETag", "etag", "md5Hash", "mtime", "LastModified", "last_modified", "Last-Modified", "created")


def _state(info: Mapping[str, Any]) -> str:
    return repr([str(info.get(key)) for key in _STATES])


def _is_plain(name: str) -> bool:
    """Whether a relative name is that of a visible file below: no part hidden, empty or with other meanings."""
    parts = name.split("/")
    return not re.search(r"[\\?#\0]", name) and (name == "" or all(part and not part.startswith(".") for part in parts))


def cache_folder() -> Path:
    """The folder of copies of recordings and of results that wait to be written to an address."""
    return user_path("cache", "", "ILF_CACHE").absolute()
