"""Which frames of the list are shown, and in which order. No widgets."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import lru_cache

from gui.frame_list.words import STAGE_WORDS
from gui.state.entries import Entry
from ilf.io.pairing import natural
from ilf.project import Stage

STATES: dict[str, str] = {
    "all": "All",
    **STAGE_WORDS,
    "note": "With a note",
    "check": "To check",
    "unsaved": "Unsaved",
}
"""What frames can be chosen by, in words."""

ORDERS: dict[str, str] = {
    "list": "In order of the list",
    "name": "By name",
    "state": "By state",
    "missing": "Most missing first",
}
"""What they can be sorted by, in words."""

_RANKS = {stage: rank for rank, stage in enumerate(Stage)}
_natural = lru_cache(maxsize=20_000)(natural)

_KEYS: dict[str, Callable[[Entry], object]] = {
    "name": lambda entry: _natural(entry.name),
    "state": lambda entry: _RANKS[entry.summary.stage],
    "missing": lambda entry: -1.0 if (missing := entry.summary.missing) is None else -missing - 2,
}


@dataclass(frozen=True)
class Sieve:
    """What the user wants to see of the list.

    Attributes
    ----------
    text : str
        Words, all of which stand in name or note.
    state : str
        One of `STATES`.
    order : str
        One of `ORDERS`.
    """

    text: str = ""
    state: str = "all"
    order: str = "list"

    def shown(self, entries: Iterable[Entry], always: Entry | None = None) -> list[Entry]:
        """Entries that get through, in their order; one of them may always do so."""
        words = self.text.casefold().split()
        through = [
            entry
            for entry in entries
            if entry is always
            or ((self.state == "all" or self.state in states_of(entry)) and (not words or _has(entry, words)))
        ]
        key = _KEYS.get(self.order)
        return through if key is None else sorted(through, key=key)  # type: ignore[arg-type]


def states_of(entry: Entry) -> tuple[str, ...]:
    """All of `STATES` that an entry is in."""
    summary = entry.summary
    found = ["all", str(summary.stage)]
    found += ["note"] * bool(summary.note) + ["check"] * bool(summary.to_check) + ["unsaved"] * entry.unsaved
    return tuple(found)


def counts(entries: Iterable[Entry]) -> Counter[str]:
    """How many entries are in which state."""
    return Counter(state for entry in entries for state in states_of(entry))


def _has(entry: Entry, words: list[str]) -> bool:
    text = f"{entry.name} {entry.note}".casefold()
    return all(word in text for word in words)
