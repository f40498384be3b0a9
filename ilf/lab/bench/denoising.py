"""Bench of denoising: scenes of known noise, peers, and the run over all methods."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.fft import dctn, idctn

from ..._runtime.installation import asset_path, optional
from ..._runtime.processes import run_units
from ...completion.completion import prepare
from ...completion.interpolation import nearest
from ...data.frame import RGBDFrame
from ...data.parameters import PRESETS
from ...errors import IlfError
from ...evaluation.metrics import measure_errors
from ...run.run import complete
from ...segmentation.extraction import extract_blocks
from .frames import load_bench_frame, parse_names

# Noise model of structured-light cameras, for scenes whose depth is known exactly.

Depth = NDArray[np.float64]


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


# Scenes of the bench: exact depth, and the same depth with known sensor noise.

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
    one_block : bool
        Whether the whole frame is one block; otherwise blocks are extracted.
    parts : dict
        Name of a part -> bool (H, W), the known pixels that are scored.
    """

    frame: RGBDFrame
    ground_truth: NDArray[np.float64]
    noise: NDArray[np.float64]
    one_block: bool
    parts: dict[str, Mask]


def _sphere(noise: float, seed: int) -> Scene:
    """2.6 x 1.2 m of a sphere of 2 m radius, in parallel projection."""
    y, x = _grid((360, 640), (1.2, 2.6))
    return _smooth("sphere", 4.0 - np.sqrt(4.0 - x**2 - y**2), noise, seed)


def _cylinder(noise: float, seed: int) -> Scene:
    """0.6 x 0.6 m of an upright cylinder of 0.5 m radius, in parallel projection."""
    _, x = _grid((480, 480), (0.6, 0.6))
    return _smooth("cylinder", 2.0 - np.sqrt(0.25 - x**2), noise, seed)


def _smooth(name: str, ground_truth: Depth, noise: float, seed: int) -> Scene:
    rng = np.random.default_rng([seed, round(1e6 * noise)])
    depth = ground_truth + noise * rng.standard_normal(ground_truth.shape)
    everywhere = np.ones(ground_truth.shape, bool)
    return Scene(
        RGBDFrame(_shaded(ground_truth), depth.astype(np.float32), name=name),
        ground_truth,
        np.full(ground_truth.shape, noise),
        True,
        {"all": everywhere},
    )


