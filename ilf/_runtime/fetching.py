"""One file from a web server, whole and right or not at all: resumed after a cut, checked, renamed into place."""

from __future__ import annotations

import os
from collections.abc import Callable
from http.client import HTTPException, HTTPResponse
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen

from filelock import FileLock, Timeout

from ..errors import ExportError, InputError, cause
from .cancellation import check_cancelled
from .files import file_sha256
from .installation import __version__
from .writing import ensure_folder, remedy

Progress = Callable[[int, int], object]
"""Called with the number of bytes that are here, and of all."""

SILENCE_S = 30.0
"""Time limit of a connection, and of waiting for more bytes [s]."""

_BLOCK = 2**18
_TRIES = 4
"""Number of connections, where they are cut."""

ROUNDED = 0.01
"""Relative difference up to which a size is a rounded one of the file; its hash tells the rest."""

_MARK = ".etag"
"""Suffix of the file beside the part with what tells one version of the file from another."""

_NOTHING_LEFT = 416
"""Status of an answer to a question for what comes after the end."""


class _CutError(Exception):
    """The connection ended before the file did."""


def fetch(
    address: str,
    target: Path,
    size: int,
    sha256: str | None,
    progress: Progress | None = None,
    check: Callable[[Path, str], object] | None = None,
) -> str:
    """Fetch a file, and return its SHA-256 in hexadecimal digits.

    If the connection is cut or the work is cancelled, what has come stays in a hidden file beside the target, and the
    next call continues there if the server has the same file still.

    Parameters
    ----------
    address : str
        https:// or http://.
    target : Path
        It appears when all is right.
    size : int
        Size of the file [bytes], which may be rounded.
    sha256 : str or None
        Its hash; None if it is not known.
    progress : callable, optional
        See `Progress`.
    check : callable, optional
        Called with the path of the whole file and its hash before it appears; may raise.

    Raises
    ------
    InputError
        If the server cannot be reached, or has no such file or another one.
    ExportError
        If the file cannot be written, or another process is fetching it.
    Cancelled
    """
    if not address.startswith(("https://", "http://")):
        raise InputError(f"{address} is not an address of a web server (https://). Correct it.")
    part = ensure_folder(target.parent) / f".{target.name}.part"
    try:
        with FileLock(part.with_suffix(".lock"), timeout=0):
            _received(address, part, size, progress)
            found = file_sha256(part)
            try:
                if sha256 not in {None, found}:
                    why = f"the SHA-256 is {found} instead of {sha256}"
                    raise InputError(f"{address}: {why}, so the file is not used. Ask its publisher.")
                if check is not None:
                    check(part, found)
            except InputError:
                part.unlink()
                part.with_suffix(_MARK).unlink()
                raise
            os.replace(part, target)
            part.with_suffix(_MARK).unlink()
    except Timeout as error:
        raise ExportError(f"Another process is fetching {target.name} now. Wait until it has ended.") from error
    except OSError as error:
        raise ExportError(f"Could not write {target}: {remedy(error)}.") from error
    return found


def _received(address: str, part: Path, size: int, progress: Progress | None) -> None:
    """Complete the part by one connection or, if they are cut, by several."""
    for left in reversed(range(_TRIES)):
        try:
            _receive(address, part, size, progress)
        except _CutError as error:
            if not left:
                raise InputError(f"{address}: cut again and again ({error}). Repeat the command to go on.") from error
        else:
            return


def _receive(address: str, part: Path, size: int, progress: Progress | None) -> None:
    """Append to the part what it lacks, or write it anew where the server does not continue it."""
    mark = part.with_suffix(_MARK)
    tag = mark.read_text(encoding="utf-8") if mark.is_file() else ""
    have = part.stat().st_size if tag and part.is_file() else 0
    headers = {"User-Agent": f"ilf-studio/{__version__}", "Accept-Encoding": "identity"}
    if have:
        headers |= {"Range": f"bytes={have}-", "If-Range": tag}
    with _answer(Request(address, headers=headers)) as answer:
        if answer.status == _NOTHING_LEFT and answer.headers.get("Content-Range") == f"bytes */{have}":
            return
        is_next = answer.headers.get("Content-Range", "").startswith(f"bytes {have}-")
        if answer.status == _NOTHING_LEFT or (answer.status == 206 and not is_next):
            mark.unlink()
            raise _CutError("the server does not send the part that was asked for")
        have = have if answer.status == 206 else 0
        stated = answer.headers.get("Content-Length")
        whole = size if stated is None else have + int(stated)
        if address.startswith("https:") and not answer.url.startswith("https:"):
            raise InputError(f"{address}: the server leads to an address without encryption, which is not opened.")
        tolerance = ROUNDED * size
        if abs(whole - size) > tolerance:
            raise InputError(f"{address}: the file has {whole} bytes instead of {size}, so it is another one.")
        entity = answer.headers.get("ETag", "")
        mark.write_text("" if entity.startswith("W/") else entity, encoding="utf-8")
        with open(part, "ab" if have else "wb") as file:
            while have <= whole + tolerance and (block := _next(answer)):
                check_cancelled()
                file.write(block)
                have += len(block)
                if progress is not None:
                    progress(have, max(whole, have))
    if have < whole - (0 if stated else tolerance):
        raise _CutError(f"after {have} of {whole} bytes")
    if have > whole + tolerance:
        raise InputError(f"{address}: the server sends more than {whole} bytes, so it is another file.")


def _answer(request: Request) -> HTTPResponse | HTTPError:
    """Connect to a server; raise _CutError if it may answer later, InputError if it does not."""
    try:
        answer: HTTPResponse = urlopen(request, timeout=SILENCE_S)
    except HTTPError as error:
        if error.code == _NOTHING_LEFT:
            return error
        told = f"status {error.code}, {error.reason}"
        if error.code >= 500:
            raise _CutError(told) from error
        raise InputError(
            f"{request.full_url}: the server refuses it ({told}). Open the address in a browser."
        ) from error
    except (OSError, HTTPException) as error:
        why = getattr(error, "reason", error)
        reason = cause(why) if isinstance(why, Exception) else str(why)
        raise InputError(f"{request.full_url}: cannot be reached ({reason}). Check the connection.") from error
    return answer


def _next(answer: HTTPResponse | HTTPError) -> bytes:
    try:
        return answer.read1(_BLOCK)
    except (OSError, HTTPException) as error:
        raise _CutError(cause(error)) from error
