"""Time and memory of all steps of a frame: edges, blocks, completion, expected error, and one block solved again.

    python -m tests.bench.pipeline [FRAME] [--sizes 640x480 3840x2160] [--threads 1 2] [--rounds 5]

Every size and number of threads is measured in a separate process, after a warm-up on the frame at 160 x 120. Times are
wall clock and processor time [s], the minimum of all rounds, also as ratios to 100 `scipy.fft.dctn` of a 640 x 480
float64 array with one thread, timed between the rounds of the same run. The peak is the process's peak memory. "depth"
is a hash of depth and expected error, which for one size must be the same for any number of threads. "block again" is
the work for one step of a slider: 200 x 200 px, another value of the filter, one thread.
"""

import argparse
import hashlib
import json
import os
import resource
import subprocess
import sys
from functools import partial

import cv2
import numpy as np

import ilf
from ilf._runtime.compiling import is_compiled

from .measuring import hundred_dcts, timed
from .samples import Size, scaled, size_of

PARTS = ("edges", "blocks", "completion", "error", "block again")
STEPS = PARTS[:4]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frame", nargs="?", help="a frame's folder; the bundled sample if left out")
    parser.add_argument("--sizes", nargs="+", default=["640x480", "3840x2160"])
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--child", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        print(json.dumps(_measured(given.frame, size_of(given.sizes[0]), given.threads[0], given.rounds)))
        return
    for size in given.sizes:
        for threads in given.threads:
            _show(size, threads, _in_a_process_of_its_own(given.frame, size, threads, given.rounds))


def _in_a_process_of_its_own(frame: str | None, size: str, threads: int, rounds: int) -> dict[str, object]:
    command = [sys.executable, "-m", "tests.bench.pipeline", *([frame] if frame else []), "--child"]
    command += ["--sizes", size, "--threads", str(threads), "--rounds", str(rounds)]
    alone = {name: str(threads) for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
    run = subprocess.run(command, env={**os.environ, **alone}, stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(run.stdout.splitlines()[-1])


def _show(size: str, threads: int, found: dict) -> None:
    machine = "machine code" if found["compiled"] else "numpy"
    print(
        f"{size}, {threads} thread{'s' * (threads > 1)}, inner loops in {machine}: peak {found['peak']:.0f} MB, "
        f"100 DCTs {found['dct'][0]:.3f} s, depth {found['hash']}"
    )
    print(f"    {'':12} {'wall [s]':>9} {'ratio':>7} {'processor':>10} {'ratio':>7}")
    rows = {name: found["times"][name] for name in PARTS}
    rows["all steps"] = [sum(found["times"][name][clock] for name in STEPS) for clock in (0, 1)]
    yard, processor_yard = found["dct"]
    for name, (wall, processor) in rows.items():
        print(f"    {name:12} {wall:9.3f} {wall / yard:7.2f} {processor:10.3f} {processor / processor_yard:7.2f}")


def _measured(folder: str | None, size: Size, threads: int, rounds: int) -> dict[str, object]:
    cv2.setNumThreads(threads)
    _steps(scaled((160, 120), folder), threads)
    found, yards = [], []
    for _ in range(rounds):
        yards.append(timed(hundred_dcts)[0])
        new = scaled(size, folder)
        times, depths = _steps(new, threads)
        found.append(times | {"block again": _block_again(new)})
    return {
        "times": {name: [min(times[name][clock] for times in found) for clock in (0, 1)] for name in PARTS},
        "dct": [min(clocks) for clocks in zip(*yards, strict=True)],
        "peak": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
        "hash": hashlib.sha256(depths).hexdigest()[:12],
        "compiled": is_compiled(),
    }


def _steps(frame: ilf.RGBDFrame, threads: int) -> tuple[dict[str, list[float]], bytes]:
    """Return the times of all steps of a frame, and its depth and expected error."""
    times = {}
    times["edges"] = timed(lambda: ilf.edge_strength(frame))[0]
    times["blocks"], blocks = timed(lambda: ilf.extract_blocks(frame))
    times["completion"], result = timed(lambda: ilf.complete(frame, blocks, threads=threads))
    times["error"], error = timed(lambda: ilf.expected_error(result))
    return times, result.depth.tobytes() + error.tobytes()


def _block_again(frame: ilf.RGBDFrame) -> list[float]:
    """Return the time of a block of 200 x 200 px that is solved with another value of the filter."""
    height, width = frame.shape
    one = np.zeros(frame.shape, np.int32)
    top, left = height // 2 - 100, width // 2 - 100
    one[max(top, 0) : top + 200, max(left, 0) : left + 200] = 1
    ilf.complete(frame, one, threads=1)
    return timed(partial(ilf.complete, frame, one, ilf.preset(noise=0.004), threads=1))[0]


if __name__ == "__main__":
    main()
