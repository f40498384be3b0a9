"""Accuracy of `ilf.select_region` by a robot's clicks: `python -m tests.bench.selection [--seed N] [FOLDER]`.

The first click is in the middle of an object, each further one in the middle of the largest error. Objects are those of
generated scenes of a fresh seed, and 20 that were outlined by hand on real frames (`selection_outlines.json`). They are
compared with the block under the first click.
"""

from __future__ import annotations

import argparse
import json
import random
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import softmax

import ilf
from ilf.segmentation import selection
from ilf.segmentation.editing.painting import inside_outline
from ilf.segmentation.selection import prepare_selection

from .corrections.scenes import frames_folder

sys.path.insert(0, str(Path(__file__).parents[2] / "assets" / "samples"))

from make_scenes import record  # type: ignore[import-not-found]

OUTLINES = Path(__file__).with_name("selection_outlines.json")
SIZE = (640, 480)
OBJECTS, SMALLEST = 8, 0.003
"""Objects of a generated scene that are selected, and the smallest share of the frame that one covers."""

CLICKS = 3

POINTS, WEIGHT_DECAY = 2, 1e-4
"""For the fit: random points of every object beside its middle, and the penalty of the coefficients' squares."""

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


def clicked(frame: ilf.RGBDFrame, truth: Mask) -> tuple[list[float], float]:
    """Return the IoU after each click, and the longest time of a click [s]."""
    inside, scores, longest = [middle(truth)], [], 0.0
    outside: list[tuple[float, float]] = []
    for _ in range(CLICKS):
        start = time.perf_counter()
        found = ilf.select_region(frame, inside, outside)
        longest = max(longest, time.perf_counter() - start)
        scores.append(overlap(found, truth))
        wrong = found != truth
        if wrong.any():
            x, y = middle(largest_part(wrong))
            (inside if truth[int(y), int(x)] else outside).append((x, y))
    return scores, longest


def boxed(frame: ilf.RGBDFrame, truth: Mask) -> float:
    """Return the IoU of what a box around the object selects."""
    rows, columns = np.flatnonzero(truth.any(axis=1)), np.flatnonzero(truth.any(axis=0))
    box = (float(columns[0] - 2), float(rows[0] - 2), float(columns[-1] + 3), float(rows[-1] + 3))
    return overlap(ilf.select_region(frame, [], box=box), truth)


def generated(seed: int, count: int) -> Iterator[tuple[ilf.RGBDFrame, list[Mask]]]:
    """Yield generated frames with some of their objects, each in one part."""
    rng = np.random.default_rng(seed)
    for number in range(count):
        made = record(seed, number, SIZE)
        objects = made["object"]
        seen = [largest_part(objects == one) for one in np.unique(objects[objects >= 0])]
        large = [mask for mask in seen if np.count_nonzero(mask) >= SMALLEST * objects.size]
        chosen = rng.permutation(len(large))[:OBJECTS]
        yield ilf.RGBDFrame(rgb=made["rgb"], depth=made["measured"]), [large[k] for k in chosen]


def outlined(folder: Path) -> Iterator[tuple[ilf.RGBDFrame, list[Mask]]]:
    """Yield the real frames with their outlined objects."""
    for name, outlines in json.loads(OUTLINES.read_text()).items():
        frame = ilf.load_frame(folder / name)
        masks = []
        for points in outlines.values():
            mask = np.zeros(frame.shape, bool)
            inside = inside_outline(frame.shape, points)
            if inside is not None:
                mask[inside.box] = inside.mask
            masks.append(mask)
        yield frame, masks


