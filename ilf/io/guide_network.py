"""Guides by a network: a user's own ONNX network that predicts depth or inverse depth from colour."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.networks.network import OnnxNetwork, as_input
from .._runtime.networks.session import RefusedInputError
from ..errors import FormatError

_MEAN, _DEVIATION = (
    np.array(of_rgb, np.float32)[:, None, None] for of_rgb in ((0.485, 0.456, 0.406), (0.229, 0.224, 0.225))
)
"""Mean and standard deviation of ImageNet's colours, which networks for depth expect to be removed."""

_SIZES = ((518, 14), (384, 32))
"""Shorter side of the input [px] and the number that its sides are multiples of, where the network leaves them open:
those of vision transformers with patches of 14 px, then of networks that halve their input five times."""


class GuideNetwork(OnnxNetwork):
    """A network that predicts depth or inverse depth from colour, such as Depth Anything or MiDaS. `load` creates one.

    The file is an ONNX network with one input, RGB as float32 (1, 3, H, W), minus the mean of ImageNet's colours and
    divided by their standard deviation. Its first output is any monotone function of depth, (1, H, W) or (1, 1, H, W),
    of any size. If the file fixes H and W, the image is resized to them, otherwise to one of the usual sizes.
    """

    KIND = "guide network"
    INSTEAD = ", or a file with the guide's values"

    def predict(self, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
        """Predict the values of a guide for an image.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (H, W, 3)

        Returns
        -------
        ndarray of float32, shape (H, W)
            In any unit.

        Raises
        ------
        FormatError
            If the network does not accept an image, or its output is not one value per pixel.
        """
        height, width = rgb.shape[:2]
        refused: RefusedInputError | None = None
        for size in self._sizes(height, width):
            try:
                found = self._run(np.asarray(cv2.resize(rgb, size[::-1], interpolation=cv2.INTER_AREA), np.uint8))
            except RefusedInputError as error:
                refused = error
                continue
            return np.asarray(cv2.resize(found, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)
        raise FormatError(
            f"{self.path.name} is not a {self.KIND}: it does not accept one RGB image of shape (1, 3, height, width)."
        ) from refused

    def _sizes(self, height: int, width: int) -> list[tuple[int, int]]:
        """Heights and widths of the input to try for an image."""
        shape = self._session.first_shape
        if len(shape) == 4 and shape[2] and shape[3]:
            return [(shape[2], shape[3])]
        return [
            (max(round(height * side / min(height, width) / step), 1) * step,
             max(round(width * side / min(height, width) / step), 1) * step)
            for side, step in _SIZES
        ]  # fmt: skip

    def _run(self, image: NDArray[np.uint8]) -> NDArray[np.float32]:
        colour = (as_input(image) - _MEAN) / _DEVIATION
        output = self._forward({"": colour})[0]
        if output.ndim < 2 or output.size != output.shape[-2] * output.shape[-1] or min(output.shape[-2:]) < 2:
            raise FormatError(
                f"{self.path.name} is not a {self.KIND}: its output is {output.shape}, not one value per pixel."
            )
        if not np.isfinite(output).all():
            raise FormatError(f"{self.path.name} returns values that are not finite for this frame.")
        return output.reshape(output.shape[-2:])

    def _try(self) -> None:
        ramp = np.linspace(0, 255, 64 * 96 * 3).astype(np.uint8).reshape(64, 96, 3)
        self.predict(ramp)


def predict_guide(path: Path, rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Predict the values of a guide, float32 (H, W), by the network in a file; the network is cached until the file
    changes.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is no such network.
    """
    return GuideNetwork.load(path).predict(rgb)
