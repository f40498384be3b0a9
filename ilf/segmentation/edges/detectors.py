"""Edge detectors (section 2): Canny's, and the networks for colour and for colour and depth."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.networks.models import BUNDLED, DEPTH_EDGES, model_path
from ..._runtime.networks.network import OnnxNetwork, as_input, reflected, trial_images
from ...data.arrays import check_shape
from ...data.pixel_grids import nearest_values, strips
from ...errors import FormatError, InputError

Array = NDArray[np.float32]

_GRADIENT_SHARE, _NETWORK_SHARE = 0.6, 0.5
"""Factors on Otsu's threshold, which keeps strong edges only; watertight boundaries also need fainter ones."""

_MIN_THRESHOLD = 0.1
"""Minimum threshold for the network's strength by Otsu's rule: an image of one colour has no edges."""


def colour_gradient(rgb: NDArray[np.uint8], sigma: float) -> tuple[NDArray[np.int16], NDArray[np.int16]]:
    """Sobel derivatives of the smoothed image, for each pixel from the Lab channel with the largest ones.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    sigma : float
        Standard deviation of the Gaussian blur [px]; 0 for none.

    Returns
    -------
    dx, dy : ndarray of int16, shape (H, W)
    """
    dx, dy = np.empty((2, *rgb.shape[:2]), np.int16)
    for rows, wider, inner in strips(len(rgb), math.ceil(3 * sigma) + 2):
        dx[rows], dy[rows] = (strongest[inner] for strongest in _strongest_gradient(rgb[wider], sigma))
    return dx, dy


def _strongest_gradient(rgb: NDArray[np.uint8], sigma: float) -> tuple[NDArray[np.int16], NDArray[np.int16]]:
    lab = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2Lab)
    if sigma > 0:
        lab = cv2.GaussianBlur(lab, (0, 0), sigma, borderType=cv2.BORDER_REFLECT)
    size, strongest_x, strongest_y = (np.zeros(lab.shape[:2], np.int16) for _ in range(3))
    for channel in cv2.split(lab):
        dx, dy = (cv2.Sobel(channel, cv2.CV_16S, x, 1 - x, borderType=cv2.BORDER_REFLECT) for x in (1, 0))
        own = np.abs(dx) + np.abs(dy)
        larger = cv2.compare(own, size, cv2.CMP_GT)
        for target, values in ((size, own), (strongest_x, dx), (strongest_y, dy)):
            cv2.copyTo(values, larger, target)
    return strongest_x, strongest_y


def gradient_strength(dx: NDArray[np.int16], dy: NDArray[np.int16]) -> Array:
    """Gradient magnitude scaled to [0, 1] by its 99th percentile, float32 (H, W)."""
    magnitude, top = _magnitude(dx, dy)
    return np.clip(magnitude / top, 0.0, 1.0) if top > 0 else magnitude


def canny_edges(dx: NDArray[np.int16], dy: NDArray[np.int16], high: float, low_ratio: float) -> NDArray[np.bool_]:
    """Canny's edges of a colour gradient: thin lines by non-maximum suppression and hysteresis.

    Parameters
    ----------
    dx, dy : ndarray of int16, shape (H, W)
        From `colour_gradient`.
    high : float
        Threshold in the unit of `gradient_strength`; 0 uses 0.6 of Otsu's threshold of the strength.
    low_ratio : float
        The lower threshold as a fraction of `high`.

    Returns
    -------
    ndarray of bool, shape (H, W)
    """
    magnitude, top = _magnitude(dx, dy)
    if top == 0:
        return np.zeros(dx.shape, bool)
    if high == 0:
        high = _GRADIENT_SHARE * _otsu(magnitude, top)
    threshold = high * top
    edges = cv2.Canny(dx, dy, low_ratio * threshold, threshold, L2gradient=True)
    return edges > 0


def otsu_edges(strength: Array, threshold: float) -> NDArray[np.bool_]:
    """Binarised edge strength.

    Parameters
    ----------
    strength : ndarray of float32, shape (H, W)
        In [0, 1].
    threshold : float
        Minimum strength of an edge; 0 uses half of Otsu's threshold, but at least 0.1.

    Returns
    -------
    ndarray of bool, shape (H, W)
    """
    return strength >= (threshold or max(_NETWORK_SHARE * _otsu(strength), _MIN_THRESHOLD))


