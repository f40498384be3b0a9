"""The correction network: what it is told of a frame, and how its answer becomes changes of log depth."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded

from .._runtime.networks.models import CORRECTION, model_path
from .._runtime.networks.network import LEAST_SIDE, OnnxNetwork, reflected
from ..errors import FormatError
from ..segmentation.edges.depth_edges import CHANNELS as KNOWN_CHANNELS
from ..segmentation.edges.depth_edges import features_of, filled_log_depth

Array = NDArray[np.float32]
Floats = NDArray[np.floating]

# What the correction network is told of a frame: the same numbers in training and in use.

CHANNELS = (*KNOWN_CHANNELS, "completed", "departure", "completed relief", "contours")
"""What `correction_features` gives, in this order."""

_DEPARTURE_GAIN, _RELIEF_GAIN = 4, 20
_FINE = 5
_LIMIT = 4


def correction_features(depth: Array, completed: Array, contours: Array) -> tuple[Array, Array]:
    """Known and completed depth and contours as pictures for the network, independent of scale.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Known depth [m], NaN = missing; at least one known pixel.
    completed : ndarray of float32, shape (H, W)
        Completed depth [m]; NaN where it has not been completed.
    contours : ndarray of float32, shape (H, W)
        Strength of the edges that the filter saw, in [0, 1].

    Returns
    -------
    features : ndarray of float32, shape (10, H, W)
        In the order of `CHANNELS`: those of `depth_features`; the completed log depth; what it departs from the one
        whose gaps are filled from around; what it rises above its mean in 5 x 5 pixels; the contours.
    log_depth : ndarray of float32, shape (H, W)
        The completed log depth less the median of the known one, filled from around where it has not been completed.
    """
    filled, median = filled_log_depth(depth)
    filled -= np.float32(median)
    with np.errstate(invalid="ignore"):
        log_depth = np.where(np.isfinite(completed), np.log(completed) - np.float32(median), filled).astype(np.float32)
    more = np.stack(
        [
            log_depth,
            _DEPARTURE_GAIN * (log_depth - filled),
            _RELIEF_GAIN * (log_depth - cv2.blur(log_depth, (_FINE, _FINE))),
            contours,
        ]
    )
    features = np.concatenate([features_of(filled, np.isfinite(depth)), np.clip(more, -_LIMIT, _LIMIT, out=more)])
    return features.astype(np.float32, copy=False), log_depth


# Changes of depth that spread from cell to cell, as far as their links conduct.

_LEAK = 1e-8
"""How firmly every cell is held to 0 at least, so that there is a solution even where nothing else holds."""


def factors_of(right: Floats, below: Floats, held: Floats) -> Floats:
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


def load_of(right: Floats, below: Floats, rise_right: Floats, rise_below: Floats, pull: Floats) -> Floats:
    """The right-hand side for rises along the links, and for what the cells are held to times how firmly they are."""
    load = pull.copy()
    load[:, 1:] += right * rise_right
    load[:, :-1] -= right * rise_right
    load[1:] += below * rise_below
    load[:-1] -= below * rise_below
    return load


def solve(factors: Floats, load: Floats) -> Floats:
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


# The correction network in use: how far completed depth is to be changed, from colour, known and completed depth.

CELL = 4
"""So many pixels one of the cells has to a side that changes spread between."""

MULTIPLE = 32
"""What the sides of the network's input are multiples of."""

LARGEST = 1.0
"""Change of log depth that is not exceeded."""

LONGEST_SIDE = 640
"""A frame with a longer side [px] is looked at as large as that: the network has learnt from such."""

_LINKS, _AROUND, _PAIR = 6, 9, 2

_CLEAR = 0.008
"""Change of log depth from which on most of it is made: what a network says of smaller ones is no better than noise."""

_MEDIAN = 5
"""Side [px] of the median that takes away what single cells say."""

_WINDOW, _ALIKE_COLOUR, _NEAR = 13, 0.03, 4.0
"""Of the bilateral filter that takes away the cells' grid: its side [px], and how far changes of log depth, and places
[px], may lie apart to count as one."""

_TRIAL_SHAPES = ((64, 64), (64, 96))


