"""The stages of EBS as pictures for a view."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..ebs import Extraction
from .block_pictures import block_overlay
from .levels import to_indices
from .marked import dimmed, marked_picture, tint

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
        dimmed colour image, with what the dilation adds around them; regions are tinted and outlined.
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
    """Colours in the picture of a stage, (R, G, B), and what they stand for; edges with their share of the pixels."""
    if stage == "binarised":
        return [(_EDGE, f"edges {_share(extraction.edges)}")]
    if stage == "dilated":
        return [(_EDGE, "edges"), (_AROUND, f"dilated {_share(extraction.dilated)}")]
    return []


def stage_count(stage: str, extraction: Extraction) -> str:
    """How many regions or blocks the picture of a stage shows; "" for the other stages."""
    if stage not in ("contracted", "blocks"):
        return ""
    count = int(getattr(extraction, stage).max())
    return f"{count} {'region' if stage == 'contracted' else 'block'}{'s' * (count != 1)}"


def _share(edges: NDArray[np.bool_]) -> str:
    return f"{np.count_nonzero(edges) / edges.size:.1%}"
