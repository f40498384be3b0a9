"""Accuracy of Refine edge: `python -m tests.bench.refining [--seed N] [--scenes N] [FOLDER]`.

The borders of the objects of `tests.bench.selection` are displaced by smooth noise, and refined by a band along them.
The table has the mean offset from the true border [px], wrong pixels per pixel of border: before, after a watershed of
the same evidence in the same band, and refined.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter, map_coordinates

import ilf
from ilf.data.blocks import Box
from ilf.data.parameters import BlockParameters
from ilf.segmentation.edges.frame_edges import find_edges
from ilf.segmentation.editing.painting import Stroke
from ilf.segmentation.editing.patches import bounds, grown
from ilf.segmentation.editing.refining import refine_borders
from ilf.segmentation.editing.snapping import Snapper
from ilf.segmentation.flooding import flood

from .corrections.scenes import frames_folder
from .selection import generated, outlined

CASES = ((5, 2.0), (8, 3.0), (12, 3.0))
"""Radius of the brush and root mean square of the displacement [px]."""

WAVE, RIM = 10.0, 40
"""Length over which the displacement changes, and width of the crop around an object [px]."""

Mask = NDArray[np.bool_]


def near_border(mask: Mask, distance: float) -> Mask:
    """Return the pixels within a distance of the border of a mask."""
    inside, outside = (
        cv2.distanceTransform(side.astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE) for side in (mask, ~mask)
    )
    return np.where(mask, inside, outside) - 0.5 <= distance


def displaced(truth: Mask, by: float, rng: np.random.Generator) -> Mask:
    """Return a mask with its border displaced by smooth noise."""
    field = np.stack([gaussian_filter(rng.normal(size=truth.shape), WAVE) for _ in range(2)])
    field *= by / np.sqrt(np.mean(field**2))
    return np.asarray(
        map_coordinates(truth.astype(float), np.indices(truth.shape) + field, order=1, mode="nearest") > 0.5
    )


def measure(name: str, frames: list[tuple[ilf.RGBDFrame, list[Mask]]]) -> None:
    """Print the rows of some frames."""
    for radius, by in CASES:
        offsets = np.array(list(_offsets(frames, radius, by)))
        print(
            f"{name:12}{radius:8}{by:8.0f}{len(offsets):9}" + "".join(f"{mean:12.2f}" for mean in offsets.mean(axis=0))
        )


def _offsets(
    frames: list[tuple[ilf.RGBDFrame, list[Mask]]], radius: float, by: float
) -> Iterator[tuple[float, float, float]]:
    """Mean offsets of each object's border: before, by the watershed, refined."""
    rng = np.random.default_rng(1)
    for frame, masks in frames:
        evidence = Snapper(frame, find_edges(frame, BlockParameters()).strength).evidence
        for mask in masks:
            box = bounds(mask)
            assert box is not None
            box = grown(box, RIM, mask.shape)
            found = _refined(frame, evidence, mask, box, displaced(mask[box], by, rng), radius)
            if found is not None:
                length = np.count_nonzero(near_border(mask[box], 1)) / 2
                before, flooded, refined = (np.count_nonzero(one != mask[box]) / length for one in found)
                yield before, flooded, refined


def _refined(
    frame: ilf.RGBDFrame, evidence: NDArray[np.float32], mask: Mask, box: Box, start: Mask, radius: float
) -> tuple[Mask, Mask, Mask] | None:
    """The mask at the start, after the watershed and refined; None if the band covers the whole object."""
    band = near_border(start, radius)
    if not (start & ~band).any():
        return None
    labels = np.ones(mask.shape, np.int32)
    labels[box] += start
    flooded = flood(evidence[box], np.where(band, 0, labels[box]), np.ones(band.shape, bool))
    patch = refine_borders(frame, evidence, labels, Stroke(box, band))
    if patch is not None:
        patch.apply(labels)
    return start, flooded == 2, labels[box] == 2


def main() -> int:
    """Print the table for the generated and the real frames."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.refining", description="Accuracy of Refine edge.")
    parser.add_argument("folder", nargs="?", type=Path, default=frames_folder(), help="folder with the real frames")
    parser.add_argument("--seed", type=int, default=7, help="seed of the generated scenes")
    parser.add_argument("--scenes", type=int, default=6, help="number of generated scenes")
    options = parser.parse_args()
    print(f"{'frames':12}{'radius':>8}{'moved':>8}{'borders':>9}{'before':>12}{'watershed':>12}{'refined':>12}")
    measure("generated", list(generated(options.seed, options.scenes)))
    if options.folder.is_dir():
        measure("real", list(outlined(options.folder)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
