"""Errors pixel by pixel, and what they come to: together, part by part, block by block."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce

import numpy as np
from numpy.typing import NDArray

from ..run import Run
from .judging import Judgement, by_label, judge

ENOUGH = 0.9
"""Who fills a smaller share of what the best fills is not compared: the others would be judged on the easy pixels only
that are left."""

Values = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class PixelErrors:
    """Pixels that should have been filled, what they came to, and what would have been right.

    Attributes
    ----------
    places : ndarray of int, shape (N,)
        Where they lie in the flattened frame, in rising order.
    depth, truth, expected : ndarray of float32, shape (N,)
        Completed depth and truth [m] and the expected error [m]; NaN where the pixel was left open.
    """

    places: NDArray[np.intp]
    depth: Values
    truth: Values
    expected: Values

    @property
    def error(self) -> Values:
        """Completed depth - truth [m], NaN where the pixel was left open."""
        return self.depth - self.truth

    @property
    def filled(self) -> NDArray[np.bool_]:
        """Which of the pixels have come to any depth."""
        return np.isfinite(self.depth)

    def among(self, places: NDArray[np.intp]) -> PixelErrors:
        """The same, as if only these places had been filled."""
        there = np.isin(self.places, places, assume_unique=True)
        return replace(self, depth=np.where(there, self.depth, np.float32(np.nan)))

    def only(self, chosen: NDArray[np.intp]) -> PixelErrors:
        """Some of the pixels, by their number in `places`."""
        return PixelErrors(self.places[chosen], self.depth[chosen], self.truth[chosen], self.expected[chosen])


@dataclass(frozen=True, eq=False)
class Judged:
    """What a completion, or several of the same blocks with other depth hidden, were judged on.

    Attributes
    ----------
    labels : ndarray of int32, shape (H, W)
        The blocks.
    parts : tuple of PixelErrors
        One per completion.
    shared : tuple of PixelErrors or None
        Those of the pixels that others have filled, too, which alone are judged; None for all.
    """

    labels: NDArray[np.int32]
    parts: tuple[PixelErrors, ...]
    shared: tuple[PixelErrors, ...] | None = None

    @property
    def pixels(self) -> int:
        """How many there are to be filled."""
        return sum(part.places.size for part in self.parts)

    @property
    def coverage(self) -> float:
        """Share of them that were filled, 0-1; 0 if there are none."""
        return sum(int(np.count_nonzero(part.filled)) for part in self.parts) / max(self.pixels, 1)

    @cached_property
    def whole(self) -> Judgement:
        """All together."""
        return _judgement(self._judged)

    @cached_property
    def by_part(self) -> tuple[Judgement, ...]:
        """Every completion by itself."""
        return tuple(_judgement([part]) for part in self._judged)

    @cached_property
    def blocks(self) -> dict[int, Judgement]:
        """Every block with pixels to be filled, all completions together; label -> Judgement in rising order."""
        found: dict[int, list[PixelErrors]] = {}
        for part in self._judged:
            for label, chosen in by_label(self.labels, part.places):
                found.setdefault(label, []).append(part.only(chosen))
        return {label: _judgement(found[label]) for label in sorted(found)}

    @property
    def _judged(self) -> tuple[PixelErrors, ...]:
        return self.parts if self.shared is None else self.shared


@dataclass(frozen=True, eq=False)
class RunJudged:
    """What a run was judged to be.

    Attributes
    ----------
    run : Run
    judged : Judged
        Error by error.
    seconds : float
        That it took.
    """

    run: Run
    judged: Judged
    seconds: float

    @property
    def whole(self) -> Judgement:
        """Over all blocks."""
        return self.judged.whole

    @property
    def blocks(self) -> dict[int, Judgement]:
        """Label -> Judgement of every block with pixels to be filled."""
        return self.judged.blocks

    @property
    def errors(self) -> tuple[PixelErrors, ...]:
        """Error by error, a part for every completion."""
        return self.judged.parts

    @property
    def coverage(self) -> float:
        """Share of the pixels to be filled that were, 0-1."""
        return self.judged.coverage


def over_shared(several: Sequence[Judged]) -> list[Judged]:
    """The same, each judged over the pixels that all of them have filled.

    Those that leave more than a tenth of what the best fills open have no say in which pixels these are.

    Parameters
    ----------
    several : sequence of Judged
        Of as many parts each, which belong together.
    """
    leading = [judged for judged in several if fills_enough(judged, several)]
    if not leading:
        return list(several)
    shared = [
        reduce(np.intersect1d, (part.places[part.filled] for part in parts))
        for parts in zip(*(judged.parts for judged in leading), strict=True)
    ]
    return [
        replace(judged, shared=tuple(part.among(places) for part, places in zip(judged.parts, shared, strict=True)))
        for judged in several
    ]


def fills_enough(judged: Judged, several: Sequence[Judged]) -> bool:
    """Whether it fills enough, beside others, for its errors to be compared with theirs."""
    return judged.coverage > 0 and judged.coverage >= ENOUGH * max(other.coverage for other in several)


def _judgement(parts: Sequence[PixelErrors]) -> Judgement:
    if not parts:
        return Judgement()
    depth, truth, expected = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("depth", "truth", "expected")
    )
    return judge(depth, truth, expected=expected)
