"""Bench of denoising: scenes whose depth and noise are known, and the run of all methods on them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np
from numpy.typing import NDArray

from ..._runtime.children import run_units
from ..._runtime.installation import asset_path, optional
from ...completion.filter import edges_for
from ...completion.interpolation import nearest
from ...data.frame import RGBDFrame
from ...data.parameters import PRESETS
from ...data.pixel_grids import mark_both, sides
from ...run.run import complete
from ...segmentation.extraction import extract_blocks
from ..evaluation import evaluate
from .denoisers import DENOISERS, Depth
from .frames import load_bench_frame
from .results import Line
from .runner import timed

Mask = NDArray[np.bool_]


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
        Standard deviation of the disparity [steps]; the default gives 1.3 mm at 1 m, growing with the range squared.
    """

    focal: float
    baseline: float = 0.075
    steps_per_pixel: int = 8
    noise: float = 0.45

    @property
    def scale(self) -> float:
        """Depth x disparity [m x steps]."""
        return self.steps_per_pixel * self.focal * self.baseline

    def measured(self, depth: Depth, rng: np.random.Generator) -> Depth:
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

    def deviation(self, depth: Depth) -> Depth:
        """Standard deviation [m] of noise and steps together at a depth, without the jitter."""
        return depth**2 / self.scale * math.sqrt(self.noise**2 + 1 / 12)


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


INPUT = "input"
"""Name that stands for the unchanged input depth in place of a method."""

DENOISE_GROUPS = {"all": (INPUT, *PRESETS, *DENOISERS), "presets": tuple(PRESETS), "peers": tuple(DENOISERS)}
"""Names of groups of methods."""


def run_denoise_bench(
    methods: Sequence[str], seed: int = 0, *, jobs: int = 1, on_progress: Callable[[str], None] = lambda name: None
) -> list[Line]:
    """Run every method on every scene.

    Presets estimate the noise themselves. Peers get the root mean square of its true deviation, and depth whose gaps
    are filled with the nearest known depth.

    Parameters
    ----------
    methods : sequence of str
        Of `DENOISE_GROUPS["all"]`.
    seed : int
        Of the noise.
    jobs : int
        Processes that share the scenes. More than one makes the timings longer and less accurate; all else stays.
    on_progress : callable, optional
        Called with a scene's name whenever it is done.

    Returns
    -------
    list of dict
        Scene, part, method, pixels, RMSE and MAE over its known pixels [m], seconds, and reason of a failure ("" if
        none), by scene, part and method. Pixels that a preset does not fill count with their input depth.

    Raises
    ------
    InputError
        If the package of the methods total-variation and nonlocal-means is missing.
    """
    if not {"total-variation", "nonlocal-means"}.isdisjoint(methods):
        optional("skimage", "ilf-studio[plot]", "A comparison with total-variation or nonlocal-means")  # first
    names = list(SCENES)
    units = [(name, methods, seed) for name in names]
    parts = run_units(_run_scene, units, jobs=jobs, on_done=lambda number: on_progress(names[number]))
    return [row for part in parts for row in part]


def _run_scene(name: str, methods: Sequence[str], seed: int) -> list[Line]:
    scene = SCENES[name](seed)
    blocks, dense = scene.blocks(), nearest(scene.frame).astype(np.float64)
    found = {method: _run_method(method, scene, blocks, dense) for method in methods}
    rows = []
    for part, pixels in scene.parts.items():
        for method, (depth, seconds, failure) in found.items():
            errors = evaluate(depth, scene.ground_truth, pixels)
            row = {"scene": name, "part": part, "method": method, "pixels": errors.pixels, "rmse": errors.rmse}
            rows.append(row | {"mae": errors.mae, "seconds": seconds, "failure": failure})
    return rows


def _run_method(method: str, scene: Scene, blocks: NDArray[np.int32], dense: Depth) -> tuple[Depth, float, str]:
    """Return depth without gaps, seconds without the extraction, and the reason of a failure ("" if none)."""
    if method == INPUT:
        return dense, 0.0, ""
    if method in DENOISERS:
        noise = float(np.sqrt(np.mean(np.square(scene.noise[scene.frame.known]))))
        return timed(lambda: DENOISERS[method](dense, noise), dense)
    parameters = PRESETS[method].replace(mode="fill+denoise")
    edges_for(scene.frame, parameters)
    run = partial(complete, scene.frame, blocks, parameters)
    depth, seconds, failure = timed(lambda: run().depth, scene.frame.depth)
    return np.where(np.isfinite(depth), depth, dense).astype(np.float64), seconds, failure
