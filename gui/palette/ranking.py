"""Which commands are offered for what has been typed, and in which order."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from gui.inventory import Entry
from gui.palette.matching import match
from gui.palette.recent import RecentCommands

_IN_HINT = -30.0
"""What only the explanation of a command has in it comes after what its name has."""
_RECENT = 10.0
"""For the command that was given last, less for those before."""
_DISABLED = -8.0
"""What cannot be given now comes after its like."""


class Offer(NamedTuple):
    """A command, and the letters of its text that are meant."""

    entry: Entry
    letters: tuple[int, ...]


def offers(entries: Iterable[Entry], query: str, recent: RecentCommands) -> list[Offer]:
    """The commands that fit, best first; without a query all of them, those given last first."""
    if not query.strip():
        return [Offer(entry, ()) for entry in sorted(entries, key=lambda entry: recent.rank(entry.key))]
    fitting = []
    for entry in entries:
        found = _score(entry, query)
        if found is not None:
            score, letters = found
            bonus = _RECENT / (1 + recent.rank(entry.key)) if entry.key in recent else 0.0
            able = 0.0 if entry.action.isEnabled() else _DISABLED
            fitting.append((score + bonus + able, Offer(entry, letters)))
    return [offer for _, offer in sorted(fitting, key=lambda fit: -fit[0])]


def _score(entry: Entry, query: str) -> tuple[float, tuple[int, ...]] | None:
    """By its text, by its text with its menu, or, for whole words only, by its explanation."""
    found = match(query, entry.text)
    if found is not None:
        return found
    found = match(query, f"{entry.text} {entry.where}")
    if found is not None:
        return found.score + _IN_HINT / 2, tuple(letter for letter in found.letters if letter < len(entry.text))
    hint = entry.action.toolTip().lower()
    if all(word in hint for word in query.lower().split()):
        return _IN_HINT, ()
    return None
