"""`python -m tests.bench.neighbours [--data FOLDER] [--cache FOLDER] [--only real]`: depth measured by neighbours.

Real frames: a sequence in the layout of 7-Scenes, every third frame. Areas of known depth are hidden and completed: by
the frame alone, with the neighbours 9 and 18 frames before and after by the poses of the files, the same by odometry,
and with neighbours in which the same surfaces are hidden. Prints MAE and RMSE over the hidden pixels, relative to those
of the frame alone, and the share of the really missing pixels that neighbours measure.

Generated rooms: sequences of the generated room with exact depth, and a board that moves through it. Prints how many of
the missing pixels neighbours measure, how many of these are within 3 % of the truth and within their expected error,
and the same near the board. Pictures take about 7 s each to render, and stay in --cache.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

import ilf
from ilf.data.frame import RGBDFrame
from ilf.evaluation.bench.denoising import StructuredLight
from ilf.evaluation.bench.frames import as_measured
from ilf.evaluation.hold_out import hidden_pixels

from .propagation.sequences import rendered

STEP, COUNT = 3, 2
"""Frames of the list between neighbours, and neighbours on either side."""

REAL = (3, 6, 9, 11, 14, 17)
"""Frames of the real sequence, as places in the list."""

ROOMS = (("dolly", 7), ("orbit", 8))
"""Paths and seeds of the generated rooms."""

ROOM_STEP, ROOM_FRAMES, ROOM_LENGTH = 4, (9, 11), 21

_SAME = 0.03
_FLIP = np.diag([1.0, -1.0, 1.0, 1.0])
"""The generated world is left-handed."""

Depth = NDArray[np.float32]
Mask = NDArray[np.bool_]


# Real frames.


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


def real(folder: Path, seed: int) -> None:
    """Print the comparison on the real sequence."""
    source = ilf.open_source(folder)
    frames = [as_measured(source.frame_source(key).load()) for key in source.keys]
    errors: dict[str, list[tuple[float, float]]] = {}
    shares = []
    for place in REAL:
        frame = frames[place]
        near = sides(frames, place)
        added = ilf.with_neighbours(frame, *near, step=STEP)
        shares.append(np.count_nonzero(np.isfinite(added.depth[frame.missing])) / np.count_nonzero(frame.missing))
        pixels = hidden_pixels(frame, "areas", seed)
        alone = hidden(frame, pixels)
        without = replace(alone, pose=None)
        both_hidden = [[hidden_there(frame, pixels, one) for one in side] for side in near]
        variants = {
            "alone": alone,
            "poses": ilf.with_neighbours(alone, *near, step=STEP),
            "odometry": ilf.with_neighbours(without, *near, step=STEP),
            "hidden there, too": ilf.with_neighbours(alone, *both_hidden, step=STEP),
        }
        depths = {name: ilf.complete(one).depth for name, one in variants.items()}
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


# Generated rooms.


@dataclass(frozen=True, eq=False)
class Scene:
    """A frame of a generated room, its true depth [m], and the pixels of the board."""

    frame: RGBDFrame
    truth: Depth
    board: Mask


def room(path: str, seed: int, cache: Path, moving: bool) -> list[Scene]:
    """A sequence of the generated room, with a board that moves through it or without."""
    moments = rendered(path, cache, ROOM_LENGTH, seed)
    poses = [np.linalg.inv(moment.pose @ _FLIP) for moment in moments]
    scenes = []
    for number, (moment, pose) in enumerate(zip(moments, poses, strict=True)):
        with np.load(cache / f"{path}-{seed}-{number:02d}.npz") as content:
            exact = content["exact"]
        plain = Scene(replace(moment.frame, pose=pose), exact, np.zeros(exact.shape, bool))
        scenes.append(_with_board(plain, poses[0], number, seed) if moving else plain)
    return scenes


def _with_board(scene: Scene, first: NDArray[np.float64], number: int, seed: int) -> Scene:
    """A board of 0.6 x 0.5 m, 1.6 m in front of the first camera, 6 cm further to the right in every frame, with holes
    of its own and the shadow that an emitter to the right of the camera leaves beside it."""
    frame, camera, pose = scene.frame, scene.frame.intrinsics, scene.frame.pose
    assert camera is not None
    assert pose is not None
    rng = np.random.default_rng([seed, number])
    rows, columns = np.indices(frame.shape)
    move = np.linalg.inv(first) @ pose
    rays = camera.points(columns, rows, np.ones(frame.shape)) @ move[:3, :3].T
    middle = np.array([-0.6 + 0.06 * number, 0.1, 1.6 + 0.01 * number])
    distance = (middle[2] - move[2, 3]) / rays[..., 2]
    x, y, _ = np.moveaxis(move[:3, 3] + rays * distance[..., None] - middle, -1, 0)
    board = (np.abs(x) < 0.3) & (np.abs(y) < 0.25) & (distance > 0) & (distance < np.nan_to_num(scene.truth, nan=99))
    squares = np.random.default_rng(seed).integers(60, 200, (8, 8, 3))
    colour = squares[np.clip((y + 0.25) * 16, 0, 7).astype(int), np.clip((x + 0.3) * 13.3, 0, 7).astype(int)]
    rgb = np.where(board[..., None], np.clip(colour + rng.normal(0, 3, colour.shape), 0, 255), frame.rgb)
    truth = np.where(board, distance, scene.truth).astype(np.float32)
    measured = StructuredLight(camera.fx).measured(np.nan_to_num(truth, nan=5.0).astype(np.float64), rng)
    rough = cv2.GaussianBlur(rng.standard_normal(frame.shape), (0, 0), 6)
    shadow = cv2.dilate(board.astype(np.uint8), np.ones((1, 25), np.uint8), anchor=(0, 0)).astype(bool)
    depth = np.where(board, measured, frame.depth)
    depth[(shadow & ~board) | (board & (rough > rough.std()))] = np.nan
    return Scene(RGBDFrame(rgb.astype(np.uint8), depth, camera, frame.name, pose=pose), truth, board)


def rooms(cache: Path) -> None:
    """Print what neighbours measure in the generated rooms."""
    reach = ROOM_STEP * COUNT
    for path, seed in ROOMS:
        for moving in (True, False):
            scenes = room(path, seed, cache, moving)
            frames = [scene.frame for scene in scenes]
            parts = []
            for place in ROOM_FRAMES:
                scene = scenes[place]
                near = [*reversed(frames[place - reach : place])], frames[place + 1 : place + 1 + reach]
                done = ilf.complete(ilf.with_neighbours(scene.frame, *near, step=ROOM_STEP))
                off, marked = np.abs(done.depth - scene.truth), done.from_neighbours
                beside = cv2.dilate(scene.board.astype(np.uint8), np.ones((61, 61), np.uint8)).astype(bool) & marked
                right, expected = off <= _SAME * scene.truth, off <= ilf.expected_error(done)
                parts.append([
                    marked.sum(), scene.frame.missing.sum(), (marked & right).sum(), (marked & expected).sum(),
                    beside.sum(), (beside & right).sum(),
                ])  # fmt: skip
            added, missing, right, within, near_board, right_there = np.sum(parts, axis=0)
            board = f"; near the board {right_there / near_board:.1%}" if moving and near_board else ""
            what = "moving board" if moving else "still"
            print(
                f"{path} {seed}, {what}: measured by neighbours {added / missing:.0%}; "
                f"within 3 % of the truth {right / added:.1%}, within the expected error {within / added:.0%}{board}",
                flush=True,
            )


def main() -> None:
    """Run both parts."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, default=Path("../shared/data/sequence"))
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "ilf-following")
    parser.add_argument("--seed", type=int, default=0, help="of the hidden areas")
    parser.add_argument("--only", choices=("rooms", "real"), help="run one part only")
    options = parser.parse_args()
    if options.only != "real":
        rooms(options.cache)
    if options.only != "rooms":
        real(options.data, options.seed)


if __name__ == "__main__":
    main()
