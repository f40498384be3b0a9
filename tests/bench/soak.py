"""Soak test: many frames in one window must leave no memory or other resources behind.

    python -m tests.bench.soak [--frames 300] [--size 160x120]

Every frame is opened, its blocks are extracted, edited, run and solved again, and it is exported and closed. After a
tenth of the frames and at the end, memory is measured, and threads, timers, open files and child processes are counted.
Memory grows by what frames leave behind; the counts must not change.
"""

from __future__ import annotations

import argparse
import gc
import os
import sys
import tempfile
import threading
from collections import Counter
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("QT_LOGGING_RULES", "default.warning=false")

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from gui.app.main_window import MainWindow
from gui.features.export.dialog import Export
from gui.features.export.feature import ExportFeature
from gui.widgets.notices import ProblemBox
from ilf.run.options import ExportOptions

from .memory import in_use, resident
from .samples import size_of, write_sample
from .window import new_window, open_frame, paint_across, pause, settled, wait

_REST_MS = 8000
"""Time after which no message is shown any more [ms]."""
_RARELY_MS = 20
"""Between two looks at the window, to leave time to its threads."""


def one_frame(window: MainWindow, folder: Path, out: Path) -> None:
    """Perform all actions with a frame."""
    open_frame(window, folder)
    workspace = window.workspace
    window.runs.start()
    wait(lambda: settled(window), _RARELY_MS)
    paint_across(window, max(workspace.current.counts()))
    wait(lambda: settled(window), _RARELY_MS)
    exporting = window.feature(ExportFeature)
    exporting.start(Export(out, ExportOptions(mesh="ply")))
    wait(lambda: not exporting.worker.busy, _RARELY_MS)
    for box in window.findChildren(ProblemBox):  # that some pixels are nobody's word, which is told in a box
        box.close()
    window.documents.close_frame()
    wait(lambda: not workspace.has_current, _RARELY_MS)
    pause(10)


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
    parser.add_argument("--limit", type=float, default=30.0, help="largest growth of memory [MB]")
    given = parser.parse_args()
    app = QApplication([])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for setting in ("ILF_AUTOSAVE", "ILF_FOLDERS", "ILF_PRESETS"):
            os.environ[setting] = str(folder / setting)
        window = new_window()
        first = max(given.frames // 10, 1)
        places = [write_sample(folder / f"frame{number}", size_of(given.size), number) for number in range(10)]
        for number in range(1, given.frames + 1):
            one_frame(window, places[number % len(places)], folder / "out")
            if number == first:
                pause(_REST_MS)
                before, memory = left(), in_use()
            if number % first == 0:
                print(f"{number:4} frames: {resident():.0f} MB", flush=True)
        pause(_REST_MS)
        after, growth = left(), in_use() - memory
        window.close()
        app.processEvents()
    print(f"memory has grown by {growth:.1f} MB between frames {first} and {given.frames}")
    changed = {what: (before[what], found) for what, found in after.items() if found != before[what]}
    for what, (earlier, later) in changed.items():
        print(f"{what}: {earlier} -> {later}")
    threads = [thread.name for thread in threading.enumerate() if thread.name.startswith("ilf")]
    print(f"threads, timers, files and children have {'' if changed else 'not '}changed; after closing: {threads}")
    sys.exit(growth > given.limit or bool(changed) or bool(threads))


if __name__ == "__main__":
    main()
