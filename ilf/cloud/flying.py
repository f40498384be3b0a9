"""Points in mid-air: between surfaces, on none of them."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..camera import CameraIntrinsics
from .links import Links, surface_links
from .points import known_pixels

_FEW = 24
"""Linked pixels, fewer of which are no surface."""

_REACH = 5
"""Side [px] of the square that says whether depth is dense there."""

_DENSE = 9
"""Known pixels in that square, fewer of which say nothing of the pixel in the middle."""


def flying_points(depth: ArrayLike, intrinsics: CameraIntrinsics) -> NDArray[np.bool_]:
    """Pixels whose points hang in mid-air, as sensors and filters put some between two surfaces.

    These are pixels cut off (`surface_links`) from both neighbours of their row, or their column, one of which is
    nearer and the other farther; and small pieces that are cut off from all around where depth is dense.

    Parameters
    ----------
    depth : array_like
        Depth along the optical axis [m], (H, W). What is not finite and positive is missing.
    intrinsics : CameraIntrinsics
        Of this image.

    Returns
    -------
    ndarray of bool, shape (H, W)

    Examples
    --------
    >>> depth = np.repeat([[1.0] * 6 + [1.5] + [2.0] * 6], 5, axis=0)
    >>> np.argwhere(flying_points(depth, CameraIntrinsics(500.0, 500.0, 6.0, 2.0))).tolist()
    [[0, 6], [1, 6], [2, 6], [3, 6], [4, 6]]
    """
    image = np.asarray(depth, np.float32)
    known = known_pixels(image)
    image = np.where(known, image, np.float32(np.nan))
    links = surface_links(image, intrinsics)
    around = cv2.boxFilter(
        known.view(np.uint8), cv2.CV_16U, (_REACH, _REACH), normalize=False, borderType=cv2.BORDER_CONSTANT
    )
    flying = known & (around >= _DENSE) & (_piece_sizes(known, links) < _FEW)
    flying[:, 1:-1] |= _between(image, links.right)
    flying[1:-1] |= _between(image.T, links.down.T).T
    return np.asarray(flying)


def _between(depth: NDArray[np.float32], right: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Pixels, all but the first and the last of each row, cut off from a nearer neighbour and from a farther one."""
    before, here, after = depth[:, :-2], depth[:, 1:-1], depth[:, 2:]
    with np.errstate(invalid="ignore"):
        within = ((before < here) & (here < after)) | ((before > here) & (here > after))
    return np.asarray(within & ~right[:, :-1] & ~right[:, 1:])


def _piece_sizes(known: NDArray[np.bool_], links: Links) -> NDArray[np.int32]:
    """How many pixels each known one is linked to, over others, itself among them; of others 0."""
    height, width = known.shape
    # pixels on a grid with their links between them: its connected components are the pieces
    grid = np.zeros((2 * height - 1, 2 * width - 1), np.uint8)
    grid[::2, ::2], grid[::2, 1::2], grid[1::2, ::2] = known, links.right, links.down
    _, labels = cv2.connectedComponents(grid, connectivity=4, ltype=cv2.CV_32S)
    pieces = np.ascontiguousarray(labels[::2, ::2])
    sizes = np.bincount(pieces.reshape(-1)).astype(np.int32)
    sizes[0] = 0
    return np.asarray(sizes[pieces])
