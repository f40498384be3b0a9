"""Delay of cancellation: extraction, runs of the presets, expected error, and other work.

    python -m tests.bench.cancel [FRAME] [--size 1920x1080] [--only extraction best ...] [--moments 5] [--stacks]

Each kind of work is run to its end, and the longest processor time between two checks for cancellation is measured, the
worst case of a cancellation at any moment; of two runs the better one counts, because allocation is slow on machines
with little memory. Then the work is started as in the window, and cancelled at some random moments. `--stacks` prints
where the longest stretches lie.
"""

from __future__ import annotations

import argparse
import random
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PySide6.QtCore import QCoreApplication

import ilf
from gui.features.export.jobs import report_file_steps
from gui.work.jobs import Worker
from ilf._runtime.cancellation import cancellable_items, set_cancel_events
from ilf.completion.confidence.expected_error import expected_error
from ilf.completion.extrapolation import extrapolation_steps
from ilf.data.results import compose
from ilf.evaluation.quality.ranking import find_places
from ilf.report.report import ReportOptions
from ilf.report.subject import Subject
from ilf.run.options import ExportOptions
from ilf.run.writing import write
from ilf.segmentation.propagation.propagate import follow
from ilf.sources.frame_writing import write_frame

from .samples import Size, scaled, size_of
from .window import pause, wait

Work = Callable[[], object]


class CancellationMeter:
    """Stand-in for a cancellation that never comes; measures the time between two checks."""

    def __init__(self) -> None:
        self.stretches: list[tuple[float, str, str]] = []
        self._before = "the start"
        self._since = time.thread_time()

    def is_set(self) -> bool:
        """Check for cancellation."""
        self._note("".join(_where()))
        return False

    def end(self) -> None:
        """Note the end of the work."""
        self._note("the end")

    @property
    def longest(self) -> float:
        """Longest stretch between checks [s]."""
        return max(seconds for seconds, *_ in self.stretches)

    def _note(self, where: str) -> None:
        now = time.thread_time()
        self.stretches.append((now - self._since, self._before, where))
        self._before, self._since = where, time.thread_time()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("frame", nargs="?", help="a frame's folder; the bundled sample if left out")
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--moments", type=int, default=5, help="random moments at which each kind of work is cancelled")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--stacks", action="store_true", help="print where the longest stretches lie")
    given = parser.parse_args()
    cv2.setNumThreads(1)
    app = QCoreApplication([])
    make = frames(size_of(given.size), given.frame)
    chance = random.Random(given.seed)
    names = given.only or list(KINDS)
    print(f"{given.size}; longest stretch of work that cannot be cancelled, processor time [ms]; longest time from")
    print(f"cancelling until the window responds, and until the work has ended, over {given.moments} random moments, ")
    print("wall time [ms]")
    print(f"{'':16} {'stretch':>8} {'window':>8} {'over':>8}")
    for name in names:
        make_work = KINDS[name]
        _warm_up(make_work)
        meter, seconds = min((measured(make_work(make())) for _ in range(2)), key=lambda found: found[0].longest)
        moments = [chance.uniform(0.02, 0.98) * seconds for _ in range(given.moments)]
        waits = [cancelled(make_work(make()), moment) for moment in moments]
        goes_on, over = (max(times) for times in zip((0.0, 0.0), *waits, strict=True))
        times = (meter.longest, goes_on, over)
        print(f"{name:16}", *(f"{1000 * seconds:8.0f}" for seconds in times), flush=True)
        if given.stacks:
            for stretch, begin, end in sorted(meter.stretches, reverse=True)[:6]:
                print(f"  {1000 * stretch:.0f} ms\n   from {begin}\n   to   {end}")
    app.quit()


def measured(work: Work) -> tuple[CancellationMeter, float]:
    """Run some work to its end; return its checks for cancellation, and its wall time [s]."""
    meters: list[CancellationMeter] = []

    def drive() -> None:
        meter = CancellationMeter()
        meters.append(meter)
        set_cancel_events(meter)  # type: ignore[arg-type]
        try:
            work()
        finally:
            meter.end()

    begun = time.perf_counter()
    thread = threading.Thread(target=drive)
    thread.start()
    thread.join()
    return meters[0], time.perf_counter() - begun


