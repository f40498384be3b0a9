"""Runs in the real window: run, drag a value, compare, restore, accept, undo, rename, delete."""

import csv

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QSlider

from gui.features.filter import FilterPanel
from gui.features.run_history.panel import RunsPanel
from gui.features.run_history.table import RunColumn
from gui.work.frame_runs import RunState
from ilf import preset


@pytest.fixture
def part(opened):
    """What keeps the window's runs, with its panel open."""
    opened.actions_["show_runs"].trigger()
    return opened.feature(RunsPanel)


def _cell(part, row: int, column: RunColumn, role: Qt.ItemDataRole = Qt.ItemDataRole.DisplayRole) -> object:
    model = part.view.model()
    return model.index(row, column).data(role)


def _type(part, row: int, column: RunColumn, text: str):
    """Into a cell, after F2."""
    view = part.view
    index = view.model().index(row, column)
    view.setCurrentIndex(index)
    QTest.keyClick(view, Qt.Key.Key_F2)
    editor = view.indexWidget(index)
    editor.setText(text)
    QTest.keyClick(editor, Qt.Key.Key_Return)
    QApplication.processEvents()  # what was typed is taken at the next turn


def test_runs_are_kept_compared_and_come_back_to(opened, part, qtbot, run_all, monkeypatch):
    monkeypatch.setattr("gui.state.parameters.DRAG_S", 1000.0)  # however busy the machine is
    workspace, actions = opened.workspace, opened.actions_
    document = workspace.current
    workspace.parameters.set(preset("paper"))
    run_all(opened)
    depth = document.completion().depth.copy()
    chosen = next(iter(document.counts()))
    workspace.select([chosen])
    opened.panels.reveal("Parameters")
    opened.refresh.now()
    form = opened.feature(FilterPanel).form
    form.all_button.click()
    slider = form.findChild(QSlider, "slider_padding")
    for position in (5, 6, 7, 8):
        slider.setValue(position)
        qtbot.waitUntil(lambda: opened.runs.state is RunState.IDLE)
    opened.panels.reveal("Runs")
    qtbot.waitUntil(lambda: len(document.state.runs) == 2 and not part.keeper.waits)
    first, live = document.state.runs
    qtbot.waitUntil(lambda: None not in (first.expected_error, live.expected_error))
    opened.refresh.now()
    texts = [_cell(part, row, RunColumn.NAME) for row in (0, 1)]
    assert texts == ["● Live 2", "Run 1"]
    assert _cell(part, 0, RunColumn.VALUES) == "paper, padding 3 x"
    numbers = [str(_cell(part, row, RunColumn.EXPECTED)) for row in (0, 1)]
    assert sum(text.startswith("★") for text in numbers) == 1
    assert _cell(part, 0, RunColumn.GROUND_TRUTH) == "–"

    assert not actions["accept_run"].isEnabled(), "no run is chosen"
    part.view.selectRow(1)
    actions["compare_runs"].trigger()
    assert document.compared == [first]
    opened.refresh.now()
    assert Qt.CheckState(_cell(part, 1, RunColumn.COMPARED, Qt.ItemDataRole.CheckStateRole)) == Qt.CheckState.Checked
    actions["compare_runs"].trigger()
    assert document.compared == []

    actions["accept_run"].trigger()
    opened.refresh.now()
    assert (document.state.common, document.changed_blocks()) == (preset("paper"), [])
    np.testing.assert_array_equal(document.completion().depth, depth)
    np.testing.assert_array_equal(document.current_depth(), depth)
    assert _cell(part, 1, RunColumn.NAME) == "● Run 1"
    actions["undo"].trigger()
    assert live.is_of(document.valid_results())
    actions["restore_run"].trigger()
    assert document.state.common == preset("paper")
    actions["undo"].trigger()
    assert document.state.common.padding == 3.0

    _type(part, 1, RunColumn.NAME, "as printed")
    _type(part, 0, RunColumn.VALUES, "sharper")
    assert (first.name, live.note) == ("as printed", "sharper")
    document.compare_runs([live])
    live.ground_truth_error = 0.001
    part.view.selectRow(0)
    QTest.keyClick(part.view, Qt.Key.Key_Delete)
    assert (document.state.runs, document.compared) == ((first,), [])
    actions["undo"].trigger()
    assert (document.state.runs, document.compared) == ((first, live), [live])
    assert live.ground_truth_error is None, "there may be another truth since"
    opened.refresh.now()
    assert part.view.rows.keys == [live, first]
    assert len(document.state.runs) == 2, "undo solves nothing anew"


def test_another_frame_has_runs_of_its_own(opened, part, run_all):
    run_all(opened)
    opened.refresh.now()
    assert len(part.view.rows.keys) == 1
    opened.actions_["close_frame"].trigger()
    QApplication.processEvents()
    assert part.view.rows.keys == []
    assert not any(opened.actions_[name].isEnabled() for name in ("export_runs", "clear_runs", "delete_runs"))


def test_the_list_is_written_with_its_errors_though_the_panel_is_closed(opened, qtbot, run_all, tmp_path):
    run_all(opened)
    panel = opened.feature(RunsPanel)
    assert not panel.visible
    assert opened.workspace.current.state.runs[0].expected_error is None, "nothing is computed for a closed panel"
    panel.export(str(tmp_path / "runs.csv"))
    qtbot.waitUntil((tmp_path / "runs.csv").is_file)
    (line,) = csv.DictReader((tmp_path / "runs.csv").read_text().splitlines())
    assert float(line["expected_error_rms [mm]"]) > 0


def test_the_list_is_written_as_it_was_when_that_was_asked_for(opened, qtbot, run_all, tmp_path):
    panel, document = opened.feature(RunsPanel), opened.workspace.current
    run_all(opened)
    panel.export(str(tmp_path / "runs.csv"))
    document.delete_runs(list(document.state.runs))
    qtbot.waitUntil((tmp_path / "runs.csv").exists)
    assert len((tmp_path / "runs.csv").read_text().splitlines()) == 2
