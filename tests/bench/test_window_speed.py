"""Time of the window for single user actions: `python -m pytest tests/bench/test_window_speed.py --benchmark-enable`.

A frame of 1920 x 1080 pixels with 30 blocks with results, and four views. Measures the processor time of this thread
until the window is painted again; the work of other threads does not count. The start of the window is wall clock.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from numpy.typing import NDArray
from PySide6.QtCore import QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication
from pytest_benchmark.fixture import BenchmarkFixture

import ilf
from gui.app.main_window import MainWindow
from gui.features.edit_summary import EditSummaryFeature
from gui.state.document import Document
from ilf.data.blocks import Blocks
from ilf.project.frame_state import FrameState
from ilf.run.run import Execution
from ilf.segmentation.editing.patches import patch_between

from .window import new_window, pause, settled, wait

WIDTH, HEIGHT = 1920, 1080
ACROSS, DOWN = 6, 5
LEFT = Qt.MouseButton.LeftButton
ROUNDS = 9

pytestmark = [
    pytest.mark.benchmark(group="window at 1920 x 1080, thread's own time", timer=time.thread_time),
]


def _labels() -> NDArray[np.int32]:
    """30 blocks with borders as irregular as those of real surfaces."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    x = columns + 14 * np.sin(rows / 23) + 5 * np.sin(rows / 5)
    y = rows + 14 * np.sin(columns / 31) + 5 * np.sin(columns / 7)
    across = np.clip(x * ACROSS // WIDTH, 0, ACROSS - 1)
    down = np.clip(y * DOWN // HEIGHT, 0, DOWN - 1)
    return (1 + across + ACROSS * down).astype(np.int32)


@pytest.fixture(scope="module")
def frame() -> ilf.RGBDFrame:
    """Slanted depth with holes, and noisy colour."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    rng = np.random.default_rng(0)
    depth = (1.5 + 0.001 * rows + 0.0007 * columns + rng.normal(0, 0.002, rows.shape)).astype(np.float32)
    depth[(rows // 40 % 5 == 2) & (columns // 60 % 4 == 1)] = np.nan
    rgb = rng.integers(60, 200, (HEIGHT // 8, WIDTH // 8, 3), np.uint8).repeat(8, axis=0).repeat(8, axis=1)
    return ilf.RGBDFrame(rgb, depth, name="full-hd")


@pytest.fixture(scope="module")
def completed(frame: ilf.RGBDFrame) -> Execution:
    """A fast run with a result for every block."""
    with ilf.Run(frame, _labels(), ilf.preset("released-code", max_iterations=2)).steps() as run:
        for _ in run:
            pass
    return run


class Context:
    """The window with an open frame, and user actions, each until everything is painted."""

    def __init__(self, window: MainWindow) -> None:
        self.window = window
        self.view = window.views.cells["colour"].view
        self._steps = 0

    def settle(self) -> None:
        """Wait for results of other threads, so that they do not count for the next action."""
        wait(lambda: settled(self.window))
        pause(30)

    def tool(self, name: str) -> None:
        """Activate a tool by its action."""
        self.window.actions_[f"tool_{name}"].trigger()
        self.settle()

    def move(self, x: float, y: float) -> None:
        """Move the mouse to image coordinates."""
        QTest.mouseMove(self.view.viewport(), self._at(x, y))
        self._paint()

    def press(self, x: float, y: float) -> None:
        """Press the left button at image coordinates."""
        QTest.mousePress(self.view.viewport(), LEFT, pos=self._at(x, y))
        self._paint()

    def release(self, x: float, y: float) -> None:
        """Release the left button."""
        QTest.mouseRelease(self.view.viewport(), LEFT, pos=self._at(x, y))
        self._paint()

    def trigger(self, name: str) -> None:
        """Trigger a command by its name."""
        self.window.actions_[name].trigger()
        self._paint()

    def stroke_place(self) -> tuple[float, float]:
        """Return a different place near a border of the first block each time."""
        self._steps += 1
        return 150.0 + 9 * (self._steps % 12), 205.0 + 3 * (self._steps % 5)

    def _at(self, x: float, y: float):  # type: ignore[no-untyped-def]
        return self.view.viewportTransform().map(QPointF(x, y)).toPoint()

    def _paint(self) -> None:
        for _ in range(3):
            QApplication.processEvents()


@pytest.fixture
def context(qtbot, frame: ilf.RGBDFrame, completed: Execution) -> Iterator[Context]:  # type: ignore[no-untyped-def]
    window = new_window()
    qtbot.addWidget(window)
    window.actions_["live"].setChecked(False)
    document = Document(FrameState(frame.name, frame, Blocks(_labels())), None, frame.name)
    window.workspace.parameters.set(ilf.preset("released-code", max_iterations=2))
    window.workspace.open_document(document)
    document.store_results(list(completed.results.values()))
    document.end_run()
    window.workspace.select([1])
    context = Context(window)
    context.settle()
    yield context
    window.close()


def _bench(benchmark: BenchmarkFixture, act: Callable[[], None], prepare: Callable[[], None]) -> None:
    benchmark.pedantic(act, setup=lambda: prepare(), rounds=ROUNDS if benchmark.enabled else 1, warmup_rounds=1)


def test_brush_move(benchmark: BenchmarkFixture, context: Context) -> None:
    """A stroke grows by some pixels in four views."""
    context.tool("paint")
    context.press(120, 200)
    places = iter([(120 + 8 * step, 200 + 4 * (step % 4)) for step in range(60)])
    _bench(benchmark, lambda: context.move(*next(places)), lambda: None)
    context.release(300, 200)


def test_stroke_release(benchmark: BenchmarkFixture, context: Context) -> None:
    """A stroke is finished and becomes a step."""
    context.tool("paint")

    def stroke() -> None:
        x, y = context.stroke_place()
        context.press(x, y)
        context.move(x + 20, y + 9)

    def prepare() -> None:
        context.settle()
        stroke()

    _bench(benchmark, lambda: context.release(200, 210), prepare)


@pytest.mark.parametrize("way", ["undo", "redo"])
def test_history(benchmark: BenchmarkFixture, context: Context, way: str) -> None:
    """A step is undone or redone."""
    context.tool("paint")
    context.press(150, 205)
    context.move(190, 214)
    context.release(190, 214)

    def prepare() -> None:
        index = context.window.workspace.current.undo_stack.index()
        if (index == 0) == (way == "undo"):
            context.trigger("redo" if way == "undo" else "undo")
        context.settle()

    _bench(benchmark, lambda: context.trigger(way), prepare)


def test_split(benchmark: BenchmarkFixture, context: Context) -> None:
    """A block is cut along a line by the tool, from the last point on."""
    stack = context.window.workspace.current.undo_stack

    def prepare() -> None:
        stack.setIndex(0)
        context.tool("select")
        context.tool("split")
        context.window.workspace.select([9])
        context.settle()
        context.press(640 + 320, 180)
        context.move(640 + 330, 300)
        context.move(640 + 320, 470)

    _bench(benchmark, lambda: context.release(640 + 320, 470), prepare)
    assert stack.index() == 1


def test_select(benchmark: BenchmarkFixture, context: Context) -> None:
    """Another block is selected by a click."""
    blocks = [(160 + 320 * (step % ACROSS), 108 + 216 * (step // ACROSS % DOWN)) for step in range(60)]
    places = iter(blocks)

    def click() -> None:
        place = next(places)
        context.press(*place)
        context.release(*place)

    context.tool("select")
    _bench(benchmark, click, context.settle)


def test_hover(benchmark: BenchmarkFixture, context: Context) -> None:
    """The mouse moves without a button; crosshair and readout are updated."""
    context.tool("select")
    places = iter([(100 + 21 * step, 100 + 13 * step) for step in range(60)])
    _bench(benchmark, lambda: context.move(*next(places)), lambda: None)


def test_border(benchmark: BenchmarkFixture, context: Context) -> None:
    """A border is redrawn by the tool, from the last point on."""
    stack = context.window.workspace.current.undo_stack

    def prepare() -> None:
        stack.setIndex(0)
        context.tool("select")
        context.tool("border")
        context.press(320, 40)
        for y in (70, 100, 130):
            context.move(334, y)

    _bench(benchmark, lambda: context.release(322, 170), prepare)
    assert stack.index() == 1


def test_outline(benchmark: BenchmarkFixture, context: Context) -> None:
    """An outline is closed around pixels of several blocks, from the last point on."""
    stack = context.window.workspace.current.undo_stack

    def prepare() -> None:
        stack.setIndex(0)
        context.tool("select")
        context.tool("outline")
        context.window.workspace.select([9])
        context.settle()
        context.press(600, 180)
        for x, y in ((760, 170), (770, 330), (610, 340)):
            context.move(x, y)

    _bench(benchmark, lambda: context.release(602, 190), prepare)
    assert stack.index() == 1


@pytest.mark.benchmark(group="wall clock", timer=time.perf_counter)
def test_new_depth_after_an_edit(benchmark: BenchmarkFixture, context: Context) -> None:
    """From the end of a stroke in a block of 200 x 200 pixels to its painted depth."""
    workspace = context.window.workspace
    document = workspace.current
    labels = document.labels.copy()
    labels[200:400, 200:400] = 31
    workspace.current.edit(patch_between(document.labels, labels), "New block")
    workspace.parameters.set(ilf.preset())
    workspace.select([31])
    context.window.actions_["live"].setChecked(True)
    context.window.actions_["run_selected"].trigger()
    context.tool("erase")
    context.window.actions_["to_no_block"].setChecked(True)
    places = iter([(215 + 10 * (step % 17), 215 + 14 * (step // 17)) for step in range(60)])
    place = (0, 0)

    def prepare() -> None:
        nonlocal place
        wait(lambda: not context.window.feature(EditSummaryFeature).presenter.busy)
        context.settle()
        place = next(places)
        context.press(*place)

    def finish() -> None:
        context.release(*place)
        while 31 not in document.valid_results():
            QApplication.processEvents()
        QApplication.processEvents()

    _bench(benchmark, finish, prepare)


@pytest.mark.benchmark(group="wall clock", timer=time.perf_counter)
def test_window_is_up(benchmark: BenchmarkFixture) -> None:
    """From the start of the interpreter to a visible window."""
    program = (
        "from PySide6.QtWidgets import QApplication\n"
        "app = QApplication([])\n"
        "from gui.app.main_window import MainWindow\n"
        "window = MainWindow(persistent=False)\n"
        "window.show()\n"
        "app.processEvents()\n"
        "window.close()\n"
    )
    run = benchmark.pedantic(subprocess.run, ([sys.executable, "-c", program],), {"capture_output": True}, rounds=3)
    assert run.returncode == 0, run.stderr
