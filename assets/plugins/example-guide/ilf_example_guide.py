"""A network of a format of its own (.linear.json) as a guide: here one layer, whose weights are in the file."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ilf.errors import FormatError


def predict(path: Path, rgb: NDArray[np.uint8]) -> NDArray[np.floating]:
    """Return a value for each pixel of an image (H, W, 3): depth or inverse depth in any unit, NaN = unknown."""
    height, width = rgb.shape[:2]
    rows, columns = np.mgrid[:height, :width]
    inputs = np.dstack([rgb / 255, rows / height, columns / width])
    return inputs @ _weights(path, path.stat().st_mtime_ns)


@lru_cache(maxsize=2)
def _weights(path: Path, modified: int) -> NDArray[np.float64]:
    """The five weights; the file is read once for many frames, and again when it has changed."""
    try:
        weights = np.array(json.loads(path.read_text(encoding="utf-8"))["weights"], float)
    except (ValueError, KeyError, TypeError) as error:
        raise FormatError(f"{path} has no list of weights ({error}).") from error
    if weights.shape != (5,):
        raise FormatError(f"{path} has {weights.size} weights, not 5: red, green, blue, row, column.")
    return weights