def cancelled(work: Work, moment: float) -> tuple[float, float]:
    """Start some work as in the window and cancel it after `seconds`; return the times [s] until the window responds
    and until the work has ended."""
    worker, ended = Worker(), []

    def job() -> Generator[None, None, None]:
        yield None
        work()

    for signal in (worker.cancelled, worker.finished, worker.failed):
        signal.connect(lambda *_: ended.append(time.perf_counter()))
    threads = set(threading.enumerate())
    worker.start(job)
    (thread,) = (one for one in set(threading.enumerate()) - threads if one.name == "ilf-worker")
    pause(max(round(1000 * moment), 1))
    asked = time.perf_counter()
    worker.cancel()
    wait(lambda: ended)
    thread.join()
    return max(ended[0] - asked, 0.0), time.perf_counter() - asked


def frames(size: Size, folder: str | None = None) -> Callable[[], ilf.RGBDFrame]:
    """Make frames of this size, each without cached results."""
    frame = scaled(size, folder)
    return lambda: ilf.RGBDFrame(frame.rgb.copy(), frame.depth.copy(), frame.intrinsics)


def _run(preset: str, **values: Any) -> Callable[[ilf.RGBDFrame], Work]:
    def make(frame: ilf.RGBDFrame) -> Work:
        blocks = ilf.extract_blocks(frame)
        fresh = ilf.RGBDFrame(frame.rgb.copy(), frame.depth.copy(), frame.intrinsics)

        def work() -> None:
            with ilf.Run(fresh, blocks, ilf.preset(preset, **values)).steps(1) as run:
                for _ in cancellable_items(run):
                    pass

        return work

    return make


def _after_run(then: Callable[[ilf.RGBDFrame, np.ndarray, ilf.Completion], Work]) -> Callable[[ilf.RGBDFrame], Work]:
    def make(frame: ilf.RGBDFrame) -> Work:
        blocks = ilf.extract_blocks(frame)
        return then(frame, blocks, ilf.complete(frame, blocks, ilf.preset(correction=False), threads=1))

    return make


def _extrapolation(frame: ilf.RGBDFrame, completion: ilf.Completion) -> Work:
    def work() -> None:
        for _ in cancellable_items(extrapolation_steps(completion)):
            pass

    return work


def _export(frame: ilf.RGBDFrame, blocks: np.ndarray, completion: ilf.Completion) -> Work:
    options = ExportOptions(mesh="ply")
    expected_error(completion)

    def work() -> None:
        with tempfile.TemporaryDirectory() as folder:
            write(folder, ilf.Run(frame, blocks), completion, options)

    return work


def _report(frame: ilf.RGBDFrame, blocks: np.ndarray, completion: ilf.Completion) -> Work:
    subject = Subject(ilf.Run(frame, blocks), completion)

    def work() -> None:
        with tempfile.TemporaryDirectory() as folder:
            for _ in cancellable_items(report_file_steps(Path(folder, "report.html"), [subject], 1, ReportOptions())):
                pass

    return work


def _follow(frame: ilf.RGBDFrame) -> Work:
    blocks = ilf.extract_blocks(frame)
    moved = ilf.RGBDFrame(np.roll(frame.rgb, 9, axis=1), np.roll(frame.depth, 9, axis=1), frame.intrinsics)
    return lambda: follow(frame, blocks, moved)


def _open(frame: ilf.RGBDFrame) -> Work:
    folder = tempfile.TemporaryDirectory()
    write_frame(folder.name, frame)

    def work() -> None:
        with folder:
            ilf.load_frame(folder.name)

    return work


def _suspects(frame: ilf.RGBDFrame, blocks: np.ndarray, completion: ilf.Completion) -> None:
    find_places(frame, blocks, ilf.edge_strength(frame), expected_error(completion))


KINDS: dict[str, Callable[[ilf.RGBDFrame], Work]] = {
    "extraction": lambda frame: lambda: ilf.extract_blocks(frame),
    "best": _run("best"),
    "paper": _run("paper"),
    "released-code": _run("released-code"),
    "fill+denoise": _run("best", mode="fill+denoise"),
    "expected error": _after_run(lambda frame, blocks, completion: lambda: expected_error(completion)),
    "suspects": _after_run(lambda frame, blocks, completion: lambda: _suspects(frame, blocks, completion)),
    "guess": lambda frame: _extrapolation(frame, compose(ilf.Run(frame, np.zeros(frame.shape, int)), {})),
    "export": _after_run(_export),
    "report": _after_run(_report),
    "follow": _follow,
    "open": _open,
}


def _warm_up(make_work: Callable[[ilf.RGBDFrame], Work]) -> None:
    """Load and compile everything that is done only once, so that it is not measured."""
    make_work(scaled((160, 120)))()


def _where() -> list[str]:
    own = [entry for entry in traceback.extract_stack() if "/ilf/" in entry.filename]
    return [f"{Path(entry.filename).name}:{entry.lineno} {entry.name} < " for entry in reversed(own[-7:])]


if __name__ == "__main__":
    main()
