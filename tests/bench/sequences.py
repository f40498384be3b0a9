"""`python -m tests.bench.sequences`: `ilf.Stream` beside the preset `best` frame by frame, over sequences.

    OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 python -m tests.bench.sequences [orbit dolly hand moving FOLDER ...]
        [--length 31] [--size 640x480] [--threads 2] [--cache FOLDER]

The generated room is rendered with a camera that orbits, moves forward, or is held in a hand, and with a moving box;
a picture takes 7 s and stays in --cache. A FOLDER is a source of frames with poses; of these, known depth is hidden in
areas. For every sequence:

- mean absolute error [mm] of missing pixels against exact depth, or of hidden depth; share of them that is filled;
- flicker: change of depth along the exact motion, beyond that of the scene, between frames that are 1 and 4 apart,
  median over pixels and frames [mm]; of pixels filled in both, and of pixels measured in both;
- latency per frame: median and 95 %, wall clock and processor time, in units of 100 `scipy.fft.dctn` of a 640 x 480
  float64 array timed in the same run. "stream" is without a rate (blocks are found in line), "stream, rate" finds them
  in a thread, and gets each frame when the one before is done.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

import ilf
from ilf.evaluation.bench.frames import as_measured
from ilf.evaluation.flicker import flicker, moved
from ilf.evaluation.hold_out import frame_without

from .pipeline import hundred_dcts, timed
from .propagation.sequences import PATHS, Moment, rendered

GAPS = (1, 4)
Depth = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class Completed:
    """A sequence completed by one method: depth [m], and wall clock and processor time [s] of every frame."""

    depths: list[Depth]
    times: list[list[float]]


def completed(frames: Sequence[ilf.RGBDFrame], complete: Callable[[ilf.RGBDFrame], ilf.Completion]) -> Completed:
    """Complete all frames."""
    found = Completed([], [])
    for frame in frames:
        seconds, completion = timed(lambda frame=frame: complete(frame))
        found.depths.append(completion.depth)
        found.times.append(seconds)
    return found


def real(folder: str) -> list[Moment]:
    """The frames of a source with poses."""
    none = np.zeros((1, 1), np.int32)
    return [Moment(frame, none, none, np.linalg.inv(frame.pose)) for frame in map(as_measured, ilf.open_source(folder))]


def scaled(moment: Moment, width: int, height: int) -> Moment:
    """A moment at another size."""
    frame = moment.frame
    if frame.shape == (height, width):
        return moment
    rgb = cv2.resize(frame.rgb, (width, height), interpolation=cv2.INTER_AREA)
    depth, exact = (
        None if values is None else cv2.resize(values, (width, height), interpolation=cv2.INTER_NEAREST)
        for values in (frame.depth, moment.exact)
    )
    factor = width / frame.shape[1]
    camera = frame.intrinsics
    near = ilf.CameraIntrinsics(
        camera.fx * factor, camera.fy * factor, (camera.cx + 0.5) * factor - 0.5, (camera.cy + 0.5) * factor - 0.5
    )
    return replace(moment, frame=ilf.RGBDFrame(rgb, depth, near, frame.name, pose=frame.pose), exact=exact)


def median_flicker(moments: Sequence[Moment], depths: Sequence[Depth], gap: int, filled: bool) -> float:
    """Median change of depth [mm] along the exact motion between frames so far apart; of filled or of measured
    pixels."""
    changes = []
    for start, end, before, after in zip(moments, moments[gap:], depths, depths[gap:], strict=False):
        camera, motion = start.frame.intrinsics, end.pose @ np.linalg.inv(start.pose)
        index, there = moved(before if start.exact is None else start.exact, camera, motion)
        seen = index >= 0
        at = np.maximum(index, 0)
        if start.exact is None:
            change = np.abs(flicker(before, after, camera, motion))
        else:
            exact = end.exact.ravel()[at]
            seen &= np.abs(exact - there) < 0.015 * there
            change = np.abs((after.ravel()[at] - exact) - (before - start.exact))
        both = seen & (start.frame.known ^ filled) & (end.frame.known ^ filled).ravel()[at] & np.isfinite(change)
        if both.any():
            changes.append(float(np.median(change[both])))
    return 1000 * float(np.median(changes)) if changes else math.nan


def show(name: str, moments: list[Moment], threads: int) -> None:
    """Complete a sequence by all methods, and print a line for each."""
    frames = [moment.frame for moment in moments]
    truths = [moment.frame.depth if moment.exact is None else moment.exact for moment in moments]
    if moments[0].exact is None:
        frames = [frame_without(frame, "areas") for frame in frames]
        moments = [replace(moment, frame=frame) for moment, frame in zip(moments, frames, strict=True)]
    with ilf.Stream(threads=threads) as in_line, ilf.Stream(threads=threads, rate=10) as with_rate:
        methods = {
            "best": lambda frame: ilf.complete(frame, threads=threads),
            "stream": in_line.complete,
            "stream, rate": with_rate.complete,
        }
        first = math.nan
        for method, complete in methods.items():
            unit = min(timed(hundred_dcts)[0] for _ in range(3))
            found = completed([replace(frame, depth=frame.measured) for frame in frames], complete)
            errors, shares = [], []
            for depth, frame, truth in zip(found.depths, frames, truths, strict=True):
                asked = ~frame.known & np.isfinite(truth)
                off = np.abs(depth - truth)[asked]
                errors.append(1000 * np.nanmean(off))
                shares.append(np.isfinite(off).mean())
            error = float(np.mean(errors))
            first = error if math.isnan(first) else first
            shaking = [median_flicker(moments, found.depths, gap, filled) for filled in (True, False) for gap in GAPS]
            wall, processor = (np.array(found.times)[1:, clock] / unit[clock] for clock in (0, 1))
            print(
                f"{name:10} {method:12} {error:7.1f} {error / first:6.2f} {np.mean(shares):7.1%}"
                + "".join(f"{one:8.1f}" for one in shaking)
                + "".join(f"{np.median(one):7.2f}{np.quantile(one, 0.95):7.2f}" for one in (wall, processor)),
                flush=True,
            )


def main() -> None:
    """Measure the sequences."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequences", nargs="*", default=["orbit", "dolly", "hand", "moving"])
    parser.add_argument("--length", type=int, default=31)
    parser.add_argument("--size", default="640x480")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--cache", type=Path, default=Path(tempfile.gettempdir()) / "ilf-sequences")
    given = parser.parse_args()
    cv2.setNumThreads(given.threads)
    width, height = map(int, given.size.split("x"))
    print(
        f"{'':23} {'MAE':>7} {'ratio':>6} {'filled':>7}{'flicker of filled':>16}{'of measured':>16}"
        f"{'wall':>14}{'processor':>14}\n{'':46}"
        + "".join(f"{f'{gap} apart':>8}" for gap in (*GAPS, *GAPS))
        + "".join(f"{what:>7}" for what in ("median", "95 %", "median", "95 %"))
    )
    for name in given.sequences:
        begun = time.monotonic()
        moments = rendered(name, given.cache, given.length) if name in PATHS else real(name)
        show(Path(name).name, [scaled(moment, width, height) for moment in moments[: given.length]], given.threads)
        print(f"{'':10} {time.monotonic() - begun:.0f} s")


if __name__ == "__main__":
    main()
