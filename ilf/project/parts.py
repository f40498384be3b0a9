"""What keeps the parts of a project: bytes by name, in a project file or in a journal."""

from __future__ import annotations

from collections.abc import Collection
from typing import Protocol


class Parts(Protocol):
    """Bytes by name. Safe from several threads."""

    def names(self) -> Collection[str]:
        """All names."""
        ...

    def read(self, name: str) -> bytes:
        """The bytes of a name.

        Raises
        ------
        InputError
            If there is no such part, or it cannot be read or is damaged.
        """
        ...
