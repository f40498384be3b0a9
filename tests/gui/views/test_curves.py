"""The convergence curves: what is drawn, where the stages are, and that nothing upsets the logarithm."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF
from PySide6.QtWidgets import QApplication

import ilf
from gui.features.curves import draw_curves
from gui.state.document import Document
from gui.state.workspace import Workspace
from gui.views.curves.axes import LengthAxis
from gui.views.curves.curve import Curve
from gui.views.curves.panel import EMPTY_TEXT, CurvesPanel
from ilf.data.results import EdgeAwareRecord, PassBandRecord


def show(panel: CurvesPanel, workspace: Workspace) -> None:
    draw_curves(panel, workspace.shown)


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
def panel(shown):
    return shown(CurvesPanel(), 700, 500)


def curve(records, name="Table", **looks):
    return Curve(name, (200, 100, 0), records, **looks)


def drawn(plot, line=0):
    x, y = plot.lines[line].getData()
    return np.array(x), np.array(y)


def marks(plot):
    return [list(group.xvals) for group in plot._stages if len(group.xvals)]


def texts(plot):
    return [line.label.toPlainText() for line in plot.labels]


def state(panel):
    curves = [drawn(plot) for plot in (panel.sigma_plot, panel.l1_plot)]
    return curves, marks(panel.l1_plot), panel.l1_plot._span.getRegion(), panel.readout.text


def test_growing_equals_showing(panel):
    records, growing = staged(), []
    for start in range(0, len(records), 7):
        growing.extend(records[start : start + 7])
        panel.show_curves([curve(growing)])
    grown = state(panel)
    panel.show_curves([curve(records)])
    np.testing.assert_equal(state(panel), grown)
    np.testing.assert_allclose(10 ** grown[0][0][1], [record.sigma_i for record in records])
    np.testing.assert_allclose(grown[0][1][1], [record.l1 for record in records])
    panel.show_curves([curve(records[:5])])
    np.testing.assert_equal(drawn(panel.sigma_plot)[0], [1, 2, 3, 4, 5])


def test_hold_out_curve_is_there_with_its_least_where_pixels_are_held_out(panel):
    panel.show_curves([curve(linear())])
    assert not panel.hold_out_plot.isVisible()
    assert "hold-out" not in panel.readout.text
    held_out = [0.02 + 0.001 * abs(i - 25) for i in range(1, 41)]
    records = [replace(record, held_out=error) for record, error in zip(linear(), held_out, strict=True)]
    growing = records[:20]
    panel.show_curves([curve(growing)])
    assert texts(panel.hold_out_plot) == ["minimum at i = 20"]
    growing.extend(records[20:])
    panel.show_curves([curve(growing)])
    assert texts(panel.hold_out_plot) == ["minimum at i = 25"]
    (x, y), (_, residual) = drawn(panel.hold_out_plot, 1), drawn(panel.hold_out_plot, 0)
    np.testing.assert_allclose(x, np.arange(1, 41))
    np.testing.assert_allclose(10**y, held_out)
    np.testing.assert_allclose(10**residual, [record.residual for record in records])
    (first, last), (low, high) = panel.hold_out_plot.getViewBox().viewRange()
    assert first <= 1 < 40 <= last
    assert low < math.log10(min(held_out)) < high
    assert "hold-out 35 mm" in panel.readout.text
    panel.show_curves([curve(records), curve(linear(), "Wall")])
    assert texts(panel.hold_out_plot) == []
    panel.show_curves([curve(linear())])
    assert not panel.hold_out_plot.isVisible()


def test_the_error_against_a_truth_has_a_plot_and_a_column(panel):
    panel.show_curves([curve(linear())])
    assert not panel.error_plot.isVisible()
    panel.show_curves([curve([replace(record, error=0.2 / record.i) for record in linear()])])
    assert panel.error_plot.isVisible()
    np.testing.assert_allclose(10 ** drawn(panel.error_plot)[1], 0.2 / np.arange(1, 41))
    assert "err 5 mm" in panel.readout.text


def test_a_corrected_block_has_the_error_of_its_depth(panel):
    depth = np.full((24, 32), 2.0, np.float32)
    depth[8:16, 8:24] = np.nan
    frame = ilf.RGBDFrame(np.zeros((24, 32, 3), np.uint8), depth, ground_truth=np.full((24, 32), 2.01, np.float32))
    workspace = Workspace()
    workspace.open_document(Document.of(ilf.Run(frame, np.ones((24, 32), np.int32)), "origin", "key"))
    document = workspace.current
    (result,) = ilf.complete(frame, document.labels).results.values()
    for correction, expected in ((("a" * 64,), "err 20 mm"), ((), "err 10 mm")):
        document.store_results([replace(result, depth=result.depth - 0.01, correction=correction)])
        show(panel, workspace)
        assert expected in panel.readout.text


def test_the_criteria_are_in_view_and_say_their_values(panel):
    panel.show_curves([curve(linear(10), s_criteria=0.005)])
    panel.grab()
    low, high = panel.sigma_plot.getViewBox().viewRange()[1]
    assert low < math.log10(0.005) < high
    assert texts(panel.sigma_plot) == ["S_criteria 5 mm"]
    panel.show_curves([curve(linear(10), s_criteria=metres, remark="own") for metres in (0.005, 0.001, 0.005)])
    assert texts(panel.sigma_plot) == ["S_criteria 5 mm (own)", "S_criteria 1 mm (own)"]
    panel.show_curves([curve(linear(10))])
    assert texts(panel.sigma_plot) == []


def test_readout_follows_the_cursor_and_returns_to_the_last(panel):
    panel.show_curves([curve(staged())])
    last = panel.readout.text
    assert last.startswith("Table   i 40 ")
    panel.sigma_plot.hovered.emit(11.7)
    assert panel.readout.text.startswith("Table   i 12   σ 171 mm   L1 1,012 m   radii 3.0 × 4.0   stage 2")
    panel.sigma_plot.hovered.emit(-50.0)
    assert panel.readout.text.startswith("Table   i 1 ")
    panel.sigma_plot.hovered.emit(math.nan)
    assert panel.readout.text == last


@pytest.mark.parametrize(("l1", "said"), [(12.34, "L1 12.34 m "), (12_345.6, "L1 12,346 m ")])
def test_readout_gives_the_norm_with_four_digits_or_all_of_a_large_one(panel, l1, said):
    panel.show_curves([curve([replace(record, l1=l1) for record in staged()])])
    assert said in panel.readout.text


def test_a_curve_that_ended_at_a_limit_says_so(panel):
    sentence = "Stopped at the limit of steps before it was steady."
    panel.show_curves([curve(staged(), limit=sentence)])
    assert panel.readout.text.startswith("Table: not converged   i 40 ")
    assert sentence in panel.readout.toolTip()
    assert sentence in panel.readout.accessibleDescription()
    panel.show_curves([curve(staged())])
    assert "not converged" not in panel.readout.text
    assert panel.readout.toolTip() == ""


def test_over_time_the_nearest_in_time_is_read(panel):
    panel.show_curves([curve(staged())])
    axes = [plot.getAxis("bottom") for plot in (panel.sigma_plot, panel.l1_plot)]
    by_iterations = [axis.labelText for axis in axes]
    panel.set_by_time(True)
    assert [axis.labelText for axis in axes] != by_iterations
    np.testing.assert_allclose(drawn(panel.sigma_plot)[0], 0.01 * np.arange(1, 41))
    assert marks(panel.l1_plot)[0][0] == pytest.approx(0.085)
    panel.sigma_plot.hovered.emit(0.122)
    assert panel.readout.text.startswith("Table   i 12   0.12 s   σ 171 mm")
    panel.set_by_time(False)
    assert drawn(panel.sigma_plot)[0][-1] == 40
    assert [axis.labelText for axis in axes] == by_iterations


def test_the_choice_of_the_axis_is_remembered(qtbot):
    for on in (True, False):
        first = CurvesPanel()
        qtbot.addWidget(first)
        first.set_by_time(on)
        second = CurvesPanel()
        qtbot.addWidget(second)
        assert second._by_time is on


def test_the_edge_aware_filter_tells_of_its_grid_and_round(panel):
    panel.resize(1100, 500)
    records = [EdgeAwareRecord(i, i, 0.1, 10.0, 0.1, math.nan, 0.0, cell=max(8 >> i, 1), round=i // 4) for i in (1, 4)]
    panel.show_curves([curve(records[:1])])
    assert "L1 10 m   cells 4 px   round –   stage 1" in panel.readout.text
    assert not panel.sigma_plot._span.isVisible()
    panel.show_curves([curve(records)])
    assert "cells 1 px   round 1   stage 4" in panel.readout.text


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
    panel.show_curves([curve(staged())])
    panel.grab()
    plot = panel.l1_plot
    place = plot.mapFromScene(plot.getViewBox().mapViewToScene(QPointF(12, 1010)))
    # two moves: a plot reports the mouse only once it has been inside
    for step in (QPoint(3, 3), QPoint(0, 0)):
        qtbot.mouseMove(plot.viewport(), place + step)
    qtbot.waitUntil(lambda: panel.readout.text.startswith("Table   i 12 "))
    QApplication.sendEvent(plot, QEvent(QEvent.Type.Leave))
    assert panel.readout.text.startswith("Table   i 40 ")


def test_a_block_without_curves_says_why(panel):
    depth = np.full((12, 16), 2.0, np.float32)
    frame = ilf.RGBDFrame(np.zeros((12, 16, 3), np.uint8), depth)
    workspace = Workspace()
    workspace.open_document(Document.of(ilf.Run(frame, np.ones((12, 16), np.int32)), "origin", "key"))
    workspace.select([1])
    show(panel, workspace)
    assert panel.hint == EMPTY_TEXT
    workspace.current.store_results(list(ilf.complete(frame, workspace.current.labels).results.values()))
    show(panel, workspace)
    assert panel.hint == "All depth is known."
    workspace.show(None)
    show(panel, workspace)
    assert panel.hint == EMPTY_TEXT


def test_zooming_one_plot_zooms_all_until_a_double_click(panel):
    growing = staged(20)
    panel.show_curves([curve(growing)])
    view = panel.l1_plot.getViewBox()
    view.setXRange(5, 15, padding=0)
    view.sigRangeChangedManually.emit(view.state["mouseEnabled"])
    growing.extend(linear(40)[20:])
    panel.show_curves([curve(growing)])
    assert panel.sigma_plot.getViewBox().viewRange()[0] == pytest.approx([5, 15])
    panel.sigma_plot.fit_requested.emit()
    for plot in (panel.sigma_plot, panel.l1_plot):
        low, high = plot.getViewBox().viewRange()[0]
        assert low <= 1
        assert 40 <= high <= 46
