"""How much faster the iteration in the pass band is than the same loop on the full grid, in one run.

python tests/bench/pass_band.py [--iterations 1500]
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import ilf
from ilf.blocks import find_blocks
from ilf.filter.iteration import BlockIteration
from tests.reference.full_grid import FullGridIteration

HEIGHT, WIDTH, DEFECT = 540, 960, 0.4277


def cap() -> ilf.RGBDFrame:
    """A curved cap of 2.6 x 1.2 m at 2 m with a continuous defect along x."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    across, down = 1.3 * (2 * columns / WIDTH - 1), 0.6 * (2 * rows / HEIGHT - 1)
    depth = 2.0 - 0.5 * np.sqrt(1.45**2 - across**2 - down**2)
    width = int(DEFECT * WIDTH)
    depth[:, (WIDTH - width) // 2 : (WIDTH + width) // 2] = np.nan
    rgb = np.random.default_rng(0).integers(0, 255, (HEIGHT, WIDTH, 3), dtype=np.uint8)
    return ilf.RGBDFrame(rgb, depth)


def main() -> None:
    """Print a table of seconds, ratios and differences."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--iterations", type=int, default=1500)
    limit = parser.parse_args().iterations
    frame = cap()
    block = find_blocks(np.ones(frame.shape, np.int32))[1]
    print("preset         precision  iterations  full grid [s]  pass band [s]  ratio  largest difference [m]")
    for name in ("released-code", "paper"):
        parameters = ilf.preset(name, max_iterations=limit)
        full, full_seconds, _ = _timed(FullGridIteration(frame, block, parameters))
        for precision in ("float64", "float32"):
            fast, seconds, count = _timed(BlockIteration(frame, block, parameters.replace(precision=precision)))
            print(
                f"{name:<14} {precision:<10} {count:>10} {full_seconds:>14.2f} {seconds:>14.3f} "
                f"{full_seconds / seconds:>6.1f} {np.abs(full - fast).max():>23.1e}"
            )


def _timed(steps: BlockIteration | FullGridIteration) -> tuple[np.ndarray, float, int]:
    start = time.perf_counter()
    count = sum(1 for _ in steps)
    return steps.surface, time.perf_counter() - start, count


if __name__ == "__main__":
    main()