def _magnitude(dx: NDArray[np.int16], dy: NDArray[np.int16]) -> tuple[Array, float]:
    """Gradient magnitude, and its 99th percentile."""
    # float32 holds these whole numbers exactly, so that the root is as exact as that of `np.hypot`, which is slow
    magnitude = np.empty(dx.shape, np.float32)
    for rows, *_ in strips(len(dx)):
        squares = (np.square(along[rows], dtype=np.float32) for along in (dx, dy))
        np.sqrt(np.add(*squares), out=magnitude[rows])
    return magnitude, float(np.percentile(magnitude, 99))


def _otsu(strength: Array, top: float = 1.0) -> float:
    levels = np.empty(strength.shape, np.uint8)
    for rows, *_ in strips(len(strength)):
        levels[rows] = np.clip(strength[rows] / top, 0, 1) * 255
    return cv2.threshold(levels, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0] / 255


# Inference of the edge network: boundary strength of a colour image.

MULTIPLE = 32
_MARGIN = 16
"""Reflected pixels around an image, at least."""

SCALES = (0.5, 1.0, 1.5)
LONGEST_SIDE = 1600
"""Pixels: larger images do not improve the boundaries of objects, and take gigabytes."""

_PROBABILITY = "probability"
"""Name of the output with the probability of a boundary, which only some networks have."""


Contours = tuple[Array, Array]
"""Strength and probability of the boundaries in an image."""


class OutputRangeError(FormatError):
    """Error: the network runs, but its output is not within 0 to 1."""


class EdgeNetwork(OnnxNetwork):
    """An edge network, ready to run. `load` creates one; it may be used from any thread.

    The file is an ONNX network with one input, RGB in [0, 1] as float32 (1, 3, H, W) with H and W multiples of 32. Its
    last output is the boundary strength in [0, 1] as float32 (1, 1, H, W); an output `probability` of the same shape
    may be among the others.
    """

    NAME = BUNDLED

    def strength(self, rgb: NDArray[np.uint8], multiscale: bool = False) -> Array:
        """Predict the boundary strength of an image; the arguments are those of `contours`, the result is of shape
        (H, W)."""
        return self.contours(rgb, multiscale)[0]

    def contours(self, rgb: NDArray[np.uint8], multiscale: bool = False) -> Contours:
        """Predict the boundaries of an image.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (H, W, 3)
            Of any size; if its longer side exceeds `LONGEST_SIDE`, it is first scaled down to that.
        multiscale : bool
            Average the image at 0.5, 1 and 1.5 times its size: slightly better, 3.5 times as slow.

        Returns
        -------
        strength, probability : ndarray of float32, shape (H, W)
            Strength of the boundaries, and their probability, in [0, 1]; the same for networks with one output.

        Raises
        ------
        InputError
            If the image is not of this shape and type, or has no pixels.
        """
        found = at_scales(rgb, SCALES if multiscale else (1.0,), self._predict)
        return found[0], found[-1]

    def _predict(self, rgb: NDArray[np.uint8]) -> Array:
        """Strength, and probability if the network gives it, (1 or 2, H, W)."""
        padded, window = reflected(rgb, MULTIPLE, _MARGIN)
        outputs = dict(zip(self._session.outputs, self._forward({"": as_input(padded)}), strict=True))
        maps = [next(reversed(outputs.values()))]
        if _PROBABILITY in outputs:
            maps.append(outputs[_PROBABILITY])
        for output in maps:
            if output.shape != (1, 1, *padded.shape[:2]):
                raise FormatError(self._unlike(f"its output is {output.shape} for an image of {padded.shape[:2]}."))
        return np.stack([output[0, 0][window] for output in maps])

    def _try(self) -> None:
        for ramp in trial_images():
            if not within_range(self._predict(ramp)):
                raise OutputRangeError(
                    f"{self.path.name} is not a supported edge network: its output is not within 0 to 1. "
                    "If it lacks the sigmoid at its end, import it with --logits."
                )


def at_scales(rgb: NDArray[np.uint8], scales: Sequence[float], predict: Callable[[NDArray[np.uint8]], Array]) -> Array:
    """Average the maps that a network predicts from an image at several scales.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
        If its longer side exceeds `LONGEST_SIDE`, it is first scaled down to that.
    scales : sequence of float
    predict : callable
        Takes an image, uint8 (h, w, 3), and returns its maps, float32 (K, h, w).

    Returns
    -------
    ndarray of float32, shape (K, H, W)
        In [0, 1].

    Raises
    ------
    InputError
        If the image is not of this shape and type, or has no pixels.
    """
    check_image(rgb)
    height, width = rgb.shape[:2]
    full = min(1.0, LONGEST_SIDE / max(height, width))
    found = []
    for scale in scales:
        size = max(1, round(width * full * scale)), max(1, round(height * full * scale))
        how = cv2.INTER_AREA if full * scale < 1 else cv2.INTER_LINEAR
        image = np.asarray(cv2.resize(rgb, size, interpolation=how), np.uint8)
        found.append([cv2.resize(one, (width, height)) for one in predict(image)])
    return np.clip(np.mean(found, axis=0), 0, 1)


