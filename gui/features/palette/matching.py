"""Fuzzy matching of typed text with the names of commands. No widgets."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from PySide6.QtCore import QSettings

from ...base.commands import ActionEntry

_WORD_START, _RUN, _LETTER = 12.0, 6.0, 1.0
_GAP = 0.4
_WHOLE = 20.0
"""Bonus if the text contains the whole query."""


class Match(NamedTuple):
    """Score of a match, higher is better, and the positions of the matched letters."""

    score: float
    letters: tuple[int, ...]


def match(query: str, text: str) -> Match | None:
    """Match the letters of a query in a text, in order, separately for each word of the query.

    Word starts and consecutive letters score higher, and so do shorter texts.

    Returns
    -------
    Match or None
        None if not all letters are found.
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
    """Return the best match of a word's letters in a text, by dynamic programming over the letters."""
    starts = {found.start() for found in re.finditer(r"\b\w", text)}
    # best[place]: best match of the word so far with its last letter at that place
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


# Recently used commands.

_KEY = "palette/recent"
_MOST = 30


class RecentCommands:
    """Keys of recently used commands, the latest first.

    Parameters
    ----------
    persistent : bool
        Whether they are stored between program starts.
    """

    def __init__(self, persistent: bool) -> None:
        self._persistent = persistent
        kept = QSettings().value(_KEY) if persistent else None
        self._keys = [kept] if isinstance(kept, str) else [str(key) for key in kept or []]

    def note(self, key: str) -> None:
        """Add a command as the latest."""
        self._keys = [key, *(other for other in self._keys if other != key)][:_MOST]
        if self._persistent:
            QSettings().setValue(_KEY, self._keys)

    def rank(self, key: str) -> float:
        """Return the rank of a command: 0 for the latest; infinite if it is not among them."""
        return self._keys.index(key) if key in self._keys else math.inf


# Commands that match a query, in order.

_IN_HINT = -30.0
"""Penalty for a match in the tooltip only."""
_RECENT = 10.0
"""Bonus for the latest command, less for earlier ones."""
_DISABLED = -8.0
"""Penalty for a disabled command."""


@dataclass(frozen=True, eq=False)
class Offer:
    """A command, and the positions of the matched letters in its text."""

    entry: ActionEntry
    letters: tuple[int, ...]


def offers(entries: Iterable[ActionEntry], query: str, recent: RecentCommands) -> list[Offer]:
    """Return the matching commands, best first; all commands for an empty query, recently used ones first."""
    if not query.strip():
        return [Offer(entry, ()) for entry in sorted(entries, key=lambda entry: recent.rank(entry.key))]
    fitting = []
    for entry in entries:
        found = _score(entry, query)
        if found is not None:
            score, letters = found
            score += _RECENT / (1 + recent.rank(entry.key)) + (_DISABLED if entry.why_not else 0.0)
            fitting.append((score, Offer(entry, letters)))
    return [offer for _, offer in sorted(fitting, key=lambda fit: -fit[0])]


def _score(entry: ActionEntry, query: str) -> tuple[float, tuple[int, ...]] | None:
    """Return the score by the text, by text and menu, or, for whole words only, by the tooltip."""
    found = match(query, entry.text)
    if found is not None:
        return found
    found = match(query, f"{entry.text} {entry.where}")
    if found is not None:
        return found.score + _IN_HINT / 2, tuple(letter for letter in found.letters if letter < len(entry.text))
    hint = entry.hint.lower()
    if all(word in hint for word in query.lower().split()):
        return _IN_HINT, ()
    return None
