"""Samples of the correction training: generated frames, and their depth completed by the filter."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ilf.completion.correction import correction_features
from ilf.errors import InputError
from ilf.segmentation.edges.detectors import filled_log_depth

from .pictures import PictureFolder

Array = NDArray[np.float32]

UNKNOWN_LINES = 255
"""Value of lines in the files of samples of real frames."""


class SampleFolder(PictureFolder):
    """Samples `<number>-<k>.npz` in a folder; several belong to the picture of one number."""

    KIND, NAMES = "samples", "<number>-<k>.npz"

    @staticmethod
    def number_in(name: str) -> str:
        """The picture's number in a file name; "" if the name has no second number."""
        number, _, k = name.partition("-")
        return number if k else ""


def read_sample(path: Path) -> tuple[Array, ...]:
    """Read an unchanged sample.

    Returns
    -------
    image : ndarray of float32, shape (H, W, 3)
        In [0, 1].
    features : ndarray of float32, shape (H, W, 10)
    lines : ndarray of float32, shape (H, W, 2)
        1 on jumps and on creases; NaN in samples of real frames, where they are not known.
    log_depth, completed : ndarray of float32, shape (H, W, 1)
        Exact or measured (NaN where there is none) and completed, both minus the median of the known log depth.

    Raises
    ------
    InputError
        If the file is not a sample.
    """
    names = ("rgb", "depth", "completed", "contours", "exact", "lines")
    try:
        with np.load(path) as file:
            rgb, depth, completed, contours, exact, lines = (file[name] for name in names)
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"{path} is not a sample. Make it again.") from error
    features, log_depth = correction_features(depth, completed, np.asarray(contours / 255, np.float32))
    true = np.log(exact) - np.float32(filled_log_depth(depth)[1])
    image = np.asarray(rgb / 255, np.float32)
    drawn = np.where(lines == UNKNOWN_LINES, np.float32(np.nan), lines)
    arrays = (image, np.moveaxis(features, 0, 2), drawn, true[..., None], log_depth[..., None])
    return tuple(np.ascontiguousarray(one, np.float32) for one in arrays)


def augmented(sample: tuple[Array, ...], rng: np.random.Generator) -> tuple[Array, ...]:
    """Augment a sample: at random mirrored, slightly brighter or darker, noisier, and tinted.

    Changes are small, because the completed depth is not computed again.
    """
    image, features, lines, *depths = sample
    gains = rng.uniform(0.85, 1.15) * rng.uniform(0.95, 1.05, 3)
    image = image * gains.astype(np.float32)
    if rng.random() < 0.3:
        image += np.float32(rng.uniform(0, 0.02)) * rng.standard_normal(image.shape, np.float32)
    arrays = (np.clip(image, 0, 1), features, lines, *depths)
    if rng.random() < 0.5:
        # lines mark the left or upper pixel of a pair
        arrays = (arrays[0], features, np.roll(lines, 1, axis=1), *depths)
        arrays = tuple(np.ascontiguousarray(one[:, ::-1]) for one in arrays)
    return arrays
