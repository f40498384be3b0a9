"""An edit in the real window: the depth follows, what it did is said, and the state before can be looked at."""

import gc
from threading import Event
from weakref import ref

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage
from PySide6.QtTest import QTest

from gui.features.edit_summary import EditSummaryFeature
from gui.features.filter import FilterPanel
from gui.features.history import HistoryFeature
from gui.work.frame_runs import RunState
from ilf._runtime.long_work import check_cancelled

from ..gui.states import edit
from .conftest import settle


def _picture(window) -> QImage:
    """What the view of the completed depth shows."""
    window.refresh.now()
    return window.views.cells["depth-out"].view.grab().toImage()


def test_an_edit_is_followed_by_its_depth_and_by_what_it_did(opened, qtbot, run_all):
    run_all(opened)
    document = opened.workspace.current
    depth, former = document.current_depth().copy(), _picture(opened)
    assert not opened.actions_["show_before_edit"].isEnabled()
    edit(opened.workspace, document.labels[20, 10], rows=np.s_[5:40], columns=np.s_[26:34])
    assert document.stale.any() or document.update_depth() is not None
    qtbot.waitUntil(lambda: "hold-out" in opened.feature(EditSummaryFeature).line.label.text())
    settle(opened, qtbot)
    assert document.changed_blocks() == []
    assert "hold-out" in opened.feature(EditSummaryFeature).line.label.text()
    assert opened.isWindowModified()
    # the same as by the library, drawn borders and all
    run = document.run(opened.workspace.parameters.current)
    assert run.blocks.drawn is not None
    np.testing.assert_array_equal(document.completion().depth, run.complete().depth)

    present = _picture(opened)
    assert present != former
    assert opened.actions_["show_before_edit"].isEnabled()
    view = opened.views.cells["colour"].view
    view.setFocus()
    QTest.keyPress(view, Qt.Key.Key_Z)
    assert "Before the edit" in opened.feature(EditSummaryFeature).line.label.text()
    assert _picture(opened) == former
    QTest.keyRelease(view, Qt.Key.Key_Z)
    assert "Before the edit" not in opened.feature(EditSummaryFeature).line.label.text()
    assert _picture(opened) == present
    assert document.undo_stack.index() == 1, "looking changes nothing"

    solved = document.completion()
    opened.actions_["undo"].trigger()
    assert opened.runs.state is RunState.IDLE, "what undo brings back is there"
    np.testing.assert_array_equal(document.current_depth(), depth)
    opened.feature(HistoryFeature).panel.stack().setIndex(1)
    assert opened.runs.state is RunState.IDLE
    np.testing.assert_array_equal(document.completion().depth, solved.depth)
    opened.actions_["show_before_edit"].trigger()
    assert "Before the edit" in opened.feature(EditSummaryFeature).line.label.text()
    opened.actions_["undo"].trigger()
    opened.refresh.now()
    assert not opened.actions_["show_before_edit"].isChecked(), "no edit is made blindly"
    assert "Before the edit" not in opened.feature(EditSummaryFeature).line.label.text()


def test_values_for_chosen_blocks_go_to_all_of_them(opened, qtbot, run_all):
    run_all(opened)
    document, panel = opened.workspace.current, opened.feature(FilterPanel)
    chosen = sorted(document.counts())
    opened.workspace.select(chosen)
    panel.scope.setCurrentIndex(1)
    panel.redraw()
    opened.refresh.now()
    panel.form.all_button.click()
    panel.form.findChild(object, "smoothness").setValue(3.0)
    assert document.blocks.own == {label: {"smoothness": 3.0} for label in chosen}
    settle(opened, qtbot)
    assert document.changed_blocks() == [], "all of them are solved again"
    panel.scope.setCurrentIndex(0)
    panel.redraw()
    panel.presets.chosen.emit("best")
    assert "Block 1 (Smoothness)" in opened.notes.message
    assert document.parameters_of(chosen[0]).smoothness == 3.0
    panel.scope.setCurrentIndex(1)
    panel.redraw()
    opened.workspace.select(chosen[:1])
    opened.actions_["reset_own"].trigger()
    assert sorted(document.blocks.own) == chosen[1:]
    opened.workspace.select(chosen[::-1])
    opened.actions_["copy_own"].trigger()
    assert sorted(document.blocks.own) == chosen
    for _ in range(4):
        opened.actions_["undo"].trigger()
    assert document.blocks.own == {}
    settle(opened, qtbot)


def test_a_closed_frame_leaves_memory_though_its_edit_is_being_evaluated(opened, qtbot, run_all, monkeypatch):
    begun, released = Event(), Event()

    def evaluated(*_):
        begun.set()
        while not released.wait(0.01):
            check_cancelled()

    monkeypatch.setattr("gui.features.edit_summary.summarise_edit", evaluated)
    run_all(opened)
    document = opened.workspace.current
    edit(opened.workspace, document.labels[20, 10], rows=np.s_[5:40], columns=np.s_[26:34])
    qtbot.waitUntil(begun.is_set)
    frame = ref(document.frame)
    del document
    opened.workspace.remove_entries([opened.workspace.current_entry])

    def gone() -> bool:
        gc.collect()
        return frame() is None

    try:
        qtbot.waitUntil(gone)
    finally:
        released.set()
