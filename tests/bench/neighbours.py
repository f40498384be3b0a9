"""Depth measured by neighbours: `python -m tests.bench.neighbours [--data FOLDER] [--places 3 6 9 11 14 17]`.

The frames at some places of a sequence in the layout of 7-Scenes. Areas of known depth are hidden and completed: by the
frame alone, with the nearest neighbours before and after by the poses of the files, the same by odometry, and with
neighbours in which the same surfaces are hidden. Prints MAE and RMSE over the hidden pixels, relative to those of the
frame alone, and the share of the really missing pixels that neighbours measure.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

import ilf
from ilf.data.frame import RGBDFrame
from ilf.evaluation.bench.frames import as_measured
from ilf.evaluation.hold_out import hidden_pixels
from ilf.sources.reading import read_frame

STEP, COUNT = 3, 2
"""Frames of the list between neighbours, and neighbours on either side."""

Mask = NDArray[np.bool_]


def hidden(frame: RGBDFrame, pixels: Mask) -> RGBDFrame:
    """The frame without depth at some pixels."""
    return replace(frame, depth=np.where(pixels, np.float32(np.nan), frame.depth))


def hidden_there(frame: RGBDFrame, pixels: Mask, other: RGBDFrame) -> RGBDFrame:
    """Another frame without depth of the surfaces at some pixels of a frame."""
    camera, there = frame.intrinsics, other.intrinsics
    assert camera is not None
    assert there is not None
    assert frame.pose is not None
    assert other.pose is not None
    rows, columns = np.indices(other.shape)
    motion = np.linalg.inv(frame.pose) @ other.pose
    points = there.points(columns, rows, other.depth) @ motion[:3, :3].T + motion[:3, 3]
    x, y = np.full((2, *other.shape), -1.0, np.float32)
    known = np.isfinite(other.depth) & (np.nan_to_num(points[..., 2]) > 0)
    x[known] = camera.fx * points[known, 0] / points[known, 2] + camera.cx
    y[known] = camera.fy * points[known, 1] / points[known, 2] + camera.cy
    around = cv2.dilate(pixels.astype(np.uint8), np.ones((5, 5), np.uint8))
    return hidden(other, cv2.remap(around, x, y, cv2.INTER_NEAREST, borderValue=0).astype(bool))


def sides(frames: Sequence[RGBDFrame], place: int) -> tuple[list[RGBDFrame], list[RGBDFrame]]:
    """Frames before and after a place, the nearest first."""
    reach = STEP * COUNT
    return [*reversed(frames[max(place - reach, 0) : place])], [*frames[place + 1 : place + 1 + reach]]


def variants(frames: Sequence[RGBDFrame], place: int, pixels: Mask) -> dict[str, RGBDFrame]:
    """The frame at a place without some pixels: alone, and with neighbours in each way."""
    frame, near = frames[place], sides(frames, place)
    alone = hidden(frame, pixels)
    both_hidden = [[hidden_there(frame, pixels, one) for one in side] for side in near]
    return {
        "alone": alone,
        "poses": ilf.with_neighbours(alone, *near, step=STEP),
        "odometry": ilf.with_neighbours(replace(alone, pose=None), *near, step=STEP),
        "hidden there, too": ilf.with_neighbours(alone, *both_hidden, step=STEP),
    }


def main() -> None:
    """Print the comparison for every frame, and the means."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data/sequence"))
    parser.add_argument("--places", type=int, nargs="+", default=[3, 6, 9, 11, 14, 17])
    parser.add_argument("--seed", type=int, default=0, help="of the hidden areas")
    given = parser.parse_args()
    source = ilf.open_source(given.data)
    frames = [as_measured(read_frame(source.ref(key))) for key in source.keys]
    errors: dict[str, list[tuple[float, float]]] = {}
    shares = []
    for place in given.places:
        frame, pixels = frames[place], hidden_pixels(frames[place], "areas", given.seed)
        added = ilf.with_neighbours(frame, *sides(frames, place), step=STEP)
        shares.append(np.count_nonzero(np.isfinite(added.depth[frame.missing])) / np.count_nonzero(frame.missing))
        depths = {name: ilf.complete(one).depth for name, one in variants(frames, place, pixels).items()}
        shared = pixels & np.all([np.isfinite(depth) for depth in depths.values()], axis=0)
        for name, depth in depths.items():
            off = np.abs(depth - frame.depth)[shared].astype(np.float64) * 1000
            errors.setdefault(name, []).append((float(off.mean()), float(np.sqrt(np.mean(off**2)))))
        line = "; ".join(f"{name} {found[-1][0]:.1f}, {found[-1][1]:.1f} mm" for name, found in errors.items())
        print(f"{frame.name}: missing measured {shares[-1]:.0%}; MAE, RMSE: {line}", flush=True)
    before = np.mean(errors["alone"], axis=0)
    for name, found in errors.items():
        mae, rmse = np.mean(found, axis=0)
        print(f"{name:18} MAE {mae:5.1f} mm ({mae / before[0]:.2f}), RMSE {rmse:5.1f} mm ({rmse / before[1]:.2f})")
    print(f"really missing pixels measured by neighbours: {np.mean(shares):.0%}")


if __name__ == "__main__":
    main()
