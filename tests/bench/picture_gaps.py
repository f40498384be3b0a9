"""Gaps of generated pictures beside those of real frames.

    python -m tests.bench.picture_gaps --pictures PICTURES --frames $(python -m tests.bench.frame_split choosing FRAMES)

Prints medians over pictures of 320 px width: share of missing depth, also along the border; holes of up to 3, 4 to 40
and more than 40 px for every 10,000 px; and how much of the missing depth is in the largest hole.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np

import ilf

WIDTH, STRIP = 320, 8
"""Width of the pictures and of the strip along the border [px]."""
FIGURES = ("missing", "at border", "holes <= 3", "4 - 40", "> 40", "largest")


def gaps(missing: np.ndarray) -> list[float]:
    """The figures of one picture, bool (H, W)."""
    height, width = missing.shape
    mask = missing.astype(np.uint8)
    mask = cv2.resize(mask, (WIDTH, round(height * WIDTH / width)), interpolation=cv2.INTER_NEAREST)
    inner = np.zeros(mask.shape, bool)
    inner[STRIP:-STRIP, STRIP:-STRIP] = True
    areas = cv2.connectedComponentsWithStats(mask, connectivity=8)[2][1:, cv2.CC_STAT_AREA]
    sizes = np.histogram(areas, [1, 4, 41, np.inf])[0] / mask.size * 1e4
    return [mask.mean(), mask[~inner].mean(), *sizes, areas.max(initial=0) / max(mask.sum(), 1)]


def main(arguments: Sequence[str] | None = None) -> int:
    """Print one row for the pictures and one for the frames."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.picture_gaps")
    parser.add_argument("--pictures", type=Path, required=True)
    parser.add_argument("--frames", type=Path, nargs="*", default=[])
    parser.add_argument("--count", type=int, default=200, help="pictures that are read, from the first on")
    given = parser.parse_args(arguments)
    pictures = sorted(given.pictures.glob("*.npz"))[: given.count]
    rows = {
        "pictures": [gaps(np.isnan(np.load(path)["measured"])) for path in pictures],
        "frames": [gaps(np.isnan(ilf.load_frame(folder).depth)) for folder in given.frames],
    }
    print(f"{'':16s}" + "".join(f"{name:>12s}" for name in FIGURES))
    for name, values in rows.items():
        if values:
            print(f"{name:9s}{len(values):7d}" + "".join(f"{value:12.2f}" for value in np.median(values, axis=0)))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
