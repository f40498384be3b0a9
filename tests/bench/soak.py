"""Many frames in one process must leave no memory, threads, files or child processes behind.

    python -m tests.bench.soak window [--frames 300] [--size 160x120]
    python -m tests.bench.soak stream [--frames 10000] [--size 80x60] [--rate 10]

In the window every frame is opened, run, edited, solved again, exported and closed; in a stream the bundled room moves
by a pixel a frame, with a cut every 500 frames. Memory and the rest are taken after a tenth of them and at the end.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import ilf

from .measuring import held, memory_in_use
from .samples import Size, scaled, size_of, write_sample

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("QT_LOGGING_RULES", "default.warning=false")

_CUT = 500
_REST_MS = 8000
"""Time after which the window shows no message any more."""
_RARELY_MS = 20
"""Between two looks at the window, to leave time to its threads."""


def in_window(count: int, size: Size) -> Iterator[None]:
    """Work in a window, frame by frame; before it is measured, it rests."""
    from PySide6.QtWidgets import QApplication

    from gui.features.export.feature import ExportFeature
    from gui.features.export.jobs import Export
    from gui.widgets.notices import ProblemBox
    from ilf.run.options import ExportOptions
    from tests.pins.window.hand import isolated

    from .window import end, new_window, open_frame, paint_across, pause, settled, wait

    _app = QApplication.instance() or QApplication([])
    with tempfile.TemporaryDirectory() as name, isolated(Path(name)):
        window = new_window()
        places = [write_sample(Path(name, f"frame{number}"), size, number) for number in range(10)]
        for number in range(count):
            open_frame(window, places[number % len(places)])
            window.runs.current.start()
            wait(lambda: settled(window), _RARELY_MS)
            paint_across(window, max(window.workspace.current.counts()))
            wait(lambda: settled(window), _RARELY_MS)
            window.feature(ExportFeature).start(Export(Path(name, "out"), ExportOptions(mesh="ply")))
            wait(lambda: not window.feature(ExportFeature).busy, _RARELY_MS)
            for box in window.findChildren(ProblemBox):
                box.close()
            window.documents.close_frame()
            wait(lambda: window.workspace.shown is None, _RARELY_MS)
            pause(_REST_MS if number + 1 in (_first(count), count) else 10)
            yield
        end(window)


def in_stream(count: int, size: Size, rate: float | None) -> Iterator[None]:
    """Stream views of the bundled room."""
    width, height = size
    room = scaled((2 * width, height))
    depth = room.depth.copy()
    depth[height // 3 : height // 2, :: width // 2] = np.nan
    with ilf.Stream(rate=rate) as stream:
        for number in range(count):
            move = number % (2 * width)
            at = min(move, 2 * width - move)
            seen = np.s_[:, at : at + width] if number // _CUT % 2 else np.s_[::-1, at : at + width]
            stream.complete(ilf.RGBDFrame(room.rgb[seen].copy(), depth[seen]))
            yield


def _first(count: int) -> int:
    return max(count // 10, 1)


def main() -> None:
    """Print what has grown; the exit status is 1 if it is too much."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("where", choices=("window", "stream"))
    parser.add_argument("--frames", type=int)
    parser.add_argument("--size")
    parser.add_argument("--rate", type=float, help="of the stream, with a thread that finds blocks")
    parser.add_argument("--limit", type=float, default=30.0, help="largest growth of memory [MB]")
    given = parser.parse_args()
    if given.where == "window":
        count = given.frames or 300
        frames = in_window(count, size_of(given.size or "160x120"))
    else:
        count = given.frames or 10_000
        frames = in_stream(count, size_of(given.size or "80x60"), given.rate)
    before, memory, after, growth = held(), 0.0, held(), 0.0
    for number, _ in enumerate(frames, 1):
        if number == _first(count):
            before, memory = held(), memory_in_use()
        if number % _first(count) == 0:
            after, growth = held(), memory_in_use() - memory
            print(f"{number} frames: {growth:+.1f} MB, {after}", flush=True)
    print(f"memory has grown by {growth:.1f} MB between frames {_first(count)} and {count}; {before} -> {after}")
    sys.exit(growth > given.limit or any(after[kind] > before[kind] for kind in before))


if __name__ == "__main__":
    main()
