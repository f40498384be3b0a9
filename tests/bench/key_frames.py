"""Cost of key frames for a run: time and memory.

    python -m tests.bench.key_frames FRAME [PRESET ...]

Every preset is run alternately with and without key frames, in one thread; the median ratio of processor time counts.
"""

from __future__ import annotations

import statistics
import sys
import time

import ilf
from ilf.run.key_frames import KeyFrames
from ilf.run.run import Run

_TURNS = 11


def _seconds(run: Run, key_frames: KeyFrames | None) -> tuple[float, int]:
    """Return the processor time of a run [s], and its iterations."""
    begun = time.process_time()
    count = 0
    with run.steps(1, None if key_frames is None else key_frames.watch(run)) as steps:
        for progress in steps:
            count += progress.record is not None
    return time.process_time() - begun, count


def main(folder: str, presets: list[str]) -> None:
    """Print a line for every preset."""
    frame = ilf.load_frame(folder)
    blocks = ilf.extract_blocks(frame)
    for name in presets:
        run = Run(frame, blocks, ilf.preset(name))
        _seconds(run, None)  # warm-up: edges are cached, code is compiled
        ratios, plain, watched = [], [], []
        for _ in range(_TURNS):
            key_frames = KeyFrames()  # frees those of the previous turn
            plain.append(_seconds(run, None)[0])
            seconds, count = _seconds(run, key_frames)
            watched.append(seconds)
            ratios.append(seconds / plain[-1])
        print(
            f"{name}: {count} iterations, {min(plain):.3f} s without, {min(watched):.3f} s with key frames; "
            f"median ratio {statistics.median(ratios):.4f}, of the best {min(watched) / min(plain):.4f}; "
            f"{key_frames.nbytes / 2**20:.1f} MiB, one of {max(track.stride for track in key_frames._tracks)} kept"
        )


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:] or ["best", "paper", "released-code"])
