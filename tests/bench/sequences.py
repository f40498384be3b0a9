"""`ilf.Stream` beside the preset `best` frame by frame, over sequences of a moving camera.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python -m tests.bench.sequences FOLDER ... [--length 31] [--threads 2]

A FOLDER is a source of frames with poses; known depth is hidden in areas. For every sequence:

- mean absolute error [mm] of hidden depth, and its ratio to that of `best`; share of the hidden pixels that is filled;
- flicker: change of depth along the camera's motion between frames that are 1 and 4 apart, median over pixels and
  frames [mm]; of pixels filled in both, and of pixels measured in both;
- latency per frame: median and 95 %, wall clock and processor time, in units of 100 `scipy.fft.dctn` of a 640 x 480
  float64 array timed in the same run. "stream" is without a rate (blocks are found in line), "stream, rate" finds them
  in a thread, and gets each frame when the one before is done.
"""

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

import ilf
from ilf.evaluation.bench.frames import as_measured
from ilf.evaluation.flicker import flicker, moved
from ilf.evaluation.hold_out import frame_without
from ilf.sources.reading import read_frame

from .measuring import hundred_dcts, timed

GAPS = (1, 4)
Depth = NDArray[np.float32]


def median_flicker(frames: Sequence[ilf.RGBDFrame], depths: Sequence[Depth], gap: int, filled: bool) -> float:
    """Median change of depth [mm] along the motion between frames so far apart; of filled or of measured pixels."""
    changes = []
    for start, end, before, after in zip(frames, frames[gap:], depths, depths[gap:], strict=False):
        motion = np.linalg.inv(end.pose) @ start.pose
        index, _ = moved(before, start.intrinsics, motion)
        change = np.abs(flicker(before, after, start.intrinsics, motion))
        there = (end.known ^ filled).ravel()[np.maximum(index, 0)]
        both = (index >= 0) & (start.known ^ filled) & there & np.isfinite(change)
        if both.any():
            changes.append(float(np.median(change[both])))
    return 1000 * float(np.median(changes)) if changes else math.nan


def measure(frames: list[ilf.RGBDFrame], complete: Callable[[ilf.RGBDFrame], ilf.Completion]) -> list[float]:
    """Complete a sequence without some areas; return error, share that is filled, flicker and latencies."""
    unit = min(timed(hundred_dcts)[0] for _ in range(3))
    # copies have no results of the method before in their cache
    hidden = [replace(frame_without(frame, "areas"), pose=frame.pose) for frame in frames]
    depths, times, errors, shares = [], [], [], []
    for frame, truth in zip(hidden, frames, strict=True):
        seconds, completion = timed(lambda frame=frame: complete(frame))
        off = np.abs(completion.depth - truth.depth)[~frame.known & truth.known]
        depths.append(completion.depth)
        times.append(seconds)
        errors.append(1000 * np.nanmean(off))
        shares.append(np.isfinite(off).mean())
    shaking = [median_flicker(hidden, depths, gap, filled) for filled in (True, False) for gap in GAPS]
    wall, processor = (np.array(times)[1:, clock] / unit[clock] for clock in (0, 1))
    latency = [value for one in (wall, processor) for value in (np.median(one), np.quantile(one, 0.95))]
    return [float(np.mean(errors)), float(np.mean(shares)), *shaking, *latency]


def show(name: str, frames: list[ilf.RGBDFrame], threads: int) -> None:
    """Complete a sequence by all methods, and print a line for each."""
    with ilf.Stream(threads=threads) as in_line, ilf.Stream(threads=threads, rate=10) as with_rate:
        methods = {
            "best": lambda frame: ilf.complete(frame, threads=threads),
            "stream": in_line.complete,
            "stream, rate": with_rate.complete,
        }
        first = math.nan
        for method, complete in methods.items():
            error, share, *rest = measure(frames, complete)
            first = error if math.isnan(first) else first
            flickers, latencies = "".join(f"{one:8.1f}" for one in rest[:4]), "".join(f"{one:7.2f}" for one in rest[4:])
            print(f"{name:10} {method:12} {error:7.1f} {error / first:6.2f} {share:7.1%}{flickers}{latencies}")


def main() -> None:
    """Measure the sequences."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequences", nargs="+", type=Path, metavar="FOLDER")
    parser.add_argument("--length", type=int, default=31)
    parser.add_argument("--threads", type=int, default=2)
    given = parser.parse_args()
    cv2.setNumThreads(given.threads)
    print(
        f"{'':23} {'MAE':>7} {'ratio':>6} {'filled':>7}{'flicker of filled':>16}{'of measured':>16}"
        f"{'wall':>14}{'processor':>14}\n{'':46}"
        + "".join(f"{f'{gap} apart':>8}" for gap in (*GAPS, *GAPS))
        + "".join(f"{what:>7}" for what in ("median", "95 %", "median", "95 %"))
    )
    for folder in given.sequences:
        source = ilf.open_source(folder)
        frames = [as_measured(read_frame(source.ref(key))) for key in source.keys[: given.length]]
        show(folder.name, frames, given.threads)


if __name__ == "__main__":
    main()