def _steps_and_slopes(seed: int) -> Scene:
    """Planes side by side, level and slanted, 1 to 2.2 m away, with steps of 3 to 50 cm between them."""
    rows, columns = np.indices(_SHAPE)
    ground_truth = np.empty(_SHAPE)
    offsets = (1.0, 1.03, 1.13, 1.33, 1.28, 1.78)
    slopes = ((0.0, 0.0), (0.0, 4e-4), (8e-4, 0.0), (0.0, 0.0), (-3e-4, 6e-4), (0.0, -8e-4))
    width = _SHAPE[1] // len(offsets)
    for band, (offset, (down, across)) in enumerate(zip(offsets, slopes, strict=True)):
        inside = np.minimum(columns // width, len(offsets) - 1) == band
        surface = offset + down * rows + across * (columns - band * width)
        ground_truth[inside] = surface[inside]
        ground_truth[inside & (rows > 380)] = 1.9 + 0.05 * band
    return _structured("steps and slopes", ground_truth, seed)


def _things(seed: int) -> Scene:
    """Balls, boxes and rods, some 2 px thin, on a floor before a slanted wall; in perspective."""
    rows, columns = np.indices(_SHAPE)
    x, y = ((at / _FOCAL).astype(np.float64) for at in (columns - 319.5, rows - 239.5))
    ground_truth = np.minimum(1 / (0.36 - 0.12 * x), 1.1 / np.maximum(y, 1e-3))
    for centre, radius in (((-0.55, 0.1, 2.0), 0.25), ((0.5, -0.3, 2.4), 0.3), ((0.1, 0.25, 1.6), 0.12)):
        ground_truth = np.minimum(ground_truth, _ball(x, y, np.array(centre), radius))
    for left, right, top, bottom, z, turn in (
        (0.05, 0.5, 0.0, 0.7, 2.1, 0.25),
        (-0.9, -0.62, -0.5, 0.6, 2.5, -0.3),
        (0.62, 1.0, 0.2, 0.62, 1.9, 0.0),
    ):
        plane = z / (1 - turn * x)
        inside = (x * plane > left) & (x * plane < right) & (y * plane > top) & (y * plane < bottom)
        ground_truth = np.where(inside, np.minimum(ground_truth, plane), ground_truth)
    for place, wide, z in ((-0.28, 2, 1.5), (-0.2, 5, 1.7), (0.02, 3, 1.3), (0.32, 9, 1.5)):
        rod = np.abs(columns - 319.5 - _FOCAL * (place + 0.08 * y)) < wide / 2
        ground_truth = np.where(rod & (y < 0.3), np.minimum(ground_truth, z), ground_truth)
    return _structured("things", ground_truth, seed)


def _things_in_white_noise(seed: int) -> Scene:
    scene = _things(seed)
    return _with_white_noise(
        "things", scene.ground_truth, scene.frame.rgb, np.isfinite(scene.frame.depth), 0.004 * scene.ground_truth, seed
    )


def _structured(name: str, ground_truth: Depth, seed: int) -> Scene:
    """A scene as a structured-light camera measures it, with seams of missing depth at some of the jumps."""
    rng = np.random.default_rng([seed, 7])
    field = cv2.GaussianBlur(rng.standard_normal(ground_truth.shape), (0, 0), 1.5)
    seam = _beside_jumps(ground_truth, 1) & (field > 0)
    depth = _SENSOR.measured(ground_truth, rng)
    frame = RGBDFrame(_shaded(ground_truth), np.where(seam, np.nan, depth), name=name)
    return Scene(
        frame, ground_truth, _SENSOR.deviation(ground_truth), False, _flat_and_edges(ground_truth, frame.known)
    )


def _room(seed: int) -> Scene:
    """The bundled sample where its depth is known, with new noise: its own depth is wrong behind glass, too."""
    source = load_bench_frame(asset_path("samples/room"))
    assert source.ground_truth is not None
    ground_truth = source.ground_truth.astype(np.float64)
    depth = np.where(source.frame.known, _SENSOR.measured(ground_truth, np.random.default_rng([seed, 11])), np.nan)
    frame = RGBDFrame(source.frame.rgb, depth, name=source.frame.name)
    return Scene(
        frame, ground_truth, _SENSOR.deviation(ground_truth), False, _flat_and_edges(ground_truth, frame.known)
    )


def _room_in_white_noise(seed: int) -> Scene:
    scene = _room(0)
    deviation = np.full(scene.ground_truth.shape, 0.01)
    return _with_white_noise("room", scene.ground_truth, scene.frame.rgb, scene.frame.known, deviation, seed)


def _with_white_noise(
    name: str, ground_truth: Depth, rgb: NDArray[np.uint8], known: Mask, deviation: Depth, seed: int
) -> Scene:
    rng = np.random.default_rng([seed, 13])
    depth = np.where(known, ground_truth + deviation * rng.standard_normal(ground_truth.shape), np.nan)
    return Scene(RGBDFrame(rgb, depth, name=name), ground_truth, deviation, False, _flat_and_edges(ground_truth, known))


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
"""Name -> function from a seed to the scene with noise."""


def _flat_and_edges(ground_truth: Depth, known: Mask) -> dict[str, Mask]:
    edges = _beside_jumps(ground_truth, _BESIDE)
    return {"flat": known & ~edges, "edges": known & edges}


def _beside_jumps(ground_truth: Depth, distance: int) -> Mask:
    jumps = np.zeros(ground_truth.shape, np.uint8)
    for depth, marks in ((ground_truth, jumps), (ground_truth.T, jumps.T)):
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


def _shaded(ground_truth: Depth) -> NDArray[np.uint8]:
    """Colour image of matt grey surfaces under one light: jumps show as far as slopes differ."""
    down, across = np.gradient(ground_truth)
    pitch = ground_truth / _FOCAL
    light = (0.77 + 0.4 * across / pitch + 0.5 * down / pitch) / np.sqrt(1 + (across**2 + down**2) / pitch**2)
    grey = np.round(60 + 180 * np.clip(light, 0, 1)).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=2)


