"""Target of a correction: the wanted label map, and the number of pixels that differ from it."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Labels = NDArray[np.int32]
Point = tuple[float, float]
"""(x, y) in image coordinates: pixel (row r, column c) covers x in [c, c + 1), y in [r, r + 1)."""

CORRECTIONS_FILE = Path(__file__).with_name("corrections.json")
SECOND_FILE = Path(__file__).with_name("second.json")
"""Twelve other corrections, on frames that were not used before."""


@dataclass(frozen=True)
class Piece:
    """Pixels that change their block.

    Attributes
    ----------
    polygon : tuple of (x, y)
        Outline around the pixels' centres.
    givers : tuple of (x, y)
        One point in each block that gives pixels; pixels of other blocks in the polygon are unchanged.
    taker : (x, y), optional
        A point in the block that takes them; without one they become a new block.
    seed : (x, y), optional
        A point well inside the new block; the label there is its label.
    """

    polygon: tuple[Point, ...]
    givers: tuple[Point, ...]
    taker: Point | None = None
    seed: Point | None = None


@dataclass(frozen=True)
class Correction:
    """One wrong boundary, and its correction.

    Attributes
    ----------
    name, frame, what : str
        Its name, the folder of its frame, and the error.
    region : tuple of int
        Left, top, right and bottom of the box of pixels that is evaluated; right and bottom are exclusive.
    pieces : tuple of Piece
    """

    name: str
    frame: str
    what: str
    region: tuple[int, int, int, int]
    pieces: tuple[Piece, ...]

    @property
    def box(self) -> tuple[slice, slice]:
        """Rows and columns of the region."""
        left, top, right, bottom = self.region
        return slice(top, bottom), slice(left, right)


@dataclass(frozen=True)
class Scene:
    """A frame of the corrections.

    Attributes
    ----------
    name : str
    seed : int
        Seed of the areas that are hidden in its depth.
    labels : str
        Beginning of the SHA-256 of the label map for which the corrections were selected.
    """

    name: str
    seed: int
    labels: str


def read_corrections(path: Path = CORRECTIONS_FILE) -> tuple[dict[str, Scene], list[Correction]]:
    """Return the frames by name, and the corrections in their order."""
    content = json.loads(path.read_text())
    scenes = {name: Scene(name, one["seed"], one["labels"]) for name, one in content["frames"].items()}
    return scenes, [_correction(one) for one in content["corrections"]]


def target_map(labels: Labels, correction: Correction) -> Labels:
    """Return the target label map of a correction.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        Before the correction.
    correction : Correction

    Returns
    -------
    ndarray of int32, shape (H, W)
        As `labels`, with the pieces in other blocks; new blocks have the next free labels.

    Raises
    ------
    ValueError
        If a giver or taker lies in no block, or a piece has no pixel of its givers.
    """
    target = labels.copy()
    free = int(labels.max()) + 1
    for piece in correction.pieces:
        givers = [_label_at(labels, point, correction) for point in piece.givers]
        moved = inside(labels.shape, piece.polygon) & np.isin(labels, givers)
        if not moved.any():
            raise ValueError(f"{correction.name}: the polygon has no pixel of the giving blocks.")
        if piece.taker is None:
            target[moved], free = free, free + 1
        else:
            target[moved] = _label_at(labels, piece.taker, correction)
    return target


def wrong_pixels(result: Labels, target: Labels, correction: Correction) -> NDArray[np.bool_]:
    """Return the pixels of the region that belong to another block than in the target.

    Blocks may have other labels than in the target: the label of a target block is read at a point well inside it. If
    the result does not divide two blocks of the target, the larger one gets their common label, and every pixel of the
    other is wrong.

    Parameters
    ----------
    result, target : ndarray of int32, shape (H, W)
    correction : Correction

    Returns
    -------
    ndarray of bool, shape (H, W)
        False outside the region.
    """
    box = correction.box
    wanted = [int(label) for label in np.unique(target[box]) if label > 0]
    seeds = _own_seeds(target, correction)
    names: dict[int, int] = {}
    for label in sorted(wanted, key=lambda label: (-np.count_nonzero(target == label), label)):
        x, y = seeds.get(label) or _middle(target == label)
        name = int(result[int(y), int(x)])
        names[label] = -label if name in names.values() or name == 0 else name
    table = np.zeros(int(target.max()) + 1, np.int64)
    for label, name in names.items():
        table[label] = name
    wrong = np.zeros(target.shape, bool)
    wrong[box] = result[box] != table[target[box]]
    return wrong


def inside(shape: tuple[int, int], polygon: tuple[Point, ...]) -> NDArray[np.bool_]:
    """Pixels whose centre lies in a polygon, bool (H, W), by the even-odd rule."""
    y, x = np.mgrid[: shape[0], : shape[1]] + 0.5
    found = np.zeros(shape, bool)
    for (x0, y0), (x1, y1) in zip(polygon, (*polygon[1:], polygon[0]), strict=True):
        if y0 != y1:
            crosses = (y0 > y) != (y1 > y)
            found ^= crosses & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    return found


def _own_seeds(target: Labels, correction: Correction) -> dict[int, Point]:
    return {int(target[int(p.seed[1]), int(p.seed[0])]): p.seed for p in correction.pieces if p.seed is not None}


def _middle(mask: NDArray[np.bool_]) -> Point:
    """Return the pixel of a mask that is farthest from its rim."""
    depth = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_PRECISE)[1:-1, 1:-1]
    row, column = np.unravel_index(int(depth.argmax()), depth.shape)
    return float(column), float(row)


def _label_at(labels: Labels, point: Point, correction: Correction) -> int:
    label = int(labels[int(point[1]), int(point[0])])
    if label == 0:
        raise ValueError(f"{correction.name}: there is no block at {point}.")
    return label


def _correction(content: dict[str, Any]) -> Correction:
    left, top, right, bottom = content["region"]
    pieces = tuple(_piece(piece) for piece in content["pieces"])
    return Correction(content["name"], content["frame"], content["what"], (left, top, right, bottom), pieces)


def _piece(content: dict[str, Any]) -> Piece:
    taker, seed = content.get("to"), content.get("seed")
    return Piece(
        tuple((float(x), float(y)) for x, y in content["polygon"]),
        tuple((float(x), float(y)) for x, y in content["from"]),
        None if taker is None else (taker[0], taker[1]),
        None if seed is None else (seed[0], seed[1]),
    )
