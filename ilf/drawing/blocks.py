"""Pictures of label maps and of the stages of EBS."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.formatting import counted
from ..data.blocks import block_colour
from ..data.pixel_grids import different_labels, mark
from ..segmentation.extraction import Extraction
from .colours import to_indices

_OPACITY = 0.5


def block_overlay(rgb: NDArray[np.uint8], labels: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Colour image with its blocks tinted and outlined in white.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    labels : ndarray of int32, shape (H, W)
        Label map; pixels without block (0) are not tinted.

    Returns
    -------
    ndarray of uint8, shape (H, W, 3)
    """
    numbers, places = np.unique(labels, return_inverse=True)
    table = np.array([block_colour(int(label)) for label in numbers], np.uint8)
    tinted = cv2.addWeighted(table[places.reshape(labels.shape)], _OPACITY, rgb, 1 - _OPACITY, 0)
    picture = np.where((labels > 0)[..., None], tinted, rgb)
    picture[mark(different_labels(labels))] = 255
    return picture


def stage_pictures(rgb: NDArray[np.uint8], extraction: Extraction) -> dict[str, NDArray[np.uint8]]:
    """One picture for each stage of EBS (section 2), in the order of the stages.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    extraction : Extraction

    Returns
    -------
    dict
        "strength": uint8 (H, W), 255 where it is 1. "edges" and "dilated": uint8 (H, W), 255 on the boundaries.
        "contracted" and "blocks": uint8 (H, W, 3), the regions overlaid on the colour image.
    """
    return {
        "strength": np.round(extraction.strength * 255).astype(np.uint8),
        "edges": extraction.edges.astype(np.uint8) * 255,
        "dilated": extraction.dilated.astype(np.uint8) * 255,
        "contracted": block_overlay(rgb, extraction.contracted),
        "blocks": block_overlay(rgb, extraction.blocks),
    }


# Pixels marked over the dimmed colour image.

_DIMMED = 0.55
_MARK_OPACITY = 0.75
"""Opacity of the marks, below 1 so that the image shows through."""


def dimmed(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """The darkened colour image, uint8 (H, W, 3)."""
    return np.asarray(cv2.convertScaleAbs(rgb, alpha=_DIMMED), np.uint8)


def tint(picture: NDArray[np.uint8], where: NDArray[np.bool_], colour: tuple[int, int, int]) -> None:
    """Mark pixels, bool (H, W), of a picture, uint8 (H, W, 3), in place."""
    tinted = cv2.addWeighted(np.full_like(picture, colour), _MARK_OPACITY, picture, 1 - _MARK_OPACITY, 0)
    cv2.copyTo(tinted, where.view(np.uint8), picture)


def marked_picture(rgb: NDArray[np.uint8], where: NDArray[np.bool_], colour: tuple[int, int, int]) -> NDArray[np.uint8]:
    """The dimmed colour image with some pixels marked.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    where : ndarray of bool, shape (H, W)
    colour : tuple of int
        Colour (R, G, B) of the marks.

    Returns
    -------
    ndarray of uint8, shape (H, W, 3)

    Examples
    --------
    >>> import numpy as np
    >>> marked_picture(np.full((1, 2, 3), 100, np.uint8), np.array([[False, True]]), (200, 0, 0)).tolist()
    [[[55, 55, 55], [164, 14, 14]]]
    """
    picture = dimmed(rgb)
    tint(picture, where, colour)
    return picture


# The stages of EBS as pictures for a view.

STAGES = {
    "strength": "Strength",
    "binarised": "Binarised",
    "dilated": "Dilated",
    "contracted": "Contracted",
    "blocks": "Blocks",
}
"""Stages in their order: name -> text."""

_EDGE, _AROUND = (255, 214, 64), (40, 140, 255)


def stage_picture(stage: str, rgb: NDArray[np.uint8], extraction: Extraction) -> NDArray[np.uint8]:
    """Picture of one stage.

    Parameters
    ----------
    stage : str
        One of `STAGES`.
    rgb : ndarray of uint8, shape (H, W, 3)
    extraction : Extraction

    Returns
    -------
    ndarray of uint8
        "strength": indices 1-255 for 0 to 1, shape (H, W). The others: shape (H, W, 3). Edges are drawn over the
        dimmed colour image, with the pixels added by the dilation around them; regions are tinted and outlined.
    """
    if stage == "strength":
        return to_indices(extraction.strength, 0.0, 1.0)
    if stage in ("contracted", "blocks"):
        return block_overlay(rgb, getattr(extraction, stage))
    if stage == "binarised":
        return marked_picture(rgb, extraction.edges, _EDGE)
    picture = dimmed(rgb)
    tint(picture, extraction.dilated & ~extraction.edges, _AROUND)
    tint(picture, extraction.edges, _EDGE)
    return picture


def stage_legend(stage: str, extraction: Extraction) -> list[tuple[tuple[int, int, int], str]]:
    """Legend of a stage's picture: colours (R, G, B) and texts; edges with their fraction of the pixels."""
    if stage == "binarised":
        return [(_EDGE, f"edges {_share(extraction.edges)}")]
    if stage == "dilated":
        return [(_EDGE, "edges"), (_AROUND, f"dilated {_share(extraction.dilated)}")]
    return []


def stage_count(stage: str, extraction: Extraction) -> str:
    """Number of regions or blocks in a stage's picture, as text; "" for the other stages."""
    if stage not in ("contracted", "blocks"):
        return ""
    count = int(getattr(extraction, stage).max())
    return counted(count, "region" if stage == "contracted" else "block")


def _share(edges: NDArray[np.bool_]) -> str:
    return f"{np.count_nonzero(edges) / edges.size:.1%}"


# Positions for block names and numbers, well inside the blocks.

_LARGEST_SIDE = 480
"""Maximum number of pixels sampled along the frame's longer side, which is precise enough for names."""

InnerPoint = tuple[float, float, float]
"""Image coordinates x, y of the middle of a large circle inside a block, and its radius."""


def inner_points(labels: NDArray[np.int32]) -> dict[int, InnerPoint]:
    """Block label -> inner point, for a label map, int32 (H, W); very small blocks are left out."""
    step = max(-(-max(labels.shape) // _LARGEST_SIDE), 1)
    few = np.pad(np.ascontiguousarray(labels[step // 2 :: step, step // 2 :: step]), 1, constant_values=-1)
    inside = np.ones(few.shape, np.uint8)
    across, down = few[:, 1:] != few[:, :-1], few[1:] != few[:-1]
    inside[:, 1:][across] = 0
    inside[1:][down] = 0
    inside[few <= 0] = 0
    distance = cv2.distanceTransform(inside, cv2.DIST_L2, 3).ravel()
    order = np.flatnonzero(distance)
    order = order[np.argsort(distance[order], kind="stable")]
    best = np.zeros(max(int(few.max()), 0) + 1, np.intp)
    best[few.ravel()[order]] = order  # the last one, farthest from the border, stays
    points = {}
    for label in np.flatnonzero(best):
        row, column = divmod(int(best[label]), few.shape[1])
        x, y = (column - 1) * step + step // 2 + 0.5, (row - 1) * step + step // 2 + 0.5
        points[int(label)] = x, y, float(distance[best[label]]) * step
    return points