# Filters that denoise dense depth; each gets the noise's standard deviation.

_SIDE = 5
"""Side of the median filter's window [px]."""

_RANGE, _SPACE = 3.0, 3.0
"""Deviations of the bilateral filter: in depth, in deviations of the noise, and in the image [px]."""

_EPSILON, _RADIUS = 16.0, 3
"""The guided filter's regularisation, in variances of the noise, and the radius of its window [px]."""

_TV_WEIGHT = 4.0
"""Weight of total variation for noise of deviation 1."""

_PATCH, _SEARCH, _LIKENESS = 7, 11, 1.2
"""Patch size and search distance of non-local means [px], and its filter strength in deviations of the noise."""


def median(depth: Depth, noise: float) -> Depth:
    """Median filter; ignores the noise."""
    return cv2.medianBlur(depth.astype(np.float32), _SIDE).astype(np.float64)


def bilateral(depth: Depth, noise: float) -> Depth:
    """Tomasi and Manduchi, "Bilateral filtering for gray and color images", 1998."""
    return cv2.bilateralFilter(depth.astype(np.float32), -1, _RANGE * noise, _SPACE).astype(np.float64)


def guided(depth: Depth, noise: float) -> Depth:
    """He, Sun and Tang, "Guided image filtering", 2013, with the depth as its own guide."""

    def mean(values: Depth) -> Depth:
        return np.asarray(cv2.blur(values, (2 * _RADIUS + 1,) * 2), np.float64)

    level = mean(depth)
    variance = mean(depth * depth) - level * level
    gain = variance / (variance + _EPSILON * noise**2)
    return mean(gain) * depth + mean(level - gain * level)


def total_variation(depth: Depth, noise: float) -> Depth:
    """Chambolle, "An algorithm for total variation minimization and applications", 2004."""
    from skimage.restoration import denoise_tv_chambolle

    return np.asarray(denoise_tv_chambolle(depth / noise, weight=_TV_WEIGHT, max_num_iter=300, eps=2e-5) * noise)


def nonlocal_means(depth: Depth, noise: float) -> Depth:
    """Buades, Coll and Morel, "A non-local algorithm for image denoising", 2005."""
    from skimage.restoration import denoise_nl_means

    scaled = denoise_nl_means(
        depth / noise, patch_size=_PATCH, patch_distance=_SEARCH, h=_LIKENESS, sigma=1.0, fast_mode=True
    )
    return np.asarray(scaled * noise)


def dct_pls(depth: Depth, noise: float) -> Depth:
    """Garcia's penalised least squares by cosine transforms, 2010; the residual is made to match the noise."""
    along = [2 - 2 * np.cos(np.pi * np.arange(size) / size) for size in depth.shape]
    roughness = (along[0][:, None] + along[1][None, :]) ** 2
    spectrum = dctn(depth, norm="ortho")
    low, high = -6.0, 9.0
    while high - low > 0.01:
        middle = (low + high) / 2
        left = 1 - 1 / (1 + 10**middle * roughness)
        too_stiff = np.mean((spectrum * left) ** 2) > noise**2 * left.mean()
        low, high = (low, middle) if too_stiff else (middle, high)
    return np.asarray(idctn(spectrum / (1 + 10**low * roughness), norm="ortho"))


DENOISERS: dict[str, Callable[[Depth, float], Depth]] = {
    "median": median,
    "bilateral": bilateral,
    "guided": guided,
    "total-variation": total_variation,
    "nonlocal-means": nonlocal_means,
    "dct-pls": dct_pls,
}
"""Name -> filter of dense depth [m], shape (H, W), given the true standard deviation of its noise [m]. Of several
settings, those with the lowest errors over the bench's scenes under another seed were taken."""


