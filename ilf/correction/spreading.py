"""Changes of depth that spread from cell to cell, as far as their links conduct."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

Array = NDArray[np.floating]

_LEAK = 1e-8
"""How firmly every cell is held to 0 at least, so that there is a solution even where nothing else holds."""


def factors_of(right: Array, below: Array, held: Array) -> Array:
    """Banded Cholesky factors of a grid, its cells being counted down the columns.

    Parameters
    ----------
    right, below : ndarray, shapes (H, W - 1) and (H - 1, W)
        Conductances of the links to the right and to the lower neighbour.
    held : ndarray, shape (H, W)
        How firmly each cell is held to 0.
    """
    height, width = held.shape
    diagonal = held + _LEAK
    diagonal[:, 1:] += right
    diagonal[:, :-1] += right
    diagonal[1:] += below
    diagonal[:-1] += below
    bands = np.zeros((height + 1, width, height), diagonal.dtype)
    bands[0] = diagonal.T
    bands[1, :, :-1] = -below.T
    bands[height, :-1] = -right.T
    return np.asarray(cholesky_banded(bands.reshape(height + 1, -1), overwrite_ab=True, lower=True, check_finite=False))


def load_of(right: Array, below: Array, rise_right: Array, rise_below: Array, pull: Array) -> Array:
    """The right-hand side for rises along the links, and for what the cells are held to times how firmly they are."""
    load = pull.copy()
    load[:, 1:] += right * rise_right
    load[:, :-1] -= right * rise_right
    load[1:] += below * rise_below
    load[:-1] -= below * rise_below
    return load


def solve(factors: Array, load: Array) -> Array:
    """The values of the cells, shape (H, W)."""
    height, width = load.shape
    values = cho_solve_banded((factors, True), load.T.reshape(-1), check_finite=False)
    return np.asarray(values.reshape(width, height).T)


def spread(links: NDArray[np.float32]) -> NDArray[np.float32]:
    """The changes of the cells.

    Parameters
    ----------
    links : ndarray of float32, shape (6, H, W)
        Conductances of the links to the right (of the last column, none) and below (of the last row, none), how much
        more the change of the next cell is to be along them, how firmly each cell is held, and that times to what.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Those with the least sum held u^2 - 2 pull u + sum conductance (u_next - u - rise)^2.
    """
    height, width = links.shape[1:]
    if height > width:
        # the work grows with the square of the side that is counted along
        return np.ascontiguousarray(spread(links[[1, 0, 3, 2, 4, 5]].transpose(0, 2, 1)).T)
    right, below, rise_right, rise_below, held, pull = links
    right, rise_right, below, rise_below = right[:, :-1], rise_right[:, :-1], below[:-1], rise_below[:-1]
    load = load_of(right, below, rise_right, rise_below, pull)
    return solve(factors_of(right, below, held), load)
