"""Waiting time of a user for the effect of a slider, and for an opened frame.

`python -m pytest tests/bench/test_live_speed.py --benchmark-enable`
Wall clock in the real window with four views, until the result is painted. The bundled sample at its size (640 x 480)
and enlarged to 1280 x 720; the selected block is the largest.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
from PySide6.QtWidgets import QApplication
from pytest_benchmark.fixture import BenchmarkFixture

import ilf
from gui.app.main_window import MainWindow
from ilf._runtime.installation import asset_path

from .waiting import pause, wait

ROUNDS = 9
SIZES = {"640x480": (640, 480), "1280x720": (1280, 720)}

pytestmark = [pytest.mark.benchmark(group="until visible, wall clock", timer=time.perf_counter)]


@pytest.fixture(scope="module", params=list(SIZES))
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Write the sample in one of the sizes as a frame folder."""
    width, height = SIZES[request.param]
    frame = ilf.load_frame(asset_path("samples/room"))
    folder = tmp_path_factory.mktemp(request.param)
    cv2.imwrite(str(folder / "rgb.png"), cv2.resize(frame.rgb, (width, height))[..., ::-1])
    depth = np.nan_to_num(cv2.resize(frame.depth, (width, height), interpolation=cv2.INTER_NEAREST))
    cv2.imwrite(str(folder / "depth.png"), (depth * 1000).round().astype(np.uint16))
    (folder / "meta.json").write_text('{"depth_units_per_m": 1000}')
    return folder


@pytest.fixture
def window(qtbot) -> Iterator[MainWindow]:  # type: ignore[no-untyped-def]
    window = MainWindow(persistent=False)
    window.documents.discard_silently = True
    qtbot.addWidget(window)
    window.resize(1440, 900)
    window.show()
    qtbot.waitExposed(window)
    pause(300)
    yield window
    window.close()


def _until(reached: Callable[[], object]) -> None:
    """Wait for a condition, and until its result is painted."""
    wait(reached)
    for _ in range(2):
        QApplication.processEvents()


def _open(window: MainWindow, folder: Path) -> None:
    window.documents.open_paths([folder])
    _until(lambda: window.workspace.has_session and window.workspace.session.counts() and not window.loader.busy)


def _bench(benchmark: BenchmarkFixture, act: Callable[[], None], prepare: Callable[[], None]) -> None:
    benchmark.pedantic(act, setup=lambda: prepare(), rounds=ROUNDS if benchmark.enabled else 1, warmup_rounds=1)


def test_filter_slider(benchmark: BenchmarkFixture, window: MainWindow, folder: Path) -> None:
    """From a changed value of the filter to the selected block's new depth."""
    _open(window, folder)
    workspace = window.workspace
    session = workspace.session
    counts = session.counts()
    workspace.blocks.select([max(counts, key=lambda label: counts[label].pixels)])
    window.actions_["run"].trigger()
    _until(lambda: window.runs.free and session.valid_results() and not window.errors.busy)
    news: list[None] = []
    for signal in (workspace.runs.previews_changed, workspace.runs.results_added):
        signal.connect(lambda: news.append(None))
    values = iter(np.linspace(0.005, 0.03, 60).tolist())

    def prepare() -> None:
        pause(900)  # each value is a separate step, with all its consequences finished
        _until(lambda: not window.errors.busy and window.runs.free and not window.runs.resolving)
        news.clear()

    def act() -> None:
        window.filter_panel.edited.emit(session.common.replace(noise=next(values)))
        _until(lambda: news)

    _bench(benchmark, act, prepare)


@pytest.mark.parametrize("name", ["granularity", "threshold"])
def test_extraction_slider(benchmark: BenchmarkFixture, window: MainWindow, folder: Path, name: str) -> None:
    """From a changed value of the extraction to its result in the view of the extraction."""
    _open(window, folder)
    window.views.set_layout("grid-extraction")
    values = iter([0.3 + 0.05 * (step % 2) + 0.002 * step for step in range(60)])
    seen: list[object] = []
    window.stages.described.connect(lambda: seen.append(None))

    def prepare() -> None:
        pause(100)
        _until(lambda: not window.stages.busy)
        seen.clear()

    def act() -> None:
        parameters = window.workspace.parameters.extraction
        window.extraction_panel.edited.emit(parameters.replace(**{name: next(values)}))
        _until(lambda: seen)

    _bench(benchmark, act, prepare)


@pytest.mark.parametrize("what", ["first pixels", "blocks"])
def test_opening(benchmark: BenchmarkFixture, window: MainWindow, folder: Path, what: str) -> None:
    """From opening a frame to its pictures, and to its blocks."""
    workspace = window.workspace

    def prepare() -> None:
        if workspace.has_session:
            _until(lambda: not window.loader.busy)
            window.actions_["close_frame"].trigger()
        pause(200)

    def act() -> None:
        window.documents.open_paths([folder])
        _until(lambda: workspace.has_session and (what == "first pixels" or workspace.session.counts()))

    _bench(benchmark, act, prepare)
