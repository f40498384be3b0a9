"""Time that a window takes to close during work, and what it leaves behind.

    python -m tests.bench.closing [--size 1920x1080] [--only opening run export batch] [--moments 5]

Each time, a separate process opens a window, starts some work, and closes the window at a random moment. Prints the
longest times until the windows are closed, and from then until the process has ended; and how often the process left an
export that is neither the older set nor the new one, partial files, or processes.
"""

from __future__ import annotations

import argparse
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("QT_LOGGING_RULES", "default.warning=false")

from PySide6.QtCore import QTimer
from PySide6.QtWidgets import QApplication

from gui.app.error_reporter import exit_soon
from gui.app.main_window import MainWindow
from gui.base import theme
from gui.features.export.dialog import ALL, Export
from gui.features.export.feature import ExportFeature
from ilf.run.options import ExportOptions

from .samples import size_of, write_sample
from .window import new_window, open_frame, settled, wait
from .writers import contents_after_cleanup

Over = Callable[[], object]
"""Returns whether the work has ended."""

_VARYING = {"run.json"}
"""Files that differ at each writing, because they contain the time."""

_OLDER, _NEWER = ExportOptions(cloud=None), ExportOptions(mesh="ply")
_ONLY_IN_NEWER = {"cloud.ply", "mesh.ply"}

_MARK = "ILF_CLOSING_BENCH"
_AFTERWARDS_S = 3.0
"""Time for worker processes to end [s]."""


def _open(window: MainWindow, folder: Path) -> Over:
    window.documents.open_paths([folder / "frame"])
    return lambda: window.workspace.has_current and window.workspace.current.counts() and not window.loader.busy


def _run(window: MainWindow, folder: Path) -> Over:
    open_frame(window, folder / "frame")
    window.runs.start()
    return lambda: settled(window)


def _export(window: MainWindow, folder: Path) -> Over:
    wait(_run(window, folder))
    for options in (_OLDER, _NEWER):
        wait(lambda: not window.documents.exporting)
        window.feature(ExportFeature).start(Export(folder / "out", options))
    return lambda: not window.documents.exporting


def _batch(window: MainWindow, folder: Path) -> Over:
    open_frame(window, folder / "frame")
    part = window.feature(ExportFeature)
    # in the same folder no work would be left
    place = folder / f"batch-{time.time_ns()}"
    part.start(Export(place, ExportOptions(), ALL, from_files=True, jobs=2))
    return lambda: not part.worker.busy


WORK: dict[str, Callable[[MainWindow, Path], Over]] = {
    "opening": _open,
    "run": _run,
    "export": _export,
    "batch": _batch,
}


@dataclass
class Found:
    """Result of closing windows during some work."""

    gone: list[float] = field(default_factory=list)
    ended: list[float] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--only", nargs="+", choices=list(WORK), default=list(WORK))
    parser.add_argument("--moments", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--child", nargs=3, metavar=("WORK", "FOLDER", "SECONDS"), help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.child:
        name, folder, seconds = given.child
        sys.exit(close_during(name, Path(folder), float(seconds)))
    chance = random.Random(given.seed)
    print(f"{given.size}; longest times [ms] until the windows are closed, and until the process has ended")
    print(f"{'':10} {'gone':>6} {'ended':>6}")
    for name in given.only:
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            write_sample(folder / "frame", size_of(given.size))
            found = closed(name, folder, given.moments, chance)
        times = (1000 * max(found.gone), 1000 * max(found.ended))
        print(f"{name:10}", *(f"{time:6.0f}" for time in times), *found.wrong, flush=True)


def closed(name: str, folder: Path, moments: int, chance: random.Random) -> Found:
    """Close windows during some work."""
    found = Found()
    (folder / "out").mkdir()
    whole, *_ = _child(name, folder, -1.0)
    newer = _set_in(folder / "out")
    for _ in range(moments):
        _, gone, ended = _child(name, folder, chance.uniform(0.02, 0.98) * whole)
        found.gone.append(gone)
        found.ended.append(ended)
        left = _set_in(folder / "out")
        if left not in (newer, {name: newer[name] for name in newer if name not in _ONLY_IN_NEWER}):
            found.wrong.append(f"a set of {sorted(left)}")
        found.wrong += [str(path) for path in folder.rglob(".ilf-*")]
        found.wrong += _processes_left()
    return found


def _child(name: str, folder: Path, seconds: float) -> tuple[float, float, float]:
    """Close a window during some work, after `seconds`; return the time of the work, from closing until the windows
    were closed, and from then until the process had ended [s]."""
    command = [sys.executable, "-m", "tests.bench.closing", "--child", name, str(folder), str(seconds)]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, env={**os.environ, _MARK: "1"}, check=True)
    ended = time.time()
    worked, closing, gone = map(float, done.stdout.split())
    return worked, gone - closing, ended - gone


def _set_in(folder: Path) -> dict[str, bytes]:
    """Files of an export, except those that differ at each writing."""
    return {name: content for name, content in contents_after_cleanup(folder).items() if name not in _VARYING}


def _processes_left() -> list[str]:
    """Worker processes that have not ended."""
    end = time.monotonic() + _AFTERWARDS_S
    while left := [path for path in Path("/proc").glob("[0-9]*/environ") if _MARK.encode() in _content(path)]:
        if time.monotonic() > end:
            return [f"process {path.parent.name}" for path in left]
        time.sleep(0.05)
    return []


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError:
        return b""


def close_during(name: str, folder: Path, seconds: float) -> int:
    """Start some work in a new window, and close the window after `seconds`; if negative, at the end of the work."""
    app = QApplication([])
    theme.apply_theme(app, "light")
    window = new_window()
    over = WORK[name](window, folder)
    begun = time.time()

    def close() -> None:
        print(time.time() - begun, time.time(), flush=True)
        window.close()
        print(time.time(), flush=True)
        app.quit()

    if seconds < 0:
        wait(over)
        close()
    else:
        QTimer.singleShot(round(1000 * seconds), close)
        app.exec()
    return exit_soon(0)


if __name__ == "__main__":
    main()
