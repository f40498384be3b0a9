"""How many times as fast the iteration in the pass band is as the same loop on the full grid.

    python -m tests.bench.pass_band [--sizes 480x270 960x540] [--precisions float64 float32] [--iterations 1500]

The bundled sample in each size is one block with the preset `released-code`. Both loops run in turns, by one thread,
after a first run that compiles; times are the least of all rounds, the difference is that of the last surfaces.
"""

import argparse

import cv2
import numpy as np

import ilf
from ilf.completion.pass_band.iteration import PassBandIteration
from ilf.data.blocks import find_blocks
from tests.reference.full_grid import FullGridIteration

from .measuring import timed
from .samples import scaled, size_of

_ROW = "{:>8} {:>9} {:>14} {:>14} {:>7} {:>16}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0], allow_abbrev=False)
    parser.add_argument("--sizes", nargs="+", default=["480x270", "960x540"])
    parser.add_argument("--precisions", nargs="+", default=["float64", "float32"])
    parser.add_argument("--iterations", type=int, default=1500)
    parser.add_argument("--rounds", type=int, default=2)
    given = parser.parse_args()
    cv2.setNumThreads(1)
    print(_ROW.format("size", "precision", "pass band [s]", "full grid [s]", "times", "difference [m]"))
    for size in given.sizes:
        frame = scaled(size_of(size))
        (block,) = find_blocks(np.ones(frame.shape, np.int32)).values()
        for precision in given.precisions:
            parameters = ilf.preset("released-code", max_iterations=given.iterations, precision=precision)
            ways = PassBandIteration, FullGridIteration
            _run(PassBandIteration, frame, block, parameters)
            rounds = [[_run(way, frame, block, parameters) for way in ways] for _ in range(given.rounds)]
            fast, full = (min(times[way][0] for times in rounds) for way in (0, 1))
            difference = np.nanmax(np.abs(np.subtract(*(surface for _, surface in rounds[-1]))))
            print(_ROW.format(size, precision, f"{fast:.3f}", f"{full:.2f}", f"{full / fast:.0f}", f"{difference:.1e}"))


def _run(way, frame, block, parameters):
    """Wall clock of all iterations, after their set-up [s], and the last surface [m]."""
    iteration = way(frame, block, parameters)
    (seconds, _), _ = timed(lambda: [None for _ in iteration])
    return seconds, np.asarray(iteration.surface)


if __name__ == "__main__":
    main()
