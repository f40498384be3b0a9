"""Cost of the autosave per brush stroke: bytes written, time of the window's thread, time until it is stored.

    QT_QPA_PLATFORM=offscreen python -m tests.bench.autosave [FRAME] [--strokes 200] [--run]

The frame is scaled to 1920 x 1080 first. Bytes are counted as the process writes them (/proc/self/io), including those
that a journal moves from its log into its file. With --run, blocks have results, which strokes invalidate.
"""

from __future__ import annotations

import argparse
import itertools
import json
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from PySide6.QtWidgets import QApplication

from gui.app.main_window import MainWindow
from gui.project.recorder import Recorder
from ilf._runtime.installation import asset_path
from ilf.segmentation.editing.painting import brush_stroke, paint
from ilf.sources.frame_source import FrameSource
from ilf.sources.frames import load_frame

from .waiting import pause, wait

_SIZE = 1920, 1080
_RADIUS = 14.0
_MOVES = 12


class _Clock:
    """Sums the time of methods: thread time, and wall clock including waits for other threads."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Reset the times."""
        self.work_ms = self.passed_ms = 0.0

    def watch(self, method: Callable[..., Any]) -> Callable[..., Any]:
        """Return the method with timing."""

        def timed(*arguments: Any) -> Any:
            work, passed = time.thread_time(), time.perf_counter()
            try:
                return method(*arguments)
            finally:
                self.work_ms += (time.thread_time() - work) * 1000
                self.passed_ms += (time.perf_counter() - passed) * 1000

        return timed


def main() -> None:
    """Make strokes, and print the cost of each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("frame", nargs="?", default=str(asset_path("samples/room")))
    parser.add_argument("--strokes", type=int, default=200)
    parser.add_argument("--run", action="store_true")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.environ["ILF_AUTOSAVE"] = str(Path(folder, "autosave"))
        app = QApplication([])
        clock = _watched()
        window = MainWindow(persistent=True)
        window.documents.discard_silently = True
        kept: list[float] = []
        window.recorder.kept.connect(lambda: kept.append(time.perf_counter()))
        window.show()
        window.loader.open(FrameSource(str(_large(options.frame, Path(folder, "frame")))))
        wait(lambda: not window.loader.busy and kept)
        if options.run:
            window.runs.start()
            wait(lambda: window.runs.free)
        pause(2000)
        _measure(window, Path(folder, "autosave"), options.strokes, clock, kept)
        window.close()
        app.processEvents()


def _watched() -> _Clock:
    """Time everything that the recorder does in the window's thread."""
    clock = _Clock()
    for name in ("_take", "_note_touched", "_finish"):
        setattr(Recorder, name, clock.watch(getattr(Recorder, name)))
    return clock


def _measure(window: MainWindow, folder: Path, strokes: int, clock: _Clock, kept: list[float]) -> None:
    random = np.random.default_rng(0)
    workspace = window.workspace
    session = workspace.session
    height, width = session.frame.shape
    written, worked, passed, late, sizes = [], [], [], [], []
    for _ in range(strokes):
        block = int(random.choice(list(session.counts())))
        at = random.uniform(0, [width, height])
        points = [at := at + random.normal(0, 15, 2) for _ in range(_MOVES)]
        kept.clear()
        clock.begin()
        before = _written()
        for one, next_one in itertools.pairwise(points):
            stroke = brush_stroke(session.frame.shape, np.array([one, next_one]), _RADIUS)
            if stroke is not None:
                workspace.blocks.stroke(paint(session.labels, stroke, block))
        begun = time.perf_counter()
        if workspace.blocks.end_stroke("Paint") is None:
            continue
        wait(lambda: kept)
        late.append((kept[0] - begun) * 1000)
        worked.append(clock.work_ms)
        passed.append(clock.passed_ms)
        written.append((_written() - before) / 1000)
        sizes.append(sum(path.stat().st_size for path in folder.iterdir()) / 1e6)
    print(f"{session.name}, {width} x {height}, {len(session.counts())} blocks, {len(written)} strokes")
    _tell("written [kB]", written)
    _tell("window's thread, own time [ms]", worked)
    _tell("window's thread, with waits for other threads [ms]", passed)
    _tell("kept after [ms]", late)
    print(f"files [MB]: {sizes[len(sizes) // 10]:.1f} after a tenth of them, {sizes[-1]:.1f} at the end")


def _tell(what: str, values: list[float]) -> None:
    low, high = np.percentile(values, [50, 95])
    print(f"{what}: mean {np.mean(values):.2f}, median {low:.2f}, 95 % {high:.2f}, maximum {max(values):.2f}")


def _written() -> int:
    """Return the bytes that the process has written so far."""
    lines = Path("/proc/self/io").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("wchar"))


def _large(source: str, folder: Path) -> Path:
    """Write the frame at 1920 x 1080 to files."""
    frame = load_frame(source)
    folder.mkdir()
    colour = cv2.resize(frame.rgb, _SIZE, interpolation=cv2.INTER_CUBIC)
    depth = cv2.resize(frame.depth, _SIZE, interpolation=cv2.INTER_NEAREST)
    cv2.imwrite(str(folder / "rgb.png"), colour[..., ::-1])
    cv2.imwrite(str(folder / "depth.png"), np.nan_to_num(depth * 1000).round().astype(np.uint16))
    camera = frame.intrinsics
    scale = np.array([_SIZE[0] / frame.shape[1], _SIZE[1] / frame.shape[0]] * 2)
    numbers = None if camera is None else list([camera.fx, camera.fy, camera.cx, camera.cy] * scale)
    meta = {
        "name": frame.name,
        "size": _SIZE,
        "depth_units_per_m": 1000,
        "K": None if camera is None else list(numbers),
    }
    (folder / "meta.json").write_text(json.dumps(meta))
    return folder


if __name__ == "__main__":
    main()
