"""Judging, sweeping and own presets in the real window."""

import gc
from dataclasses import replace
from threading import Event
from weakref import ref

import cv2
import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QApplication, QInputDialog, QWidget

import ilf
from gui.features.accuracy.ground_truth import GroundTruthDialog
from gui.features.accuracy.hold_out import HoldOutDialog
from gui.features.accuracy.panel import AccuracyPanel
from gui.features.blocks.feature import BlocksFeature
from gui.features.blocks.table import BlockColumn
from gui.features.filter import FilterPanel
from gui.features.presets import SavePresetDialog
from gui.features.sweep.feature import SweepFeature
from gui.state.parts import Part
from gui.views.colours import depth_table
from ilf._runtime.formatting import millimetres
from ilf.evaluation.evaluation import evaluate_blocks
from ilf.project.run_history import StoredRun
from ilf.sources.frame_ref import ReadingOptions

from ..gui.states import edit
from .conftest import answer, open_frame, settle


@pytest.fixture
def ground_truth_file(tmp_path, small_frame):
    """The small frame's depth 10 mm farther, holes included, in millimetres."""
    rows, columns = np.mgrid[:48, :64]
    depth = np.where(columns < 30, 1.51 + 0.004 * rows, 2.41 + 0.005 * columns)
    path = tmp_path / "true.png"
    cv2.imwrite(str(path), (1000 * depth).round().astype(np.uint16))
    return path


def errors_shown(window) -> list[str]:
    model = window.feature(BlocksFeature).table.model()
    return [model.index(row, BlockColumn.ERROR).data() for row in range(model.rowCount())]


