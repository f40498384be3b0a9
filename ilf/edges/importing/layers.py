"""The layers of HED (Xie and Tu 2015), by the names that its Caffe model gave them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError

CONVOLUTIONS = tuple(
    tuple(f"conv{stage}_{number}" for number in range(1, count + 1)) for stage, count in enumerate((2, 2, 3, 3, 3), 1)
)
"""Those of VGG16, stage by stage; each stage after the first begins with a max-pooling."""

SCORES = tuple(f"score-dsn{stage}" for stage in range(1, 6))
"""1 x 1, one side output per stage."""

UPSAMPLINGS = {stage: f"upsample_{2 ** (stage - 1)}" for stage in range(2, 6)}
"""Transposed convolutions of stages 2 to 5; bilinear and not trained, so that a file may lack them."""

FUSION = "new-score-weighting"
"""1 x 1 over the five side outputs."""


class Layer(NamedTuple):
    """Weights of a convolution, float32."""

    weight: NDArray[np.float32]
    """(out, in, height, width)."""
    bias: NDArray[np.float32]
    """(out,)."""


def check_layers(layers: Mapping[str, Layer], file: str) -> None:
    """Refuse what is not the whole of HED; the channels are free, as long as they fit together.

    Parameters
    ----------
    layers : mapping of str to Layer
    file : str
        Name of the file, for the message.

    Raises
    ------
    FormatError
        If a layer is missing or has another shape.
    """
    channels = 3
    for names, score in zip(CONVOLUTIONS, SCORES, strict=True):
        for name in names:
            channels = _check(layers, name, (None, channels, 3, 3), file)
        _check(layers, score, (1, channels, 1, 1), file)
    _check(layers, FUSION, (1, len(SCORES), 1, 1), file)
    for stage, name in UPSAMPLINGS.items():
        if name in layers:
            _check(layers, name, (1, 1, 2**stage, 2**stage), file)


def _check(layers: Mapping[str, Layer], name: str, shape: tuple[int | None, ...], file: str) -> int:
    """The number of channels that a layer makes."""
    if name not in layers:
        raise FormatError(
            f"{file} holds no weights of HED: the layer {name} is missing. Choose HED's own file, "
            "or convert the network to ONNX."
        )
    weight, bias = layers[name]
    fits = weight.ndim == 4 and all(wanted in {None, found} for wanted, found in zip(shape, weight.shape, strict=True))
    if not fits or bias.shape != weight.shape[:1]:
        wanted = " x ".join("any" if size is None else str(size) for size in shape)
        raise FormatError(
            f"{file} holds no weights of HED: the layer {name} is {' x '.join(map(str, weight.shape))}, not {wanted}. "
            "Choose HED's own file, or convert the network to ONNX."
        )
    return int(weight.shape[0])
