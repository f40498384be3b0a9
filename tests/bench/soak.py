"""Soak test: many frames in one window must leave no memory or other resources behind.

    python -m tests.bench.soak [--frames 300] [--size 160x120]

Every frame is opened, its blocks are extracted, edited, run and solved again, and it is exported and closed. After a
tenth of the frames and at the end, memory is measured, and threads, timers, open files and child processes are counted.
Memory grows by what frames leave behind; the counts must not change.
"""

from __future__ import annotations

import argparse
import ctypes
import gc
import os
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("QT_LOGGING_RULES", "default.warning=false")

import numpy as np
from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from gui.app.main_window import MainWindow
from gui.widgets.notices import ProblemBox
from ilf.run.options import ExportOptions
from ilf.segmentation.editing.painting import brush_stroke, paint

from .memory import resident
from .responsive import new_window, open_frame, sample
from .waiting import pause

MAX_GROWTH = 30.0
"""MB."""
_LIMIT_S = 300
_REST_MS = 8000
"""Time after which no message is shown any more [ms]."""


def wait(reached: Callable[[], object]) -> None:
    """Run the event loop until a condition holds; checked rarely, to leave time to the threads."""
    end = time.monotonic() + _LIMIT_S
    while not reached():
        pause(20)
        if time.monotonic() > end:
            raise TimeoutError("the window did not reach the expected state")


def one_frame(window: MainWindow, folder: Path, out: Path) -> None:
    """Perform all actions with a frame."""
    open_frame(window, folder)
    workspace, runs = window.workspace, window.runs
    runs.start()
    wait(lambda: runs.free and not runs.resolving)
    session = workspace.session
    height, width = session.frame.shape
    line = np.array([[0.2 * width, 0.5 * height], [0.8 * width, 0.5 * height]])
    stroke = brush_stroke((height, width), line, 5.0)
    if stroke is not None:
        workspace.blocks.stroke(paint(session.labels, stroke, max(session.counts()), session.locked))
        workspace.blocks.end_stroke("Paint")
    wait(lambda: runs.free and not runs.resolving and not window.errors.busy)
    window.documents.export(out, ExportOptions(mesh="ply"))
    wait(lambda: not window.documents.exporting)
    for box in window.findChildren(ProblemBox):  # that some pixels are nobody's word, which is told in a box
        box.close()
    window.documents.close_frame()
    wait(lambda: not workspace.has_session)
    pause(10)


def in_use() -> int:
    """Return the memory [bytes] of this process, without freed memory that the C library keeps."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return resident()


def left() -> dict[str, object]:
    """Count the resources of this process other than memory."""
    QApplication.processEvents()
    gc.collect()
    timers = Counter(
        type(item.parent()).__name__ for item in gc.get_objects() if issubclass(type(item), QTimer) and _runs(item)
    )
    files = Counter(os.readlink(f"/proc/self/fd/{number}").split(":")[0] for number in _descriptors())
    children = [
        child
        for task in Path("/proc/self/task").iterdir()
        for child in (task / "children").read_text().split()
    ]  # fmt: skip
    threads = Counter(thread.name.rstrip("0123456789-_") for thread in threading.enumerate())
    return {"threads": threads, "timers": timers, "files": files, "children": children}


def _descriptors() -> list[str]:
    with os.scandir("/proc/self/fd") as entries:
        names = [entry.name for entry in entries]
    return [name for name in names if os.path.lexists(f"/proc/self/fd/{name}")]


def _runs(timer: object) -> bool:
    try:
        return bool(timer.isActive())  # type: ignore[attr-defined]
    except RuntimeError:
        return False


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--frames", type=int, default=300)
    parser.add_argument("--size", default="160x120")
    given = parser.parse_args()
    width, height = map(int, given.size.split("x"))
    app = QApplication([])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for setting in ("ILF_AUTOSAVE", "ILF_FOLDERS", "ILF_PRESETS"):
            os.environ[setting] = str(folder / setting)
        window = new_window()
        first = max(given.frames // 10, 1)
        places = [sample(folder, (width, height), number) for number in range(10)]
        for number in range(1, given.frames + 1):
            one_frame(window, places[number % len(places)], folder / "out")
            if number == first:
                pause(_REST_MS)
                before, memory = left(), in_use()
            if number % first == 0:
                print(f"{number:4} frames: {resident() / 2**20:.0f} MB", flush=True)
        pause(_REST_MS)
        after, growth = left(), (in_use() - memory) / 2**20
        window.close()
        app.processEvents()
    print(f"memory has grown by {growth:.1f} MB between frames {first} and {given.frames}")
    changed = {what: (before[what], found) for what, found in after.items() if found != before[what]}
    for what, (earlier, later) in changed.items():
        print(f"{what}: {earlier} -> {later}")
    threads = [thread.name for thread in threading.enumerate() if thread.name.startswith("ilf")]
    print(f"threads, timers, files and children have {'' if changed else 'not '}changed; after closing: {threads}")
    sys.exit(growth > MAX_GROWTH or bool(changed) or bool(threads))


if __name__ == "__main__":
    main()
