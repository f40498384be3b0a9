"""Pictures of label maps and of the stages of EBS."""

from __future__ import annotations

import colorsys
from typing import TYPE_CHECKING

import cv2
import numpy as np
from numpy.typing import NDArray

from ..ebs.boundaries import outlines

if TYPE_CHECKING:
    from ..ebs import Extraction

_OPACITY = 0.5


def block_colour(label: int) -> tuple[int, int, int]:
    """Colour of a block: neighbours in number are far apart in hue, and the colour of a number never changes."""
    hue = (label * 0.61803398875) % 1.0
    saturation = (0.75, 0.55, 0.9)[label % 3]
    value = (0.95, 0.8, 1.0)[(label // 3) % 3]
    red, green, blue = colorsys.hsv_to_rgb(hue, saturation, value)
    return round(red * 255), round(green * 255), round(blue * 255)


def block_overlay(rgb: NDArray[np.uint8], labels: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Colour image with its blocks tinted and outlined in white.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (H, W, 3)
    labels : ndarray of int32, shape (H, W)
        Label map; 0 = no block stays as it is.

    Returns
    -------
    ndarray of uint8, shape (H, W, 3)
    """
    table = np.array([block_colour(label) for label in range(int(labels.max()) + 1)], np.uint8)
    tinted = cv2.addWeighted(table[labels], _OPACITY, rgb, 1 - _OPACITY, 0)
    picture = np.where((labels > 0)[..., None], tinted, rgb)
    picture[outlines(labels)] = 255
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
        "contracted" and "blocks": uint8 (H, W, 3), the regions laid over the colour image.
    """
    return {
        "strength": np.round(extraction.strength * 255).astype(np.uint8),
        "edges": extraction.edges.astype(np.uint8) * 255,
        "dilated": extraction.dilated.astype(np.uint8) * 255,
        "contracted": block_overlay(rgb, extraction.contracted),
        "blocks": block_overlay(rgb, extraction.blocks),
    }
