"""The paper's existence rate: what is left of blocks of which too little is known (section 2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from skimage.measure import label as connected_regions

from ..blocks import find_blocks

_HALVINGS = 2


def keep_existing(
    labels: NDArray[np.int32], known: NDArray[np.bool_], rate: float, smallest: float
) -> NDArray[np.int32]:
    """Halve blocks of which too small a share is known, up to twice, and keep the parts that reach the rate.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
    known : ndarray of bool, shape (H, W)
        Pixels with depth.
    rate : float
        Least share of a block's pixels that have depth, 0-1.
    smallest : float
        Least number of pixels of a part.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Blocks that reach the rate keep their label; the parts of others, each one 4-connected region, have new ones
        above the largest. Pixels of parts that do not reach it belong to no block.
    """
    kept = labels.copy()
    following = int(labels.max()) + 1
    for block in find_blocks(labels).values():
        pixels = np.argwhere(block.mask)
        has_depth = known[block.box][block.mask]
        if has_depth.mean() >= rate:
            continue
        parts = np.zeros(block.mask.shape, np.int32)
        for number, part in enumerate(_good_parts(pixels, has_depth, rate, _HALVINGS), 1):
            parts[tuple(part.T)] = number
        pieces = connected_regions(parts, background=0, connectivity=1)
        large = np.bincount(pieces.ravel()) >= smallest
        large[0] = False
        numbers = np.where(large, np.cumsum(large) + following - 1, 0)
        kept[block.box][block.mask] = numbers[pieces][block.mask]
        following += int(np.count_nonzero(large))
    return kept


def _good_parts(
    pixels: NDArray[np.intp], has_depth: NDArray[np.bool_], rate: float, halvings: int
) -> list[NDArray[np.intp]]:
    """Those parts of a block, as rows of (row, column), that reach the rate."""
    if has_depth.mean() >= rate:
        return [pixels]
    if halvings == 0 or len(pixels) < 2:
        return []
    off = pixels - pixels.mean(axis=0)
    _, axes = np.linalg.eigh(off.T @ off)
    along = off @ axes[:, -1]
    first = along < np.median(along)
    if not first.any():
        return []
    halves = ((pixels[part], has_depth[part]) for part in (first, ~first))
    return [part for half in halves for part in _good_parts(*half, rate, halvings - 1)]
