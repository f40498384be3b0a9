"""The convergence curves: what is drawn, where the stages are, and that nothing upsets the logarithm."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF
from PySide6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from gui.curves.curves_panel import EMPTY_TEXT, SIGMA_FLOOR, CurvesPanel, LengthAxis, SumAxis, length_text
from gui.curves.presenter import CurvesPresenter
from gui.state.session import Session
from gui.state.workspace import Workspace
from ilf.completion import complete
from ilf.filter.edge_aware.record import EdgeAwareRecord
from ilf.filter.pass_band.record import PassBandRecord
from ilf.frame import RGBDFrame
from ilf.run import Run


def staged(count=40, length=8, weighted=10):
    return [
        PassBandRecord(
            i,
            1 + (i - 1) // length,
            0.5 * 0.7 ** ((i - 1) % length),
            1000.0 + i,
            0.3 / i,
            math.nan,
            0.01 * i,
            radii=(2.0 + (i - 1) // length, 3.0 + (i - 1) // length),
            weighted=i <= weighted,
        )
        for i in range(1, count + 1)
    ]


def linear(count=40):
    return [
        PassBandRecord(i, i, 0.9 / i, 1000.0 + i, 0.3 / i, math.nan, 0.01 * i, (1 + 0.01 * i, 1 + 0.02 * i), False)
        for i in range(1, count + 1)
    ]


@pytest.fixture
def panel(qtbot):
    widget = CurvesPanel()
    qtbot.addWidget(widget)
    widget.resize(700, 300)
    widget.set_block(3, "Table", (200, 100, 0))
    widget.show()
    return widget


def drawn(plot):
    x, y = plot.curve.getData()
    return np.array(x), np.array(y)


def state(panel):
    curves = [drawn(plot) for plot in (panel.sigma_plot, panel.l1_plot)]
    return curves, list(panel.l1_plot._stages.xvals), panel.l1_plot._span.getRegion(), panel._readout.text()


def test_appending_equals_setting(qtbot, panel):
    records = staged()
    for start in range(0, len(records), 7):
        panel.append_records(records[start : start + 7])
    appended = state(panel)
    panel.set_records(records)
    np.testing.assert_equal(state(panel), appended)
    np.testing.assert_allclose(10 ** appended[0][0][1], [record.sigma_i for record in records])
    np.testing.assert_allclose(appended[0][1][1], [record.l1 for record in records])


def test_stages_are_marked_and_the_linear_schedule_has_none(panel):
    panel.set_records(staged(count=25, length=8))
    assert list(panel.sigma_plot._stages.xvals) == [8.5, 16.5, 24.5]
    assert panel.sigma_plot._stages.isVisible()
    panel.set_records(linear())
    assert not panel.sigma_plot._stages.isVisible()


def test_colour_weighted_iterations_are_shaded(panel):
    panel.set_records(staged(weighted=10))
    assert panel.sigma_plot._span.getRegion() == (0.5, 10.5)
    assert panel.sigma_plot._span.isVisible()
    panel.set_records(linear())
    assert not panel.sigma_plot._span.isVisible()


def test_hold_out_curve_is_there_with_its_least_where_pixels_are_held_out(panel):
    panel.set_records(linear())
    assert panel.error_plot.least is None
    assert not panel.error_plot.isVisible()
    assert "hold-out" not in panel._readout.text()
    held_out = [0.02 + 0.001 * abs(i - 25) for i in range(1, 41)]
    records = [replace(record, held_out=error) for record, error in zip(linear(), held_out, strict=True)]
    panel.set_records(records[:20])
    assert panel.error_plot.least == 20
    panel.append_records(records[20:])
    assert panel.error_plot.least == 25
    x, y = panel.error_plot.curve.getData()
    np.testing.assert_allclose(x, np.arange(1, 41))
    np.testing.assert_allclose(10**y, held_out)
    np.testing.assert_allclose(10 ** panel.error_plot.residual.getData()[1], [record.residual for record in records])
    low, high = panel.error_plot.getViewBox().viewRange()[1]
    assert low < math.log10(min(held_out)) < high
    assert "hold-out 35 mm" in panel._readout.text()
    panel.set_block(4, "", (1, 2, 3))
    assert panel.error_plot.least is None


def test_zero_and_unknown_sigma_do_not_upset_the_axis(qtbot, panel):
    records = [
        PassBandRecord(i, 1, sigma, 10.0, 0.1, math.nan, 0.0, (2.0, 2.0), False)
        for i, sigma in enumerate((0.5, 0.0, math.nan, 1e-12, 0.2), 1)
    ]
    panel.set_records(records)
    panel.grab()
    _, values = drawn(panel.sigma_plot)
    assert values[1] == values[3] == math.log10(SIGMA_FLOOR)
    low, high = panel.sigma_plot.getViewBox().viewRange()[1]
    assert -8 < low < high < 1


def test_the_criterion_is_in_view_and_says_its_value(panel):
    panel.set_s_criteria(0.005)
    panel.set_records(linear(10))
    panel.grab()
    low, high = panel.sigma_plot.getViewBox().viewRange()[1]
    assert low < math.log10(0.005) < high
    assert panel._criterion_line.label.toPlainText() == "S_criteria 5 mm"
    panel.set_s_criteria(None)
    assert not panel._criterion_line.isVisible()


def test_readout_follows_the_cursor_and_returns_to_the_last(panel):
    panel.set_records(staged())
    last = panel._readout.text()
    assert last.startswith("i 40 ")
    panel.sigma_plot.hovered.emit(11.7)
    assert panel._readout.text().startswith("i 12   σ 171 mm   L1 1,012 m   radii 3.0 × 4.0   stage 2")
    panel.sigma_plot.hovered.emit(-50.0)
    assert panel._readout.text().startswith("i 1 ")
    panel.sigma_plot.hovered.emit(math.nan)
    assert panel._readout.text() == last


def test_the_edge_aware_filter_tells_of_its_grid_and_round(panel):
    panel.resize(1100, 300)
    records = [EdgeAwareRecord(i, i, 0.1, 10.0, 0.1, math.nan, 0.0, cell=max(8 >> i, 1), round=i // 4) for i in (1, 4)]
    panel.set_records(records[:1])
    assert "L1 10 m   cells 4 px   stage 1" in panel._readout.text()
    assert not panel.sigma_plot._span.isVisible()
    panel.append_records(records[1:])
    assert "cells 1 px   round 1   stage 4" in panel._readout.text()


def test_another_block_starts_empty(panel):
    panel.set_records(staged())
    assert panel._pages.currentIndex() == 1
    panel.set_block(4, "", (1, 2, 3))
    assert panel.records == []
    assert panel._pages.currentIndex() == 0
    assert (panel._title.text(), panel._readout.text()) == ("Block 4", "")


@pytest.mark.parametrize(
    ("metres", "text"),
    [(10, "10 m"), (1, "1 m"), (0.1, "100 mm"), (1e-3, "1 mm"), (1e-4, "0.1 mm"), (1e-6, "1 µm"), (0, "0 mm")],
)
def test_lengths_have_the_unit_that_reads_best(metres, text):
    assert length_text(metres) == text


@pytest.mark.parametrize(
    ("low", "high", "size"), [(-6.2, 1.3, 90), (-2.5, -0.2, 200), (-3.0, 0.0, 20), (-2.3, -1.1, 60)]
)
def test_ticks_are_in_view_and_have_room(qtbot, low, high, size):
    ticks = sorted(value for _, level in LengthAxis().tickValues(low, high, size) for value in level)
    assert ticks
    assert all(low - 1e-6 <= value <= high + 1e-6 for value in ticks)
    assert all(b - a > 0.25 for a, b in pairwise(ticks))
    assert len(ticks) <= size / 9 + 1


def test_the_mouse_points_at_an_iteration_until_it_leaves(qtbot, panel):
    panel.set_records(staged())
    panel.grab()
    plot = panel.l1_plot
    place = plot.mapFromScene(plot.getViewBox().mapViewToScene(QPointF(12, 1010)))
    # two moves: a plot reports the mouse only once it has been inside
    for step in (QPoint(3, 3), QPoint(0, 0)):
        qtbot.mouseMove(plot.viewport(), place + step)
    qtbot.waitUntil(lambda: panel._readout.text().startswith("i 12 "))
    QApplication.sendEvent(plot, QEvent(QEvent.Type.Leave))
    assert panel._readout.text().startswith("i 40 ")


@pytest.mark.parametrize("height", [30, 45, 70, 200])
def test_labels_of_sums_have_room(qtbot: QtBot, height: int) -> None:
    ((_, values),) = SumAxis().tickValues(334_560, 335_470, height)
    assert 1 <= len(values) <= max(1, height / 15)


def test_a_block_without_curves_says_why(panel: CurvesPanel) -> None:
    depth = np.full((12, 16), 2.0, np.float32)
    frame = RGBDFrame(np.zeros((12, 16, 3), np.uint8), depth)
    workspace = Workspace()
    workspace.add_session(Session.of(Run(frame, np.ones((12, 16), np.int32)), "origin", "key"))
    workspace.select([1])
    presenter = CurvesPresenter(workspace, panel)
    panel.show()
    presenter.show()
    assert panel.hint == EMPTY_TEXT
    workspace.store_results(workspace.session, list(complete(frame, workspace.session.labels).results.values()))
    presenter.show()
    assert panel.hint == "All depth is known."
    workspace.show_session(None)
    presenter.show()
    assert panel.hint == EMPTY_TEXT
