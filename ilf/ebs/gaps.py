"""Blocks that do not cover the frame, as other programs leave them, and what the extraction finds between them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..parameters import BlockParameters
from .reextraction import flow_around


def gaps_filled(
    labels: NDArray[np.int32], extracted: NDArray[np.int32], parameters: BlockParameters
) -> NDArray[np.int32]:
    """A label map with the blocks of an extraction where it has none.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        0 = no block; its blocks stay as they are, with their numbers.
    extracted : ndarray of int32, shape (H, W)
        Blocks of an extraction.
    parameters : BlockParameters
        What the extraction was made with: slivers that are smaller than it lets blocks be go to a neighbouring new
        block.

    Returns
    -------
    ndarray of int32, shape (H, W)
    """
    kept = frozenset(np.unique(labels).tolist()) - {0}
    return flow_around(labels, kept, extracted, parameters.smallest_block(labels.size))
