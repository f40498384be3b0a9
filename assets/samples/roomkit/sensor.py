"""What a structured-light camera makes of exact depth: quantised, noisier with range, and with holes."""

from __future__ import annotations

import cv2
import numpy as np

from ilf.lab.bench.denoising import StructuredLight

from .light import OFF_SURFACE
from .room import BACK, DOOR, SPOT, SPOT_RADIUS, Room
from .scene import Hits, dot
from .textures import noise

BASELINE = 0.075
"""From the camera to the pattern projector on its right [m]."""
STEPS_PER_PIXEL = 8
"""Disparity is measured in eighths of a pixel."""
DISPARITY_NOISE = 0.45
"""Standard deviation of the disparity [steps]; 1.3 mm at 1 m, growing with the square of the range."""
FARTHEST = 4.6
"""Range beyond which the pattern is too weak [m]."""


def holes(
    room: Room, hits: Hits, views: np.ndarray, shape: tuple[int, int], rng: np.random.Generator
) -> dict[str, np.ndarray]:
    """Pixels without depth by cause, bool (H, W) each; a pixel belongs to the first cause that takes it.

    Parameters
    ----------
    room : Room
        The scene and camera.
    hits, views : Hits, ndarray (H * W, 3)
        What the ray through each pixel's centre met, and these rays, scaled to depth 1.
    shape : tuple of int
        Height and width.
    rng : numpy.random.Generator
        For ragged outlines and drop-outs.
    """
    depth = hits.distance.reshape(shape)
    ragged = noise(hits.points * 14, octaves=4)
    unit = views / np.linalg.norm(views, axis=1, keepdims=True)
    cos = -dot(unit, hits.flat)
    causes = {
        "black surface": room.scene.of("black", hits) & (ragged < 0.78),
        "halogen light": _halogen(hits, ragged) | (room.scene.of("emission", hits).max(axis=1) > 0),
        "glossy floor": room.scene.of("floor", hits) & _glare(hits, unit, ragged),
        "out of range": hits.distance + 0.5 * (ragged - 0.5) > FARTHEST,
        "stereo shadow": _unlit(room, hits),
        "steep surface": cos < 0.16 + 0.22 * (ragged - 0.5),
    }
    flat = {name: mask.reshape(shape) for name, mask in causes.items()}
    # The shadow's outline follows the matching window, not single pixels.
    flat["stereo shadow"] = cv2.morphologyEx(
        flat["stereo shadow"].astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)
    ).astype(bool)
    flat["depth edge"] = _edges(depth, rng)
    flat["drop-out"] = _dropouts(depth, rng)
    taken = np.zeros(shape, bool)
    for name, mask in flat.items():
        flat[name] = mask & ~taken
        taken |= mask
    return flat


def measured(depth: np.ndarray, intrinsics: tuple[float, ...], rng: np.random.Generator) -> np.ndarray:
    """Depth [m], float (H, W), with lateral jitter, correlated disparity noise and disparity steps."""
    return StructuredLight(intrinsics[0], BASELINE, STEPS_PER_PIXEL, DISPARITY_NOISE).measured(depth, rng)


def _halogen(hits: Hits, ragged: np.ndarray) -> np.ndarray:
    """The lamp's spot on the wall, about 15 cm across, where the camera is dazzled."""
    away = np.linalg.norm(hits.points - SPOT, axis=1)
    return away < SPOT_RADIUS * (1.0 + 0.5 * (ragged - 0.5))


def _glare(hits: Hits, unit: np.ndarray, ragged: np.ndarray) -> np.ndarray:
    """Where the floor mirrors the bright doorway instead of scattering the pattern back."""
    away = unit * (1, -1, 1)
    ahead = (BACK - hits.points[:, 2]) / np.maximum(away[:, 2], 1e-6)
    x, y = hits.points[:, 0] + ahead * away[:, 0], ahead * away[:, 1]
    middle, half = (DOOR[0] + DOOR[1]) / 2, (DOOR[1] - DOOR[0]) / 2
    round_patch = ((x - middle) / half) ** 2 + ((y - 0.27) / 0.23) ** 2
    outline = 0.85 + 2.2 * (noise(hits.points * 5, octaves=3) - 0.5) + 0.8 * (ragged - 0.5)
    return (round_patch < outline) & (hits.points[:, 2] < BACK)


def _unlit(room: Room, hits: Hits) -> np.ndarray:
    """Points that the projector's pattern does not reach because something nearer is in its way."""
    projector = room.camera.position + BASELINE * room.camera.right
    start = hits.points + 20 * OFF_SURFACE * hits.flat
    return room.scene.blocked(start, projector - start, far=0.99)


def _edges(depth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A ragged seam along depth jumps of more than 4 %, where the matching window straddles two surfaces."""
    low, high = cv2.erode(depth, np.ones((3, 3))), cv2.dilate(depth, np.ones((3, 3)))
    jump = (high - low > 0.04 * depth).astype(np.uint8)
    wide = cv2.dilate(jump, np.ones((5, 5), np.uint8)).astype(bool)
    field = cv2.GaussianBlur(rng.standard_normal(depth.shape), (0, 0), 1.5)
    return (jump.astype(bool) & (field > -0.6 * field.std())) | (wide & (field > 0.45 * field.std()))


def _dropouts(depth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Small clusters that found no match, more of them far away."""
    field = cv2.GaussianBlur(rng.standard_normal(depth.shape), (0, 0), 1.1)
    field /= field.std()
    return field > 3.1 - 0.18 * depth
