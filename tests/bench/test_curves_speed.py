"""Time of the window's thread per batch of records, with curves of four blocks of 500 iterations."""

from __future__ import annotations

import math
import time

import pytest
from PySide6.QtWidgets import QApplication
from pytest_benchmark.fixture import BenchmarkFixture
from pytestqt.qtbot import QtBot

from gui.views.curves.curve import Curve
from gui.views.curves.panel import CurvesPanel
from ilf.data.results import PassBandRecord

pytestmark = [pytest.mark.benchmark(group="curves, thread's own time", timer=time.thread_time)]

_COLOURS = [(220, 60, 60), (60, 160, 60), (60, 60, 220), (200, 160, 40)]


def _record(i: int, block: int) -> PassBandRecord:
    sigma = 0.3 * math.exp(-i / 80) * (1.5 + math.sin(i * (block + 1)))
    return PassBandRecord(i, 1 + i // 40, sigma, 1000.0 + i, 0.1, math.nan, 0.01 * i, (3.0, 4.0), False, error=sigma)


@pytest.mark.parametrize("blocks", [1, 4])
@pytest.mark.parametrize("size", [(300, 420), (1100, 190)])
def test_a_batch_of_records(qtbot: QtBot, benchmark: BenchmarkFixture, blocks: int, size: tuple[int, int]) -> None:
    panel = CurvesPanel()
    qtbot.addWidget(panel)
    panel.resize(*size)
    panel.show()
    records = [[_record(i, block) for i in range(1, 501)] for block in range(blocks)]
    curves = [Curve(f"Block {at}", _COLOURS[at], records[at], s_criteria=0.005) for at in range(blocks)]
    panel.show_curves(curves)
    QApplication.processEvents()

    def batch() -> None:
        for block, own in enumerate(records):
            own.extend(_record(len(own) + more, block) for more in range(1, 3))
        panel.show_curves(curves)
        QApplication.processEvents()

    benchmark.pedantic(batch, rounds=40, warmup_rounds=3)
