"""From edges to watertight boundaries: dilation, and contraction with the edges as the guide (section 2)."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from skimage.segmentation import watershed


def dilate(edges: NDArray[np.bool_], radius: int) -> NDArray[np.bool_]:
    """Edges dilated by a disk, so that gaps of up to two radii close.

    Parameters
    ----------
    edges : ndarray of bool, shape (H, W)
    radius : int
        Radius of the disk [px].
    """
    if radius == 0:
        return edges.copy()
    size = 2 * radius + 1
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    return cv2.dilate(edges.astype(np.uint8), disk).astype(bool)


def regions_between(boundaries: NDArray[np.bool_]) -> NDArray[np.int32]:
    """4-connected regions that dilated boundaries leave, numbered from 1, int32 (H, W); 0 on the boundaries."""
    regions = cv2.connectedComponents((~boundaries).astype(np.uint8), connectivity=4, ltype=cv2.CV_32S)[1]
    return regions.astype(np.int32, copy=False)


def contract(
    regions: NDArray[np.int32], strength: NDArray[np.float32], inside: NDArray[np.bool_] | None = None
) -> NDArray[np.int32]:
    """Let the regions grow into the dilated boundary until they meet where the edges are strongest.

    A watershed from the regions over the edge strength: every pixel ends in one region, so the result is
    watertight by construction.

    Parameters
    ----------
    regions : ndarray of int32, shape (H, W)
        Regions > 0 to grow, 0 elsewhere.
    strength : ndarray of float32, shape (H, W)
        Edge strength; edges that shall guide the contraction are at the top.
    inside : ndarray of bool, shape (H, W), optional
        Where regions may grow; everywhere if left out.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Regions that touch each other, 0 outside; all 0 where there was no region to start from.
    """
    if not regions.any():
        return regions.copy()
    return watershed(strength, regions, mask=inside).astype(np.int32, copy=False)


def outlines(labels: NDArray[np.int32]) -> NDArray[np.bool_]:
    """Pixels whose right or lower neighbour has another label: the picture of a label map's boundaries."""
    lines = np.zeros(labels.shape, bool)
    lines[:, :-1] |= labels[:, :-1] != labels[:, 1:]
    lines[:-1, :] |= labels[:-1, :] != labels[1:, :]
    return lines
