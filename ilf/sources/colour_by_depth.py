"""Colour for each pixel of the depth camera."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from ..data.camera import Camera
from ..data.frame import BroughtColour, read_only

_HIDDEN_BEHIND = 0.04
"""How much nearer a surface must be to hide what lies behind it, relative; less moves colour by hardly a pixel."""

_BLUR_FROM, _BLUR_SHARE = 1.5, 1 / 3
"""Colour that is so many times as fine as depth, or more, is averaged by a Gaussian of this share of a depth pixel."""

_Floats = NDArray[np.float32]


def colour_by_depth(
    rgb: NDArray[np.uint8],
    colour: Camera,
    depth: _Floats,
    camera: Camera,
    depth_to_colour: NDArray[np.float64],
    front: _Floats,
) -> tuple[NDArray[np.uint8], BroughtColour]:
    """Look up the colour of each depth pixel where its depth puts it in the colour image.

    Where depth is missing, 1 / depth is filled smoothly for the lookup alone: along a plane it is linear in the image,
    and these pixels need colour most, to be completed by it. Such depth hides nothing. What the colour camera sees
    nothing of is black: outside its image, or behind a measured surface that is nearer by more than 4 %.

    Parameters
    ----------
    rgb : ndarray of uint8, shape (h, w, 3)
    colour, camera : Camera
        The colour and the depth camera, without distortion.
    depth : ndarray of float32, shape (H, W)
        Depth along the axis of `camera` [m], NaN = missing.
    depth_to_colour : ndarray of float64, shape (4, 4)
        Transform of points [m].
    front : ndarray of float32, shape (h, w)
        Measured depth along the axis of `colour` [m], as `projected_depth` gives it, NaN = missing.

    Returns
    -------
    ndarray of uint8, shape (H, W, 3)
        Colour, black where nothing is seen.
    BroughtColour
    """
    guessed = np.reciprocal(smoothly_filled(np.reciprocal(depth), np.isfinite(depth)))
    columns, rows, away = _places(guessed, camera, colour, depth_to_colour)
    seen = (away > 0) & colour.has(columns, rows)
    place = np.rint(rows[seen]).astype(int), np.rint(columns[seen]).astype(int)
    seen[seen] = ~(away[seen] > (1 + _HIDDEN_BEHIND) * front[place])  # NaN: nothing was measured there
    fineness = max(colour.fx / camera.fx, colour.fy / camera.fy)
    if fineness >= _BLUR_FROM:
        rgb = np.asarray(cv2.GaussianBlur(rgb, (0, 0), _BLUR_SHARE * fineness), np.uint8)
    across, down = (np.where(seen, places, 0).astype(np.float32) for places in (columns, rows))
    brought = np.asarray(cv2.remap(rgb, across, down, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), np.uint8)
    brought[~seen] = 0
    edge_rgb = np.rint(smoothly_filled(brought.astype(np.float32), seen)).astype(np.uint8)
    return brought, BroughtColour(read_only(seen), read_only(edge_rgb), colour, depth_to_colour)


def smoothly_filled(values: _Floats, known: NDArray[np.bool_]) -> _Floats:
    """Values, shape (H, W) or (H, W, channels), where known; elsewhere averages of those around, over ever wider areas
    the farther away they are. Without any known value they are returned as they are."""
    if known.all() or not known.any():
        return values
    height, width = known.shape
    mask = known.reshape(height, width, *(1,) * (values.ndim - 2))
    weight = cv2.pyrDown(known.astype(np.float32))
    total = cv2.pyrDown(np.where(mask, values, np.float32(0)))
    some = weight > 0
    share = np.where(some, weight, np.float32(1)).reshape(*weight.shape, *(1,) * (values.ndim - 2))
    coarse = smoothly_filled(np.asarray(total / share, np.float32), some)
    return np.where(mask, values, cv2.pyrUp(coarse, dstsize=(width, height)))


def _places(
    depth: _Floats, camera: Camera, colour: Camera, depth_to_colour: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Column and row [px] in the colour image, and depth [m] along the colour camera's axis, of each pixel's centre."""
    height, width = depth.shape
    down, across = np.indices((height, width), np.float64)
    turn = colour.matrix @ depth_to_colour[:3, :3] @ np.linalg.inv(camera.matrix)
    shift = colour.matrix @ depth_to_colour[:3, 3]
    x, y, away = (
        depth * (row[0] * across + row[1] * down + row[2]) + along for row, along in zip(turn, shift, strict=True)
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return x / away, y / away, away
