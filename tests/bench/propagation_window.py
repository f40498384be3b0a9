"""Response of the window while blocks are propagated through frames: `python -m tests.bench.propagation_window`.

The frames are crops of a picture, 1920 x 1080, that move to the right: blocks are extracted in the first frame and
propagated through the others. Prints the time per frame and the gaps of the window's event loop; wall clock, on an idle
machine.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np
from PySide6.QtWidgets import QApplication

import ilf
from gui.base import theme
from gui.features.propagation.feature import PropagationFeature
from gui.state.entries import Entry
from ilf._runtime.installation import asset_path
from ilf.sources.frame_source import FrameSource

from .responsive import EventLoopMonitor, new_window
from .waiting import pause, wait

_STEP = 12
"""Motion from frame to frame [px]."""


def frames(folder: Path, size: tuple[int, int], count: int) -> list[FrameSource]:
    """Moving crops of the bundled sample."""
    sample = ilf.load_frame(asset_path("samples/room"))
    width, height = size
    wide = width + _STEP * count, height
    rgb = cv2.resize(sample.rgb, wide)
    depth = cv2.resize(sample.depth, wide, interpolation=cv2.INTER_NEAREST)
    found = []
    for number in range(count):
        place, part = folder / f"frame-{number}", np.s_[:, _STEP * number : _STEP * number + width]
        place.mkdir()
        cv2.imwrite(str(place / "rgb.png"), rgb[part][..., ::-1])
        cv2.imwrite(str(place / "depth.png"), np.nan_to_num(1000 * depth[part]).round().astype(np.uint16))
        (place / "meta.json").write_text(json.dumps({"depth_units_per_m": 1000}))
        found.append(FrameSource(str(place)))
    return found


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--frames", type=int, default=8)
    parser.add_argument("--size", default="1920x1080")
    given = parser.parse_args()
    width, height = map(int, given.size.split("x"))
    app = QApplication.instance() or QApplication([])
    assert isinstance(app, QApplication)
    theme.apply_theme(app, "dark")
    with tempfile.TemporaryDirectory() as folder:
        sources = frames(Path(folder), (width, height), given.frames)
        window = new_window()
        window.workspace.frames.add_entries([Entry.of(source) for source in sources])
        window.loader.open(sources[0])
        wait(lambda: window.workspace.has_session and not window.loader.busy)
        pause(500)
        part = next(part for part in window.parts if isinstance(part, PropagationFeature))
        rest = given.frames - 2
        for what, count, begin in (
            ("to the next, shown", 1, part.propagate_next),
            ("through the rest", rest, lambda: part.propagate_through(rest)),
        ):
            heart = EventLoopMonitor()
            heart.start()
            begun = time.perf_counter()
            begin()
            wait(lambda: part.propagator.propagation_run is None)
            seconds = time.perf_counter() - begun
            print(f"{what:18} {seconds / count:5.2f} s a frame; window's thread: {heart.stop()}")
            pause(500)
        window.close()


if __name__ == "__main__":
    main()
