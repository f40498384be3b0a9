"""Whether depth depends on how the camera was held: `python -m tests.bench.mirrored FRAME ...`.

Every frame is completed as it is, mirrored (left is right), turned (upside down), and with doubled depth; the results
are turned back. Prints, over the pixels that are filled in both: the share of block borders that have a border of the
other result within a pixel, and the median and the 95th percentile of the difference of depth [mm], once with blocks of
its own and once with the same blocks. At the end the medians over all frames.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf import RGBDFrame
from ilf.data.pixel_grids import sides
from ilf.evaluation.bench.frames import find_frames, load_bench_frame
from ilf.run.run import complete
from ilf.segmentation.extraction import extract_blocks

Turn = Callable[[NDArray], NDArray]

TURNS: dict[str, tuple[Turn, float]] = {
    "mirrored": (np.fliplr, 1.0),
    "turned": (lambda image: image[::-1, ::-1], 1.0),
    "doubled": (np.asarray, 2.0),
}
"""Name -> how an image is turned, which is its own inverse, and the factor of depth."""

REACH = 1
"""Distance at which two borders are in common [px]."""

HEADER = f"{'':26} {'':9}{'in common':>10} {'own blocks':>17} {'same blocks':>17} [mm]: median, 95 %"


def turned_frame(frame: RGBDFrame, turn: Turn, factor: float) -> RGBDFrame:
    """Return a frame whose images are turned and whose depth is multiplied."""
    return RGBDFrame(
        np.ascontiguousarray(turn(frame.rgb)), np.ascontiguousarray(turn(frame.depth)) * np.float32(factor)
    )


def borders(blocks: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Return the pixels beside a border of blocks, (H, W)."""
    found = np.zeros(blocks.shape, bool)
    for (one, other), (here, there) in zip(sides(blocks), sides(found), strict=True):
        here |= one != other
        there |= one != other
    return found


def in_common(one: NDArray[np.bool_], other: NDArray[np.bool_]) -> float:
    """Return the share of both borders with one of the other within `REACH`."""
    kernel = np.ones((2 * REACH + 1,) * 2, np.uint8)
    near = [cv2.dilate(border.view(np.uint8), kernel) > 0 for border in (one, other)]
    shared = np.count_nonzero(one & near[1]) + np.count_nonzero(other & near[0])
    return shared / max(np.count_nonzero(one) + np.count_nonzero(other), 1)


def apart(one: NDArray[np.float32], other: NDArray[np.float32], holes: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the median and the 95th percentile of the difference in holes [mm]."""
    difference = 1000 * np.abs(one - other)[holes & np.isfinite(one) & np.isfinite(other)]
    median, far = np.percentile(difference, (50, 95)) if difference.size else (0.0, 0.0)
    return float(median), float(far)


def main() -> None:
    """Print the figures of every frame and turn, and the medians."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("frames", nargs="+", type=Path)
    rows: dict[str, list[list[float]]] = defaultdict(list)
    print(HEADER)
    for folder in find_frames(parser.parse_args().frames):
        frame = turned_frame(load_bench_frame(folder).frame, np.asarray, 1.0)
        blocks = extract_blocks(frame)
        depth, holes = complete(frame, blocks).depth, np.isnan(frame.depth)
        for name, (turn, factor) in TURNS.items():
            other = turned_frame(frame, turn, factor)
            own = extract_blocks(other)
            same = np.ascontiguousarray(turn(blocks))
            found = [turn(complete(other, given).depth) / np.float32(factor) for given in (own, same)]
            figures = [in_common(borders(blocks), borders(turn(own)))]
            figures += [figure for result in found for figure in apart(depth, result, holes)]
            rows[name].append(figures)
            print(line(folder.name, name, figures), flush=True)
    for name, values in rows.items():
        print(line("median", name, list(np.median(values, axis=0))))


def line(title: str, name: str, figures: list[float]) -> str:
    """Format one row."""
    shared, *differences = figures
    return f"{title:26} {name:9}{shared:10.1%} " + " ".join(f"{value:8.1f}" for value in differences)


if __name__ == "__main__":
    main()
