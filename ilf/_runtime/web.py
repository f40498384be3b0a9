"""The driver of http:// and https://: fsspec's, with limits of time and size, and with true reasons of failures."""

from __future__ import annotations

import re
from typing import Any

import aiohttp
from fsspec.asyn import sync
from fsspec.implementations.http import HTTPFileSystem, HTTPStreamFile

CONNECT_S, SILENCE_S = 10.0, 30.0
"""Time limits of a connection, and of waiting for more bytes [s]."""

_MAX_PAGE_BYTES = 2**26
"""Maximum size of a page of links."""

_RANGE = re.compile(r"bytes=(\d+)-(\d+)")


class _Response(aiohttp.ClientResponse):
    """An answer of whose body no more is read than was asked for."""

    async def read(self) -> bytes:
        if self._body is None:
            asked = _RANGE.fullmatch(self.request_info.headers.get("Range", ""))
            first, last = (0, _MAX_PAGE_BYTES) if asked is None else map(int, asked.groups())
            skipped = 0 if self.status == 206 else first  # some servers send whole files
            self._body = await self._read_piece(skipped, last + 1 - first)
            if asked is None and len(self._body) > _MAX_PAGE_BYTES:
                raise OSError(f"it is a page of more than {_MAX_PAGE_BYTES / 2**20:g} MiB")
        return self._body

    async def _read_piece(self, start: int, size: int) -> bytes:
        parts, left = [], size
        while left > 0 and (part := await self.content.readany()):
            part, start = part[start : start + left], max(start - len(part), 0)
            parts.append(part)
            left -= len(part)
        if not self.content.at_eof():
            self.close()
        return b"".join(parts)


class WebFiles(HTTPFileSystem):
    """The driver; its arguments are those of the user's configuration of fsspec."""

    def __init__(self, client_kwargs: dict[str, Any] | None = None, **options: Any) -> None:
        session = dict(client_kwargs or {})
        session["headers"] = {"Accept-Encoding": "identity", **session.get("headers", {})}
        session["timeout"] = aiohttp.ClientTimeout(total=None, sock_connect=CONNECT_S, sock_read=SILENCE_S)
        session["response_class"] = _Response
        super().__init__(client_kwargs=session, **{**options, "use_listings_cache": False})

    async def _ls_real(self, url: str, detail: bool = True, **kwargs: Any) -> Any:
        try:
            return await super()._ls_real(url, detail, **kwargs)
        except FileNotFoundError:
            raise
        except OSError as error:
            raise aiohttp.ClientError(url) from error  # fsspec takes an OSError for an empty folder

    async def _info(self, url: str, **_: Any) -> dict[str, Any]:
        """The size, None if it is not stated, and what changes with the content; fsspec's takes any failure for a
        missing file."""
        session = await self.set_session()
        for method in ("HEAD", "GET"):
            async with session.request(method, self.encode_url(url), allow_redirects=True, **self.kwargs) as answer:
                size = None if "Content-Encoding" in answer.headers else answer.headers.get("Content-Length")
                if method == "HEAD" and (size is None or answer.status >= 400):
                    continue  # some servers do not answer it as they answer GET
                self._raise_not_found_for_status(answer, url)
                states = {name: answer.headers.get(name) for name in ("ETag", "Last-Modified")}
                return {"name": url, "type": "file", "size": None if size is None else int(size), **states}
        raise AssertionError

    def _open(self, path: str, *_: Any, **__: Any) -> HTTPStreamFile:
        return HTTPStreamFile(self, path, loop=self.loop, session=sync(self.loop, self.set_session), **self.kwargs)
