"""Four small frames: of the sample, a sparse one, one with a guide, and one of a sequence."""

import json
from collections.abc import Callable
from contextlib import redirect_stdout
from functools import cache
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np

import ilf
import ilf.cli

CAMERA = 80.0, 80.0, 39.5, 29.5
"""Intrinsics of the sequence: fx, fy, cx, cy [px]."""


@cache
def sample() -> ilf.RGBDFrame:
    """The bundled sample in its full size."""
    with TemporaryDirectory() as folder, redirect_stdout(StringIO()):
        ilf.cli.main(["sample", folder])
        return ilf.load_frame(folder)


def room() -> ilf.RGBDFrame:
    """Every fourth row and column of the sample."""
    return _every(4, "room")


def sparse() -> ilf.RGBDFrame:
    """Every fifth row and column of the sample, with 3 % of its known depth."""
    return _every(5, "sparse", known=0.03)


def _every(step: int, name: str, known: float = 1.0) -> ilf.RGBDFrame:
    whole, rng = sample(), np.random.default_rng(3)
    rgb, depth, truth = (each[::step, ::step].copy() for each in (whole.rgb, whole.depth, whole.ground_truth))
    depth[rng.random(depth.shape) >= known] = np.nan
    camera = 525 / step, 525 / step, 319.5 / step, 239.5 / step
    return ilf.RGBDFrame(rgb, depth, camera, name, ground_truth=truth)


def hills() -> ilf.RGBDFrame:
    """A box before wavy ground, with noise and five holes; its guide is inverse depth that drifts."""
    rows, columns = np.indices((72, 96)).astype(float)
    rng = np.random.default_rng(4)
    box = np.abs(columns - 24) + np.abs(rows - 30) < 20
    exact = 2 + 0.25 * np.sin(columns / 9) * np.cos(rows / 11) + 0.004 * columns - 0.4 * box
    depth = exact + 0.002 * rng.standard_normal(exact.shape)
    for _ in range(5):
        row, column = rng.integers(0, 72), rng.integers(0, 96)
        depth[np.hypot(rows - row, columns - column) < rng.integers(4, 20)] = np.nan
    rgb = np.where(box[..., None], [200, 140, 60], [70, 90, 160]) + rng.integers(-12, 13, (72, 96, 1))
    guide = 3 / exact + 0.001 * rows
    return ilf.RGBDFrame(rgb.astype(np.uint8), depth, (96.0, 96.0, 47.5, 35.5), "hills", guide=guide)


def wall() -> ilf.RGBDFrame:
    """The middle of the sequence, without its neighbours."""
    return _of_sequence(neighbours=0)


def wall_with_neighbours() -> ilf.RGBDFrame:
    """The same, with the depth of the frame before it and the frame after it."""
    return _of_sequence(neighbours=1)


def _of_sequence(neighbours: int) -> ilf.RGBDFrame:
    with TemporaryDirectory() as folder:
        source = ilf.open_source(write_sequence(Path(folder, "wall")), intrinsics=CAMERA)
        return source.read(source.keys[1], neighbours=neighbours)


def write_frame(folder: Path, frame: ilf.RGBDFrame, units: float = 10_000) -> Path:
    """Write a frame as the folder of a frame, by default with depth in tenths of a millimetre."""
    folder.mkdir()
    cv2.imwrite(str(folder / "rgb.png"), frame.rgb[..., ::-1])
    ilf.write_depth(folder / "depth.png", frame.measured, units=units)
    if frame.ground_truth is not None:
        ilf.write_depth(folder / "gt.png", frame.ground_truth, units=units)
    if frame.guide is not None:
        np.save(folder / "guide.npy", frame.guide.array)
    camera = frame.intrinsics
    numbers = None if camera is None else [camera.fx, camera.fy, camera.cx, camera.cy]
    (folder / "meta.json").write_text(json.dumps({"depth_units_per_m": units, "K": numbers}))
    return folder


def write_sequence(folder: Path) -> Path:
    """Write a sequence of three frames with poses, in the layout of 7-Scenes."""
    folder.mkdir()
    for number in range(3):
        rgb, depth, pose = _view(number)
        name = str(folder / f"frame-{number:06}")
        cv2.imwrite(f"{name}.color.png", rgb[..., ::-1])
        ilf.write_depth(f"{name}.depth.png", depth)
        np.savetxt(f"{name}.pose.txt", pose)
    return folder


def _view(number: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Colour, depth [m] and pose of a camera that moves along a slanted wall with a board before it, and a hole."""
    rows, columns = np.indices((60, 80))
    x, y = (columns - CAMERA[2]) / CAMERA[0], (rows - CAMERA[3]) / CAMERA[1]
    pose = np.eye(4)
    along = pose[0, 3] = 0.03 * number
    board = (np.abs(1.4 * x + along) < 0.25) & (np.abs(1.4 * y) < 0.3)
    depth = np.where(board, 1.4, (2 + 0.3 * along) / (1 - 0.3 * x - 0.1 * y))
    waves = [np.sin(a * (x * depth + along) + b * y * depth) for a, b in ((9, 4), (-6, 11), (8, -9))]
    rgb = np.where(board, 60, 0)[..., None] + 110 + 60 * np.stack(waves, axis=-1)
    depth += 0.002 * np.random.default_rng(number).standard_normal(depth.shape)
    depth[12 + 4 * number : 38 + 4 * number, 16:44] = np.nan
    return rgb.astype(np.uint8), depth, pose


FRAMES: dict[str, Callable[[], ilf.RGBDFrame]] = {"room": room, "sparse": sparse, "hills": hills, "wall": wall}
