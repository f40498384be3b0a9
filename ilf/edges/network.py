"""Inference of the edge network: boundary strength of a colour image, through OpenCV's own reader of ONNX."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError, InputError
from ..models import model_path
from .onnx_network import OnnxNetwork, reflected

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
    """The network of a name, one of `ilf.models.model_names`, read once and kept until its file changes.

    Raises
    ------
    InputError
        If there is none of that name.
    FormatError
        If its file is no edge network.
    """
    return EdgeNetwork.load(model_path(name))
