"""Which commands were given last."""

from __future__ import annotations

from PySide6.QtCore import QSettings

_KEY = "palette/recent"
_MOST = 30


class RecentCommands:
    """Keys of commands, the last one first.

    Parameters
    ----------
    remembers : bool
        Whether they are those of the last time, and are kept for the next.
    """

    def __init__(self, remembers: bool) -> None:
        self._remembers = remembers
        kept = QSettings().value(_KEY) if remembers else None
        self._keys = [kept] if isinstance(kept, str) else [str(key) for key in kept or []]

    def note(self, key: str) -> None:
        """This one has been given."""
        self._keys = [key, *(other for other in self._keys if other != key)][:_MOST]
        if self._remembers:
            QSettings().setValue(_KEY, self._keys)

    def rank(self, key: str) -> int:
        """0 of the last one, 1 of the one before; as many as there are of one that is not among them."""
        return self._keys.index(key) if key in self._keys else len(self._keys)

    def __contains__(self, key: str) -> bool:
        return key in self._keys
