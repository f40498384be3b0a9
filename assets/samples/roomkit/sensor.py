"""What a structured-light camera makes of exact depth: quantised, noisier with range, and with holes.

The camera projects a pattern of infrared dots from beside its lens, finds each window of the pattern in its image, and
measures by how much it has moved (disparity). Depth is missing where the pattern

- does not reach: something nearer is in the projector's way, and so the shadow lies left of it ("stereo shadow");
- does not come back: absorbed by black plastic and lacquer, which screens are made of ("black surface"), spread over
  too large an area by steep surfaces, too weak beyond the range, thrown aside by polished metal and varnish;
- is outshone, by lamps or by the projector's own mirror image in glaze ("halogen light", "glossy thing");
- is torn: its window lies half on one surface and half on another ("depth edge"), or on a thing narrower than itself
  ("thin thing"), or it goes through the walls of a glass aslant ("glass"). Where it passes glass straight, the
  depth of what is behind is measured, and is wrong.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import cv2
import numpy as np

from .light import OFF_SURFACE
from .room import BACK, DOOR, SPOT, SPOT_RADIUS, Room
from .scene import Hits, dot, in_front
from .textures import noise

BASELINE = 0.075
"""From the camera to the pattern projector on its right [m]."""
STEPS_PER_PIXEL = 8
"""Disparity is measured in eighths of a pixel."""
DISPARITY_NOISE = 0.45
"""Standard deviation of the disparity [steps]; 1.3 mm at 1 m, growing with the square of the range."""
FARTHEST = 4.6
"""Range beyond which the pattern is too weak [m]."""
WINDOW = 5
"""Side of the window of the pattern that is matched [px]."""
METAL = 0.15
"""Mirror reflection from which on a surface scatters too little [Schlick's F0]."""
GLARE = 3.0
"""Radiance of a mirrored lamp, per irradiance, that blinds the camera [1/sr]; ten times that of matt white."""


@dataclass(frozen=True)
class StructuredLight:
    """A camera that measures disparity in steps, as a Kinect of the first kind does.

    Attributes
    ----------
    focal : float
        Focal length [px].
    baseline : float
        From the camera to the pattern projector [m].
    steps_per_pixel : int
        Steps of the measured disparity per pixel.
    noise : float
        Standard deviation of the disparity [steps].
    """

    focal: float
    baseline: float = BASELINE
    steps_per_pixel: int = STEPS_PER_PIXEL
    noise: float = DISPARITY_NOISE

    @property
    def scale(self) -> float:
        """Depth x disparity [m x steps]."""
        return self.steps_per_pixel * self.focal * self.baseline

    def measured(self, depth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Return depth [m], (H, W), with lateral jitter, correlated disparity noise and disparity steps."""
        height, width = depth.shape
        rows, columns = np.mgrid[:height, :width]
        jitter = np.round(0.45 * rng.standard_normal((2, height, width))).astype(int)
        seen = depth[np.clip(rows + jitter[0], 0, height - 1), np.clip(columns + jitter[1], 0, width - 1)]
        # Neighbours share most of their matching window, hence most of their error.
        shared = cv2.GaussianBlur(rng.standard_normal(depth.shape), (0, 0), 1.2)
        error = 0.8 * shared / shared.std() + 0.6 * rng.standard_normal(depth.shape)
        steps = np.round(self.scale / seen + self.noise * error)
        return self.scale / np.maximum(steps, 1)

    def deviation(self, depth: np.ndarray) -> np.ndarray:
        """Standard deviation [m] of noise and steps together at a depth, without the jitter."""
        return depth**2 / self.scale * math.sqrt(self.noise**2 + 1 / 12)


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
    unit = _unit(views)
    cos = -dot(unit, hits.flat)
    causes = {
        "black surface": room.scene.of("black", hits) & (ragged < 0.78),
        "halogen light": _halogen(hits, ragged) | (room.scene.of("emission", hits).max(axis=1) > 0),
        "glossy floor": room.scene.of("floor", hits) & _glare(hits, unit, ragged),
        "glossy thing": _glossy(room, hits),
        "glass": _refracted(room, hits, views),
        "out of range": hits.distance + 0.5 * (ragged - 0.5) > FARTHEST,
        "stereo shadow": _unlit(room, hits),
        "steep surface": cos < 0.16 + 0.22 * (ragged - 0.5),
    }
    flat = {name: mask.reshape(shape) for name, mask in causes.items()}
    # The shadow's outline follows the matching window, not single pixels.
    flat["stereo shadow"] = cv2.morphologyEx(
        flat["stereo shadow"].astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)
    ).astype(bool)
    flat["thin thing"] = _thin(depth, rng)
    flat["depth edge"] = _edges(depth, rng)
    flat["drop-out"] = _dropouts(depth, rng)
    taken = np.zeros(shape, bool)
    for name, mask in flat.items():
        flat[name] = mask & ~taken
        taken |= mask
    return flat


def measured(depth: np.ndarray, intrinsics: tuple[float, ...], rng: np.random.Generator) -> np.ndarray:
    """Depth [m], float (H, W), with lateral jitter, correlated disparity noise and disparity steps."""
    return StructuredLight(intrinsics[0]).measured(depth, rng)


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


def _glossy(room: Room, hits: Hits) -> np.ndarray:
    """Polished metal, and where a glaze mirrors the projector into the camera."""
    gloss, roughness = room.scene.of("gloss", hits), room.scene.of("roughness", hits)
    ways = [_unit(place - hits.points) for place in (room.camera.position, _projector(room))]
    aligned = dot(_unit(sum(ways)), hits.normals)
    slope = np.sqrt(np.maximum(1 / np.maximum(aligned, 1e-3) ** 2 - 1, 0))
    blinding = (gloss > GLARE * 4 * np.pi * roughness**2) & (slope < 0.02 + 2 * roughness)
    return (gloss > METAL) | (blinding & ~room.scene.of("floor", hits))


def _refracted(room: Room, hits: Hits, views: np.ndarray) -> np.ndarray:
    """Glass whose wall stands aslant."""
    glass = in_front(room.scene.cast(np.broadcast_to(room.camera.position, views.shape), views, glass=True), hits)
    return glass.found & (-dot(_unit(views), glass.flat) < 0.82 + 0.3 * (noise(glass.points * 40, octaves=3) - 0.5))


def _thin(depth: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Most of what is narrower than the matching window and more than 4 % nearer than what is around."""
    around = cv2.morphologyEx(depth, cv2.MORPH_CLOSE, np.ones((WINDOW, WINDOW), np.uint8))
    field = cv2.GaussianBlur(rng.standard_normal(depth.shape), (0, 0), 3)
    return (around - depth > 0.04 * depth) & (field > -0.8 * field.std())


def _projector(room: Room) -> np.ndarray:
    return room.camera.position + BASELINE * room.camera.right


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def _unlit(room: Room, hits: Hits) -> np.ndarray:
    """Points that the projector's pattern does not reach because something nearer is in its way."""
    start = hits.points + 20 * OFF_SURFACE * hits.flat
    return room.scene.blocked(start, _projector(room) - start, far=0.99)


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
