"""Running methods over the scenes of the bench of denoising."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..completion import complete, prepare
from ..ebs import extract_blocks
from ..errors import IlfError
from ..metrics import measure_errors
from ..parameters import PRESETS
from ..processes import run_units
from .choices import chosen_names
from .denoise_scenes import SCENES, Scene
from .peers.denoisers import DENOISERS, Depth
from .peers.interpolation import nearest

INPUT = "input"
"""What stands for the depth as it is given, in the place of a method."""

DENOISE_METHODS = (INPUT, *PRESETS, *DENOISERS)


@dataclass(frozen=True)
class DenoisePlan:
    """What is compared: names of methods, and what the noise follows from."""

    methods: tuple[str, ...]
    seed: int = 0


@dataclass(frozen=True)
class DenoiseRow:
    """One method on one part of a scene: errors over its known pixels [m], seconds, and why it failed, "" if it did
    not. What a preset leaves open counts as given."""

    scene: str
    part: str
    method: str
    pixels: int
    rmse: float
    mae: float
    seconds: float
    failure: str


def choose_denoise_methods(names: str) -> list[str]:
    """Names of the methods that a comma-separated list means, each once; "all", "presets" and "peers" are groups.

    Raises
    ------
    ParameterError
        For an unknown name, or if there is none.
    """
    groups = {"all": DENOISE_METHODS, "presets": tuple(PRESETS), "peers": tuple(DENOISERS)}
    return chosen_names(names, DENOISE_METHODS, groups)


def run_denoise_bench(
    plan: DenoisePlan, *, jobs: int = 1, on_progress: Callable[[str], None] | None = None
) -> list[DenoiseRow]:
    """Run every method on every scene; rows by scene, part and method.

    Presets find the noise themselves. Peers are told the root mean square of its true deviation, and get depth whose
    gaps are closed with the nearest known depth.

    Parameters
    ----------
    plan : DenoisePlan
    jobs : int
        Processes that share the scenes. More than one makes the seconds longer and less certain; all else stays.
    on_progress : callable, optional
        Called with a scene's name whenever it is done.
    """
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
            errors = measure_errors(depth, scene.truth, pixels)
            rows[part, method] = DenoiseRow(
                name, part, method, errors.pixels, errors.rmse, errors.mae, seconds, failure
            )
    return [rows[part, method] for part in scene.parts for method in methods]


def _run_method(method: str, scene: Scene, labels: np.ndarray, dense: Depth) -> tuple[Depth, float, str]:
    """Depth, closed where it was left open, seconds without the extraction, and why the method failed if it did."""
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
