"""Accuracy of `ilf.select_region` by a robot's clicks: `python -m tests.bench.selection [FOLDER] [--half judging]`.

The first click is in the middle of an object, each further one in the middle of the largest error. The objects were
outlined by hand on real frames (`selection_outlines.json`). Those of the half `choosing` chose properties and orders of
merging; those of `judging` had no part in it.
"""

import argparse
import json
from collections.abc import Collection, Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

import ilf
from ilf.data.blocks import enclosed

from .frame_split import SPLIT

OUTLINES = Path(__file__).with_name("selection_outlines.json")
CLICKS = 3

Mask = NDArray[np.bool_]


def middle(mask: Mask) -> tuple[float, float]:
    """Return the pixel (x, y) that is farthest from the border of a mask."""
    distance = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 5)[1:-1, 1:-1]
    row, column = np.unravel_index(np.argmax(distance), mask.shape)
    return float(column) + 0.5, float(row) + 0.5


def overlap(one: Mask, other: Mask) -> float:
    """Return the IoU of two masks."""
    return float(np.count_nonzero(one & other) / np.count_nonzero(one | other))


def largest_part(mask: Mask) -> Mask:
    """Return the largest 4-connected part of a mask."""
    _, parts, sizes, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    return np.asarray(parts == 1 + np.argmax(sizes[1:, cv2.CC_STAT_AREA]))


def clicked(frame: ilf.RGBDFrame, truth: Mask) -> list[float]:
    """Return the IoU after each click."""
    inside, outside, scores = [middle(truth)], list[tuple[float, float]](), []
    for _ in range(CLICKS):
        found = ilf.select_region(frame, inside, outside)
        scores.append(overlap(found, truth))
        wrong = found != truth
        if wrong.any():
            x, y = middle(largest_part(wrong))
            (inside if truth[int(y), int(x)] else outside).append((x, y))
    return scores


def boxed(frame: ilf.RGBDFrame, truth: Mask) -> float:
    """Return the IoU of what a box around the object selects."""
    rows, columns = np.flatnonzero(truth.any(axis=1)), np.flatnonzero(truth.any(axis=0))
    box = (float(columns[0] - 2), float(rows[0] - 2), float(columns[-1] + 3), float(rows[-1] + 3))
    return overlap(ilf.select_region(frame, [], box=box), truth)


def outlined(folder: Path, file: Path, names: Collection[str]) -> Iterator[tuple[str, ilf.RGBDFrame, dict[str, Mask]]]:
    """Yield frames of some names, or all for none, with their outlined objects."""
    for name, outlines in json.loads(file.read_text()).items():
        if names and name not in names:
            continue
        frame = ilf.load_frame(folder / name)
        masks = {}
        for what, points in outlines.items():
            masks[what] = np.zeros(frame.shape, bool)
            inside = enclosed(points, frame.shape)
            if inside is not None:
                masks[what][inside.box] = inside.mask
        yield name, frame, masks


def main(arguments: list[str] | None = None) -> None:
    """Print the IoU after each click and of a box, of every object and in the mean."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.selection", description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?", default=Path("../shared/data/rgbd"), help="folder of frames")
    parser.add_argument("--half", choices=SPLIT, default="judging")
    parser.add_argument("--outlines", type=Path, help="file of other outlines, of which all are measured")
    given = parser.parse_args(arguments)
    rows = []
    for name, frame, masks in outlined(
        given.folder, given.outlines or OUTLINES, () if given.outlines else SPLIT[given.half]
    ):
        for what, truth in masks.items():
            rows.append([*clicked(frame, truth), boxed(frame, truth)])
            print(f"{name:20} {what:16}", *(f"{score:.2f}" for score in rows[-1]), flush=True)
    print(
        f"{len(rows)} objects, after 1, 2, 3 clicks, and a box:", *(f"{score:.3f}" for score in np.mean(rows, axis=0))
    )


if __name__ == "__main__":
    main()
