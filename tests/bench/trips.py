"""Size of the code, and number of its files involved in typical operations: `python -m tests.bench.trips`.

Four operations, each in a separate process with every function call of every thread recorded: `ilf complete` on the
bundled sample, and in the window opening the sample, a slider of the filter until its new depth is visible, and a brush
stroke until the depth is updated. A file counts if a function in it was called; imports do not count.
"""

import argparse
import importlib
import io
import os
import pkgutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout, suppress
from inspect import CO_OPTIMIZED
from pathlib import Path
from types import FrameType

import ilf
from ilf.errors import InputError

from .code_size import show_sizes

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("QT_LOGGING_RULES", "default.warning=false")

ROOT = Path(__file__).parents[2]
TRIPS = ("complete", "open", "slider", "stroke")


class Recorder:
    """Records which functions of the project were called, and from which file."""

    def __init__(self) -> None:
        self.functions: set[tuple[str, str]] = set()
        self.arrows: set[tuple[str, str]] = set()
        self._names: dict[str, str | None] = {}

    def start(self) -> None:
        threading.setprofile(self._note)
        sys.setprofile(self._note)

    def stop(self) -> None:
        sys.setprofile(None)
        threading.setprofile(None)

    def _file(self, name: str) -> str | None:
        if name not in self._names:
            path = Path(name)
            inside = path.is_relative_to(ROOT) and path.relative_to(ROOT).parts[0] in ("ilf", "gui")
            self._names[name] = path.relative_to(ROOT).as_posix() if inside else None
        return self._names[name]

    def _note(self, frame: FrameType, event: str, _argument: object) -> None:
        if event != "call" or not frame.f_code.co_flags & CO_OPTIMIZED:
            return  # the body of a module or a class
        file = self._file(frame.f_code.co_filename)
        if file is None:
            return
        self.functions.add((file, frame.f_code.co_qualname))
        caller = frame.f_back and self._file(frame.f_back.f_code.co_filename)
        if caller and caller != file:
            self.arrows.add((caller, file))

    def report(self, trip: str, files: bool) -> None:
        entered = sorted({file for file, _ in self.functions})
        print(f"{trip:10} {len(entered):4} files {len(self.functions):5} functions {len(self.arrows):4} arrows")
        if files:
            print(*(f"    {file}" for file in entered), sep="\n")


def import_all() -> None:
    """Import the library, so that nothing is imported during the recording."""
    for module in pkgutil.walk_packages(ilf.__path__, "ilf."):
        if not module.name.endswith("__main__"):
            with suppress(InputError, ModuleNotFoundError):  # it needs an extra that is not installed
                importlib.import_module(module.name)


def complete(recorder: Recorder) -> None:
    """Record the command line from a folder to files."""
    from ilf.cli import main

    with tempfile.TemporaryDirectory() as folder, redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
        recorder.start()
        main(["complete", str(ROOT / "assets/samples/room"), "--out", f"{folder}/out"])
        recorder.stop()


def in_window(recorder: Recorder, trip: str) -> None:
    """Record operations in the window; preparations are not recorded."""
    from PySide6.QtWidgets import QApplication

    from gui.features.filter import FilterPanel
    from gui.state.parts import Part

    from .window import end, new_window, open_frame, paint_across, pause, settled, wait

    _app = QApplication([])
    if trip == "open":
        recorder.start()  # includes threads started from now on
    window = new_window()
    open_frame(window, ROOT / "assets/samples/room")
    workspace, runs = window.workspace, window.runs
    document = workspace.current
    if trip != "open":
        runs.current.start()
        wait(lambda: settled(window))
        recorder.start()
        news: list[None] = []
        workspace.changed.connect(lambda parts: news.append(None) if parts & Part.SOME_RESULTS else None)
        label = max(document.counts(), key=lambda label: document.counts()[label].pixels)
        if trip == "slider":
            workspace.select([label])
            window.feature(FilterPanel).form.changed.emit(document.state.common.replace(noise=0.02))
        else:
            paint_across(window, label)
        wait(lambda: news)
    for _ in range(2):  # the run history, for example, begins when nothing has happened for a moment
        wait(lambda: settled(window))
        pause(500)
    recorder.stop()
    end(window)


def _follow(trip: str) -> Callable[[Recorder], None]:
    return complete if trip == "complete" else lambda recorder: in_window(recorder, trip)


def main() -> int:
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.trips", description="Files involved in typical operations."
    )
    parser.add_argument("trip", nargs="?", choices=TRIPS, help="only this operation, in this process")
    parser.add_argument("--files", action="store_true", help="list the files, too")
    arguments = parser.parse_args()
    if arguments.trip is None:
        own = [sys.executable, "-m", "tests.bench.trips", *(["--files"] if arguments.files else [])]
        show_sizes()
        return max(subprocess.run([*own, trip], check=False).returncode for trip in TRIPS)
    import_all()
    recorder = Recorder()
    _follow(arguments.trip)(recorder)
    recorder.report(arguments.trip, arguments.files)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
