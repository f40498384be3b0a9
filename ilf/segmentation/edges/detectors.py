"""Edges of the colour image: where boundaries of surfaces are looked for (section 2)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.networks.models import model_path
from ..._runtime.networks.network import OnnxNetwork, reflected
from ...errors import FormatError, InputError

_GRADIENT_SHARE, _NETWORK_SHARE = 0.6, 0.5
"""Otsu's threshold parts strong edges from all others; watertight boundaries need the fainter ones too."""

_FAINTEST = 0.1
"""Least threshold that Otsu's rule may give for the network's strength: an image of one colour has no edges."""


def colour_gradient(rgb: NDArray[np.uint8], sigma: float) -> tuple[NDArray[np.int16], NDArray[np.int16]]:
    """Sobel derivatives of the smoothed image, each pixel's from the Lab channel in which they are largest.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    sigma : float
        Standard deviation of the Gaussian blur [px]; 0 for none.

    Returns
    -------
    dx, dy : ndarray of int16, shape (H, W)
    """
    lab = cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2Lab)
    if sigma > 0:
        lab = cv2.GaussianBlur(lab, (0, 0), sigma, borderType=cv2.BORDER_REFLECT)
    dx = cv2.Sobel(lab, cv2.CV_16S, 1, 0, borderType=cv2.BORDER_REFLECT)
    dy = cv2.Sobel(lab, cv2.CV_16S, 0, 1, borderType=cv2.BORDER_REFLECT)
    sizes = np.abs(dx) + np.abs(dy)
    size, strongest_x, strongest_y = sizes[..., 0], dx[..., 0], dy[..., 0]
    # arrays of one channel each: reducing along the last, short axis takes several times as long
    for channel in (1, 2):
        larger = sizes[..., channel] > size
        size = np.maximum(size, sizes[..., channel])
        strongest_x = np.where(larger, dx[..., channel], strongest_x)
        strongest_y = np.where(larger, dy[..., channel], strongest_y)
    return np.ascontiguousarray(strongest_x), np.ascontiguousarray(strongest_y)


