"""The surface network: one look at colour and known depth for jumps, creases, borders, and what the correction needs."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.networks.network import OnnxNetwork, RefusedInputError, as_input, reflected
from ...data.pixel_grids import nearest_values
from ...errors import FormatError, InputError
from .detectors import check_image

Array = NDArray[np.float32]

# Input features of the network from known depth: the same in training and inference.

CHANNELS = ("known", "filled", "fine relief", "wide relief", "distance", "nearest")
"""The channels of `depth_features`, in this order."""

_FINE, _WIDE = 5, 33
"""Sides [px] of the squares whose mean is subtracted for the relief."""

_FINE_GAIN, _WIDE_GAIN, _NEAREST_GAIN = 20, 4, 4
_LIMIT = 4
"""Weights that scale jumps of a few per cent to about 1, and the value at which features are clipped."""


def depth_features(depth: Array) -> Array:
    """Features of the known depth for the network, independent of scale: from the logarithm minus its median.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.

    Returns
    -------
    ndarray of float32, shape (6, H, W)
        In the order of `CHANNELS`: 1 where depth is known; the log depth with its gaps filled from around
        (`filled_log_depth`); the known log depth minus its mean in 5 x 5 pixels; the filled log depth minus its mean in
        33 x 33 pixels; log(1 + distance to known depth [px]) / 4; and the log depth of the nearest known pixel minus
        the filled one.
    """
    known = np.isfinite(depth)
    if not known.any():
        features = np.zeros((len(CHANNELS), *depth.shape), np.float32)
        features[4] = np.log1p(np.float32(max(depth.shape))) / 4
        return features
    filled, median = filled_log_depth(depth)
    return features_of(filled - np.float32(median), known)


def features_of(filled: Array, known: NDArray[np.bool_]) -> Array:
    """`depth_features` from the filled log depth minus the median of the known one, and the mask of known depth."""
    features = np.zeros((len(CHANNELS), *filled.shape), np.float32)
    distance, nearest = nearest_values(filled, known)
    features[0] = known
    features[1] = filled
    features[2] = known * _FINE_GAIN * (filled - cv2.blur(filled, (_FINE, _FINE)))
    features[3] = _WIDE_GAIN * (filled - cv2.blur(filled, (_WIDE, _WIDE)))
    features[4] = np.log1p(distance) / 4
    features[5] = _NEAREST_GAIN * (nearest - filled)
    return np.clip(features, -_LIMIT, _LIMIT, out=features)


def filled_log_depth(depth: Array) -> tuple[Array, float]:
    """Log depth with gaps filled from around, and the median of the known log depth.

    A gap gets the interpolated mean of the smallest square of 2, 4, 8 ... pixels around it that contains known depth.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing; at least one known pixel.
    """
    known = np.isfinite(depth)
    logarithm = np.log(np.where(known, depth, 1), dtype=np.float32)
    return _fill(logarithm, known.astype(np.float32)), float(np.median(logarithm[known]))


def _fill(values: Array, weights: Array) -> Array:
    """Fill values of weight 0 from the image at half the size, recursively; other values stay."""
    if weights.all() or min(values.shape) == 1:
        return values if weights.all() else np.full_like(values, np.average(values, weights=weights))
    half = (-(-values.shape[1] // 2), -(-values.shape[0] // 2))
    share = cv2.resize(weights, half, interpolation=cv2.INTER_AREA)
    total = cv2.resize(values * weights, half, interpolation=cv2.INTER_AREA)
    coarse = _fill(np.divide(total, share, out=np.zeros_like(total), where=share > 0), (share > 0).astype(np.float32))
    around = cv2.resize(coarse, values.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return np.where(weights > 0, values, around)


# The network.

MULTIPLE = 32
"""The sides of the network's input are multiples of this."""

LONGEST_SIDE = 640
"""A frame with a longer side [px] is scaled down to this: the network was trained at this size."""

CELL = 4
"""Side of a cell in pixels of the network's input."""

AROUND = 9
"""Number of cells whose values are averaged for a pixel: its own and its neighbours."""

_PAIR = 2
_LINES, _EMBEDDING, _CONTEXT = 3, 8, 36
"""Channels of the outputs."""

LOG_SPREADS = (-7.0, 3.0)
"""Minimum and maximum log of the expected error of the coarse depth."""

_TRIAL_SHAPES = ((64, 64), (64, 96))


@dataclass(frozen=True, eq=False)
class Surfaces:
    """What the network finds in a frame.

    Attributes
    ----------
    jump : ndarray of float32, shape (H, W)
        Probability that depth jumps between this pixel and its right or lower neighbour.
    crease : ndarray of float32, shape (H, W)
        Probability that the surface bends sharply there.
    border : ndarray of float32, shape (H, W)
        Probability that one object ends there, or that depth jumps.
    size : tuple of int
        Height and width of the network's input, without the padding to multiples of `MULTIPLE`.
    embedding : ndarray of float32, shape (8, h, w)
        Of the cells of the padded input, see `CELL`: near each other in one object, and apart in different ones.
    coarse : ndarray of float32, shape (2, h, w)
        Log depth of the cells minus the filled one of the features, and the log of its expected mean error.
    context : ndarray of float32, shape (36, h, w)
        What the correction needs.
    weights : ndarray of float32, shape (36, 2 h, 2 w)
        Logits of the weights with which each pixel averages the values of the 9 cells around it: for each cell those
        of 2 x 2 pixels.
    """

    jump: Array
    crease: Array
    border: Array
    size: tuple[int, int]
    embedding: Array
    coarse: Array
    context: Array
    weights: Array