def test_errors_against_a_truth_and_on_hidden_depth(window, qtbot, frame_folder, ground_truth_file, run_all):
    panel = window.feature(AccuracyPanel)
    workspace, actions = window.workspace, window.actions_
    assert not actions["load_ground_truth"].isEnabled()
    assert not actions["hold_out_test"].isEnabled()
    open_frame(window, qtbot, frame_folder)
    run_all(window)
    window.panels.reveal("Accuracy")
    settle(window, qtbot)
    qtbot.waitUntil(lambda: "–" not in errors_shown(window))  # without a truth the expected errors are shown
    assert panel.tabs.currentIndex() == 1  # without a truth, hidden depth is what there is

    # a truth by the dialog: what does not fit is said, what fits is taken
    actions["load_ground_truth"].trigger()
    dialog = window.findChild(GroundTruthDialog)
    dialog.units.setEditText("many")
    dialog.path.setText(str(ground_truth_file))
    dialog.read()
    assert dialog.message.tone() == "error"
    assert "Units per metre must be a number" in dialog.message.text()
    dialog.units.setEditText("100")
    dialog.read()
    settle(window, qtbot)
    assert "give 1000" in dialog.message.text()
    assert not dialog.accept_button.isEnabled()
    dialog.units.setCurrentIndex(0)
    dialog.choose(str(ground_truth_file))
    qtbot.waitUntil(dialog.accept_button.isEnabled)
    assert not dialog.depth_preview.picture.pixmap().isNull()
    described = "Known at 100% of the pixels without depth; median deviation from the known depth: 10.0 mm."
    assert dialog.message.text().startswith(described)
    dialog.accept()
    settle(window, qtbot)
    document = workspace.current
    assert document.frame.inputs.ground_truth.path == str(ground_truth_file)
    assert "true.png" in panel.source.text()

    # numbers are those of the library, for frame, block and rectangle, and in the table of blocks
    label = next(iter(document.counts()))
    box = slice(8, 24), slice(4, 24)
    workspace.select([label])
    workspace.current.look(Part.REGION, region=box)
    qtbot.waitUntil(lambda: len(panel.ground_truth_table.numbers) == 3)
    completion = document.completion()
    blocks = evaluate_blocks(document.frame, completion, document.labels)
    wanted = [
        ilf.evaluate_completion(document.frame, completion),
        blocks[label],
        ilf.evaluate_completion(document.frame, completion, box),
    ]
    assert [row.cells[0] for row in panel.ground_truth_table.numbers] == [millimetres(one.rmse) for one in wanted]
    assert [row.name for row in panel.ground_truth_table.numbers] == ["Frame", document.info(label).name, "Rectangle"]
    qtbot.waitUntil(lambda: errors_shown(window)[0] == millimetres(blocks[label].rmse))
    panel.pixels.setCurrentIndex(1)
    panel.pixels.activated.emit(1)
    everything = ilf.evaluate_completion(document.frame, completion, every=True)
    qtbot.waitUntil(lambda: panel.ground_truth_table.numbers[0].cells[0] == millimetres(everything.rmse))

    # runs that are compared stand below each other
    run = document.run(document.state.common)
    other = replace(run, parameters=ilf.PRESETS["paper"].replace(max_iterations=20))
    kept = StoredRun(1, "paper", other, other.complete().results, 0.1, (200, 0, 0))
    document.keep_run(kept)
    workspace.current.compare_runs([kept])
    qtbot.waitUntil(lambda: len(panel.ground_truth_table.numbers) == 9)
    assert [row.is_best for row in panel.ground_truth_table.numbers[:3]].count(True) == 0
    assert all("All are equal within" in row.hint for row in panel.ground_truth_table.numbers[1:3]), "of so few pixels"
    actions["remove_ground_truth"].trigger()
    settle(window, qtbot)
    assert document.frame.ground_truth is None
    qtbot.waitUntil(lambda: document.expected_error() is not None)
    rms = {label: np.sqrt(np.nanmean(document.expected_error()[document.labels == label] ** 2)) for label in (1, 2)}
    window.refresh.now()
    assert errors_shown(window) == [millimetres(rms[1]), millimetres(rms[2])]
    window.feature(BlocksFeature).table.sortByColumn(BlockColumn.ERROR, Qt.SortOrder.AscendingOrder)
    assert errors_shown(window) == [millimetres(error) for error in sorted(rms.values(), reverse=True)], "worst first"
    window.feature(BlocksFeature).table.sortByColumn(-1, Qt.SortOrder.AscendingOrder)
    assert not actions["remove_ground_truth"].isEnabled()

    # on hidden depth: the present values, a kept run and a preset, all on the same pixels
    actions["hold_out_test"].trigger()
    dialog = window.findChild(HoldOutDialog)
    assert [one.name for one in dialog.chosen()] == ["Current values", "paper"]
    dialog.hold_out.seeds.setValue(2)
    dialog.candidates.item(dialog.candidates.count() - 1).setCheckState(dialog.candidates.item(0).checkState())
    dialog.accept()
    settle(window, qtbot)
    rows = panel.hold_out_table.numbers
    assert [row.name for row in rows] == ["Current values", "paper", "Preset released-code"]
    assert len({row.cells[3] for row in rows}) == 1
    assert 1000 * kept.hold_out_error == pytest.approx(float(rows[1].cells[0]), abs=0.06)
    assert errors_shown(window)[0] == millimetres(panel.outcomes[document].errors_of(document)[label])
    assert panel.outcome.tone() == "muted"
    panel.hold_out_table.selectAll()
    assert panel.hold_out_table.text().splitlines()[1].startswith("Current values\t")
    held_out = errors_shown(window)[0]

    # other blocks: it is outdated until undo brings them back; other values: those of the blocks no longer hold
    edit(workspace, document.next_label(), rows=np.s_[40:44], columns=np.s_[2:20])
    settle(window, qtbot)
    assert panel.outcome.tone() == "warning"
    assert "Outdated" in panel.outcome.text()
    assert errors_shown(window)[0] != held_out
    actions["undo"].trigger()
    settle(window, qtbot)
    assert panel.outcome.tone() == "muted"
    assert errors_shown(window)[0] == held_out
    workspace.parameters.set(document.state.common.replace(smoothness=3.0), label)
    settle(window, qtbot)
    assert errors_shown(window)[0] == "–"
    assert errors_shown(window)[1] != "–"

    # a test that is cancelled leaves the last one
    former = panel.outcomes[document]
    actions["hold_out_test"].trigger()
    again = window.findChildren(HoldOutDialog)[-1]
    assert [one.name for one in again.chosen()] == [one.name for one in former.candidates]
    again.accept()
    panel.work.cancel_button.click()
    settle(window, qtbot)
    assert panel.outcomes[document] is former
    assert panel.work.isHidden()

    # depth by hand outdates it, before anything is run with it
    actions["clear_results"].trigger()
    settle(window, qtbot)
    assert "Outdated" not in panel.outcome.text()
    document.set_by_hand(np.full(document.frame.shape, 1.0, np.float32), document.labels == label, "Paint")
    settle(window, qtbot)
    assert "Outdated" in panel.outcome.text()