def measure(name: str, frames: Iterator[tuple[ilf.RGBDFrame, list[Mask]]]) -> None:
    """Print a line with the mean IoU of the block under the first click, after each click, and of a box."""
    blocks, clicks, boxes, times = [], [], [], []
    for frame, masks in frames:
        labels = ilf.extract_blocks(frame)
        prepare_selection(frame)
        for truth in masks:
            x, y = middle(truth)
            blocks.append(overlap(labels == labels[int(y), int(x)], truth))
            scores, longest = clicked(frame, truth)
            clicks.append(scores)
            boxes.append(boxed(frame, truth))
            times.append(longest)
    after = ", ".join(f"{score:.2f}" for score in np.mean(clicks, axis=0))
    print(
        f"{name}: {len(blocks)} objects, block {np.mean(blocks):.2f}, after 1, 2, 3 clicks {after}, "
        f"box {np.mean(boxes):.2f}, a click {1000 * np.median(times):.1f} ms (at most {1000 * max(times):.0f})",
        flush=True,
    )


# The fit of the score's coefficients.


@dataclass(frozen=True)
class Choices:
    """The regions around a point of an object: their properties, (N, 13), and their IoU with the object, (N,)."""

    properties: NDArray[np.float64]
    overlaps: NDArray[np.float64]


def choices(frame: ilf.RGBDFrame, masks: list[Mask], rng: np.random.Generator) -> Iterator[Choices]:
    """Yield the choices around the middle of each object, and around `POINTS` random points of it."""
    pieces, tree = selection._tree_of(frame)
    order, first, stop = selection._in_order(tree.parents, int(pieces.max()) + 1)
    properties = selection._properties(tree)
    for truth in masks:
        inside = np.bincount(pieces[truth], minlength=order.size)[order]
        before = np.concatenate([[0], np.cumsum(inside)])
        shared = before[stop] - before[first]
        overlaps = shared / (tree.pixels + np.count_nonzero(truth) - shared)
        x, y = middle(truth)
        for place in (pieces[int(y), int(x)], *rng.choice(pieces[truth], POINTS)):
            nodes = [int(place)]
            while tree.parents[nodes[-1]] >= 0:
                nodes.append(int(tree.parents[nodes[-1]]))
            yield Choices(properties[nodes], overlaps[nodes])


def fit(seed: int, count: int) -> None:
    """Print the coefficients of the score that are fitted to generated scenes: those with the largest expected IoU, if
    regions are chosen with probabilities proportional to the exponential of their score."""
    rng = np.random.default_rng(seed)
    found = [one for frame, masks in generated(seed, count) for one in choices(frame, masks, rng)]
    scale = np.concatenate([one.properties for one in found]).std(axis=0)

    def loss(scaled: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        value, slopes = WEIGHT_DECAY * float(scaled @ scaled), 2 * WEIGHT_DECAY * scaled
        for one in found:
            properties = one.properties / scale
            likely = softmax(properties @ scaled)
            expected = likely @ one.overlaps
            value -= expected / len(found)
            slopes = slopes - (likely * (one.overlaps - expected)) @ properties / len(found)
        return value, slopes

    start = np.zeros(scale.size)
    coefficients = minimize(loss, start, jac=True, method="L-BFGS-B", options={"maxiter": 500}).x / scale
    chosen = [one.overlaps[np.argmax(one.properties @ coefficients)] for one in found]
    best = [one.overlaps.max() for one in found]
    print(f"{len(found)} points, IoU {np.mean(chosen):.3f}, of the best region {np.mean(best):.3f}")
    print(f"({', '.join(f'{value:.3g}' for value in coefficients)})")


def main(arguments: list[str] | None = None) -> None:
    """Measure on generated scenes and real frames."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench.selection", description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, nargs="?", default=frames_folder(), help="folder of the real frames")
    parser.add_argument(
        "--seed", type=int, default=random.randrange(10**6), help="of the scenes; a fresh one if left out"
    )
    parser.add_argument("--scenes", type=int, default=12, help="number of generated scenes")
    parser.add_argument("--fit", action="store_true", help="fit the score to generated scenes instead of measuring")
    given = parser.parse_args(arguments)
    if given.fit:
        fit(given.seed, given.scenes)
        return
    measure("outlined by hand", outlined(given.folder))
    if given.scenes:
        measure(f"generated with seed {given.seed}", generated(given.seed, given.scenes))


if __name__ == "__main__":
    main()
