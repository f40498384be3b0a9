"""Responsiveness and memory of the window during work: `python -m tests.bench.responsive`.

Prints the longest gaps of the window's event loop during each kind of long work, and during all of them together; the
processor time of switches of theme and layout; and the memory that remains after opening, running and closing many
frames in turn. Gaps are wall clock on an idle machine. `--frames 0` skips the frames, `--switches` all except the
switches.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import cv2
import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

import ilf
from gui.app.main_window import MainWindow
from gui.base import theme
from gui.features.accuracy.feature import AccuracyFeature
from gui.features.filter.feature import FilterFeature
from gui.features.layouts.feature import LayoutsFeature
from gui.features.layouts.layout import BUILT_IN, STANDARD
from gui.features.sweep.feature import SweepFeature
from gui.features.views import ErrorFeature
from ilf._runtime.installation import asset_path

from .memory import resident
from .waiting import pause, wait

_BEAT_MS = 2


class EventLoopMonitor:
    """Timer in the window's thread that records gaps between its events."""

    def __init__(self) -> None:
        self._timer = QTimer(interval=_BEAT_MS)
        self._timer.timeout.connect(self._beat)
        self._last = 0.0
        self.gaps: list[float] = []

    def start(self) -> None:
        """Start recording."""
        self.gaps = []
        self._last = time.perf_counter()
        self._timer.start()

    def stop(self) -> str:
        """Stop recording; return the gaps as text."""
        self._timer.stop()
        gaps = 1000 * np.sort(self.gaps)
        return f"longest {gaps[-1]:6.1f} ms, 2nd {gaps[-2]:6.1f}, over 50 ms: {int((gaps > 50).sum())} of {gaps.size}"

    def _beat(self) -> None:
        now = time.perf_counter()
        self.gaps.append(now - self._last)
        self._last = now


def sample(folder: Path, size: tuple[int, int], number: int = 0) -> Path:
    """Write the bundled sample in a size as a frame folder; the number varies it slightly."""
    frame = ilf.load_frame(asset_path("samples/room"))
    assert frame.ground_truth is not None
    place = folder / f"{size[0]}x{size[1]}-{number}"
    place.mkdir()
    rgb = cv2.resize(frame.rgb, size)
    rgb[0, 0] = number % 256
    cv2.imwrite(str(place / "rgb.png"), rgb[..., ::-1])
    for name, depth in (("depth", frame.depth), ("gt", frame.ground_truth)):
        metres = np.nan_to_num(cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST))
        cv2.imwrite(str(place / f"{name}.png"), (1000 * metres).round().astype(np.uint16))
    (place / "meta.json").write_text(
        '{"depth_units_per_m": 1000, "gt_units_per_m": 1000, "K": [525, 525, 319.5, 239.5]}'
    )
    return place


def new_window() -> MainWindow:
    """Open a window with all panels that show numbers."""
    window = MainWindow(persistent=False)
    window.documents.discard_silently = True
    window.resize(1440, 900)
    window.show()
    pause(300)
    return window


def open_frame(window: MainWindow, folder: Path) -> None:
    """Open a frame, and wait for its blocks."""
    window.documents.open_paths([folder])
    wait(lambda: window.workspace.has_session and window.workspace.session.counts() and not window.loader.busy)


