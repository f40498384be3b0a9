"""Objects that are closed at the end of a with-block."""

from __future__ import annotations

from typing import Self


class Closeable:
    """A context manager for itself, closed at its end."""

    def close(self) -> None:
        """Close it."""
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