def test_a_frame_with_ground_truth_is_not_kept_in_memory_once_it_is_closed(opened, qtbot, run_all):
    opened.workspace.current.set_ground_truth(np.full((48, 64), 2.0, np.float32))
    run_all(opened)
    settle(opened, qtbot)
    assert "–" not in errors_shown(opened)
    document = ref(opened.workspace.current)
    opened.workspace.remove_entries(list(opened.workspace.entries))
    settle(opened, qtbot)
    gc.collect()
    assert document() is None


def test_a_sweep_shows_what_comes_and_a_click_takes_a_value(window, qtbot, frame_folder, ground_truth_file):
    workspace, shown = window.workspace, window.feature(SweepFeature)
    open_frame(window, qtbot, frame_folder, options=ReadingOptions(ground_truth=str(ground_truth_file)))
    document = workspace.current
    # from the menu of a parameter in the form
    form = window.feature(FilterPanel).form
    form.all_button.click()
    row = form.findChild(QWidget, "smoothness").parentWidget()
    row.customContextMenuRequested.emit(QPoint(2, 2))
    menu = QApplication.activePopupWidget()
    assert menu.actions()[0].text() == "Sweep Smoothness…"
    menu.actions()[0].trigger()
    menu.close()
    assert shown.visible
    assert shown.first.declaration.name == "smoothness"
    assert shown.second.declaration.name != shown.first.declaration.name
    assert shown.criterion.by_ground_truth
    shown.first.low.setValue(9.0)
    shown.first.high.setValue(1.0)
    assert not shown.start_button.isEnabled()
    assert "must increase" in shown.state.text()
    shown.first.low.setValue(0.01)
    shown.first.high.setValue(100.0)
    shown.first.steps.setValue(3)
    shown.start_button.click()
    qtbot.waitUntil(lambda: not shown.busy)
    tiles = [shown.pictures.item(*shown.pictures.place(number)).text() for number in range(3)]
    assert [text.splitlines()[0].partition(" ")[0] for text in tiles] == ["0.01", "1", "100"]
    widest = max(shown.pictures.fontMetrics().horizontalAdvance(line) for text in tiles for line in text.splitlines())
    assert widest <= shown.pictures.iconSize().width(), "captions are not cut off"
    assert ["current" in text for text in tiles] == [False, True, False]
    marked = {number for number, text in enumerate(tiles) if "best" in text or "equal" in text}
    assert marked == shown.found.marked
    assert ("equal within" in shown.state.text()) == (len(marked) > 1)
    assert "over the pixels that all values filled" in shown.state.text()
    assert len(shown.found.errors) == 3
    assert [shown.content.itemText(number) for number in range(2)] == ["Depth", "Error"]
    window.views.ranges.set_depth_map("grey")
    settle(window, qtbot)
    bar = shown.bar.grab().toImage()
    left = bar.pixelColor(0, bar.height() - 1).getRgb()[:3]
    np.testing.assert_allclose(left, depth_table("grey")[1, :3].astype(int), atol=2)
    shown.pictures.setFocus()
    shown.pictures.setCurrentCell(*shown.pictures.place(2))
    qtbot.keyClick(shown.pictures, Qt.Key.Key_Return)
    assert not shown.busy, "no new sweep"
    assert document.state.common.smoothness == 100.0
    settle(window, qtbot)
    assert "current" in shown.pictures.item(*shown.pictures.place(2)).text()
    window.actions_["undo"].trigger()
    assert document.state.common.smoothness == 1.0

    # what is opened later is about the present value
    shown.widget.close()
    workspace.parameters.set(document.state.common.replace(smoothness=1e5))
    window.actions_["sweep"].trigger()
    assert shown.first.low.value() < 1e5 < shown.first.high.value()
    window.actions_["undo"].trigger()

    # two of the chosen block alone, by hidden depth: its own values are taken
    label = next(iter(document.counts()))
    workspace.select([label])
    settle(window, qtbot)
    shown.criterion.kind.setCurrentIndex(1)
    shown.criterion.blocks.setCurrentIndex(1)
    shown.second.setChecked(True)
    shown.second.choose("smoothness")
    assert "two different" in shown.state.text()
    shown.second.choose("slope_weight")
    shown.second.steps.setValue(2)
    shown.start_button.click()
    assert not shown.first.isEnabled()
    qtbot.waitUntil(lambda: not shown.busy)
    cells = shown.pictures.rowCount() * shown.pictures.columnCount()
    assert len(shown.found.errors) == cells == 9  # with the present value among the second's
    texts = [shown.pictures.item(*shown.pictures.place(number)).text() for number in range(9)]
    widest = max(shown.pictures.fontMetrics().horizontalAdvance(line) for text in texts for line in text.splitlines())
    assert widest <= shown.pictures.iconSize().width()
    wanted = shown.found.points[0]
    shown.pictures.taken.emit(0)
    assert document.blocks.own[label] == wanted
    assert set(wanted) == {"smoothness", "slope_weight"}
    workspace.select([])
    shown.pictures.taken.emit(1)
    qtbot.waitUntil(lambda: document.is_up_to_date(label))  # solved, though it is not chosen
    workspace.select([label])

    # what had come stays when it is cancelled; what is of a closed frame goes
    shown.start_button.click()
    shown.work.cancel_button.click()
    qtbot.waitUntil(lambda: not shown.busy)
    assert "Cancelled" in shown.state.text()
    assert "not run" in shown.pictures.item(*shown.pictures.place(8)).text()
    assert shown.first.isEnabled()
    shown.start_button.click()
    window.actions_["close_frame"].trigger()
    settle(window, qtbot)
    assert shown.found is None
    assert not shown.pictures.isVisible()
    assert "Running" not in shown.state.text()