def within_range(maps: Array) -> bool:
    """Whether all values are within 0 to 1, but for rounding."""
    return bool(np.isfinite(maps).all() and maps.min() >= -1e-3 and maps.max() <= 1 + 1e-3)


def check_image(rgb: NDArray[np.generic]) -> None:
    """Raise InputError if an array is not a colour image."""
    if rgb.dtype != np.uint8 or rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.size == 0:
        raise InputError(f"Edges require an 8-bit RGB image of shape (H, W, 3), not {rgb.dtype} of shape {rgb.shape}.")


def load_model(name: str) -> EdgeNetwork:
    """Load the network with a name, one of `model_names`; it is cached until its file changes.

    Raises
    ------
    InputError
        If there is none with that name.
    FormatError
        If its file is not an edge network.
    """
    return EdgeNetwork.bundled() if name == BUNDLED else EdgeNetwork.load(model_path(name))


# Input features of the depth-edge network from known depth: the same in training and inference.

DEPTH_CHANNELS = ("known", "filled", "fine relief", "wide relief", "distance", "nearest")
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
        In the order of `DEPTH_CHANNELS`: 1 where depth is known; the log depth with its gaps filled from around
        (`filled_log_depth`); the known log depth minus its mean in 5 x 5 pixels; the filled log depth minus its mean in
        33 x 33 pixels; log(1 + distance to known depth [px]) / 4; and the log depth of the nearest known pixel minus
        the filled one.
    """
    known = np.isfinite(depth)
    if not known.any():
        features = np.zeros((len(DEPTH_CHANNELS), *depth.shape), np.float32)
        features[4] = np.log1p(np.float32(max(depth.shape))) / 4
        return features
    filled, median = filled_log_depth(depth)
    return features_of(filled - np.float32(median), known)


def features_of(filled: Array, known: NDArray[np.bool_], further: Sequence[Array] = ()) -> Array:
    """`depth_features` from the filled log depth minus the median of the known one, and the mask of known depth;
    `further` features of the same range come after them."""
    features = np.empty((len(DEPTH_CHANNELS) + len(further), *filled.shape), np.float32)
    distance, nearest = nearest_values(filled, known)
    features[0] = known
    features[1] = filled
    features[2] = features[0] * _FINE_GAIN * (filled - cv2.blur(filled, (_FINE, _FINE)))
    features[3] = _WIDE_GAIN * (filled - cv2.blur(filled, (_WIDE, _WIDE)))
    features[4] = np.log1p(distance) / 4
    features[5] = _NEAREST_GAIN * (nearest - filled)
    for channel, values in zip(features[len(DEPTH_CHANNELS) :], further, strict=True):
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


# Inference of the depth-edge network: jumps and creases from colour and known depth.

DEPTH_SCALES = (1.0, 0.5, 0.25)
"""Scales at which the network runs. It was trained on images of 320 x 256, so for 640 x 480 these cover both details
and the whole image."""


class DepthEdgeNetwork(OnnxNetwork):
    """A depth-edge network, ready to run. `bundled` creates one; it may be used from any thread.

    The file is an ONNX network with two inputs, `image`, RGB in [0, 1] as float32 (1, 3, H, W), and `depth`, the
    `depth_features`, H and W multiples of 32. Its first outputs are `jump` and `crease`, (1, 1, H, W) in [0, 1].
    """

    KIND, NAME = "depth-edge network", DEPTH_EDGES

    def look(self, rgb: NDArray[np.uint8], depth: Array) -> tuple[Array, Array]:
        """Predict the depth edges of a frame.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (H, W, 3)
            Of any size; if its longer side exceeds `LONGEST_SIDE`, it is first scaled down to that. The result is the
            mean of the predictions at the scales of `DEPTH_SCALES`.
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
        jump, crease = at_scales(rgb, DEPTH_SCALES, lambda image: self._predict(image, depth))
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
