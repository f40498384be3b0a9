"""A surface of second order in every block."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...blocks import find_blocks
from ...frame import RGBDFrame


def polynomial(frame: RGBDFrame, labels: NDArray[np.int32]) -> NDArray[np.float64]:
    """Least-squares polynomial of order 2 in row and column through the known pixels of each block.

    Missing stays what lies in no block, what the polynomial puts behind the camera, and blocks whose known pixels
    do not determine its six coefficients.

    Parameters
    ----------
    frame : RGBDFrame
    labels : ndarray of int32, shape (H, W)
        Label map, 0 = no block.
    """
    depth = frame.depth.astype(np.float64)
    for block in find_blocks(labels).values():
        raw = depth[block.box]
        known, missing = block.mask & np.isfinite(raw), block.mask & np.isnan(raw)
        # positions in [-1, 1] keep the six terms about equally large
        y, x = (2 * (index + 0.5) / size - 1 for index, size in zip(np.indices(raw.shape), raw.shape, strict=True))
        terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
        coefficients, _, rank, _ = np.linalg.lstsq(terms[known], raw[known])
        if rank == terms.shape[-1]:
            surface = terms[missing] @ coefficients
            raw[missing] = np.where(surface > 0, surface, np.nan)
    return depth
