"""Guides by a network: a user's own ONNX network that predicts depth or inverse depth from colour."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.networks.network import OnnxNetwork, as_input
from .._runtime.networks.session import RefusedInputError
from ..data.guide import GuideCard
from ..errors import FormatError

_ANY = GuideCard("", "", "", "relative-inverse", 0)
"""The card of a network without one."""

_SIZES = ((518, 14), (384, 32))
"""Shorter side of the input [px] and the number that its sides are multiples of, where neither network nor card says:
those of vision transformers with patches of 14 px, then of networks that halve their input five times."""


class GuideNetwork(OnnxNetwork):
    """A network that predicts depth or inverse depth from colour, such as Depth Anything or MiDaS. `load` creates one.

    The file is an ONNX network with one input, RGB as float32 (1, 3, H, W), and an output that is any monotone function
    of depth, (1, H, W) or (1, 1, H, W), of any size. If the file fixes H and W, the image is resized to them. Its card
    states the rest; without one, the size is one of the usual, colour is normalised by the mean and the standard
    deviation of ImageNet's colours, and the output is the first.
    """

    KIND = "guide network"
    INSTEAD = ", or a file with the guide's values"

    def predict(self, rgb: NDArray[np.uint8], card: GuideCard = _ANY) -> NDArray[np.float32]:
        """Predict the values of a guide for an image.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (H, W, 3)
        card : GuideCard

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
        for size in self._sizes(height, width, card):
            image = np.asarray(cv2.resize(rgb, size[::-1], interpolation=cv2.INTER_AREA), np.uint8)
            try:
                found = self._run(image, card)
            except RefusedInputError as error:
                refused = error
                continue
            return np.asarray(cv2.resize(found, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)
        raise self._takes_no_image() from refused

    def _sizes(self, height: int, width: int, card: GuideCard) -> list[tuple[int, int]]:
        """Heights and widths of the input to try for an image."""
        shape = self._session.first_shape
        if len(shape) == 4 and shape[2] and shape[3]:
            return [(shape[2], shape[3])]
        if card.size and not card.keep_aspect:
            return [(card.size, card.size)]
        return [
            (max(round(height * side / min(height, width) / step), 1) * step,
             max(round(width * side / min(height, width) / step), 1) * step)
            for side, step in ([(card.size, card.step)] if card.size else _SIZES)
        ]  # fmt: skip

    def _run(self, image: NDArray[np.uint8], card: GuideCard) -> NDArray[np.float32]:
        if card.output and card.output not in self._session.outputs:
            known = ", ".join(self._session.outputs)
            raise FormatError(f"{self.path.name} has no output {card.output}, only {known}. Correct its card.")
        mean, deviation = (np.array(of_rgb, np.float32).reshape(3, 1, 1) for of_rgb in (card.mean, card.deviation))
        outputs = self._forward({"": (as_input(image) - mean) / deviation})
        output = outputs[self._session.outputs.index(card.output) if card.output else 0]
        if output.ndim < 2 or output.size != output.shape[-2] * output.shape[-1] or min(output.shape[-2:]) < 2:
            raise FormatError(self._unlike(f"its output is {output.shape}, not one value per pixel."))
        if not np.isfinite(output).all():
            raise FormatError(f"{self.path.name} returns values that are not finite for this frame.")
        return output.reshape(output.shape[-2:])

    def _try(self) -> None:
        """The network may be large: only its input is looked at, and `predict` tells the rest."""
        shape = self._session.first_shape
        if len(shape) != 4 or shape[1] not in {3, None}:
            raise self._takes_no_image()

    def _takes_no_image(self) -> FormatError:
        return FormatError(self._unlike("it does not accept one RGB image of shape (1, 3, height, width)."))


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
