"""Cost of a list of 10,000 frames: `python -m tests.bench.frame_list [--frames N]`.

Frames are links to the bundled sample. Prints the time to find them, the longest gap of the window's event loop while
the list is filled, scrolled, filtered and sorted, and the time until the next frame is visible, during reading and
extraction. With --folder, for that folder instead.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")

import numpy as np
from PySide6.QtWidgets import QApplication

from gui.app.main_window import MainWindow
from gui.base import theme
from ilf._runtime.installation import asset_path
from ilf.sources.listing import list_frames

from .responsive import EventLoopMonitor, new_window
from .waiting import pause, wait


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=10_000, help="number of frames (default: 10000)")
    parser.add_argument("--folder", type=Path, help="a folder of frames to list instead")
    arguments = parser.parse_args()
    app = QApplication([])
    theme.apply_theme(app, "light")
    with tempfile.TemporaryDirectory() as name:
        folder = arguments.folder or linked(Path(name), arguments.frames)
        begun = time.perf_counter()
        count = len(list_frames(folder).sources)
        print(f"{count} frames found in {time.perf_counter() - begun:.2f} s")
        window = new_window()
        window.recorder.start()
        window.panels.reveal("Frames")
        pause(300)
        look(window, folder)
        turn(window)
        window.close()


def linked(folder: Path, count: int) -> Path:
    """Make a folder of `count` frames, all of them the bundled sample."""
    sample = asset_path("samples/room")
    for number in range(count):
        (folder / f"frame-{number}").symlink_to(sample, target_is_directory=True)
    return folder


def look(window: MainWindow, folder: Path) -> None:
    """Print the gaps of the window's event loop for actions on the list."""
    panel, heart = window.frames, EventLoopMonitor()

    def say(what: str, begin: Callable[[], object], over: Callable[[], object] = lambda: True) -> None:
        wait(lambda: not window.loader.busy)
        pause(300)
        heart.start()
        begin()
        wait(over)
        pause(400)
        print(f"  {what:<24} {heart.stop()}", flush=True)

    def scroll() -> None:
        bar = panel.view.verticalScrollBar()
        for step in range(60):
            bar.setValue(round(bar.maximum() * step / 59))
            pause(16)

    say("fill, open the first", lambda: window.documents.open_paths([folder]), lambda: window.workspace.has_session)
    say("scroll to the end", scroll, lambda: not panel.thumbnails.busy)
    for text in ("frame-77", "77", ""):
        say(f"filter by {text!r}", lambda text=text: panel.text.setText(text))
    say("filter by state", lambda: panel.state.setCurrentIndex(1))
    panel.show_all()
    for order in ("name", "state", "missing", "list"):
        say(f"sort by {order}", lambda order=order: panel.order.choose(order))
    entries = window.workspace.frames.entries
    say("a note", lambda: window.workspace.frames.set_note(entries[5000 % len(entries)], "glass"))
    half = list(entries)[1::2]
    say(f"take {len(half)} out", lambda: window.frames_feature.remove(half))


def turn(window: MainWindow) -> None:
    """Print the time until the next frame is visible."""

    def seen(begin: Callable[[], object], rest: bool) -> float:
        drawn: list[float] = []
        told = window.workspace.frames.session_changed.connect(lambda: drawn.append(0.0))
        begun = time.perf_counter()
        begin()
        wait(lambda: drawn)
        window.workspace.frames.session_changed.disconnect(told)
        window.refresh.now()
        window.views.repaint()
        taken = time.perf_counter() - begun
        if rest:
            wait(lambda: not window.loader.busy)
            pause(400)
        return 1000 * taken

    def say(what: str, times: list[float]) -> None:
        print(f"  {what}: median {np.median(times):.0f} ms, longest {max(times):.0f} ms", flush=True)

    forward = window.actions_["next_frame"].trigger
    say("next frame, window idle", [seen(forward, True) for _ in range(12)])
    say("next frame, in quick succession", [seen(forward, False) for _ in range(12)])
    wait(lambda: not window.loader.busy)
    pause(1500)
    left = [entry for entry in window.workspace.frames.entries if entry.has_state and entry.session is None][:8]
    say(
        "back to an unloaded frame",
        [seen(lambda entry=entry: window.frames_feature.open(entry), True) for entry in left],
    )
    pause(1500)
    print(f"  open frames: {len(window.workspace.frames.sessions)}")


if __name__ == "__main__":
    main()
