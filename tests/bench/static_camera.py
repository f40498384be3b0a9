"""`python -m tests.bench.static_camera [--frames 9] [--reach 3] [--contrast 40]`: effect of --static-camera.

Repeated frames of the bundled room from a simulated camera with noise in colour and depth, holes that flicker at their
rims, and a moving board. Prints, over static pixels: the change of depth from frame to frame (median and mean of the
absolute change), the share of pixels that appear or disappear, and the mean absolute error, for measured depth, for
frames completed separately, and for frames completed with their neighbours; and the error where the board moves.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

import ilf
from ilf._runtime.installation import asset_path
from ilf.batch.task import temporal_median
from ilf.data.camera import CameraIntrinsics
from ilf.data.frame import RGBDFrame
from ilf.evaluation.bench.denoising import StructuredLight

Depth = NDArray[np.floating]


def scene(number: int, contrast: float) -> tuple[RGBDFrame, Depth, NDArray[np.bool_]]:
    """A frame, its true depth [m], and the pixels of the board."""
    room = ilf.load_frame(asset_path("samples/room"))
    assert room.ground_truth is not None
    rng = np.random.default_rng([11, number])
    rgb, ground_truth, known = (
        room.rgb[::2, ::2].astype(np.float64),
        room.ground_truth[::2, ::2].copy(),
        room.known[::2, ::2],
    )
    height, width = ground_truth.shape
    board = np.zeros((height, width), bool)
    left = 40 + 9 * number
    board[90:150, left : left + 46] = True
    rgb[board] = np.clip(rgb[board] + contrast, 0, 255)
    ground_truth[board] = 1.2
    flicker = cv2.GaussianBlur(rng.standard_normal((height, width)), (0, 0), 2)
    outside = cv2.distanceTransform(known.astype(np.uint8), cv2.DIST_L2, 3)
    inside = cv2.distanceTransform((~known).astype(np.uint8), cv2.DIST_L2, 3)
    seen = (outside - inside + 3 * flicker / flicker.std() > 0) & (rng.random((height, width)) > 0.005)
    measured = StructuredLight(262.5).measured(np.nan_to_num(ground_truth, nan=5.0).astype(np.float64), rng)
    noisy = np.clip(np.round(rgb + 3 * rng.standard_normal(rgb.shape)), 0, 255).astype(np.uint8)
    depth = np.where((seen | board) & np.isfinite(ground_truth), measured, np.nan)
    return RGBDFrame(noisy, depth, CameraIntrinsics(262.5, 262.5, 159.5, 119.5), f"frame {number}"), ground_truth, board


def print_summary(
    what: str, depths: Sequence[Depth], ground_truths: Sequence[Depth], boards: Sequence[NDArray[np.bool_]]
) -> None:
    """Print one line about one kind of depth."""
    changes, flips, errors, near = [], [], [], []
    for number in range(len(depths) - 1):
        still = ~(boards[number] | boards[number + 1])
        one, other = depths[number][still], depths[number + 1][still]
        changes.append(np.abs(one - other)[np.isfinite(one) & np.isfinite(other)])
        flips.append(np.mean(np.isfinite(one) != np.isfinite(other)))
    for depth, ground_truth, board in zip(depths, ground_truths, boards, strict=True):
        error = np.abs(depth - ground_truth)
        around = cv2.dilate(board.astype(np.uint8), np.ones((61, 61), np.uint8)).astype(bool)
        errors.append(error[~around & np.isfinite(error)])
        near.append(error[around & np.isfinite(error)])
    change, off, off_near = (np.concatenate(parts) * 1000 for parts in (changes, errors, near))
    print(
        f"{what:24} change {np.median(change):5.2f} mm, mean {change.mean():5.1f} mm, come and go "
        f"{np.mean(flips):5.2%}; off {off.mean():5.1f} mm, median {np.median(off):4.1f}; near what moves "
        f"{off_near.mean():5.1f}, {np.median(off_near):4.1f}",
        flush=True,
    )


def main() -> None:
    """Make the frames, and print the comparison."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=9)
    parser.add_argument("--reach", type=int, default=3, help="neighbours on either side")
    parser.add_argument("--contrast", type=float, default=40, help="contrast of the board to its background [levels]")
    options = parser.parse_args()
    scenes = [scene(number, options.contrast) for number in range(options.frames + 2 * options.reach)]
    frames = [frame for frame, _, _ in scenes]
    inner = range(options.reach, options.reach + options.frames)
    ground_truths, boards = [scenes[place][1] for place in inner], [scenes[place][2] for place in inner]
    print_summary("measured", [frames[place].depth for place in inner], ground_truths, boards)
    steady = {}
    for place in inner:
        others = [frames[place + by] for by in range(-options.reach, options.reach + 1) if by]
        steady[place] = temporal_median(frames[place], others)
    print_summary("measured, steady", [steady[place] for place in inner], ground_truths, boards)
    alone, helped = [], []
    for place in inner:
        frame = frames[place]
        alone.append(ilf.Run.of(frame).complete(threads=1).depth)
        fused = RGBDFrame(frame.rgb, steady[place], frame.intrinsics, frame.name)
        helped.append(ilf.Run.of(fused).complete(threads=1).depth)
    print_summary("completed separately", alone, ground_truths, boards)
    print_summary("completed, steady", helped, ground_truths, boards)


if __name__ == "__main__":
    main()
