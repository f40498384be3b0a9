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
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

import ilf
from ilf.segmentation import selection
from ilf.segmentation.editing.painting import inside_outline
from ilf.segmentation.region_tree import region_tree
from ilf.segmentation.selection import prepare_selection

from .corrections.scenes import frames_folder

sys.path.insert(0, str(Path(__file__).parents[2] / "assets" / "models"))

from make_scenes import record  # type: ignore[import-not-found]

OUTLINES = Path(__file__).with_name("selection_outlines.json")
SIZE = (640, 480)
OBJECTS, SMALLEST = 8, 0.003
"""Objects of a generated scene that are selected, and the smallest share of the frame that one covers."""

CLICKS = 3

WEIGHT_DECAY = 3e-4
"""For the fit: the penalty of the coefficients' squares."""

Mask = NDArray[np.bool_]
Point = tuple[float, float]


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
    """The parts that a click may add or take away: properties, (K, N), and the IoU with the object after it, (K,)."""

    kind: str
    properties: NDArray[np.float64]
    overlaps: NDArray[np.float64]


def choices(frame: ilf.RGBDFrame, truth: Mask, place: Callable[[Mask], Point]) -> Iterator[Choices]:
    """Yield the choices at each click on an object: at some place of the largest error."""
    tree = region_tree(frame)
    pixels, inside, outside = tree.pixels[: tree.order.size], [place(truth)], list[Point]()
    correct = np.bincount(tree.pieces[truth], minlength=pixels.size)
    chosen, adds = np.zeros(pixels.size, bool), True
    for number in range(CLICKS + 1):
        point = (inside if adds else outside)[-1]
        wanted, unwanted = ([int(tree.pieces[int(y), int(x)]) for x, y in side] for side in (inside, outside))
        if adds:
            parts = selection.regions_around(tree, wanted[-1:], [])
            after = chosen | parts
        else:
            parts = selection.removable_parts(tree, chosen, unwanted[-1:], wanted, unwanted)
            after = chosen & ~parts
        shared = after @ correct
        yield Choices(
            "outside" if not adds else "further" if number else "first",
            selection.part_properties(tree, chosen, parts, np.array([point]), adds),
            shared / (after @ pixels + np.count_nonzero(truth) - shared),
        )
        found = ilf.select_region(frame, inside, outside)
        chosen = np.bincount(tree.pieces[found], minlength=pixels.size) > 0
        wrong = found != truth
        if not wrong.any():
            return
        x, y = place(largest_part(wrong))
        adds = bool(truth[int(y), int(x)])
        if not adds and tree.pieces[int(y), int(x)] in wanted:
            return
        (inside if adds else outside).append((x, y))


def fitted(found: list[Choices]) -> NDArray[np.float64]:
    """Return the coefficients with the largest expected IoU, if parts are chosen with probabilities proportional to the
    exponential of their score."""
    properties, overlaps = (
        np.concatenate([getattr(one, what) for one in found]) for what in ("properties", "overlaps")
    )
    scale = np.maximum(properties.std(axis=0), 1e-3)
    scaled = (properties - properties.mean(axis=0)) / scale
    counts = np.array([one.overlaps.size for one in found])
    starts = np.cumsum(counts) - counts

    def loss(weights: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
        scores = scaled @ weights
        likely = np.exp(scores - np.repeat(np.maximum.reduceat(scores, starts), counts))
        likely /= np.repeat(np.add.reduceat(likely, starts), counts)
        expected = np.add.reduceat(likely * overlaps, starts)
        slopes = (likely * (overlaps - np.repeat(expected, counts))) @ scaled / counts.size
        return WEIGHT_DECAY * float(weights @ weights) - expected.mean(), 2 * WEIGHT_DECAY * weights - slopes

    best = minimize(loss, np.zeros(scale.size), jac=True, method="L-BFGS-B", options={"maxiter": 300}).x
    return np.round(best / scale, 3)


def fit(frames: list[tuple[ilf.RGBDFrame, list[Mask]]]) -> None:
    """Print the coefficients of the score that are fitted to some frames, by clicks in the middle of errors and
    anywhere in them. Clicks after the first depend on the present coefficients."""
    rng = np.random.default_rng(0)

    def anywhere(mask: Mask) -> Point:
        row, column = np.argwhere(mask)[rng.integers(np.count_nonzero(mask))]
        return float(column) + 0.5, float(row) + 0.5

    found = [
        one
        for frame, masks in frames
        for truth in masks
        for place in (middle, middle, anywhere)  # most people click in the middle
        for one in choices(frame, truth, place)
    ]
    columns = []
    for kind in selection.KINDS:
        these = [one for one in found if one.kind == kind]
        columns.append(fitted(these))
        chosen = np.mean([one.overlaps[np.argmax(one.properties @ columns[-1])] for one in these])
        best = np.mean([one.overlaps.max() for one in these])
        print(f"{kind}: {len(these)} clicks, IoU {chosen:.3f}, of the best part {best:.3f}", flush=True)
    print(*zip(*(column.tolist() for column in columns), strict=True), sep=",\n")


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
        fit([one for k in range(given.scenes) for one in generated(given.seed + k, 1)])  # one scene of each seed
        return
    measure("outlined by hand", outlined(given.folder))
    if given.scenes:
        measure(f"generated with seed {given.seed}", generated(given.seed, given.scenes))


if __name__ == "__main__":
    main()
