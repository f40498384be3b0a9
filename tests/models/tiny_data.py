"""Pictures, samples and images of a few pixels, as the scripts write them and the recipes read them."""

from pathlib import Path

import cv2
import numpy as np
from scipy.io import savemat

from ilf.data.pixel_grids import different_labels, mark


def write_picture(folder: Path, number: int) -> Path:
    """Two surfaces at 2 m with a nearer disc in front of one; jumps around it, a crease between them."""
    rows, columns = np.mgrid[:64, :96]
    part = np.where(columns < 20, 1, 2).astype(np.int32)
    part[np.hypot(rows - 30, columns - 50) < 18] = 3
    exact = np.where(part == 3, np.float32(1.2), np.float32(2))
    jump = mark(different_labels(np.asarray(part == 3, np.int32)))
    values = {
        "rgb": np.random.default_rng(number).integers(0, 256, (64, 96, 3), np.uint8),
        "exact": exact,
        "measured": exact + np.float32(0.01),
        "part": part,
        "object": np.where(part == 3, 1, 0).astype(np.int32),
        "jump": jump.astype(np.uint8),
        "crease": (mark(different_labels(part)) & ~jump).astype(np.uint8),
    }
    path = folder / f"{number:06d}.npz"
    np.savez(path, **values)
    return path


def write_correction_sample(folder: Path, name: str) -> Path:
    """A slope of 1 to 2 m with a hole, completed 1 % too far."""
    shape = (32, 32)
    exact = np.linspace(1, 2, shape[1], dtype=np.float32) + np.zeros(shape, np.float32)
    depth = exact.copy()
    depth[8:16, 10:20] = np.nan
    lines = np.zeros((*shape, 2), np.float32)
    lines[:, 5] = 1
    path = folder / f"{name}.npz"
    np.savez(path, rgb=np.full((*shape, 3), 128, np.uint8), depth=depth, completed=np.float32(1.01) * exact,
             contours=np.zeros(shape, np.uint8), exact=exact, lines=lines)  # fmt: skip
    return path


def write_bsds500(folder: Path, count: int) -> None:
    """Images of a bright square, numbered from 1, by turns among those for training and for validation."""
    segmentation = np.ones((24, 30), np.uint16)
    segmentation[6:18, 8:20] = 2
    rgb = np.where(segmentation[..., None] > 1, 230, 20).astype(np.uint8).repeat(3, axis=2)
    ground_truth = np.empty((1, 1), object)
    ground_truth[0, 0] = {"Segmentation": segmentation}
    for number in range(1, count + 1):
        split = "train" if number % 2 else "val"
        for kind in ("images", "groundTruth"):
            (folder / kind / split).mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(folder / "images" / split / f"{number}.jpg"), rgb)
        savemat(folder / "groundTruth" / split / f"{number}.mat", {"groundTruth": ground_truth})
