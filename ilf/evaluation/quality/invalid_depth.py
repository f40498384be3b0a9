"""Known depth that is likely invalid: flying pixels, speckles, suspect islands, and depth behind glass."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_fill_holes, find_objects

from ...completion.edge_aware.view import flying_pixels
from ...completion.suspects import suspect_islands
from ...data.arrays import check_shape
from ...data.blocks import Box, grown
from ...data.frame import RGBDFrame
from ...data.pixel_grids import nearest_values, piece_sizes, sides

Mask = NDArray[np.bool_]

_JUMP, _JUMP_SHARE = 0.04, 0.04
"""Maximum difference of connected neighbours: the larger of the two [m, share of the depth]."""

_SPECKLE = 0.0001
"""Maximum size of a speckle, as a share of the frame."""

_STANDS_OUT = 2.0
"""Minimum distance of a speckle from the nearest surface, in such differences."""

_BESIDE = 12
"""Maximum distance [px] of that surface from a speckle."""

_EDGES = (0.3, 0.5, 0.7)
"""Edge strengths at which contours are searched: touching objects are separated at one of them."""

_MIN_SIZE, _MAX_SIZE = 0.0005, 0.04
"""Minimum and maximum size of objects of glass, as shares of the frame."""

_RING = 10
"""Width [px] of the ring around an object that shows its background."""

_CONTINUES, _CONTINUES_SHARE = 0.012, 0.6
"""Depth continues through an object if it is within this share of its value from the plane around, for at least this
share of the pixels."""

_MIN_KNOWN_AROUND, _MIN_REDUCTION = 0.5, 0.1
"""Minimum share of known pixels in the ring, and minimum reduction of this share in the object: depth is missing in
parts of glass."""

_MAX_COLOUR_DIFFERENCE = 60.0
"""Maximum colour difference (Lab, 8 bits) between a transparent object and its surroundings."""


def suggest_invalid(frame: RGBDFrame, strength: NDArray[np.float32]) -> Mask:
    """Find known depth that is likely invalid, for the user to check.

    These are flying pixels; speckles, which stand out from the surface around them; suspect islands, which the preset
    `best` leaves out of the fill; and recognisable objects of glass: a closed contour with colours as around it, where
    some depth is missing and the rest continues the background.

    Parameters
    ----------
    frame : RGBDFrame
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1], from `ilf.edge_strength`.

    Returns
    -------
    ndarray of bool, shape (H, W)
        Only pixels with known depth.

    Raises
    ------
    InputError
        If the shapes differ.

    Examples
    --------
    >>> depth = np.full((40, 60), 2.0)
    >>> depth[20:22, 30:32] = 1.2
    >>> frame = RGBDFrame(np.zeros((40, 60, 3), np.uint8), depth)
    >>> np.argwhere(suggest_invalid(frame, np.zeros((40, 60), np.float32))).tolist()
    [[20, 30], [20, 31], [21, 30], [21, 31]]
    """
    check_shape("The edge strength", strength.shape, frame.shape)
    found = flying_pixels(frame) | _speckles(frame) | suspect_islands(frame)
    lab = cv2.cvtColor(np.ascontiguousarray(frame.edge_rgb), cv2.COLOR_RGB2Lab).astype(np.float32)
    for least in _EDGES:
        for box, thing, inside in _objects(strength >= least):
            if _is_seen_through(frame.depth[box], lab[box], thing, inside):
                found[box] |= thing
    return found & frame.known


def _speckles(frame: RGBDFrame) -> Mask:
    """Small pieces of known depth that stand out from the surface beside them."""
    known, depth = frame.known, frame.depth
    near_by = np.maximum(_JUMP, _JUMP_SHARE * depth)
    right, down = (
        np.abs(one - other) <= limit for (one, other), (limit, _) in zip(sides(depth), sides(near_by), strict=True)
    )
    small = known & (piece_sizes(known, (right, down)) <= max(_SPECKLE * depth.size, 4))
    large = known & ~small
    if not (small.any() and large.any()):
        return np.zeros(depth.shape, bool)
    away, surface = nearest_values(depth, large)
    return np.asarray(small & (away <= _BESIDE) & (np.abs(depth - surface) > _STANDS_OUT * near_by))


def _objects(edges: Mask) -> Iterator[tuple[Box, Mask, Mask]]:
    """Objects inside closed contours: boxes with a margin, and masks of contour with interior, and of the interior."""
    height, width = edges.shape
    _, contours = cv2.connectedComponents(edges.astype(np.uint8), connectivity=8, ltype=cv2.CV_32S)
    for number, (rows, columns) in enumerate(find_objects(np.asarray(contours, np.int32)), 1):
        area = (rows.stop - rows.start) * (columns.stop - columns.start)
        cut_off = rows.start == 0 or columns.start == 0 or rows.stop == height or columns.stop == width
        if cut_off or not _MIN_SIZE <= area / edges.size <= 2 * _MAX_SIZE:
            continue
        box = grown((rows, columns), _RING, edges.shape)
        contour = contours[box] == number
        thing = np.asarray(binary_fill_holes(contour), bool)
        inside = thing & ~contour
        if not _MIN_SIZE <= np.count_nonzero(inside) / edges.size <= _MAX_SIZE:
            continue
        yield box, thing, inside


def _is_seen_through(depth: NDArray[np.float32], lab: NDArray[np.float32], thing: Mask, inside: Mask) -> bool:
    """Whether the depth behind is seen through an object, as through glass."""
    known = np.isfinite(depth)
    ring = cv2.dilate(thing.astype(np.uint8), np.ones((2 * _RING + 1,) * 2, np.uint8)) > 0
    ring &= cv2.dilate(thing.astype(np.uint8), np.ones((5, 5), np.uint8)) == 0
    behind, shown = ring & known, inside & known
    calm = float(np.mean(known[ring])) if ring.any() else 0.0
    if calm < _MIN_KNOWN_AROUND or np.mean(known[thing]) > calm - _MIN_REDUCTION or not shown.any():
        return False
    if np.linalg.norm(np.median(lab[inside], axis=0) - np.median(lab[ring], axis=0)) > _MAX_COLOUR_DIFFERENCE:
        return False
    terms = np.stack([np.ones(depth.shape), *np.indices(depth.shape)], axis=-1)
    plane = np.linalg.lstsq(terms[behind], 1 / depth[behind], rcond=None)[0]
    off = np.abs(depth * (terms @ plane) - 1)
    return bool(np.mean(off[shown] < _CONTINUES) >= _CONTINUES_SHARE and np.median(off[behind]) < _CONTINUES)