def listen(window: MainWindow, folder: Path) -> None:
    """Print the gaps during all kinds of long work."""
    heart = EventLoopMonitor()
    workspace, runs = window.workspace, window.runs
    accuracy = window.feature(AccuracyFeature)
    sweep = window.feature(SweepFeature)

    def say(what: str, begin: Callable[[], object], over: Callable[[], object]) -> None:
        pause(500)
        heart.start()
        begin()
        wait(over)
        pause(300)
        print(f"  {what:<22} {heart.stop()}", flush=True)

    def drag() -> None:
        for step in range(40):
            window.feature(FilterFeature).panel.edited.emit(
                workspace.parameters.current.replace(smoothness=0.5 + 0.02 * step)
            )
            pause(20)

    def everything() -> None:
        accuracy.ask_test()
        window.actions_["run_all"].trigger()
        sweep.start()
        for _ in range(20):
            window.views.fit()
            window.actions_["undo"].trigger()
            pause(30)

    say("opening", lambda: open_frame(window, folder), lambda: True)
    say("run, best", window.actions_["run_all"].trigger, lambda: runs.free)
    counts = workspace.session.counts()
    workspace.blocks.select([max(counts, key=lambda label: counts[label].pixels)])
    say("a value dragged, live", drag, lambda: runs.free and not runs.resolving)
    workspace.parameters.set(ilf.preset("released-code", max_iterations=40))
    say("run, released-code", window.actions_["run_all"].trigger, lambda: runs.free)
    workspace.parameters.set(ilf.preset())
    sweep.open("noise")
    say("sweep", sweep.start, lambda: not sweep.worker.busy)
    window.actions_["live"].setChecked(True)
    say("all of it", everything, lambda: runs.free and not sweep.worker.busy)


def switches(window: MainWindow, app: QApplication) -> None:
    """Print the processor time of the longest turn of the window's thread in each switch: the first, and later ones."""
    window.actions_["run_all"].trigger()
    wait(lambda: window.runs.free and not window.feature(ErrorFeature).busy)
    layouts = [layout.name for layout in BUILT_IN if layout.name != window.feature(LayoutsFeature).present]
    names = [*[*layouts, STANDARD] * _ROUNDS, *("dark", "light") * _ROUNDS]
    found: dict[str, list[float]] = {}
    for name in names:
        pause(300)  # what the last switch deferred
        theme_name = name in theme.THEMES
        begin = partial(theme.apply_theme, app, name) if theme_name else window.actions_[f"layout_{name}"].trigger
        found.setdefault("theme" if theme_name else f"layout {name}", []).append(_longest_turn(begin))
    for what, turns in found.items():
        print(f"  {what:<22} first {turns[0]:5.0f} ms, then at most {max(turns[1:]):5.0f} ms", flush=True)


_ROUNDS = 3
_TURNS = 20


def _longest_turn(begin: Callable[[], object]) -> float:
    """Return the processor time [ms] of the longest of the turns that a call causes, itself the first."""
    turns = []
    for turn in (begin, *[QApplication.processEvents] * _TURNS):
        begun = time.thread_time()
        turn()
        turns.append(1000 * (time.thread_time() - begun))
    return max(turns)


def soak(window: MainWindow, folder: Path, count: int) -> None:
    """Print the memory of the process while many frames are opened and closed."""
    for number in range(count):
        place = sample(folder, (640, 480), 1 + number)
        open_frame(window, place)
        window.actions_["run_all"].trigger()
        wait(lambda: window.runs.free and not window.feature(ErrorFeature).busy)
        window.actions_["close_frame"].trigger()
        pause(20)
        if number in (0, 4, 9, 19) or number % 50 == 49:
            print(f"  after {number + 1:3d} frames {resident() / 2**20:7.0f} MB", flush=True)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--frames", type=int, default=200, help="number of frames to open, run and close (default: 200)"
    )
    parser.add_argument("--switches", action="store_true", help="only switches of theme and layout")
    arguments = parser.parse_args()
    app = QApplication([])
    theme.apply_theme(app, "light")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for size in ((640, 480), (1920, 1080)):
            print(f"{size[0]} x {size[1]}, processor time of the longest turn of a switch:")
            window = new_window()
            open_frame(window, sample(folder, size))
            switches(window, app)
            window.close()
        if arguments.switches:
            return
        for size in ((640, 480), (1280, 720)):
            print(f"{size[0]} x {size[1]}, gaps of the window's thread:")
            window = new_window()
            listen(window, sample(folder, size))
            window.close()
        if arguments.frames:
            print(f"{arguments.frames} frames of 640 x 480, opened, run and closed:")
            window = new_window()
            soak(window, folder, arguments.frames)
            window.close()


if __name__ == "__main__":
    main()
