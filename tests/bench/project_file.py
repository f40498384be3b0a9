"""`python -m tests.bench.project_file`: time to open and save a project of many edited and completed frames.

Every frame has its own files, hand-edited blocks, results of all of them, and a stored run. The frames are variants of
the bundled sample (640 x 480), each with other noise in its depth, so that they share no parts except by chance.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import ilf
from ilf._runtime.installation import asset_path
from ilf.data.frame import RGBDFrame
from ilf.data.results import BlockResult, Completion
from ilf.io.depth import write_depth
from ilf.project.encoding import Encoder
from ilf.project.file import open_project, save_project
from ilf.project.frame_state import BlockInfo, BlockNotes, FrameState
from ilf.project.project import FrameSummary, Project, ProjectFrame, Stage
from ilf.project.run_history import StoredRun
from ilf.run.run import Run
from ilf.sources.frame_source import FrameSource
from ilf.sources.reading_options import ReadingOptions

TIMES = 5


def main() -> None:
    """Make the project, and print the times that a user waits."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=200)
    count = parser.parse_args().frames
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = folder / "bench.ilf"
        states, listed = _made(folder, count)
        base = states[0]
        seconds, _ = _timed(lambda: save_project(path, Project(tuple(listed)), states))
        states.clear()
        with open_project(path) as opened:
            print(f"{count} frames, {path.stat().st_size / 1e6:.1f} MB in {len(opened.parts.names())} parts")
        print(f"first save of everything: {seconds:.2f} s")
        times = [_timed(lambda: _opened(path, listed[0].id))[0] for _ in range(TIMES)]
        print(f"open the list and the first frame: {_words(times)}")
        times = [_timed(lambda: open_project(path).close())[0] for _ in range(TIMES)]
        print(f"of that, the list: {_words(times)}")
        times = []
        for number in range(TIMES):
            labels = base.labels.copy()
            labels[40 : 60 + number, 30:50] = 1
            changed = replace(base, labels=labels)
            with open_project(path) as opened:
                times.append(
                    _timed(
                        lambda changed=changed, opened=opened: save_project(
                            path, opened.project, [changed], base=[opened.parts], places=opened.places
                        )
                    )[0]
                )
        print(f"save after one edit: {_words(times)}")
        with open_project(path) as opened:
            found = opened.state(listed[0].id)
            encoder = Encoder()
            encoder.learn(found.origins, found.names)
            labels = found.state.labels.copy()
            labels[10:30, 10:60] = 2
            seconds, encoded = _timed(lambda: encoder.encode(replace(found.state, labels=labels)))
        size = sum(map(len, encoded.arrays.values()))
        print(f"encode one stroke: {1000 * seconds:.0f} ms, {(size + len(encoded.frame)) / 1000:.0f} kB")
        print(f"largest memory: {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


def _made(folder: Path, count: int) -> tuple[list[FrameState], list[ProjectFrame]]:
    """Make states of variants of the sample; their files are written into a folder."""
    sample = asset_path("samples/room")
    frame = ilf.load_frame(sample)
    run = Run.of(frame)
    completion = run.complete()
    rng = np.random.default_rng(0)
    states, listed = [], []
    for number in range(count):
        own = folder / "frames" / f"{number:04}"
        own.mkdir(parents=True)
        shutil.copy(sample / "rgb.jpg", own)
        noise = rng.normal(0, 0.003, frame.shape).astype(np.float32)
        write_depth(own / "depth.png", frame.measured + noise, units=1000)
        variant = ilf.load_frame(own / "rgb.jpg", own / "depth.png", depth_units=1000, intrinsics=frame.intrinsics)
        states.append(_state(variant, run, completion, noise, f"{number:04x}"))
        summary = FrameSummary(
            Stage.RUN, shape=frame.shape, missing=frame.missing_share, blocks=len(completion.results)
        )
        source = FrameSource(str(own / "rgb.jpg"), str(own / "depth.png"), options=ReadingOptions(depth_units=1000.0))
        listed.append(ProjectFrame(states[-1].id, own.name, source, summary, True))
    return states, listed


def _state(frame: RGBDFrame, run: Run, completion: Completion, noise: Any, frame_id: str) -> FrameState:
    labels = run.blocks.copy()
    top, left = np.random.default_rng(int(frame_id, 16)).integers(0, 300, 2)
    labels[top : top + 40, left : left + 60] = labels.max()
    results = {label: _moved(result, frame, noise) for label, result in completion.results.items()}
    own = replace(run, frame=frame, blocks=labels, edited=True)
    notes = BlockNotes(
        {label: BlockInfo(f"Block {label}", (1, 2, 3)) for label in results},
        extraction=run.extraction,
        network=run.network,
        extracted=run.blocks,
    )
    return FrameState(
        frame_id, frame, own.blocks, notes, results=results, runs=(StoredRun(1, "best", own, results, 1.0, (1, 2, 3)),)
    )


def _moved(result: BlockResult, frame: RGBDFrame, noise: Any) -> BlockResult:
    """Return the result with other noise: known depth is that of the frame."""
    box, mask = result.block.box, result.block.mask
    known = frame.measured[box][mask]
    return replace(result, depth=np.where(np.isfinite(known), known, result.depth + noise[box][mask]))


def _opened(path: Path, frame_id: str) -> None:
    with open_project(path) as opened:
        assert not opened.state(frame_id).problems


def _timed(do: Callable[[], Any]) -> tuple[float, Any]:
    started = time.perf_counter()
    result = do()
    return time.perf_counter() - started, result


def _words(times: list[float]) -> str:
    return f"{np.median(times):.2f} s (median of {len(times)}, maximum {max(times):.2f} s)"


if __name__ == "__main__":
    main()
