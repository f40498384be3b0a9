"""Accuracy of snapping of hand-drawn lines to the true border: `python -m tests.bench.snapping FOLDER ...`.

The long lines of depth jumps of every frame, whose depth should be dense, are the ground truth. Each is drawn with a
hand's jitter, snapped with several leashes, and evaluated by the mean distance to the ground truth: with unchanged
depth, and with the depth hidden in a band around the border, as in the holes of real sensors.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt, gaussian_filter1d
from scipy.spatial import cKDTree
from skimage.measure import find_contours

import ilf
from ilf.data.pixel_grids import mark
from ilf.evaluation.bench.frames import as_measured
from ilf.segmentation.edges.relief import find_relief
from ilf.segmentation.editing.snapping import Snapper

LEASHES = (0, 3, 6, 10)
BANDS = (0, 4, 8)
JITTER = 3.0
"""Standard deviation [px] of the jitter, which changes over about 12 px of the line."""

SHORTEST = 60


def true_lines(depth: NDArray[np.float32]) -> list[NDArray[np.float64]]:
    """Long lines (n, 2) of (x, y), a pixel apart, along the jumps of dense depth."""
    relief = find_relief(depth, 0.15, 0.06)
    near_side = np.nan_to_num(depth)
    lines = []
    # along outlines of objects nearer than their surroundings, where depth jumps
    jumps = mark(relief.jumps)
    distance = distance_transform_edt(~jumps)
    for level in np.quantile(near_side[near_side > 0], (0.2, 0.4, 0.6, 0.8)):
        for contour in find_contours(near_side, level):
            points = contour[:, ::-1] + 0.5
            rows, columns = (np.clip(points[:, k].astype(int), 0, jumps.shape[1 - k] - 1) for k in (1, 0))
            at_jump = distance[rows, columns] <= 1.5
            edges = np.flatnonzero(np.diff(np.concatenate([[0], at_jump.astype(int), [0]])))
            for start, stop in zip(edges[::2], edges[1::2], strict=True):
                line = _every_pixel(points[start:stop])
                if len(line) >= SHORTEST:
                    lines.append(line[: 4 * SHORTEST])
    return lines


def by_hand(line: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Add a smooth jitter across the line."""
    smooth = gaussian_filter1d(line, 4, axis=0, mode="nearest")
    along = np.gradient(smooth, axis=0)
    along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    noise = gaussian_filter1d(rng.normal(size=len(line)), 6)
    noise *= JITTER / max(float(noise.std()), 1e-9)
    return smooth + noise[:, None] * np.stack([-along[:, 1], along[:, 0]], axis=1)


def main(folders: list[str]) -> None:
    """Print the mean distances [px] by band and leash."""
    rng = np.random.default_rng(0)
    found: dict[tuple[int, int], list[float]] = {(band, leash): [] for band in BANDS for leash in LEASHES}
    count = 0
    for folder in folders:
        whole = _frame(Path(folder))
        lines = true_lines(whole.depth)
        drawn = [by_hand(line, rng) for line in lines]
        count += len(lines)
        for band in BANDS:
            frame = whole
            if band and lines:
                ground_truth = np.ones(whole.shape, bool)
                points = np.concatenate(lines).astype(int)
                ground_truth[
                    np.clip(points[:, 1], 0, ground_truth.shape[0] - 1),
                    np.clip(points[:, 0], 0, ground_truth.shape[1] - 1),
                ] = False
                frame = whole.with_invalid_mask(distance_transform_edt(ground_truth) <= band)
            snapper = Snapper(frame, ilf.edge_strength(frame))
            for line, sketch in zip(lines, drawn, strict=True):
                tree = cKDTree(line)
                for leash in LEASHES:
                    snapped = np.array(snapper.snap([tuple(point) for point in sketch.tolist()], leash))
                    found[band, leash].append(float(np.mean(tree.query(snapped)[0])))
    print(f"{count} lines of {len(folders)} frames; mean distance to the true border [px], share of lines made worse")
    for band in BANDS:
        cells = [
            f"leash {leash}: {np.mean(found[band, leash]):.2f} "
            f"({np.mean(np.array(found[band, leash]) > np.array(found[band, 0]) + 0.1):.0%})"
            for leash in LEASHES
        ]
        print(f"band of {band} px hidden: " + ", ".join(cells))


def _frame(folder: Path) -> ilf.RGBDFrame:
    """Read the frame with its ground truth as depth."""
    image = next(folder.glob("rgb.*"))
    return as_measured(ilf.load_frame(image, folder / "gt.png", depth_units=1000))


def _every_pixel(line: NDArray[np.float64]) -> NDArray[np.float64]:
    along = np.append(0, np.cumsum(np.hypot(*np.diff(line, axis=0).T)))
    wanted = np.arange(0, along[-1], 1.0)
    return np.stack([np.interp(wanted, along, line[:, k]) for k in range(2)], axis=1)


if __name__ == "__main__":
    main(sys.argv[1:])
