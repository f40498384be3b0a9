"""The scenes of the bench of denoising: exact depth, and what sensors of known noise make of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..assets import asset_path
from ..frame import RGBDFrame
from .frames import load_bench_frame
from .sensor_noise import StructuredLight

Depth = NDArray[np.float64]
Mask = NDArray[np.bool_]

_SHAPE, _FOCAL = (480, 640), 525.0
_SENSOR = StructuredLight(_FOCAL)

_JUMP = 0.02
"""Neighbours whose true depth differs by more than that, in metres and as a share of depth, are an edge."""

_BESIDE = 4
"""Pixels up to so many away from an edge are scored as edges, all others as flat."""


@dataclass(frozen=True, eq=False)
class Scene:
    """A frame of known noise.

    Attributes
    ----------
    frame : RGBDFrame
        With noise.
    truth : ndarray of float64, shape (H, W)
        Depth [m] without.
    noise : ndarray of float64, shape (H, W)
        True standard deviation [m] of every pixel's noise, which the peers are told.
    one_block : bool
        Whether the whole frame is one block; else blocks are extracted.
    parts : dict
        Name of a part -> bool (H, W), the known pixels that are scored.
    """

    frame: RGBDFrame
    truth: NDArray[np.float64]
    noise: NDArray[np.float64]
    one_block: bool
    parts: dict[str, Mask]


def _sphere(noise: float, seed: int) -> Scene:
    """2.6 x 1.2 m of a sphere of 2 m, seen in parallel."""
    y, x = _grid((360, 640), (1.2, 2.6))
    return _smooth("sphere", 4.0 - np.sqrt(4.0 - x**2 - y**2), noise, seed)


def _cylinder(noise: float, seed: int) -> Scene:
    """0.6 x 0.6 m of an upright cylinder of 0.5 m, seen in parallel."""
    _, x = _grid((480, 480), (0.6, 0.6))
    return _smooth("cylinder", 2.0 - np.sqrt(0.25 - x**2), noise, seed)


def _smooth(name: str, truth: Depth, noise: float, seed: int) -> Scene:
    rng = np.random.default_rng([seed, round(1e6 * noise)])
    depth = truth + noise * rng.standard_normal(truth.shape)
    everywhere = np.ones(truth.shape, bool)
    return Scene(
        RGBDFrame(_shaded(truth), depth.astype(np.float32), name=name),
        truth,
        np.full(truth.shape, noise),
        True,
        {"all": everywhere},
    )


def _steps_and_slopes(seed: int) -> Scene:
    """Planes side by side, level and slanted, 1 to 2.2 m away, with steps of 3 to 50 cm between them."""
    rows, columns = np.indices(_SHAPE)
    truth = np.empty(_SHAPE)
    offsets = (1.0, 1.03, 1.13, 1.33, 1.28, 1.78)
    slopes = ((0.0, 0.0), (0.0, 4e-4), (8e-4, 0.0), (0.0, 0.0), (-3e-4, 6e-4), (0.0, -8e-4))
    width = _SHAPE[1] // len(offsets)
    for band, (offset, (down, across)) in enumerate(zip(offsets, slopes, strict=True)):
        inside = np.minimum(columns // width, len(offsets) - 1) == band
        surface = offset + down * rows + across * (columns - band * width)
        truth[inside] = surface[inside]
        truth[inside & (rows > 380)] = 1.9 + 0.05 * band
    return _structured("steps and slopes", truth, seed)


def _things(seed: int) -> Scene:
    """Balls, boxes and rods, some 2 px thin, before a slanted wall, on a floor; seen in perspective."""
    rows, columns = np.indices(_SHAPE)
    x, y = ((at / _FOCAL).astype(np.float64) for at in (columns - 319.5, rows - 239.5))
    truth = np.minimum(1 / (0.36 - 0.12 * x), 1.1 / np.maximum(y, 1e-3))
    for centre, radius in (((-0.55, 0.1, 2.0), 0.25), ((0.5, -0.3, 2.4), 0.3), ((0.1, 0.25, 1.6), 0.12)):
        truth = np.minimum(truth, _ball(x, y, np.array(centre), radius))
    for left, right, top, bottom, z, turn in (
        (0.05, 0.5, 0.0, 0.7, 2.1, 0.25),
        (-0.9, -0.62, -0.5, 0.6, 2.5, -0.3),
        (0.62, 1.0, 0.2, 0.62, 1.9, 0.0),
    ):
        plane = z / (1 - turn * x)
        inside = (x * plane > left) & (x * plane < right) & (y * plane > top) & (y * plane < bottom)
        truth = np.where(inside, np.minimum(truth, plane), truth)
    for place, wide, z in ((-0.28, 2, 1.5), (-0.2, 5, 1.7), (0.02, 3, 1.3), (0.32, 9, 1.5)):
        rod = np.abs(columns - 319.5 - _FOCAL * (place + 0.08 * y)) < wide / 2
        truth = np.where(rod & (y < 0.3), np.minimum(truth, z), truth)
    return _structured("things", truth, seed)


def _things_in_white_noise(seed: int) -> Scene:
    scene = _things(seed)
    return _parted("things", scene.truth, scene.frame.rgb, np.isfinite(scene.frame.depth), 0.004 * scene.truth, seed)


def _structured(name: str, truth: Depth, seed: int) -> Scene:
    """What a structured-light camera sees, with seams of missing depth at some of the jumps."""
    rng = np.random.default_rng([seed, 7])
    field = cv2.GaussianBlur(rng.standard_normal(truth.shape), (0, 0), 1.5)
    seam = _beside_jumps(truth, 1) & (field > 0)
    depth = _SENSOR.measured(truth, rng)
    frame = RGBDFrame(_shaded(truth), np.where(seam, np.nan, depth), name=name)
    return Scene(frame, truth, _SENSOR.deviation(truth), False, _flat_and_edges(truth, frame.known))


def _room(seed: int) -> Scene:
    """The bundled sample; its noise follows from the seed, but for 0, where it is the sample's own."""
    source = load_bench_frame(asset_path("samples/room"))
    assert source.truth is not None
    truth, frame = source.truth.astype(np.float64), source.frame
    if seed:
        depth = np.where(frame.known, _SENSOR.measured(truth, np.random.default_rng([seed, 11])), np.nan)
        frame = RGBDFrame(frame.rgb, depth, name=frame.name)
    return Scene(frame, truth, _SENSOR.deviation(truth), False, _flat_and_edges(truth, frame.known))


