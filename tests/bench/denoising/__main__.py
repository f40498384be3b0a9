"""The noise that presets in the mode fill + denoise and other filters leave on scenes whose depth and noise are known.

python -m tests.bench.denoising [--methods input,best,peers] [--seed 0] [--scenes NAME ...]

Presets estimate the noise themselves. Peers get the root mean square of its true deviation, and depth whose gaps are
filled with the nearest known depth. Pixels that a preset does not fill count with their input depth.
"""

import argparse
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ilf import PRESETS
from ilf.cli.output import Column, table
from ilf.completion.interpolation import nearest
from ilf.evaluation.bench.frames import parse_names
from ilf.evaluation.evaluation import Evaluation, evaluate
from ilf.run.run import complete

from .filters import DENOISERS, Depth
from .scenes import SCENES, Scene

INPUT = "input"
"""Name that stands for the unchanged input depth in place of a method."""

GROUPS = {"all": (INPUT, *PRESETS, *DENOISERS), "presets": tuple(PRESETS), "peers": tuple(DENOISERS)}
"""Names of groups of methods."""

COLUMNS = (
    Column("method", lambda row: row[0]),
    Column("RMSE [mm]", lambda row: 1000 * row[1].rmse, ".3f", min),
    Column("MAE [mm]", lambda row: 1000 * row[1].mae, ".3f", min),
)


def denoised(method: str, scene: Scene, blocks: NDArray[np.int32], dense: Depth) -> Depth:
    """Return depth without gaps, by a method; `dense` is the input without gaps."""
    if method == INPUT:
        return dense
    if method in DENOISERS:
        return DENOISERS[method](dense, float(np.sqrt(np.mean(np.square(scene.noise[scene.frame.known])))))
    depth = complete(scene.frame, blocks, PRESETS[method].replace(mode="fill+denoise")).depth
    return np.where(np.isfinite(depth), depth, dense).astype(np.float64)


def errors(scene: Scene, methods: Sequence[str]) -> dict[str, list[tuple[str, Evaluation]]]:
    """Return part of the scene -> methods and their errors, the lowest RMSE first."""
    blocks, dense = scene.blocks(), nearest(scene.frame).astype(np.float64)
    found = {method: denoised(method, scene, blocks, dense) for method in methods}
    parts = {}
    for part, pixels in scene.parts.items():
        rows = [(method, evaluate(depth, scene.ground_truth, pixels)) for method, depth in found.items()]
        parts[part] = sorted(rows, key=lambda row: row[1].rmse)
    return parts


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.bench.denoising", description=__doc__.splitlines()[0])
    parser.add_argument("--methods", default="all", help=f"any of {', '.join([*GROUPS, *GROUPS['all']])}")
    parser.add_argument("--seed", type=int, default=0, help="of the noise")
    parser.add_argument("--scenes", nargs="+", default=list(SCENES), choices=list(SCENES), metavar="NAME")
    arguments = parser.parse_args()
    methods = parse_names(arguments.methods, GROUPS["all"], GROUPS)
    for name in arguments.scenes:
        for part, rows in errors(SCENES[name](arguments.seed), methods).items():
            print(f"{name}: {part} ({rows[0][1].pixels:,} pixels)", *table(COLUMNS, rows), "", sep="\n")


if __name__ == "__main__":
    main()
