"""How well what is typed fits the name of a command. No Qt."""

from __future__ import annotations

import re
from typing import NamedTuple

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
