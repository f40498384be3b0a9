"""Weights out of a .caffemodel, with the layers' fields of today's Caffe and of that of 2014."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from .. import wire
from .layers import FUSION, Layer

_ALIASES = {"upscore-fuse": FUSION}


class _Fields(NamedTuple):
    """Where a layer's message has what is needed."""

    layers: int
    name: int
    blobs: int


_VERSIONS = (_Fields(layers=100, name=1, blobs=7), _Fields(layers=2, name=4, blobs=6))
_OLD_SHAPE, _DATA, _SHAPE, _DOUBLES = (1, 2, 3, 4), 5, 7, 8


def read_caffemodel(content: NDArray[np.uint8], file: str) -> dict[str, Layer]:
    """The layers that have weights, by name.

    Parameters
    ----------
    content : ndarray of uint8
        Of the file.
    file : str
        Its name, for the message.

    Raises
    ------
    FormatError
        If it is no Caffe model, or is truncated.
    """
    layers = {}
    try:
        for number, value in wire.fields(content.data):
            for version in _VERSIONS:
                if number == version.layers and isinstance(value, memoryview):
                    blobs = [_blob(blob) for blob in wire.messages(value, version.blobs)]
                    if blobs:
                        name = wire.text(value, version.name)
                        layers[_ALIASES.get(name, name)] = _layer(blobs)
    except ValueError as error:
        raise FormatError(f"{file} is no intact Caffe model ({error}). Download or copy it again.") from error
    return layers


def _layer(blobs: list[NDArray[np.float32]]) -> Layer:
    weight = blobs[0]
    return Layer(weight, blobs[1].ravel() if len(blobs) > 1 else np.zeros(weight.shape[:1], np.float32))


def _blob(message: memoryview) -> NDArray[np.float32]:
    shapes = wire.messages(message, _SHAPE)
    if shapes:
        shape = wire.integers(shapes[-1], 1)
    else:
        shape = [size for number in _OLD_SHAPE for size in wire.integers(message, number)]
    doubles = wire.messages(message, _DOUBLES)
    numbers = np.frombuffer(b"".join(doubles or wire.messages(message, _DATA)), "<f8" if doubles else "<f4")
    if numbers.size != math.prod(shape):
        raise ValueError(f"{numbers.size} weights for a shape of {' x '.join(map(str, shape))}")
    return numbers.astype(np.float32).reshape(shape)