def _room_in_white_noise(seed: int) -> Scene:
    scene = _room(0)
    deviation = np.full(scene.truth.shape, 0.01)
    return _parted("room", scene.truth, scene.frame.rgb, scene.frame.known, deviation, seed)


def _parted(name: str, truth: Depth, rgb: NDArray[np.uint8], known: Mask, deviation: Depth, seed: int) -> Scene:
    rng = np.random.default_rng([seed, 13])
    depth = np.where(known, truth + deviation * rng.standard_normal(truth.shape), np.nan)
    return Scene(RGBDFrame(rgb, depth, name=name), truth, deviation, False, _flat_and_edges(truth, known))


SCENES: dict[str, Callable[[int], Scene]] = {
    "sphere, 6.5 mm": lambda seed: _sphere(0.0065, seed),
    "sphere, 65 mm": lambda seed: _sphere(0.065, seed),
    "cylinder, 6.5 mm": lambda seed: _cylinder(0.0065, seed),
    "cylinder, 65 mm": lambda seed: _cylinder(0.065, seed),
    "steps and slopes, Kinect": _steps_and_slopes,
    "room, Kinect": _room,
    "room, 10 mm": _room_in_white_noise,
    "things, Kinect": _things,
    "things, 0.4 %": _things_in_white_noise,
}
"""Name -> the scene with noise that follows from a seed."""


def _flat_and_edges(truth: Depth, known: Mask) -> dict[str, Mask]:
    edges = _beside_jumps(truth, _BESIDE)
    return {"flat": known & ~edges, "edges": known & edges}


def _beside_jumps(truth: Depth, distance: int) -> Mask:
    jumps = np.zeros(truth.shape, np.uint8)
    for depth, marks in ((truth, jumps), (truth.T, jumps.T)):
        one, other = depth[:, 1:], depth[:, :-1]
        apart = np.abs(one - other) > _JUMP * np.maximum(1, np.minimum(one, other))
        marks[:, 1:] |= apart
        marks[:, :-1] |= apart
    return cv2.dilate(jumps, np.ones((2 * distance - 1,) * 2, np.uint8)) > 0


def _grid(shape: tuple[int, int], size: tuple[float, float]) -> tuple[Depth, Depth]:
    y, x = (np.linspace(-0.5, 0.5, count) * length for count, length in zip(shape, size, strict=True))
    return y[:, None] + 0 * x, x + 0 * y[:, None]


def _ball(x: Depth, y: Depth, centre: Depth, radius: float) -> Depth:
    """Depth where rays (x, y, 1) meet a ball; infinite where they do not."""
    squares, along = x * x + y * y + 1, x * centre[0] + y * centre[1] + centre[2]
    under = along**2 - squares * (centre @ centre - radius**2)
    return np.where(under > 0, (along - np.sqrt(np.maximum(under, 0))) / squares, np.inf)


def _shaded(truth: Depth) -> NDArray[np.uint8]:
    """Colour image of matt grey surfaces under one light: jumps show as far as slopes differ."""
    down, across = np.gradient(truth)
    pitch = truth / _FOCAL
    light = (0.77 + 0.4 * across / pitch + 0.5 * down / pitch) / np.sqrt(1 + (across**2 + down**2) / pitch**2)
    grey = np.round(60 + 180 * np.clip(light, 0, 1)).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)
