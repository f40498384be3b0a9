"""What two cameras see of a wall with a board before it: exact depth along any ray."""

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.data.camera import Camera
from ilf.sources.registration import RawPair

WALL_M, BOARD_M = 2.0, 1.0
BOARD = (-0.2, 0.1, -0.15, 0.15)
"""Left, right, top and bottom of the board [m] in the colour camera's axes; the wall leans back by a tenth."""

COLOUR = Camera(60.0, 61.0, 47.0, 36.5, size=(96, 72), distortion=(0.08, -0.1, 0.001, -0.001, 0.02))
DEPTH = Camera(50.0, 54.0, 32.0, 27.0, size=(64, 56), distortion=(0.3, -0.02, 0.0, 0.001, 0.01, 0.5, 0.05, 0.0))

Floats = NDArray[np.float64]


def motion(x: float = -0.05, turn: float = 0.02) -> Floats:
    """From the depth to the colour camera: a shift to the side [m], and a turn about the upright axis."""
    found = np.eye(4)
    found[:3, :3], _ = cv2.Rodrigues(np.array([0.0, turn, 0.0]))
    found[:3, 3] = x, 0.01, -0.005
    return found


def rays(camera: Camera) -> Floats:
    """Of every pixel, (N, 3) with depth 1."""
    columns, rows = np.meshgrid(*map(np.arange, camera.shape[::-1]))
    pixels = np.stack([columns.ravel(), rows.ravel()], axis=1).astype(np.float64)
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-10)
    flat = cv2.undistortPoints(pixels[:, None], camera.matrix, camera.coefficients, None, None, None, criteria)
    return np.concatenate([flat[:, 0], np.ones((len(pixels), 1))], axis=1)


def seen(views: Floats, to_colour: Floats) -> Floats:
    """Depth [m] along rays of a camera whose points `to_colour` takes to the colour camera."""
    start, directions = to_colour[:3, 3], views @ to_colour[:3, :3].T
    board = (BOARD_M - start[2]) / directions[:, 2]
    x, y, _ = (start + board[:, None] * directions).T
    on_board = (BOARD[0] < x) & (x < BOARD[1]) & (BOARD[2] < y) & (y < BOARD[3])
    # the wall is z = WALL_M + x / 10
    wall = (WALL_M + start[0] / 10 - start[2]) / (directions[:, 2] - directions[:, 0] / 10)
    return np.where(on_board, board, wall)


def made_pair(colour: Camera = COLOUR, depth: Camera = DEPTH, to_colour: Floats | None = None) -> RawPair:
    """The raw pair of the scene; colour is as bright as its pixel is far to the right."""
    moved = motion() if to_colour is None else to_colour
    height, width = colour.shape
    rgb = np.broadcast_to((255 * np.arange(width) // width).astype(np.uint8)[None, :, None], (height, width, 3))
    return RawPair(rgb, seen(rays(depth), moved).reshape(depth.shape), colour, depth, moved, "board")


def _numbers(camera: Camera) -> dict[str, Any]:
    """A camera as a calibration has it."""
    return {"size": list(camera.shape[::-1]), "K": list(camera.numbers), "distortion": list(camera.distortion)}


def calibration(pair: RawPair) -> dict[str, Any]:
    """What calibration.json says of a pair that `write_pair` writes."""
    return {
        "colour": _numbers(pair.colour_camera),
        "depth": _numbers(pair.depth_camera),
        "depth_to_colour": pair.depth_to_colour.tolist(),
        "depth_units_per_m": 10000,
    }


def write_pair(folder: Path, colour: str = "colour.png", depth: str = "depth.png") -> RawPair:
    """Write the scene as a folder of raw pairs."""
    pair = made_pair()
    for name, image in ((colour, pair.rgb[..., ::-1]), (depth, np.rint(10000 * pair.depth).astype(np.uint16))):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(folder / name), image)
    (folder / "calibration.json").write_text(json.dumps(calibration(pair)))
    return pair
