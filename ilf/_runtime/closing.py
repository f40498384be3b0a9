"""Objects that are closed at the end of a with-block."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Self


class Closeable:
    """A context manager for itself, closed at its end."""

    def close(self) -> None:
        """Close it."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@contextmanager
def closed_on_error(opened: Any) -> Iterator[None]:
    """Close what was opened if the block, which prepares it, fails."""
    try:
        yield
    except BaseException:
        opened.close()
        raise
