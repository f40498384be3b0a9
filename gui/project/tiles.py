"""Copies of an array that changes in place: cheap to bring up to date, whatever its size."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ilf.blocks import Box

T = TypeVar("T", bound=np.generic)

_SIDE = 256


class Tiles(Generic[T]):
    """An array (H, W) as it was, in tiles that nobody changes: only those that a change touches are copied anew."""

    def __init__(self) -> None:
        self._shape: tuple[int, ...] = ()
        self._tiles: list[list[NDArray[T]]] = []

    def update(self, array: NDArray[T], box: Box | None) -> Callable[[], NDArray[T]]:
        """Note how the array is now, which since the last time has changed in a box only; None if nowhere.

        Returns
        -------
        callable
            Puts the copy together, of this very moment: in any thread, at any time.
        """
        height, width = array.shape
        if array.shape != self._shape:
            self._shape, box = array.shape, (slice(0, height), slice(0, width))
            self._tiles = [[array[:0, :0]] * -(-width // _SIDE) for _ in range(-(-height // _SIDE))]
        if box is not None:
            rows, columns = (range(side.start // _SIDE, -(-side.stop // _SIDE)) for side in box)
            for row in rows:
                fresh = list(self._tiles[row])
                for column in columns:
                    top, left = row * _SIDE, column * _SIDE
                    fresh[column] = array[top : top + _SIDE, left : left + _SIDE].copy()
                self._tiles[row] = fresh
        now = list(self._tiles)
        return lambda: np.block(now)
