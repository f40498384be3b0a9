"""A web server of a test's own on this machine."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any


@contextmanager
def serving(handler: Callable[..., Any]) -> Iterator[str]:
    """The address of a server with this handler of requests, which ends with the block."""
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        thread = threading.Thread(target=server.serve_forever, args=(0.01,))
        thread.start()
        try:
            yield f"http://127.0.0.1:{server.server_port}"
        finally:
            server.shutdown()
            thread.join()


@contextmanager
def serving_folder(folder: Path) -> Iterator[tuple[str, list[str]]]:
    """The address of a folder on a server, and the paths that are asked for."""
    asked: list[str] = []
    noting = {"log_message": lambda handler, *_: asked.append(handler.path)}
    with serving(partial(type("Noting", (SimpleHTTPRequestHandler,), noting), directory=str(folder))) as address:
        yield address, asked
