"""Samples of the correction lesson: generated frames, and what the filter has made of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...edges.depth_features import filled_log_depth
from ...errors import InputError
from ..features import correction_features

Array = NDArray[np.float32]

HELD_OUT = 40
"""Samples of pictures of lower numbers are held out."""


class SampleFolder:
    """Samples `<number>-<k>.npz` in a folder; those that appear later are found by `look_again`.

    Attributes
    ----------
    learnt, held_out : list of Path
        In order of their numbers, which are at least `HELD_OUT`, or below.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.look_again()
        if not self.learnt or not self.held_out:
            raise InputError(
                f"{folder} has no samples to learn from: it needs files <number>-<k>.npz, some of numbers below "
                f"{HELD_OUT}, which are held out, and some above."
            )

    def look_again(self) -> None:
        """List what the folder holds now."""
        paths = sorted(path for path in self.folder.glob("*-*.npz") if path.stem.split("-")[0].isdigit())
        self.held_out = [path for path in paths if int(path.stem.split("-")[0]) < HELD_OUT]
        self.learnt = [path for path in paths if int(path.stem.split("-")[0]) >= HELD_OUT]


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
