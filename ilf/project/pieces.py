"""Which pieces the parts of a journal are made of: parts share those that are equal, so that each is kept once."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .strips import chunks

Numbers = NDArray[np.int64]
"""Of pieces, in their order."""


@dataclass(frozen=True, eq=False)
class Change:
    """What becomes of the pieces when parts come and go.

    Attributes
    ----------
    parts : dict of str to ndarray of int64
        The parts that come, or come anew, and what they are made of.
    made : dict of int to bytes
        New pieces.
    gone : frozenset of int
        Pieces that no part is made of any more.
    """

    parts: dict[str, Numbers]
    made: dict[int, bytes]
    gone: frozenset[int]
    _dropped: frozenset[str]
    _numbers: dict[bytes, int]
    _uses: Counter[int]


class Pieces:
    """Knows the pieces of all parts.

    Parameters
    ----------
    parts : mapping of str to ndarray of int64
        Those that there are already; their pieces are not compared with new ones.

    Examples
    --------
    >>> pieces = Pieces()
    >>> change = pieces.change({"a": b"one", "b": b"one", "c": b"two"}, drop=[])
    >>> sorted(change.made.values())
    [b'one', b'two']
    >>> pieces.take(change)
    >>> sorted(pieces.change({"a": b"two"}, drop=["b"]).gone) == [int(change.parts["a"][0])]
    True
    """

    def __init__(self, parts: Mapping[str, Numbers] | None = None) -> None:
        self._parts = dict(parts or {})
        self._uses = Counter(number for numbers in self._parts.values() for number in numbers.tolist())
        self._numbers: dict[bytes, int] = {}
        """Digest of a piece's content -> its number."""
        self._next = max(self._uses, default=0) + 1

    def change(self, put: Mapping[str, bytes], drop: Collection[str]) -> Change:
        """What would become of them; nothing has changed until it is taken."""
        dropped = frozenset(drop) - put.keys()
        uses: Counter[int] = Counter()
        for name in dropped | put.keys():
            uses.subtract(self._parts[name].tolist() if name in self._parts else ())
        made: dict[int, bytes] = {}
        numbers: dict[bytes, int] = {}
        parts = {}
        for name, content in put.items():
            parts[name] = np.array([self._number(piece, made, numbers) for piece in _cut(name, content)], np.int64)
            uses.update(parts[name].tolist())
        gone = frozenset(number for number, more in uses.items() if self._uses[number] + more <= 0)
        return Change(parts, made, gone, dropped, numbers, uses)

    def take(self, change: Change) -> None:
        """It has been made."""
        for name in change._dropped:
            self._parts.pop(name, None)
        self._parts |= change.parts
        self._numbers |= change._numbers
        self._uses.update(change._uses)
        self._next += len(change.made)
        if change.gone:
            self._numbers = {digest: number for digest, number in self._numbers.items() if number not in change.gone}
            for number in change.gone:
                del self._uses[number]

    def _number(self, piece: bytes, made: dict[int, bytes], numbers: dict[bytes, int]) -> int:
        digest = hashlib.blake2b(piece, digest_size=20).digest()
        known = self._numbers.get(digest) or numbers.get(digest)
        if known is not None:
            return known
        number = numbers[digest] = self._next + len(made)
        made[number] = piece
        return number


def _cut(name: str, content: bytes) -> Iterator[bytes]:
    return chunks(content) if name.endswith(".png") else iter([content] if content else [])
