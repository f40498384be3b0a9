"""Speed of the iteration in the pass band, compared with the same loop on the full grid, in one run.

python -m tests.bench.pass_band [--iterations 1500] [--repeat 5] [--size 960x540]

Seconds are processor time, and the runs in the pass band alternate with parts of the loop on the full grid, so that
other load on the machine affects both alike. The set-up of a block is not part of the loop and has a separate column.
"""

from __future__ import annotations

import argparse
import itertools
import math
import statistics
import time
from collections import deque

import numpy as np

import ilf
from ilf.completion.pass_band.iteration import PassBandIteration
from ilf.data.label_map import Block, find_blocks
from tests.reference.full_grid import FullGridIteration

from .samples import Size, size_of

DEFECT = 0.4277
Run = tuple[np.ndarray, float, float, int]
"""Surface, seconds of the loop in the pass band, seconds before it, and the number of iterations."""


def cap(size: Size) -> ilf.RGBDFrame:
    """A curved cap of 2.6 x 1.2 m at 2 m with a continuous defect along x."""
    width, height = size
    rows, columns = np.mgrid[:height, :width]
    across, down = 1.3 * (2 * columns / width - 1), 0.6 * (2 * rows / height - 1)
    depth = 2.0 - 0.5 * np.sqrt(1.45**2 - across**2 - down**2)
    missing = int(DEFECT * width)
    depth[:, (width - missing) // 2 : (width + missing) // 2] = np.nan
    rgb = np.random.default_rng(0).integers(0, 255, (height, width, 3), dtype=np.uint8)
    return ilf.RGBDFrame(rgb, depth)


def main() -> None:
    """Print a table of seconds, ratios and differences."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--iterations", type=int, default=1500)
    parser.add_argument("--repeat", type=int, default=5, help="number of runs in the pass band; the median counts")
    parser.add_argument("--size", default="960x540")
    arguments = parser.parse_args()
    limit, repeat = arguments.iterations, arguments.repeat
    frame = cap(size_of(arguments.size))
    block = find_blocks(np.ones(frame.shape, np.int32))[1]
    print(
        "preset         precision  iterations  full grid [s]  pass band [s]  set up [s]  ratio  largest difference [m]"
    )
    for name in ("released-code", "paper"):
        parameters = ilf.preset(name, max_iterations=limit)
        reference, full_seconds = FullGridIteration(frame, block, parameters), 0.0
        runs: dict[str, list[Run]] = {"float64": [], "float32": []}
        for _ in range(repeat):
            start = time.process_time()
            deque(itertools.islice(reference, math.ceil(limit / repeat)), maxlen=0)
            full_seconds += time.process_time() - start
            for precision, done in runs.items():
                done.append(_run(frame, block, parameters.replace(precision=precision)))
        for precision, done in runs.items():
            seconds, setup = (statistics.median(run[k] for run in done) for k in (1, 2))
            difference = np.abs(reference.surface - done[0][0]).max()
            print(
                f"{name:<14} {precision:<10} {done[0][3]:>10} {full_seconds:>14.2f} {seconds:>14.3f} {setup:>11.3f} "
                f"{full_seconds / seconds:>6.1f} {difference:>23.1e}"
            )


def _run(frame: ilf.RGBDFrame, block: Block, parameters: ilf.Parameters) -> Run:
    start = time.process_time()
    steps = PassBandIteration(frame, block, parameters)
    ready = time.process_time()
    count = sum(1 for _ in steps)
    return steps.surface, time.process_time() - ready, ready - start, count


if __name__ == "__main__":
    main()
