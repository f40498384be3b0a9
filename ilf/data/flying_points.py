"""Flying points: points between two surfaces that belong to neither."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.arrays import plain_array
from .camera import Camera
from .pixel_grids import piece_sizes
from .points import known_pixels
from .surface import surface_links

_MIN_PIECE_PIXELS = 24
"""Minimum number of linked pixels of a surface."""

_REACH = 5
"""Side [px] of the square in which the density of known depth is measured."""

_DENSE = 9
"""Minimum number of known pixels in that square to classify its centre pixel."""


def flying_points(depth: ArrayLike, intrinsics: Camera) -> NDArray[np.bool_]:
    """Find flying points: pixels whose points lie between two surfaces, as sensors and filters produce them.

    These are pixels without a link (`surface_links`) to either neighbour in their row, or their column, one of which is
    nearer and the other farther; and small isolated pieces where depth is dense.

    Parameters
    ----------
    depth : array_like
        Depth along the optical axis [m], (H, W). Values that are not finite and positive are missing.
    intrinsics : Camera
        Of this image.

    Returns
    -------
    ndarray of bool, shape (H, W)

    Examples
    --------
    >>> depth = np.repeat([[1.0] * 6 + [1.5] + [2.0] * 6], 5, axis=0)
    >>> np.argwhere(flying_points(depth, Camera(500.0, 500.0, 6.0, 2.0))).tolist()
    [[0, 6], [1, 6], [2, 6], [3, 6], [4, 6]]
    """
    image = np.asarray(plain_array(depth), np.float32)
    known = known_pixels(image)
    image = np.where(known, image, np.float32(np.nan))
    right, down = links = surface_links(image, intrinsics)
    around = cv2.boxFilter(
        known.view(np.uint8), cv2.CV_16U, (_REACH, _REACH), normalize=False, borderType=cv2.BORDER_CONSTANT
    )
    flying = known & (around >= _DENSE) & (piece_sizes(known, links) < _MIN_PIECE_PIXELS)
    flying[:, 1:-1] |= _between_neighbours(image, right)
    flying[1:-1] |= _between_neighbours(image.T, down.T).T
    return np.asarray(flying)


def _between_neighbours(depth: NDArray[np.float32], right: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return pixels, without the first and last of each row, not linked to their nearer and farther neighbours."""
    before, here, after = depth[:, :-2], depth[:, 1:-1], depth[:, 2:]
    with np.errstate(invalid="ignore"):
        within = ((before < here) & (here < after)) | ((before > here) & (here > after))
    return np.asarray(within & ~right[:, :-1] & ~right[:, 1:])