class CorrectionNetwork(OnnxNetwork):
    """A correction network, ready to run. `load` makes one; it may be used from any thread.

    The file is an ONNX network of two inputs, `image`, RGB in [0, 1] as float32 (1, 3, H, W), and `features`, the
    `correction_features`, H and W multiples of 32. Its outputs are `links`, (1, 6, H/4, W/4), in the order that
    `spread` takes, and `logits`, (1, 36, H/2, W/2): of whose change each pixel takes how much, of the 9 cells around
    it, as logarithms but for what they have in common; of every cell those of 2 x 2 pixels.
    """

    KIND = "correction network"

    def change(self, rgb: NDArray[np.uint8], depth: Array, completed: Array, contours: Array) -> Array:
        """How far the logarithm of completed depth is to be changed.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (H, W, 3)
        depth : ndarray of float32, shape (H, W)
            Known depth [m], NaN = missing; at least one known pixel.
        completed : ndarray of float32, shape (H, W)
            Completed depth [m], NaN where it is not.
        contours : ndarray of float32, shape (H, W)
            Strength of the contours that the filter saw, in [0, 1].

        Returns
        -------
        ndarray of float32, shape (H, W)
        """
        height, width = depth.shape
        scale = LONGEST_SIDE / max(height, width)
        if scale < 1:
            size = max(1, round(width * scale)), max(1, round(height * scale))
            rgb, contours = (cv2.resize(one, size, interpolation=cv2.INTER_AREA) for one in (rgb, contours))  # type: ignore[assignment]
            small = cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST)
            if np.isfinite(small).any():
                completed = cv2.resize(completed, size, interpolation=cv2.INTER_NEAREST)  # type: ignore[assignment]
                found = self._look(rgb, np.asarray(small, np.float32), completed, contours)
                return np.asarray(cv2.resize(found, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)
            return np.zeros(depth.shape, np.float32)
        return self._look(rgb, depth, completed, contours)

    def _look(self, rgb: NDArray[np.uint8], depth: Array, completed: Array, contours: Array) -> Array:
        image, window = reflected(rgb, MULTIPLE, least=LEAST_SIDE)
        features, _ = correction_features(depth, completed, contours)
        size = image.shape[:2]
        colour = np.asarray(cv2.dnn.blobFromImage(image, 1 / 255), np.float32)
        whole = np.stack([reflected(channel, MULTIPLE, least=LEAST_SIDE)[0] for channel in features])
        try:
            outputs = self._forward({"image": colour, "features": whole[None]})
        except cv2.error as error:
            raise FormatError(
                f"{self.path.name} is no correction network: it does not take an image of {size} and its depth."
            ) from error
        shapes = [one.shape for one in outputs]
        cells, pairs = (tuple(side // length for side in size) for length in (CELL, _PAIR))
        if shapes != [(1, _LINKS, *cells), (1, _AROUND * _PAIR**2, *pairs)]:
            raise FormatError(f"{self.path.name} is no correction network: it makes {shapes} of an image of {size}.")
        if not all(np.isfinite(one).all() for one in outputs):
            raise FormatError(f"{self.path.name} gives no numbers for this frame.")
        links, logits = outputs[0][0], outputs[1][0]
        return smoothed(_weighted(spread(links), logits))[window]

    def _try(self) -> None:
        for height, width in _TRIAL_SHAPES:
            ramp = np.linspace(0, 255, height * width * 3).astype(np.uint8).reshape(height, width, 3)
            depth = np.asarray(1 + ramp[..., 0] / 255, np.float32)
            known = np.where(ramp[..., 1] > 128, depth, np.float32(np.nan))
            found = self._look(ramp, known, depth, np.zeros_like(depth))
            if not np.isfinite(found).all():
                raise FormatError(f"{self.path.name} is no correction network: its changes are not finite.")


def smoothed(change: Array) -> Array:
    """Changes without small ones, without specks, and without the grid of the cells; their edges stay."""
    change = np.clip(change, -LARGEST, LARGEST)
    found = np.asarray(change * -np.expm1(-np.square(change / np.float32(_CLEAR))), np.float32)
    for _ in range(2):
        found = np.asarray(cv2.medianBlur(found, _MEDIAN), np.float32)
    return np.asarray(cv2.bilateralFilter(found, _WINDOW, _ALIKE_COLOUR, _NEAR), np.float32)


def _weighted(cells: Array, logits: Array) -> Array:
    """Of every pixel the weighted mean of what its cell and those around it have."""
    height, width = logits.shape[1:]
    # what a cell has stands at each of its pairs of pixels, as the logits do
    around = np.pad(cells, 1, mode="edge").repeat(CELL // _PAIR, axis=0).repeat(CELL // _PAIR, axis=1)
    of_cells = logits.reshape(_AROUND, _PAIR**2, height, width)
    largest = of_cells.max(axis=0)
    total, weights = np.zeros_like(largest), np.zeros_like(largest)
    for k, of_cell in enumerate(of_cells):
        row, column = (place * (CELL // _PAIR) for place in divmod(k, 3))
        weight = np.exp(of_cell - largest)
        weights += weight
        total += weight * around[row : row + height, column : column + width]
    mean = (total / weights).reshape(_PAIR, _PAIR, height, width)
    return np.ascontiguousarray(mean.transpose(2, 0, 3, 1)).reshape(_PAIR * height, _PAIR * width)


def load_correction_network() -> CorrectionNetwork:
    """The correction network that comes with the program.

    Raises
    ------
    InputError
        If its file is missing.
    FormatError
        If it is no such network.
    """
    return CorrectionNetwork.load(model_path(CORRECTION))
