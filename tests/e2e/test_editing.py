"""Editing blocks with the mouse in the real window."""

import numpy as np
import pytest
from PySide6.QtCore import QEvent, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from gui.features.blocks.feature import BlocksFeature
from gui.features.blocks.table import BlockColumn
from gui.features.status import StatusFeature
from ilf import RGBDFrame

from .conftest import open_frame, readout, write_frame
from .hand import click, drag, let_go, viewport


@pytest.fixture
def editing(opened):
    """The window on a frame of two blocks: 1 on the right, larger, and 2 on the left."""
    counts = opened.workspace.current.counts()
    assert set(counts) == {1, 2}
    return opened


def test_clicking_chooses_control_adds_and_so_does_the_table_which_renames_locks_and_hides(editing):
    document = editing.workspace.current
    click(editing, (50, 24))
    assert document.selected == [int(document.labels[24, 50])]
    click(editing, (5, 24), Qt.KeyboardModifier.ControlModifier)
    assert len(document.selected) == 2
    editing.refresh.now()
    assert sorted(editing.feature(BlocksFeature).table.chosen()) == sorted(document.selected)
    click(editing, (5, 24), Qt.KeyboardModifier.ControlModifier)
    assert document.selected == [int(document.labels[24, 50])]
    editing.feature(BlocksFeature).table.select([])
    editing.feature(BlocksFeature).table.selectRow(1)
    assert document.selected == editing.feature(BlocksFeature).table.chosen()
    assert len(document.selected) == 1

    workspace, table, before = editing.workspace, editing.feature(BlocksFeature).table, document.labels.copy()

    def click_icon(column: BlockColumn) -> None:
        """Click it in the row of block 1."""
        editing.refresh.now()
        at = table.visualRect(table.model().index(table.labels().index(1), column)).center()
        QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=at)

    table.model().setData(table.model().index(table.labels().index(1), BlockColumn.NAME), "Wall")
    click_icon(BlockColumn.LOCKED)
    click_icon(BlockColumn.VISIBLE)
    assert (document.info(1).name, document.locked, document.info(1).visible) == ("Wall", {1}, False)
    assert document.selected == [2], "icons select nothing"
    assert np.array_equal(document.labels, before)
    assert document.undo_stack.undoText() == "Lock Wall"
    click_icon(BlockColumn.LOCKED)
    assert document.undo_stack.undoText() == "Unlock Wall"
    for _ in range(3):
        workspace.undo_group.undo()
    assert (document.info(1).name, document.locked, document.info(1).visible) == ("Block 1", set(), False)
    assert document.undo_stack.index() == 0, "looking at less is no step"


def test_erasing_takes_from_the_chosen_block_only_and_ctrl_swaps(editing):
    document = editing.workspace.current
    before = document.labels.copy()
    click(editing, (50, 24))
    editing.actions_["tool_erase"].trigger()
    editing.editor.options.brush_radius = 4.0
    drag(editing, [(26, 24), (34, 24)], release=False)
    assert document.labels[24, 32] == 0, "under way, they are seen to go"
    let_go(editing, (34, 24))
    assert document.undo_stack.undoText() == "Erase from Block 1"
    changed = document.labels != before
    assert changed.any()
    assert (before[changed] == before[24, 50]).all()
    assert (document.labels[changed] == before[24, 5]).all(), "the neighbour gets them"
    editing.editor.set_option("to_no_block", True)
    drag(editing, [(40, 24), (48, 24)])
    assert document.labels[24, 44] == 0
    drag(editing, [(40, 24), (34, 24)], Qt.KeyboardModifier.ControlModifier)
    assert document.labels[24, 34] == before[24, 50]


def test_readout_tells_block_and_depths(editing):
    text = readout(editing, (50, 5))
    assert "x 50, y 5" in text
    assert "in 2.650 m" in text
    assert "in missing" in readout(editing, (45, 35))
    document = editing.workspace.current
    rows, columns = document.frame.known.nonzero()
    row, column = int(rows[0]), int(columns[0])
    editing.workspace.current.set_lock(int(document.labels[row, column]), True)
    wrong = np.zeros(document.labels.shape, bool)
    wrong[row, column] = True
    editing.workspace.current.set_invalid_mask(wrong, "Distrust depth")
    assert f"invalid {document.frame.measured[row, column]:.3f} m" in readout(editing, (column, row))
    assert "(locked)" in editing.feature(StatusFeature).bar.readout.text()
    QApplication.sendEvent(viewport(editing), QEvent(QEvent.Type.Leave))
    assert editing.feature(StatusFeature).bar.readout.text() == ""


def test_a_frame_that_opens_in_the_middle_of_a_stroke_stays_as_it_is(editing, qtbot, tmp_path):
    first = editing.workspace.current
    before = first.labels.copy()
    folder = write_frame(tmp_path / "other", RGBDFrame(first.frame.rgb[:40], first.frame.depth[:40]))
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    drag(editing, [(10, 10), (14, 14)], release=False)
    open_frame(editing, qtbot, folder)
    second = editing.workspace.current
    fresh = second.labels.copy()
    editing.actions_["cancel_stroke"].trigger()
    assert np.array_equal(first.labels, before)
    assert np.array_equal(second.labels, fresh)
