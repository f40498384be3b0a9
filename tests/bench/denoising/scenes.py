"""Scenes whose depth and noise are known."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf._runtime.installation import asset_path
from ilf.data.frame import RGBDFrame
from ilf.data.pixel_grids import mark_both, sides
from ilf.evaluation.bench.frames import load_bench_frame
from ilf.segmentation.extraction import extract_blocks

from .filters import Depth

sys.path.insert(0, str(asset_path("samples")))
from roomkit.sensor import StructuredLight

Mask = NDArray[np.bool_]


_SHAPE, _FOCAL = (480, 640), 525.0
_SENSOR = StructuredLight(_FOCAL)

_JUMP = 0.02
"""Neighbours whose true depth differs by more than this, in metres and as a share of depth, form an edge."""

_BESIDE = 4
"""Pixels up to this distance [px] from an edge are scored as edges, all others as flat."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A frame with known noise.

    Attributes
    ----------
    frame : RGBDFrame
        With noise.
    ground_truth : ndarray of float64, shape (H, W)
        Depth [m] without noise.
    noise : ndarray of float64, shape (H, W)
        True standard deviation [m] of every pixel's noise; given to the peers.
    """

    frame: RGBDFrame
    ground_truth: Depth
    noise: Depth

    @property
    def parts(self) -> dict[str, Mask]:
        """Name -> bool (H, W) of the known pixels that are scored together; "all" of them in a scene without edges."""
        edges, known = _beside_jumps(self.ground_truth, _BESIDE), self.frame.known
        return {"flat": known & ~edges, "edges": known & edges} if edges.any() else {"all": known}

    def blocks(self) -> NDArray[np.int32]:
        """The extracted blocks; a scene without edges is one block."""
        return np.ones(self.frame.shape, np.int32) if "all" in self.parts else extract_blocks(self.frame)


def _sphere() -> Depth:
    """2.6 x 1.2 m of a sphere of 2 m radius, in parallel projection."""
    y, x = 1.2 * np.linspace(-0.5, 0.5, 360)[:, None], 2.6 * np.linspace(-0.5, 0.5, 640)
    return 4.0 - np.sqrt(4.0 - x**2 - y**2)


def _cylinder() -> Depth:
    """0.6 x 0.6 m of an upright cylinder of 0.5 m radius, in parallel projection."""
    x = 0.6 * np.linspace(-0.5, 0.5, 480)
    return np.tile(2.0 - np.sqrt(0.25 - x**2), (480, 1))


def _steps_and_slopes() -> Depth:
    """Planes side by side, level and slanted, 1 to 2.2 m away, with steps of 3 to 50 cm between them."""
    rows, columns = np.indices(_SHAPE)
    offsets = np.array((1.0, 1.03, 1.13, 1.33, 1.28, 1.78))
    down, across = np.array(((0, 0), (0, 4e-4), (8e-4, 0), (0, 0), (-3e-4, 6e-4), (0, -8e-4))).T
    width = _SHAPE[1] // len(offsets)
    band = np.minimum(columns // width, len(offsets) - 1)
    planes = offsets[band] + down[band] * rows + across[band] * (columns - band * width)
    return np.where(rows > 380, 1.9 + 0.05 * band, planes)


def _things() -> Depth:
    """Balls, boxes and rods, some 2 px thin, on a floor before a slanted wall; in perspective."""
    rows, columns = np.indices(_SHAPE)
    x, y = ((at / _FOCAL).astype(np.float64) for at in (columns - 319.5, rows - 239.5))
    depth = np.minimum(1 / (0.36 - 0.12 * x), 1.1 / np.maximum(y, 1e-3))
    for centre, radius in (((-0.55, 0.1, 2.0), 0.25), ((0.5, -0.3, 2.4), 0.3), ((0.1, 0.25, 1.6), 0.12)):
        depth = np.minimum(depth, _ball(x, y, np.array(centre), radius))
    for left, right, top, bottom, z, turn in (
        (0.05, 0.5, 0.0, 0.7, 2.1, 0.25),
        (-0.9, -0.62, -0.5, 0.6, 2.5, -0.3),
        (0.62, 1.0, 0.2, 0.62, 1.9, 0.0),
    ):
        plane = z / (1 - turn * x)
        inside = (x * plane > left) & (x * plane < right) & (y * plane > top) & (y * plane < bottom)
        depth = np.where(inside, np.minimum(depth, plane), depth)
    for place, wide, z in ((-0.28, 2, 1.5), (-0.2, 5, 1.7), (0.02, 3, 1.3), (0.32, 9, 1.5)):
        rod = np.abs(columns - 319.5 - _FOCAL * (place + 0.08 * y)) < wide / 2
        depth = np.where(rod & (y < 0.3), np.minimum(depth, z), depth)
    return depth


def _ball(x: Depth, y: Depth, centre: Depth, radius: float) -> Depth:
    """Depth where rays (x, y, 1) meet a ball; infinite where they do not."""
    squares, along = x * x + y * y + 1, x * centre[0] + y * centre[1] + centre[2]
    under = along**2 - squares * (centre @ centre - radius**2)
    return np.where(under > 0, (along - np.sqrt(np.maximum(under, 0))) / squares, np.inf)


def _smooth(surface: Callable[[], Depth], noise: float, seed: int) -> Scene:
    """A surface without edges in white noise of a standard deviation [m]."""
    depth = surface()
    exact = Scene(RGBDFrame(_shaded(depth), depth), depth, np.full(depth.shape, noise))
    return _in_white_noise(exact, exact.noise, [seed, round(1e6 * noise)])


def _with_seams(surface: Callable[[], Depth], seed: int) -> Scene:
    """A surface as a structured-light camera measures it, with seams of missing depth at some of the jumps."""
    depth, rng = surface(), np.random.default_rng([seed, 7])
    field = cv2.GaussianBlur(rng.standard_normal(depth.shape), (0, 0), 1.5)
    seams = _beside_jumps(depth, 1) & (field > 0)
    return _measured(RGBDFrame(_shaded(depth), np.where(seams, np.nan, depth)), depth, rng)


def _room(seed: int) -> Scene:
    """The bundled sample where its depth is known, with new noise: its own depth is wrong behind glass, too."""
    source = load_bench_frame(asset_path("samples/room"))
    assert source.ground_truth is not None
    return _measured(source.frame, source.ground_truth.astype(np.float64), np.random.default_rng([seed, 11]))


def _measured(frame: RGBDFrame, ground_truth: Depth, rng: np.random.Generator) -> Scene:
    """The scene as a structured-light camera measures it, where a frame has depth."""
    depth = np.where(frame.known, _SENSOR.measured(ground_truth, rng), np.nan)
    return Scene(RGBDFrame(frame.rgb, depth), ground_truth, _SENSOR.deviation(ground_truth))


def _in_white_noise(scene: Scene, deviation: Depth, seed: Sequence[int]) -> Scene:
    """The scene in other noise, of a standard deviation [m]."""
    noise = deviation * np.random.default_rng(seed).standard_normal(deviation.shape)
    depth = np.where(scene.frame.known, scene.ground_truth + noise, np.nan)
    return Scene(RGBDFrame(scene.frame.rgb, depth), scene.ground_truth, deviation)


def _room_in_white_noise(seed: int) -> Scene:
    scene = _room(0)
    return _in_white_noise(scene, np.full(scene.noise.shape, 0.01), [seed, 13])


def _things_in_white_noise(seed: int) -> Scene:
    scene = _with_seams(_things, seed)
    return _in_white_noise(scene, 0.004 * scene.ground_truth, [seed, 13])


SCENES: dict[str, Callable[[int], Scene]] = {
    "sphere, 6.5 mm": partial(_smooth, _sphere, 0.0065),
    "sphere, 65 mm": partial(_smooth, _sphere, 0.065),
    "cylinder, 6.5 mm": partial(_smooth, _cylinder, 0.0065),
    "cylinder, 65 mm": partial(_smooth, _cylinder, 0.065),
    "steps and slopes, Kinect": partial(_with_seams, _steps_and_slopes),
    "room, Kinect": _room,
    "room, 10 mm": _room_in_white_noise,
    "things, Kinect": partial(_with_seams, _things),
    "things, 0.4 %": _things_in_white_noise,
}
"""Name -> function from a seed to the scene with noise."""


def _beside_jumps(ground_truth: Depth, distance: int) -> Mask:
    right, below = (
        np.abs(one - other) > _JUMP * np.maximum(1, np.minimum(one, other)) for one, other in sides(ground_truth)
    )
    return cv2.dilate(mark_both((right, below)).view(np.uint8), np.ones((2 * distance - 1,) * 2, np.uint8)) > 0


def _shaded(ground_truth: Depth) -> NDArray[np.uint8]:
    """Colour image of matt grey surfaces under one light: jumps show as far as slopes differ."""
    down, across = np.gradient(ground_truth)
    pitch = ground_truth / _FOCAL
    light = (0.77 + 0.4 * across / pitch + 0.5 * down / pitch) / np.sqrt(1 + (across**2 + down**2) / pitch**2)
    grey = np.round(60 + 180 * np.clip(light, 0, 1)).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)
