"""labelme's JSON: polygons, rectangles, circles and masks, one file per image."""

from __future__ import annotations

import base64
import binascii
import os
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import FormatError, InputError
from ..files import FileContent
from ..headers import image_header
from ..images import read_image
from .outlines import outline_polygons
from .polygons import Points, filled_polygon, points_of
from .stacking import UNNAMED, Candidate, LoadedBlocks, Part, cropped, stacked

_AREAS = ("polygon", "rectangle", "circle", "mask")


def blocks_of_labelme(path: Path, content: dict[str, Any], shape: tuple[int, int]) -> LoadedBlocks:
    """The blocks of a file's content.

    Shapes of one label and group_id are one block, as labelme has it; those without a group_id are one each. The
    group_ids are the blocks' numbers where each block has another.

    Raises
    ------
    InputError
        If it is for an image of another size than `shape` (H, W), or a shape is damaged or off the image.
    """
    stated = content.get("imageHeight"), content.get("imageWidth")
    if None not in stated and stated != shape:
        raise InputError(
            f"{path}: its image is {stated[1]!s:.20} x {stated[0]!s:.20}, the frame {shape[1]} x {shape[0]}. "
            "Use the file of this frame."
        )
    groups: dict[object, list[tuple[int, dict[str, Any]]]] = {}
    left_out: Counter[str] = Counter()
    for number, one in enumerate(content["shapes"], 1):
        if not isinstance(one, dict):
            raise InputError(f"{path}: shape {number} is no shape. Export it again.")
        kind = str(one.get("shape_type", "polygon"))
        if kind not in _AREAS:
            left_out[kind[:20]] += 1
            continue
        group = one.get("group_id")
        groups.setdefault(number if group is None else (str(one.get("label")), str(group)), []).append((number, one))
    candidates = [
        Candidate(
            str(shapes[0][1].get("label") or ""),
            group if type(group := shapes[0][1].get("group_id")) is int else None,
            _parts(path, shapes, shape),
        )
        for shapes in groups.values()
    ]
    kinds = ", ".join(f"{count} {kind}" for kind, count in left_out.items())
    notes = [f"Shapes without an area are left out: {kinds}."] if kinds else []
    return stacked(path, shape, candidates, notes)


def labelme_of_blocks(labels: NDArray[np.int32], names: Mapping[int, str], image: Path | None, target: Path) -> Any:
    """A file's content: a polygon for every connected part of a block, with the block's number as group_id."""
    return {
        "version": "5.5.0",
        "flags": {},
        "shapes": [
            {
                "label": names.get(label, UNNAMED),
                "points": points.astype(float).tolist(),
                "group_id": label,
                "description": "",
                "shape_type": "polygon",
                "flags": {},
                "mask": None,
            }
            for label, parts in outline_polygons(labels).items()
            for points in parts
        ],
        "imagePath": "" if image is None else _way_to(image, target),
        "imageData": None,
        "imageHeight": labels.shape[0],
        "imageWidth": labels.shape[1],
    }


def _way_to(image: Path, target: Path) -> str:
    """Where the image lies, as seen from the file's folder."""
    try:
        return Path(os.path.relpath(image, target.absolute().parent)).as_posix()
    except ValueError:  # on another drive
        return str(image)


def _parts(path: Path, shapes: list[tuple[int, dict[str, Any]]], shape: tuple[int, int]) -> Iterator[Part]:
    for number, one in shapes:
        where = f"{path}: shape {number} ({str(one.get('label'))!r:.40})"
        points = points_of(one.get("points"), where, shape)
        kind = one.get("shape_type", "polygon")
        if kind != "polygon" and len(points) != 2:
            raise InputError(f"{where} is a {kind} with {len(points)} points instead of 2. Correct it in labelme.")
        if kind == "mask":
            part = _part_of_mask(one.get("mask"), points, where, shape)
        elif kind == "circle":
            part = _part_of_circle(points, shape)
        else:
            part = filled_polygon(points if kind == "polygon" else _rectangle(points), where, shape)
        if part is not None:
            yield part


def _rectangle(points: Points) -> Points:
    """Between two corners."""
    return np.column_stack((points[[0, 1, 1, 0], 0], points[[0, 0, 1, 1], 1]))


def _part_of_circle(points: Points, shape: tuple[int, int]) -> Part | None:
    """Around the first point, through the second."""
    (x, y), rim = points
    radius = np.hypot(rim[0] - x, rim[1] - y)
    rows, columns = np.arange(shape[0])[:, None] + 0.5, np.arange(shape[1]) + 0.5
    return cropped((columns - x) ** 2 + (rows - y) ** 2 <= radius**2)


def _part_of_mask(encoded: Any, points: Points, where: str, shape: tuple[int, int]) -> Part | None:
    """A PNG in base64, from the first point on."""
    try:
        data = base64.b64decode(encoded, validate=True)
    except (TypeError, ValueError, binascii.Error):
        raise InputError(f"{where} has no mask that can be read. Export it again.") from None
    source = FileContent(Path(where), np.frombuffer(data, np.uint8))
    header = image_header(source, data)
    left, top = np.floor(points.min(axis=0)).astype(int).tolist()
    if left < 0 or top < 0 or top + header.height > shape[0] or left + header.width > shape[1]:
        raise InputError(
            f"{where} reaches beyond the image, which is {shape[1]} x {shape[0]}. Is this the frame's file?"
        )
    image = read_image(source)
    if image.ndim != 2:
        raise FormatError(f"{where} has a mask in colour. Export it with one channel.")
    return cropped(image > 0, top, left)