def test_own_presets_stand_beside_the_others(opened, qtbot, tmp_path, monkeypatch):
    monkeypatch.setattr("gui.state.parameters.DRAG_S", 0.0)  # a user takes longer from one choice to the next
    window, box = opened, opened.feature(FilterPanel).presets
    workspace, actions = window.workspace, window.actions_
    window.workspace.parameters.set(ilf.PRESETS["paper"].replace(padding=3.0))
    settle(window, qtbot)
    assert not actions["rename_preset"].isEnabled()
    box.ask_save()
    dialog = window.findChild(SavePresetDialog)
    dialog.name.setText("wide")
    dialog.with_extraction.setChecked(True)
    dialog.accept()
    settle(window, qtbot)
    assert box.present == "wide"
    assert box.names.currentText() == "wide"
    assert actions["rename_preset"].isEnabled()
    window.feature(FilterPanel).form.changed.emit(ilf.PRESETS["paper"].replace(padding=4.0))
    settle(window, qtbot)
    assert box.names.currentText() == "wide (changed)"

    # choosing it is one undoable step
    workspace.parameters.set(ilf.PRESETS["best"])
    settle(window, qtbot)
    assert box.present == "best"
    box.names.setCurrentIndex(box.names.findData("wide"))
    box.names.activated.emit(box.names.currentIndex())
    assert workspace.parameters.current.padding == 3.0
    actions["undo"].trigger()
    assert workspace.parameters.current == ilf.PRESETS["best"]
    actions["redo"].trigger()
    settle(window, qtbot)

    monkeypatch.setattr(QInputDialog, "getText", lambda *_, **__: ("broad", True))
    actions["rename_preset"].trigger()
    settle(window, qtbot)
    assert box.names.findData("wide") < 0
    assert box.present == "broad"
    exported = tmp_path / "broad.json"
    monkeypatch.setattr("gui.features.presets.ask_path", lambda *_: str(exported))
    actions["export_preset"].trigger()
    for button in ("Cancel", "&Delete"):
        assert box.names.findData("broad") >= 0
        actions["delete_preset"].trigger()
        answer(window, button)
    settle(window, qtbot)
    assert box.names.findData("broad") < 0
    assert box.present == "paper"
    assert "(changed)" in box.names.currentText()
    monkeypatch.setattr("gui.features.presets.choose_file", lambda *_: str(exported))
    actions["import_preset"].trigger()
    assert box.parameters("broad").padding == 3.0
    reported = []
    window.notes.reported.connect(reported.append)
    monkeypatch.setattr("gui.features.presets.choose_file", lambda *_: str(tmp_path / "none.json"))
    actions["import_preset"].trigger()
    assert reported
    assert "none.json" in reported[0]


def test_a_hold_out_test_ends_with_its_frame(opened, qtbot, monkeypatch):
    panel, goes_on = opened.feature(AccuracyPanel), Event()
    monkeypatch.setattr("gui.features.accuracy.panel.outcome_steps", lambda *_: goes_on.wait(5))
    opened.actions_["hold_out_test"].trigger()
    opened.findChild(HoldOutDialog).accept()
    assert panel.busy
    assert [work.what for work in panel.pending_work()] == ["a hold-out test of two-planes"]
    opened.actions_["close_frame"].trigger()
    opened.refresh.now()
    assert panel.pending_work() == [], "though it tells no progress"
    assert "Open a frame" in panel.source.text()
    goes_on.set()
    settle(opened, qtbot)
