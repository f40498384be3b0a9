"""Inference of the depth-edge network: jumps and creases from colour and known depth."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.networks.network import OnnxNetwork, as_input, reflected, trial_images
from ...data.arrays import check_shape
from ...data.pixel_grids import nearest_values
from ...errors import FormatError
from .detectors import at_scales, check_image, within_range

Array = NDArray[np.float32]

# Input features of the depth-edge network from known depth: the same in training and inference.

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


def features_of(filled: Array, known: NDArray[np.bool_], further: Sequence[Array] = ()) -> Array:
    """`depth_features` from the filled log depth minus the median of the known one, and the mask of known depth;
    `further` features of the same range come after them."""
    features = np.empty((len(CHANNELS) + len(further), *filled.shape), np.float32)
    distance, nearest = nearest_values(filled, known)
    features[0] = known
    features[1] = filled
    features[2] = features[0] * _FINE_GAIN * (filled - cv2.blur(filled, (_FINE, _FINE)))
    features[3] = _WIDE_GAIN * (filled - cv2.blur(filled, (_WIDE, _WIDE)))
    features[4] = np.log1p(distance) / 4
    features[5] = _NEAREST_GAIN * (nearest - filled)
    for channel, values in zip(features[len(CHANNELS) :], further, strict=True):
        channel[:] = values
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
SCALES = (1.0, 0.5, 0.25)
"""Scales at which the network runs. It was trained on images of 320 x 256, so for 640 x 480 these cover both details
and the whole image."""


class DepthEdgeNetwork(OnnxNetwork):
    """A depth-edge network, ready to run. `load` creates one; it may be used from any thread.

    The file is an ONNX network with two inputs, `image`, RGB in [0, 1] as float32 (1, 3, H, W), and `depth`, the
    `depth_features`, H and W multiples of 32. Its first outputs are `jump` and `crease`, (1, 1, H, W) in [0, 1].
    """

    KIND = "depth-edge network"

    def look(self, rgb: NDArray[np.uint8], depth: Array) -> tuple[Array, Array]:
        """Predict the depth edges of a frame.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (H, W, 3)
            Of any size; if its longer side exceeds `LONGEST_SIDE`, it is first scaled down to that. The result is the
            mean of the predictions at the scales of `SCALES`.
        depth : ndarray of float32, shape (H, W)
            Depth [m], NaN = missing.

        Returns
        -------
        jump : ndarray of float32, shape (H, W)
            Probability that depth jumps between this pixel and its right or lower neighbour.
        crease : ndarray of float32, shape (H, W)
            Probability that the surface bends sharply there.

        Raises
        ------
        InputError
            If the image is not of this shape and type, has no pixels, or the depth has another shape.
        """
        check_image(rgb)
        check_shape("Depth", depth.shape, rgb.shape[:2], "the image")
        jump, crease = at_scales(rgb, SCALES, lambda image: self._predict(image, depth))
        return jump, crease

    def _predict(self, rgb: NDArray[np.uint8], depth: Array) -> Array:
        """Jumps and creases, (2, H, W) of the image's size; the depth may be of another size."""
        image, window = reflected(rgb, MULTIPLE)
        resized = np.asarray(cv2.resize(depth, rgb.shape[1::-1], interpolation=cv2.INTER_NEAREST), np.float32)
        features, _ = reflected(depth_features(resized), MULTIPLE, axis=1)
        size = image.shape[:2]
        outputs = self._forward({"image": as_input(image), "depth": features[None]})
        shapes = [one.shape for one in outputs]
        if shapes[:2] != [(1, 1, *size)] * 2:
            raise FormatError(self._unlike(f"its outputs are {shapes} for an image of {size}."))
        return np.stack([one[0, 0][window] for one in outputs[:2]])

    def _try(self) -> None:
        for ramp in trial_images():
            if not within_range(self._predict(ramp, np.asarray(1 + ramp[..., 0] / 255, np.float32))):
                raise FormatError(self._unlike("its output is not within 0 to 1."))
