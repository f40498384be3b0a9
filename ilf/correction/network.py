"""The correction network in use: how far completed depth is to be changed, from colour, known and completed depth."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..edges.onnx_network import LEAST_SIDE, OnnxNetwork, reflected
from ..errors import FormatError
from .features import correction_features
from .spreading import spread

Array = NDArray[np.float32]

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

_WINDOW, _ALIKE, _NEAR = 13, 0.03, 4.0
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
    return np.asarray(cv2.bilateralFilter(found, _WINDOW, _ALIKE, _NEAR), np.float32)


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