def gradient_strength(dx: NDArray[np.int16], dy: NDArray[np.int16]) -> NDArray[np.float32]:
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
        Threshold in the unit of `gradient_strength`; 0 takes 0.6 of Otsu's threshold of the strength.
    low_ratio : float
        The lower threshold as a share of `high`.

    Returns
    -------
    ndarray of bool, shape (H, W)
    """
    magnitude, top = _magnitude(dx, dy)
    if top == 0:
        return np.zeros(dx.shape, bool)
    if high == 0:
        high = _GRADIENT_SHARE * _otsu(magnitude / top)
    threshold = high * top
    edges = cv2.Canny(dx, dy, low_ratio * threshold, threshold, L2gradient=True)
    return edges > 0


def otsu_edges(strength: NDArray[np.float32], threshold: float) -> NDArray[np.bool_]:
    """Binarised edge strength.

    Parameters
    ----------
    strength : ndarray of float32, shape (H, W)
        In [0, 1].
    threshold : float
        Strength from which on there is an edge; 0 takes half of Otsu's threshold, 0.1 at least.

    Returns
    -------
    ndarray of bool, shape (H, W)
    """
    return strength >= (threshold or max(_NETWORK_SHARE * _otsu(strength), _FAINTEST))


def _magnitude(dx: NDArray[np.int16], dy: NDArray[np.int16]) -> tuple[NDArray[np.float32], float]:
    """Length of the gradient, and its 99th percentile."""
    magnitude = np.hypot(dx.astype(np.float32), dy.astype(np.float32))
    return magnitude, float(np.percentile(magnitude, 99))


def _otsu(strength: NDArray[np.float32]) -> float:
    levels = (np.clip(strength, 0, 1) * 255).astype(np.uint8)
    return cv2.threshold(levels, 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)[0] / 255


# Inference of the edge network: boundary strength of a colour image, through OpenCV's own reader of ONNX.

MULTIPLE = 16
SCALES = (0.5, 1.0, 1.5)
LONGEST_SIDE = 1600
"""Pixels: larger images tell nothing more of the boundaries of objects, and take gigabytes."""

_TRIAL_SHAPES = ((48, 48), (64, 96))


class OutOfRange(FormatError):
    """A network that works, but whose output is not within 0 to 1."""


class EdgeNetwork(OnnxNetwork):
    """An edge network, ready to run. `load` makes one; it may be used from any thread.

    The file is an ONNX network of one input, RGB in [0, 1] as float32 (1, 3, H, W) with H and W multiples of 16, and
    the boundary strength in [0, 1] as float32 (1, 1, H, W) as its output, the last one where there are several.
    """

    def strength(self, rgb: NDArray[np.uint8], multiscale: bool = False) -> NDArray[np.float32]:
        """Boundary strength of an image.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (H, W, 3)
            Of any size; one with a longer side of more than `LONGEST_SIDE` is scaled down to that before all else.
        multiscale : bool
            The mean over the image at 0.5, 1 and 1.5 times its size: slightly better, 3.5 times as slow.

        Returns
        -------
        ndarray of float32, shape (H, W)
            In [0, 1].

        Raises
        ------
        InputError
            If the image is not of this shape and type, or has no pixels.
        """
        check_image(rgb)
        full = min(1.0, LONGEST_SIDE / max(rgb.shape[:2]))
        if not multiscale:
            return self._at_scale(rgb, full)
        return np.mean([self._at_scale(rgb, full * scale) for scale in SCALES], axis=0, dtype=np.float32)

    def _at_scale(self, rgb: NDArray[np.uint8], scale: float) -> NDArray[np.float32]:
        height, width = rgb.shape[:2]
        if scale != 1:
            size = (max(1, round(width * scale)), max(1, round(height * scale)))
            rgb = cv2.resize(rgb, size, interpolation=cv2.INTER_AREA if scale < 1 else cv2.INTER_LINEAR)  # type: ignore[assignment]
        padded, window = reflected(rgb, MULTIPLE, MULTIPLE)
        strength = self._run(padded)[window]
        if scale != 1:
            strength = cv2.resize(strength, (width, height), interpolation=cv2.INTER_LINEAR)  # type: ignore[assignment]
        return np.clip(strength, 0, 1)

    def _run(self, padded: NDArray[np.uint8]) -> NDArray[np.float32]:
        image = np.asarray(cv2.dnn.blobFromImage(padded, 1 / 255), np.float32)
        try:
            output = self._forward({"": image})[-1]
        except cv2.error as error:
            raise FormatError(
                f"{self.path.name} is no edge network: it does not take one RGB image of shape "
                f"{(1, 3, *padded.shape[:2])}."
            ) from error
        if output.shape != (1, 1, *padded.shape[:2]):
            raise FormatError(
                f"{self.path.name} is no edge network: it makes {output.shape} of an image of {padded.shape[:2]}, "
                f"not {(1, 1, *padded.shape[:2])}."
            )
        return output[0, 0]

    def _try(self) -> None:
        for height, width in _TRIAL_SHAPES:
            ramp = np.linspace(0, 255, height * width * 3).astype(np.uint8).reshape(height, width, 3)
            output = self._run(ramp)
            if not (np.isfinite(output).all() and output.min() >= -1e-3 and output.max() <= 1 + 1e-3):
                raise OutOfRange(
                    f"{self.path.name} is no edge network as needed here: its output is not within 0 to 1. "
                    "If it lacks the sigmoid at its end, import it with --logits."
                )


def check_image(rgb: NDArray[np.generic]) -> None:
    """Raise InputError for what is no colour image."""
    if rgb.dtype != np.uint8 or rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.size == 0:
        raise InputError(f"Edges need an 8-bit RGB image of shape (H, W, 3), not {rgb.dtype} of shape {rgb.shape}.")


def load_model(name: str) -> EdgeNetwork:
    """The network of a name, one of `model_names`, read once and kept until its file changes.

    Raises
    ------
    InputError
        If there is none of that name.
    FormatError
        If its file is no edge network.
    """
    return EdgeNetwork.load(model_path(name))
