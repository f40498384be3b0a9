"""`python -m tests.bench.stream_soak [--frames 10000] [--size 80x60] [--rate 10]`: a stream must leave nothing behind.

Views of the bundled room that move by a pixel a frame, with a cut every 500 frames, are streamed. After a tenth of the
frames and at the end, memory is measured, and threads and open files are counted.
"""

from __future__ import annotations

import argparse
import os
import sys
import threading

import numpy as np

import ilf

from .memory import in_use
from .samples import scaled, size_of

_CUT = 500


def left() -> tuple[int, int]:
    """Number of threads and of open files."""
    return threading.active_count(), len(os.listdir("/proc/self/fd"))


def main() -> None:
    """Stream, and report what has grown."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=10_000)
    parser.add_argument("--size", default="80x60")
    parser.add_argument("--rate", type=float, help="with a thread that finds blocks; in line if left out")
    parser.add_argument("--limit", type=float, default=30.0, help="largest growth of memory [MB]")
    given = parser.parse_args()
    width, height = size_of(given.size)
    room = scaled((2 * width, height))
    rgb, depth = room.rgb, room.depth.copy()
    depth[height // 3 : height // 2, :: width // 2] = np.nan
    first = max(given.frames // 10, 1)
    with ilf.Stream(rate=given.rate) as stream:
        for number in range(1, given.frames + 1):
            move = number % (2 * width)
            at = min(move, 2 * width - move)
            seen = np.s_[:, at : at + width] if number // _CUT % 2 else np.s_[::-1, at : at + width]
            stream.complete(ilf.RGBDFrame(rgb[seen].copy(), depth[seen]))
            if number == first:
                before, memory = left(), in_use()
            if number % first == 0:
                print(f"{number} frames: {in_use():.0f} MB, {stream.statistics}", flush=True)
        after, growth = left(), in_use() - memory
    print(f"memory has grown by {growth:.1f} MB; threads and files: {before} -> {after}, at the end {left()}")
    sys.exit(growth > given.limit or before != after)


if __name__ == "__main__":
    main()
