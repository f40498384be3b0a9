"""BSDS500 as training samples: warped images with boundaries that stay one pixel wide at every angle and scale."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat

from ilf.errors import InputError

HELD_OUT_EVERY = 10

Pixel = TypeVar("Pixel", np.uint8, np.int16)


@dataclass(frozen=True)
class Example:
    """One image with the segmentation of each annotator.

    Attributes
    ----------
    name : str
        Number of the image in BSDS500.
    rgb : ndarray of uint8, shape (H, W, 3)
    segmentations : tuple of ndarray of int16, shape (H, W)
    """

    name: str
    rgb: NDArray[np.uint8]
    segmentations: tuple[NDArray[np.int16], ...]


def load_examples(folder: Path) -> tuple[list[Example], list[Example]]:
    """Load the 300 images of train and val, split into training and held-out images.

    Every tenth image by number is held out; the test images are never read.

    Parameters
    ----------
    folder : Path
        BSDS500 with `images/{train,val}/*.jpg` and `groundTruth/{train,val}/*.mat`.

    Returns
    -------
    learnt, held_out : list of Example

    Raises
    ------
    InputError
        If the folder does not have these images.
    """
    examples = [_load(folder, path) for path in image_paths(folder, "train", "val")]
    held_out = examples[::HELD_OUT_EVERY]
    return [example for k, example in enumerate(examples) if k % HELD_OUT_EVERY], held_out


def image_paths(folder: Path, *splits: str) -> list[Path]:
    """List the images of some splits of BSDS500 by number; raise InputError if there are none."""
    paths = [path for split in splits for path in (folder / "images" / split).glob("*.jpg")]
    if not paths:
        raise InputError(f"{folder} has no images/{splits[0]}/*.jpg. Give the folder of BSDS500.")
    return sorted(paths, key=lambda path: int(path.stem))


def read_image(path: Path) -> NDArray[np.uint8]:
    """Read an image file as uint8 RGB (H, W, 3); raise InputError if it is not an image."""
    bgr = cv2.imread(str(path))
    if bgr is None:
        raise InputError(f"{path} cannot be read as an image. Unpack BSDS500 again.")
    return np.ascontiguousarray(bgr[..., ::-1], np.uint8)


def _load(folder: Path, path: Path) -> Example:
    ground_truth = loadmat(folder / "groundTruth" / path.parent.name / f"{path.stem}.mat")["groundTruth"]
    segmentations = tuple(
        ground_truth[0, k]["Segmentation"][0, 0].astype(np.int16) for k in range(ground_truth.shape[1])
    )
    return Example(path.stem, read_image(path), segmentations)


def boundary(segmentation: NDArray[np.int16]) -> NDArray[np.bool_]:
    """One-pixel boundary of a segmentation: a pixel that differs from its right, lower or lower right neighbour."""
    padded = np.pad(segmentation, ((0, 1), (0, 1)), mode="edge")
    here = padded[:-1, :-1]
    return (here != padded[:-1, 1:]) | (here != padded[1:, :-1]) | (here != padded[1:, 1:])


def consensus(segmentations: tuple[NDArray[np.int16], ...]) -> NDArray[np.float32]:
    """Share of the annotators who marked a boundary at each pixel, float32 (H, W) in [0, 1]."""
    return np.mean([boundary(one) for one in segmentations], axis=0, dtype=np.float32)


def random_sample(
    example: Example, size: int, rng: np.random.Generator
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return a random crop, rotated, mirrored, scaled and changed in colour.

    Returns
    -------
    rgb : ndarray of float32, shape (size, size, 3)
        In [0, 1].
    share : ndarray of float32, shape (size, size)
        Share of the annotators who marked a boundary.
    """
    matrix = _random_warp(example.rgb.shape[:2], size, rng)
    # Reflection continues image and segmentation alike, so a crop beyond the border creates no false boundary.
    rgb = _warp(example.rgb, matrix, size, cv2.INTER_LINEAR)
    warped = tuple(_warp(one, matrix, size, cv2.INTER_NEAREST) for one in example.segmentations)
    return _random_colour(rgb, rng), consensus(warped)


def _warp(image: NDArray[Pixel], matrix: NDArray[np.float64], size: int, how: int) -> NDArray[Pixel]:
    warped = cv2.warpAffine(image, matrix, (size, size), flags=how, borderMode=cv2.BORDER_REFLECT_101)
    return np.asarray(warped, image.dtype)


def _random_warp(shape: tuple[int, int], size: int, rng: np.random.Generator) -> NDArray[np.float64]:
    # Half of the samples stay nearly upright, like photographs; the others have any rotation.
    angle = rng.normal(0, 5) if rng.random() < 0.5 else rng.uniform(0, 360)
    scale = np.exp(rng.uniform(np.log(0.55), np.log(1.6)))
    reach = size / (2 * scale)
    height, width = shape
    y = rng.uniform(min(reach, height / 2), max(height - reach, height / 2))
    x = rng.uniform(min(reach, width / 2), max(width - reach, width / 2))
    matrix = np.asarray(cv2.getRotationMatrix2D((x, y), angle, scale), np.float64)
    matrix[:, 2] += size / 2 - np.array([x, y])
    if rng.random() < 0.5:
        matrix[0] = -matrix[0]
        matrix[0, 2] += size - 1
    return matrix


def _random_colour(rgb: NDArray[np.uint8], rng: np.random.Generator) -> NDArray[np.float32]:
    image = rgb.astype(np.float32) / 255
    if rng.random() < 0.1:
        image[:] = image.mean(axis=2, keepdims=True)
    grey = image.mean(axis=2, keepdims=True)
    image = grey + (image - grey) * np.float32(rng.uniform(0.6, 1.4))
    mean = image.mean()
    image = (image - mean) * np.float32(rng.uniform(0.6, 1.4)) + mean + np.float32(rng.uniform(-0.12, 0.12))
    image *= rng.uniform(0.9, 1.1, 3).astype(np.float32)
    image = np.clip(image, 0, 1) ** np.float32(np.exp(rng.uniform(-0.3, 0.3)))
    if rng.random() < 0.15:
        image = np.asarray(cv2.GaussianBlur(image, (0, 0), rng.uniform(0.4, 1.0)), np.float32)
    if rng.random() < 0.3:
        image += rng.normal(0, rng.uniform(0, 0.03), image.shape).astype(np.float32)
    return np.clip(image, 0, 1)
