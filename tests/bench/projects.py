"""`python -m tests.bench.projects [--frames 200] [--of FOLDER]`: time to open and save a project of many edited frames
in the real window, and the longest time that the window is blocked."""

from __future__ import annotations

import argparse
import dataclasses
import os
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import cv2
import numpy as np
from PySide6.QtCore import QCoreApplication, QSettings, QTimer
from PySide6.QtWidgets import QApplication

import ilf
from gui.app.main_window import MainWindow
from gui.features.project.saving import SaveRequest
from ilf._runtime.installation import asset_path
from ilf.data.results import BlockResult
from ilf.project.file import save_project
from ilf.project.frame_state import BlockInfo, BlockNotes, FrameState
from ilf.project.project import Project, ProjectFrame
from ilf.run.run import Run
from ilf.sources.frame_source import FrameSource

from .waiting import pause, wait

_TICK_MS = 2


def made(folder: Path, of: Path, count: int) -> Path:
    """Make a project of frames in separate folders, each edited and completed, with different files."""
    frames, states = [], []
    sample = ilf.load_frame(of)
    blocks = ilf.extract_blocks(sample)
    run = Run(sample, blocks, ilf.preset("released-code", max_iterations=20))
    results = run.complete().results
    for number in range(count):
        there = folder / f"frame-{number:03}"
        shutil.copytree(of, there)
        for file in there.glob("*.png"):
            file.write_bytes(file.read_bytes() + number.to_bytes(2, "big"))
        frame = ilf.load_frame(there)
        labels = blocks.copy()
        rng = np.random.default_rng(number)
        for label in np.unique(blocks)[1:6]:  # different outlines
            row, column = (int(rng.integers(20, size - 20)) for size in labels.shape)
            cv2.circle(labels, (column, row), 15, int(label), -1)
        infos = {label: BlockInfo(f"Block {label} of {number}", (9, 8, 7)) for label in range(1, 9)}
        same = [label for label in results if np.array_equal(labels == label, blocks == label)]
        fresh = {label: _varied(results[label], rng) for label in same}
        identity = f"{number:032x}"
        notes = BlockNotes(infos, {1: {"max_iterations": number + 1}}, extracted=blocks)
        states.append(FrameState(identity, frame, labels, notes, run.parameters, fresh, note=f"Frame {number}"))
        frames.append(ProjectFrame(identity, there.name, FrameSource(str(there)), has_state=True))
    path = folder / "many.ilf"
    save_project(path, Project(tuple(frames), frames[count // 2].id), states)
    return path


def _varied(result: BlockResult, rng: np.random.Generator) -> BlockResult:
    """Make a result that no other frame has, so that nothing is stored only once."""
    noise = rng.normal(0, 0.002, result.depth.shape).astype(np.float32)
    return dataclasses.replace(result, depth=result.depth + noise)


def timed(do: Callable[[], object], reached: Callable[[], object]) -> tuple[float, float]:
    """Return the time until a condition holds [s], and the longest time that the window was blocked [s]."""
    last, longest = time.perf_counter(), 0.0

    def tick() -> None:
        nonlocal last, longest
        now = time.perf_counter()
        longest, last = max(longest, now - last), now

    timer = QTimer(interval=_TICK_MS)
    timer.timeout.connect(tick)
    timer.start()
    begun = time.perf_counter()
    do()
    wait(reached)
    took = time.perf_counter() - begun
    tick()
    timer.stop()
    return took, longest


def main() -> None:
    """Make the project, open it, save it after an edit."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=200)
    parser.add_argument("--of", type=Path, default=asset_path("samples/room"))
    options = parser.parse_args()
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    with tempfile.TemporaryDirectory() as name:
        QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, f"{name}/settings")
        QCoreApplication.setApplicationName("ilf-studio-bench")
        app = QApplication([])
        path = made(Path(name), options.of, options.frames)
        print(f"{options.frames} frames, {path.stat().st_size / 1e6:.0f} MB")
        window = MainWindow(persistent=False)
        window.resize(1280, 800)
        window.show()
        pause(2500)
        workspace, project = window.workspace, window.project
        drawn: list[bool] = []
        window.refresh.add("bench", lambda: drawn.append(workspace.has_session), (workspace.frames.session_changed,))
        took, held = timed(lambda: project.open(path), lambda: drawn and drawn[-1] and window.views.isVisible())
        print(f"open, to the first picture: {took:.2f} s (window blocked for up to {held * 1000:.0f} ms)")
        pause(3000)
        for attempt in range(3):
            workspace.blocks.edit_info(1, "Rename", name=f"Wall {attempt}")
            pause(500)
            done: list[bool] = []
            wish = SaveRequest(path, then=done.append)
            took, held = timed(lambda wish=wish: project.saving.save(wish), lambda done=done: done)
            print(f"save after one edit: {took:.2f} s (blocked for up to {held * 1000:.0f} ms), {done[0]}")
        row = workspace.frames.entries.row_of(workspace.frames.entries.of(workspace.session.id)) + 1
        entry = workspace.frames.entries[row]
        took, held = timed(lambda: window.loader.open_entry(entry), lambda: entry.session is not None)
        print(f"switch to the next frame: {took:.2f} s (blocked for up to {held * 1000:.0f} ms)")
        window.documents.discard_silently = True
        window.close()
        del app


if __name__ == "__main__":
    main()
