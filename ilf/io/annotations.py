"""Blocks in annotation files: COCO's JSON and lists of masks like segment-anything's, and labelme's JSON."""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Iterator, Mapping
from itertools import takewhile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent
from .._runtime.formatting import counted
from ..data.blocks import Blocks, Region, cropped, find_blocks
from ..errors import FormatError, InputError, told_as
from .images import image_header, read_indices
from .polygons import Points, compressed, filled_polygon, outline_polygons, part_of_runs, points_of, run_lengths
from .shapes import UNNAMED, Candidate, stacked

_IMAGES_SHOWN = 5


def blocks_of_coco(path: Path, content: dict[str, Any], shape: tuple[int, int], image: Path | None) -> Blocks:
    """Convert a COCO file's content to blocks: one per annotation of the image, named after its category.

    Parameters
    ----------
    path : Path
    content : dict
        With `annotations`, and `images` or, as in SA-1B, one `image`.
    shape : (int, int)
        (H, W) of the frame.
    image : Path, optional
        The frame's colour file, whose name selects the image if there are several.

    Raises
    ------
    InputError
        If there are several images and none has that name, if its size differs, or an annotation is damaged or outside
        the image.
    """
    images = content["images"] if "images" in content else [content["image"]] if "image" in content else []
    if not isinstance(images, list) or not all(isinstance(one, dict) for one in images):
        raise InputError(f'{path}: "images" is not a list of images. Export it again.')
    annotations = _checked(path, content["annotations"])
    if images:
        chosen = _chosen_image(path, images, image)
        _check_size(f"{path}: its image {_name(chosen)!r}", chosen.get("height"), chosen.get("width"), shape)
        if "id" in chosen:
            annotations = [one for one in annotations if one.get("image_id", chosen["id"]) == chosen["id"]]
    return _stacked(path, annotations, shape, _categories(content.get("categories")))


def blocks_of_mask_list(path: Path, content: list[Any], shape: tuple[int, int]) -> Blocks:
    """Convert a list of {"segmentation": ...}, as written by segment-anything for an image, to blocks.

    Raises
    ------
    InputError
        If it contains several images, or a mask is damaged or its image size differs from `shape` (H, W).
    """
    annotations = _checked(path, content)
    if len({str(one.get("image_id")) for one in annotations}) > 1:
        raise InputError(f"{path} contains masks of several images, but no list of them. Make a file for each.")
    # the ids of such masks, if any, are numbers of the generator's attempts
    return _stacked(path, [{**one, "id": None} for one in annotations], shape, {})


def coco_of_blocks(labels: NDArray[np.int32], names: Mapping[int, str], image: str, runs: bool) -> Any:
    """Return the content of a COCO file: an annotation for every block, with its number as id and its name as
    category."""
    blocks = find_blocks(labels)
    traced = {} if runs else outline_polygons(labels)
    used = dict.fromkeys(names.get(label, UNNAMED) for label in blocks)
    categories = {name: number for number, name in enumerate(used, 1)}
    height, width = labels.shape
    annotations = []
    for label, block in blocks.items():
        rows, columns = block.box
        segmentation: Any = [points.astype(float).ravel().tolist() for points in traced.get(label, ())]
        if runs:
            segmentation = {"size": [height, width], "counts": compressed(run_lengths(labels == label))}
        annotations.append({
            "id": label,
            "image_id": 1,
            "category_id": categories[names.get(label, UNNAMED)],
            "segmentation": segmentation,
            "area": int(np.count_nonzero(block.mask)),
            "bbox": [columns.start, rows.start, columns.stop - columns.start, rows.stop - rows.start],
            "iscrowd": 0,
        })  # fmt: skip
    return {
        "images": [{"id": 1, "file_name": Path(image).name, "width": width, "height": height}],
        "annotations": annotations,
        "categories": [{"id": number, "name": name, "supercategory": ""} for name, number in categories.items()],
    }


def _checked(path: Path, annotations: Any) -> list[dict[str, Any]]:
    if not isinstance(annotations, list) or not all(isinstance(one, dict) for one in annotations):
        raise InputError(f'{path}: "annotations" is not a list of annotations. Export it again.')
    return annotations


def _check_size(what: str, height: Any, width: Any, shape: tuple[int, int]) -> None:
    if None not in (height, width) and (height, width) != shape:
        told = f"{what} is {width!s:.20} x {height!s:.20}, but the frame is {shape[1]} x {shape[0]}"
        raise InputError(f"{told}. Use the file of this frame.")


def _chosen_image(path: Path, images: list[dict[str, Any]], image: Path | None) -> dict[str, Any]:
    """Return the image whose path agrees best with the frame's colour file, compared from the end."""
    alike = [0 if image is None else _alike(_name(one), image) for one in images]
    best = max(alike)
    if len(images) == 1 or (best > 0 and alike.count(best) == 1):
        return images[alike.index(best)]
    shown = ", ".join(repr(_name(one)) for one in images[:_IMAGES_SHOWN]) + ", ..." * (len(images) > _IMAGES_SHOWN)
    told = f"{path} contains {len(images)} images ({shown}), and which is that of the frame is not clear"
    raise InputError(f"{told}. Export that one alone, or rename the colour file to match.")


def _alike(name: str, image: Path) -> int:
    """Return how far two paths agree, compared from the end; an equal stem, or folder name, counts least."""
    stated = Path(name.replace("\\", "/"))
    both = zip(reversed(stated.parts), reversed(image.parts), strict=False)
    common = sum(1 for _ in takewhile(lambda parts: parts[0] == parts[1], both))
    return 2 * common if common else int(stated.stem in {image.stem, image.parent.name})


