"""How well what is typed fits the name of a command. No Qt."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple

from PySide6.QtCore import QSettings

from ...base.commands import Entry

_WORD_START, _RUN, _LETTER = 12.0, 6.0, 1.0
_GAP = 0.4
_WHOLE = 20.0
"""For a query that stands in the text as it is."""


class Match(NamedTuple):
    """How well it fits, the more the better, and which letters of the text are meant."""

    score: float
    letters: tuple[int, ...]


def match(query: str, text: str) -> Match | None:
    """Find the letters of a query in a text, in their order, each of the query's words by itself.

    What begins words and what hangs together counts more, and of equals the shorter text.

    Returns
    -------
    Match or None
        None if letters are left over.
    """
    low = text.lower()
    score, letters = 0.0, set[int]()
    for word in query.lower().split():
        found = _best(word, low)
        if found is None:
            return None
        score += found.score
        letters.update(found.letters)
    if query.strip() and query.lower().strip() in low:
        score += _WHOLE
    return Match(score - 0.05 * len(text), tuple(sorted(letters)))


def _best(word: str, text: str) -> Match | None:
    """The best way to find a word's letters in a text: over all places, by the best end of each beginning."""
    starts = {found.start() for found in re.finditer(r"\b\w", text)}
    # best[place]: the word up to here, its last letter standing at that place
    best: dict[int, tuple[float, tuple[int, ...]]] = {}
    for number, letter in enumerate(word):
        there = [place for place, other in enumerate(text) if other == letter]
        following: dict[int, tuple[float, tuple[int, ...]]] = {}
        for place in there:
            own = _LETTER + (_WORD_START if place in starts else 0.0)
            if number == 0:
                following[place] = own, (place,)
                continue
            before = [
                (score + own + (_RUN if last == place - 1 else -_GAP * (place - last)), (*path, place))
                for last, (score, path) in best.items()
                if last < place
            ]
            if before:
                following[place] = max(before)
        best = following
    return Match(*max(best.values())) if best else None


# Which commands were given last.

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


# Which commands are offered for what has been typed, and in which order.

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
