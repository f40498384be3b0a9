"""Timings for comparison, without limits: `python -m pytest tests/bench --benchmark-enable`.

`python tests/bench/pass_band.py` prints the speed-up of the pass band over the full grid.
"""

from __future__ import annotations

import itertools
import subprocess
import sys

import cv2
import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import ilf
from ilf._runtime.installation import asset_path
from ilf.completion.completion import CompletionRun
from ilf.completion.pass_band.iteration import PassBandIteration
from ilf.data.blocks import find_blocks
from ilf.data.parameters import PRESETS
from tests.reference.full_grid import FullGridIteration

ITERATIONS = 100


@pytest.fixture(scope="module")
def room() -> ilf.RGBDFrame:
    """The bundled sample."""
    return ilf.load_frame(asset_path("samples/room"))


@pytest.fixture(scope="module")
def room_blocks(room: ilf.RGBDFrame) -> np.ndarray:
    """Its operation blocks."""
    return ilf.extract_blocks(room)


def _scaled(frame: ilf.RGBDFrame, width: int, height: int) -> ilf.RGBDFrame:
    rgb = cv2.resize(frame.rgb, (width, height), interpolation=cv2.INTER_AREA)
    depth = cv2.resize(np.nan_to_num(frame.depth), (width, height), interpolation=cv2.INTER_NEAREST)
    return ilf.RGBDFrame(rgb, depth)


@pytest.mark.parametrize("stepper", [PassBandIteration, FullGridIteration], ids=["pass band", "full grid"])
@pytest.mark.benchmark(group="iterations of the largest block")
def test_iterations(
    benchmark: BenchmarkFixture,
    room: ilf.RGBDFrame,
    room_blocks: np.ndarray,
    stepper: type[PassBandIteration] | type[FullGridIteration],
) -> None:
    block = find_blocks(room_blocks)[1]
    parameters = ilf.preset("released-code", max_iterations=ITERATIONS)
    assert benchmark(lambda: sum(1 for _ in stepper(room, block, parameters))) == ITERATIONS


@pytest.mark.parametrize("name", ["paper", "released-code"])
@pytest.mark.benchmark(group="whole frame, blocks given")
def test_whole_frame(benchmark: BenchmarkFixture, room: ilf.RGBDFrame, room_blocks: np.ndarray, name: str) -> None:
    result = benchmark.pedantic(ilf.complete, (room, room_blocks, ilf.preset(name)), rounds=2)
    assert result.filled.any()


@pytest.mark.parametrize("threads", [1, None], ids=["one thread", "all cores"])
@pytest.mark.benchmark(group="whole frame, blocks given, by threads")
def test_threads(
    benchmark: BenchmarkFixture, room: ilf.RGBDFrame, room_blocks: np.ndarray, threads: int | None
) -> None:
    result = benchmark.pedantic(ilf.complete, (room, room_blocks), {"threads": threads}, rounds=5)
    assert result.filled.any()


@pytest.mark.parametrize("name", list(PRESETS))
@pytest.mark.benchmark(group="block of 200 x 200, a value changed")
def test_one_block_again(benchmark: BenchmarkFixture, room: ilf.RGBDFrame, name: str) -> None:
    """Work for one step of a slider in the window, each time with another value."""
    labels = np.zeros(room.shape, np.int32)
    labels[140:340, 240:440] = 1
    other_values = itertools.cycle([ilf.preset(name, s_criteria=0.0005 + 0.0001 * step) for step in range(7)])

    def again() -> CompletionRun:
        with CompletionRun(room, labels, next(other_values), only={1}) as run:
            for _ in run:
                pass
        return run

    assert benchmark(again).results[1].outcome.recovered


@pytest.mark.parametrize("size", [(320, 240), (640, 480), (1280, 960), (3840, 2160)], ids=str)
@pytest.mark.benchmark(group="extraction and completion by size")
def test_size(benchmark: BenchmarkFixture, room: ilf.RGBDFrame, size: tuple[int, int]) -> None:
    frame = _scaled(room, *size)
    result = benchmark.pedantic(lambda: ilf.complete(frame, ilf.extract_blocks(frame)), rounds=1)
    assert result.filled.any()


@pytest.mark.benchmark(group="window")
def test_window_is_up(benchmark: BenchmarkFixture) -> None:
    """From the start of the interpreter to a visible window."""
    program = (
        "from PySide6.QtWidgets import QApplication\n"
        "app = QApplication([])\n"
        "from gui.app.main_window import MainWindow\n"
        "window = MainWindow(remembers=False)\n"
        "window.show()\n"
        "app.processEvents()\n"
        "window.close()\n"
    )
    run = benchmark.pedantic(subprocess.run, ([sys.executable, "-c", program],), {"capture_output": True}, rounds=3)
    assert run.returncode == 0, run.stderr
