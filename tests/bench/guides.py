"""Effect of a guide on frames with hidden areas: `python -m tests.bench.guides FOLDER... --seeds 1,2`.

With `--guides FOLDER`, the guides are those of a real network, files `<frame>.png` in that folder.

Otherwise they are simulated: a monotone curve of the ground truth, which is the frame's own depth before
the hold-out (with its holes filled smoothly), with a slowly varying bias, blur and noise. Also wrong guides: one that
is right on near things only, that of another frame, white noise, and slowly varying noise.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from ilf.evaluation.bench.frames import find_frames, load_bench_frame
from ilf.evaluation.bench.patterns import make_task
from ilf.evaluation.bench.runner import score
from ilf.io.frame_additions import load_guide
from ilf.run.run import complete
from ilf.segmentation.extraction import extract_blocks

Array = NDArray[np.float32]

BIAS, BIAS_LENGTH = 0.1, 1 / 6
"""Standard deviation of the bias as a share of depth, and of the Gaussian that smooths it, in widths of the frame."""

BLUR = 5.0
"""Standard deviation of the blur [px]."""

NOISE = 0.01
"""Standard deviation of the white noise, as a share of the guide's range."""

PATCH = 20.0
"""Standard deviation of the Gaussian for slowly varying noise [px]."""

CURVES: tuple[Callable[[Array], Array], ...] = (
    lambda depth: 1 / depth,
    lambda depth: 3.7 * depth - 0.8,
    np.log,
    lambda depth: -np.sqrt(depth + 0.5),
    lambda depth: 1 / (0.4 + depth**2),
)
"""Monotone curves from depth to the values of a guide, rising and falling."""


def simulated_guide(depth: Array, seed: int) -> Array:
    """Simulate the output of a depth network for a frame with this true depth [m], NaN = unknown."""
    rng = np.random.default_rng([seed, 4])
    whole = filled_smoothly(depth)
    bias = BIAS * slow_noise(whole.shape, rng, BIAS_LENGTH * whole.shape[1])
    values = CURVES[seed % len(CURVES)](whole * np.exp(bias))
    blurred = cv2.GaussianBlur(values, (0, 0), BLUR)
    low, high = np.percentile(blurred, (5, 95))
    return (blurred + rng.normal(0, NOISE * (high - low), blurred.shape)).astype(np.float32)


def bent_behind(depth: Array) -> Array:
    """Depth [m] as it is up to its median, and beyond turned away by up to 35 % at the sides of the frame."""
    turned = depth * np.exp(np.linspace(-0.35, 0.35, depth.shape[1], dtype=np.float32))
    return np.where(depth > np.nanmedian(depth), turned, depth)


def slow_noise(shape: tuple[int, ...], rng: np.random.Generator, length: float) -> Array:
    """Noise of mean 0 and deviation 1, smoothed by a Gaussian [px]."""
    values = cv2.GaussianBlur(rng.normal(size=shape).astype(np.float32), (0, 0), length, borderType=cv2.BORDER_REFLECT)
    return (values - values.mean()) / values.std()


def filled_smoothly(depth: Array) -> Array:
    """Fill gaps of depth by means over growing neighbourhoods."""
    known = np.isfinite(depth)
    result = np.where(known, depth, np.float32(np.nan))
    values, weights = np.where(known, depth, np.float32(0)), known.astype(np.float32)
    sigma = 1.0
    while np.isnan(result).any():
        share = cv2.GaussianBlur(weights, (0, 0), sigma)
        mean = cv2.GaussianBlur(values, (0, 0), sigma) / np.maximum(share, np.float32(1e-12))
        fill = np.isnan(result) & (share > (0.02 if sigma < max(depth.shape) else 0))
        result[fill] = mean[fill]
        sigma *= 1.5
    return result


def guides(depth: Array, other: Array, seed: int) -> Iterator[tuple[str, Array]]:
    """Return the guides of a frame by name, with the wrong ones."""
    yield "simulated", simulated_guide(depth, seed)
    yield "bent behind", simulated_guide(bent_behind(depth), seed)
    yield "of another frame", cv2.resize(simulated_guide(other, seed + 1), depth.shape[::-1])
    rng = np.random.default_rng(seed)
    yield "noise", rng.normal(size=depth.shape).astype(np.float32)
    yield "slow noise", slow_noise(depth.shape, rng, PATCH)


def real_guides(folder: Path, name: str) -> Iterator[tuple[str, Array]]:
    """Return the guide of a frame from a folder; 0 = missing."""
    path = folder / f"{name}.png"
    if path.is_file():
        yield "real", load_guide(path).values


def main() -> None:
    """Print for every frame the ratio of errors with and without a guide, RMSE and MAE, and geometric means."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--seeds", default="1,2")
    parser.add_argument("--guides", type=Path, metavar="FOLDER", help="guides of a real network, <frame>.png")
    arguments = parser.parse_args()
    folders = find_frames(arguments.folders)
    ratios: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for base in map(int, arguments.seeds.split(",")):
        for number, folder in enumerate(folders):
            task = make_task(load_bench_frame(folder), "areas", base)
            blocks = extract_blocks(task.frame)
            without = score(complete(task.frame, blocks).depth, task)
            line = f"{folder.name:26} seed {base}  {1000 * without.rmse:6.1f} {1000 * without.mae:6.1f} mm"
            other = load_bench_frame(folders[(number + len(folders) // 2) % len(folders)]).frame.depth
            found_guides = guides(task.ground_truth, other, 10 * base + number)
            if arguments.guides:
                found_guides = real_guides(arguments.guides, folder.name)
            for name, guide in found_guides:
                found = score(complete(task.frame, blocks, guide=guide).depth, task)
                ratios[name].append((found.rmse / without.rmse, found.mae / without.mae))
                line += f"  {name} {ratios[name][-1][0]:.3f} {ratios[name][-1][1]:.3f}"
            print(line, flush=True)
    print("\nErrors with a guide / without, RMSE and MAE:")
    for name, values in ratios.items():
        mean, worst = np.exp(np.mean(np.log(values), axis=0)), np.max(values, axis=0)
        print(f"{name:18} geometric mean {mean[0]:.3f} {mean[1]:.3f}  worst {worst[0]:.3f} {worst[1]:.3f}")


if __name__ == "__main__":
    main()