INPUT = "input"
"""Name that stands for the unchanged input depth in place of a method."""

DENOISE_METHODS = (INPUT, *PRESETS, *DENOISERS)


@dataclass(frozen=True)
class DenoisePlan:
    """Input of the denoising bench: names of methods, and the seed of the noise."""

    methods: tuple[str, ...]
    seed: int = 0


@dataclass(frozen=True)
class DenoiseRow:
    """One method on one part of a scene: errors over its known pixels [m], seconds, and reason of a failure ("" if
    none). Pixels that a preset does not fill count with their input depth."""

    scene: str
    part: str
    method: str
    pixels: int
    rmse: float
    mae: float
    seconds: float
    failure: str


def parse_denoise_methods(names: str) -> list[str]:
    """Parse a comma-separated list of methods, each named once; "all", "presets" and "peers" are groups.

    Raises
    ------
    ParameterError
        For an unknown name, or if there is none.
    """
    groups = {"all": DENOISE_METHODS, "presets": tuple(PRESETS), "peers": tuple(DENOISERS)}
    return parse_names(names, DENOISE_METHODS, groups)


def run_denoise_bench(
    plan: DenoisePlan, *, jobs: int = 1, on_progress: Callable[[str], None] | None = None
) -> list[DenoiseRow]:
    """Run every method on every scene; rows by scene, part and method.

    Presets estimate the noise themselves. Peers get the root mean square of its true deviation, and depth whose gaps
    are filled with the nearest known depth.

    Parameters
    ----------
    plan : DenoisePlan
    jobs : int
        Processes that share the scenes. More than one makes the timings longer and less accurate; all else stays.
    on_progress : callable, optional
        Called with a scene's name whenever it is done.

    Raises
    ------
    InputError
        If the package of the methods total-variation and nonlocal-means is missing.
    """
    if not {"total-variation", "nonlocal-means"}.isdisjoint(plan.methods):
        optional(
            "skimage", "experiments", "A comparison with total-variation or nonlocal-means"
        )  # fail before the work
    names, report = list(SCENES), on_progress or (lambda name: None)
    units = [(name, plan.methods, plan.seed) for name in names]
    parts = run_units(_run_scene, units, jobs=jobs, on_done=lambda number: report(names[number]))
    return [row for part in parts for row in part]


def _run_scene(name: str, methods: Sequence[str], seed: int) -> list[DenoiseRow]:
    scene = SCENES[name](seed)
    labels = np.ones(scene.frame.shape, np.int32) if scene.one_block else extract_blocks(scene.frame)
    dense = nearest(scene.frame).astype(np.float64)
    rows: dict[tuple[str, str], DenoiseRow] = {}
    for method in methods:
        depth, seconds, failure = _run_method(method, scene, labels, dense)
        for part, pixels in scene.parts.items():
            errors = measure_errors(depth, scene.ground_truth, pixels)
            rows[part, method] = DenoiseRow(
                name, part, method, errors.pixels, errors.rmse, errors.mae, seconds, failure
            )
    return [rows[part, method] for part in scene.parts for method in methods]


def _run_method(method: str, scene: Scene, labels: np.ndarray, dense: Depth) -> tuple[Depth, float, str]:
    """Return depth without gaps, seconds without the extraction, and the reason of a failure ("" if none)."""
    if method == INPUT:
        return dense, 0.0, ""
    if method in DENOISERS:
        noise = float(np.sqrt(np.mean(np.square(scene.noise[scene.frame.known]))))
        started = time.perf_counter()
        return DENOISERS[method](dense, noise), time.perf_counter() - started, ""
    parameters = PRESETS[method].replace(mode="fill+denoise")
    prepare(scene.frame, parameters)
    started = time.perf_counter()
    try:
        depth, failure = complete(scene.frame, labels, parameters).depth, ""
    except (IlfError, MemoryError) as error:
        depth, failure = scene.frame.depth, str(error) or type(error).__name__
    seconds = time.perf_counter() - started
    return np.where(np.isfinite(depth), depth, dense).astype(np.float64), seconds, failure