def _name(image: dict[str, Any]) -> str:
    return str(image.get("file_name", ""))[:200]


def _categories(categories: Any) -> dict[object, str]:
    """Return category id -> name."""
    listed = categories if isinstance(categories, list) else []
    return {
        one["id"]: str(one["name"])
        for one in listed
        if isinstance(one, dict) and isinstance(one.get("id"), (int, str)) and "name" in one
    }


def _stacked(
    path: Path, annotations: list[dict[str, Any]], shape: tuple[int, int], categories: Mapping[object, str]
) -> Blocks:
    candidates: list[Candidate] = []
    for number, one in enumerate(annotations, 1):
        if outline := one.get("segmentation"):
            own = one.get("id") if type(one.get("id")) is int else None
            category = one.get("category_id")
            name = categories.get(category, "") if isinstance(category, (int, str)) else ""
            where = f"{path}: annotation {number if own is None else own}" + f" ({name!r:.40})" * bool(name)
            candidates.append((name, own, _coco_parts(outline, where, shape)))
    boxes = len(annotations) - len(candidates)
    notes = [f"Left out {counted(boxes, 'annotation')} without an outline, such as boxes."] if boxes else []
    return stacked(path, shape, candidates, notes)


def _coco_parts(segmentation: Any, where: str, shape: tuple[int, int]) -> Iterator[Region]:
    if isinstance(segmentation, dict):
        found = [part_of_runs(segmentation, where, shape)]
    elif isinstance(segmentation, list):
        found = [filled_polygon(points_of(one, where, shape), where, shape) for one in segmentation]
    else:
        raise InputError(f"{where} has an outline that is neither a list of polygons nor run lengths. Export it again.")
    yield from (part for part in found if part is not None)


# labelme's JSON: polygons, rectangles, circles and masks, one file per image.

_AREAS = ("polygon", "rectangle", "circle", "mask")


def blocks_of_labelme(path: Path, content: dict[str, Any], shape: tuple[int, int]) -> Blocks:
    """Convert a labelme file's content to blocks.

    Shapes with the same label and group_id are one block, as in labelme; shapes without a group_id are one block each.
    The group_ids are used as the blocks' numbers if they are all different.

    Raises
    ------
    InputError
        If its image size differs from `shape` (H, W), or a shape is damaged or outside the image.
    """
    _check_size(f"{path}: its image", content.get("imageHeight"), content.get("imageWidth"), shape)
    groups: dict[object, list[tuple[int, dict[str, Any]]]] = {}
    left_out: Counter[str] = Counter()
    for number, one in enumerate(content["shapes"], 1):
        if not isinstance(one, dict):
            raise InputError(f"{path}: shape {number} is not a JSON object. Export it again.")
        kind = str(one.get("shape_type", "polygon"))
        if kind not in _AREAS:
            left_out[kind[:20]] += 1
            continue
        group = one.get("group_id")
        groups.setdefault(number if group is None else (str(one.get("label")), str(group)), []).append((number, one))
    candidates: list[Candidate] = []
    for shapes in groups.values():
        first = shapes[0][1]
        group = first.get("group_id") if type(first.get("group_id")) is int else None
        candidates.append((str(first.get("label") or ""), group, _labelme_parts(path, shapes, shape)))
    kinds = ", ".join(f"{count} {kind}" for kind, count in left_out.items())
    notes = [f"Left out shapes without an area: {kinds}."] if kinds else []
    return stacked(path, shape, candidates, notes)


def labelme_of_blocks(labels: NDArray[np.int32], names: Mapping[int, str], image: str) -> Any:
    """Return the content of a labelme file: a polygon for every connected part of a block, with its number as
    group_id."""
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
        "imagePath": image,
        "imageData": None,
        "imageHeight": labels.shape[0],
        "imageWidth": labels.shape[1],
    }


def _labelme_parts(path: Path, shapes: list[tuple[int, dict[str, Any]]], shape: tuple[int, int]) -> Iterator[Region]:
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
            corners = (
                points if kind == "polygon" else np.column_stack((points[[0, 1, 1, 0], 0], points[[0, 0, 1, 1], 1]))
            )
            part = filled_polygon(corners, where, shape)
        if part is not None:
            yield part


def _part_of_circle(points: Points, shape: tuple[int, int]) -> Region | None:
    """Return the disk around the first point through the second."""
    (x, y), rim = points
    radius = np.hypot(rim[0] - x, rim[1] - y)
    rows, columns = np.arange(shape[0])[:, None] + 0.5, np.arange(shape[1]) + 0.5
    return cropped((columns - x) ** 2 + (rows - y) ** 2 <= radius**2)


def _part_of_mask(encoded: Any, points: Points, where: str, shape: tuple[int, int]) -> Region | None:
    """Decode a mask, a PNG in base64, whose top left corner is the first point."""
    with told_as(InputError, f"{where} has no readable mask. Export it again.", (TypeError, ValueError)):
        data = base64.b64decode(encoded, validate=True)
    source = FileContent(Path(where), np.frombuffer(data, np.uint8))
    header = image_header(source, data)
    left, top = np.floor(points.min(axis=0)).astype(int).tolist()
    if left < 0 or top < 0 or top + header.height > shape[0] or left + header.width > shape[1]:
        raise InputError(f"{where} extends beyond the image of {shape[1]} x {shape[0]}. Use the file of this frame.")
    image = read_indices(source)
    if image.ndim != 2:
        raise FormatError(f"{where} has a colour mask. Export it with one channel.")
    return cropped(image > 0, top, left)
