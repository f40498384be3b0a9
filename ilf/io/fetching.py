"""One file from a web server, whole and right or not at all: continued after a cut, checked, renamed into place."""

from __future__ import annotations

import os
from collections.abc import Callable
from http.client import HTTPException, HTTPResponse
from pathlib import Path
from urllib.error import HTTPError
from urllib.request import Request, urlopen

from filelock import FileLock, Timeout

from .._runtime.files import file_sha256
from .._runtime.installation import __version__
from .._runtime.long_work import check_cancelled
from .._runtime.writing import ensure_folder, remedy
from ..errors import ExportError, InputError, cause

Progress = Callable[[int, int], object]
"""Called with the number of bytes that are here, and of all."""

_SILENCE_S = 30.0
"""Time limit of a connection, and of waiting for more bytes [s]."""

_BLOCK = 2**18

ROUNDED = 0.01
"""Relative difference up to which a size is a rounded one of the file; its hash tells the rest."""

_NOTHING_LEFT = 416
"""Status of an answer to a question for what comes after the end."""


def fetch(
    address: str,
    target: Path,
    size: int,
    sha256: str | None,
    progress: Progress | None,
    check: Callable[[Path, str], object],
) -> str:
    """Fetch a file, and return its SHA-256 in hexadecimal digits.

    If the connection is cut or the work is cancelled, what has come stays in a hidden file beside the target, and the
    next call continues there if the hash is known, which tells whether the server had the same file still.

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
    progress : callable or None
        See `Progress`.
    check : callable
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
            if sha256 is None:
                part.unlink(missing_ok=True)
            _receive(address, part, size, progress)
            found = file_sha256(part)
            try:
                if sha256 not in {None, found}:
                    why = f"the SHA-256 is {found} instead of {sha256}"
                    raise InputError(f"{address}: {why}, so the file is not used. Try again, or ask its publisher.")
                check(part, found)
            except InputError:
                part.unlink()
                raise
            os.replace(part, target)
    except Timeout as error:
        raise ExportError(f"Another process is fetching {target.name} now. Wait until it has ended.") from error
    except OSError as error:
        raise ExportError(f"Could not write {target}: {remedy(error)}.") from error
    return found


def _receive(address: str, part: Path, size: int, progress: Progress | None) -> None:
    """Append to the part what it lacks, or write it anew where the server sends the whole file."""
    have = part.stat().st_size if part.is_file() else 0
    headers = {"User-Agent": f"ilf-studio/{__version__}", "Accept-Encoding": "identity"}
    if have:
        headers["Range"] = f"bytes={have}-"
    tolerance = ROUNDED * size
    with _answer(Request(address, headers=headers)) as answer:
        if answer.status == _NOTHING_LEFT:
            return
        have = have if answer.status == 206 else 0
        stated = answer.headers.get("Content-Length")
        whole = size if stated is None else have + int(stated)
        if address.startswith("https:") and not answer.url.startswith("https:"):
            raise InputError(f"{address}: the server leads to an address without encryption, which is not opened.")
        if abs(whole - size) > tolerance:
            raise InputError(f"{address}: the file has {whole} bytes instead of {size}, so it is another one.")
        with open(part, "ab" if have else "wb") as file:
            while block := _next(answer, address):
                check_cancelled()
                file.write(block)
                have += len(block)
                if have > whole + tolerance:
                    file.truncate(0)
                    raise InputError(f"{address}: the server sends more than {whole} bytes, so it is another file.")
                if progress is not None:
                    progress(have, max(whole, have))
    if have < whole - (0 if stated else tolerance):
        raise InputError(f"{address}: cut after {have} of {whole} bytes. Repeat the command to go on.")


def _answer(request: Request) -> HTTPResponse | HTTPError:
    """Connect to a server; raise InputError if it does not answer with the file."""
    try:
        answer: HTTPResponse = urlopen(request, timeout=_SILENCE_S)
    except HTTPError as error:
        if error.code == _NOTHING_LEFT:
            return error
        told = f"{request.full_url}: the server refuses it (status {error.code}, {error.reason})"
        raise InputError(f"{told}. Open the address in a browser, or try again later.") from error
    except (OSError, HTTPException) as error:
        why = getattr(error, "reason", error)
        reason = cause(why) if isinstance(why, Exception) else str(why)
        raise InputError(f"{request.full_url}: cannot be reached ({reason}). Check the connection.") from error
    return answer


def _next(answer: HTTPResponse | HTTPError, address: str) -> bytes:
    try:
        return answer.read1(_BLOCK)
    except (OSError, HTTPException) as error:
        raise InputError(f"{address}: cut ({cause(error)}). Repeat the command to go on.") from error
