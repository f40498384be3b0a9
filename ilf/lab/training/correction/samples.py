"""Samples of the correction lesson: generated frames, and what the filter has made of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ....completion.correction_network import correction_features
from ....errors import InputError
from ....segmentation.edges.depth_edges import filled_log_depth
from ..depth_edges.pictures import PictureFolder

Array = NDArray[np.float32]


class SampleFolder(PictureFolder):
    """Samples `<number>-<k>.npz` in a folder, some of each picture of a number."""

    KIND, NAMES = "samples", "<number>-<k>.npz"

    @staticmethod
    def number_in(name: str) -> str:
        """That of the picture; of a name without another one behind it, none."""
        number, _, k = name.partition("-")
        return number if k else ""


def read_sample(path: Path) -> tuple[Array, ...]:
    """A sample as it was made.

    Returns
    -------
    image : ndarray of float32, shape (H, W, 3)
        In [0, 1].
    features : ndarray of float32, shape (H, W, 10)
    lines : ndarray of float32, shape (H, W, 2)
        1 on jumps and on creases.
    log_depth, completed : ndarray of float32, shape (H, W, 1)
        Exact, NaN where there is none, and completed, both less the median of the known one.

    Raises
    ------
    InputError
        If it is none.
    """
    names = ("rgb", "depth", "completed", "contours", "exact", "lines")
    try:
        with np.load(path) as file:
            rgb, depth, completed, contours, exact, lines = (file[name] for name in names)
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} is no sample. Make it again.") from error
    features, log_depth = correction_features(depth, completed, np.asarray(contours / 255, np.float32))
    true = np.log(exact) - np.float32(filled_log_depth(depth)[1])
    image = np.asarray(rgb / 255, np.float32)
    arrays = (image, np.moveaxis(features, 0, 2), lines, true[..., None], log_depth[..., None])
    return tuple(np.ascontiguousarray(one, np.float32) for one in arrays)


def varied(sample: tuple[Array, ...], rng: np.random.Generator) -> tuple[Array, ...]:
    """A sample, perhaps as a mirror shows it, a little brighter or darker, noisier, and of other tint.

    Only a little: what the filter has made of the picture is not made again.
    """
    image, features, lines, *depths = sample
    gains = rng.uniform(0.85, 1.15) * rng.uniform(0.95, 1.05, 3)
    image = image * gains.astype(np.float32)
    if rng.random() < 0.3:
        image += np.float32(rng.uniform(0, 0.02)) * rng.standard_normal(image.shape, np.float32)
    arrays = (np.clip(image, 0, 1), features, lines, *depths)
    if rng.random() < 0.5:
        # lines mark the left or upper of two pixels
        arrays = (arrays[0], features, np.roll(lines, 1, axis=1), *depths)
        arrays = tuple(np.ascontiguousarray(one[:, ::-1]) for one in arrays)
    return arrays