class SurfaceNetwork(OnnxNetwork):
    """A surface network, ready to run. `load` creates one; it may be used from any thread.

    The file is an ONNX network with two inputs, `image`, RGB in [0, 1] as float32 (1, 3, H, W), and `depth`, the
    `depth_features`, H and W multiples of 32. Its outputs are `lines`, jump, crease and border, (1, 3, H, W) in [0, 1];
    and `coarse`, (1, 2, H/4, W/4), `embedding`, (1, 8, H/4, W/4), `context`, (1, 36, H/4, W/4), and `weights`,
    (1, 36, H/2, W/2), as in `Surfaces`.
    """

    KIND = "surface network"

    def look(self, rgb: NDArray[np.uint8], depth: Array) -> Surfaces:
        """Find the surfaces of a frame.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (H, W, 3)
            Of any size; if its longer side exceeds `LONGEST_SIDE`, it is first scaled down to that.
        depth : ndarray of float32, shape (H, W)
            Depth [m], NaN = missing.

        Raises
        ------
        InputError
            If the image is not of this shape and type, has no pixels, or the depth has another shape.
        FormatError
            If the file is not such a network.
        """
        check_image(rgb)
        height, width = rgb.shape[:2]
        if depth.shape != (height, width):
            raise InputError(f"Edges require depth of the image's shape {(height, width)}, not {depth.shape}.")
        size = input_size((height, width))
        lines, coarse, embedding, context, weights, window = self._run(resized(rgb, size), nearest_depth(depth, size))
        jump, crease, border = (
            np.clip(np.asarray(cv2.resize(line[window], (width, height), interpolation=cv2.INTER_LINEAR)), 0, 1)
            for line in lines
        )
        return Surfaces(jump, crease, border, size, embedding, coarse, context, weights)

    def _run(self, rgb: NDArray[np.uint8], depth: Array) -> tuple[Array, ...]:
        """The outputs of the network, and the image's window in them."""
        image, window = reflected(rgb, MULTIPLE)
        features, _ = reflected(np.moveaxis(depth_features(depth), 0, 2), MULTIPLE)
        height, width = image.shape[:2]
        inputs = {"image": as_input(image), "depth": np.moveaxis(features, 2, 0)[None]}
        try:
            outputs = self._forward(inputs)
        except RefusedInputError as error:
            raise FormatError(
                f"{self.path.name} is not a {self.KIND}: it does not accept an image of {(height, width)} and its depth."
            ) from error
        cells, pairs = ((height // side, width // side) for side in (CELL, CELL // _PAIR))
        wanted = [(_LINES, height, width), (2, *cells), (_EMBEDDING, *cells), (_CONTEXT, *cells)]
        shapes = [one.shape[1:] for one in outputs]
        if shapes != [*wanted, (AROUND * _PAIR**2, *pairs)]:
            raise FormatError(
                f"{self.path.name} is not a {self.KIND}: its outputs are {shapes} for an image of {(height, width)}."
            )
        if not all(np.isfinite(one).all() for one in outputs):
            raise FormatError(f"{self.path.name} returns values that are not finite for this frame.")
        return *(one[0] for one in outputs), window

    def _try(self) -> None:
        for height, width in _TRIAL_SHAPES:
            ramp = np.linspace(0, 255, height * width * 3).astype(np.uint8).reshape(height, width, 3)
            lines = self._run(ramp, np.asarray(1 + ramp[..., 0] / 255, np.float32))[0]
            if not (lines.min() >= -1e-3 and lines.max() <= 1 + 1e-3):
                raise FormatError(f"{self.path.name} is not a {self.KIND}: its output is not within 0 to 1.")


def input_size(shape: tuple[int, int]) -> tuple[int, int]:
    """Height and width at which the network sees a frame of this height and width."""
    scale = min(1.0, LONGEST_SIDE / max(shape))
    return max(1, round(shape[0] * scale)), max(1, round(shape[1] * scale))


def resized(image: NDArray, size: tuple[int, int]) -> NDArray:
    """An image at the size at which the network sees it."""
    if image.shape[:2] == size:
        return image
    return np.asarray(cv2.resize(image, size[::-1], interpolation=cv2.INTER_AREA))


def nearest_depth(depth: Array, size: tuple[int, int]) -> Array:
    """Depth at the size at which the network sees it, without mixing depths."""
    if depth.shape == size:
        return depth
    return np.asarray(cv2.resize(depth, size[::-1], interpolation=cv2.INTER_NEAREST), np.float32)
