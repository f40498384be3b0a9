"""Editing blocks with the mouse in the real window."""

from __future__ import annotations

import gc
import weakref
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from pytestqt.qtbot import QtBot

from gui.app.main_window import MainWindow
from gui.features.blocks.feature import BlocksFeature
from gui.features.status import StatusFeature
from ilf import BlockParameters, RGBDFrame, preset
from ilf.sources.frame_ref import FrameRef

from .conftest import WAIT_MS, open_frame, write_frame
from .hand import click, drag, place


@pytest.fixture
def editing(opened: MainWindow) -> MainWindow:
    """The window on a frame of two blocks: 1 on the right, larger, and 2 on the left."""
    counts = opened.workspace.current.counts()
    assert set(counts) == {1, 2}
    return opened


def test_clicking_chooses_and_control_adds(editing: MainWindow) -> None:
    document = editing.workspace.current
    click(editing, (50, 24))
    assert document.selected == [int(document.labels[24, 50])]
    click(editing, (5, 24), Qt.KeyboardModifier.ControlModifier)
    assert len(document.selected) == 2
    editing.refresh.now()
    assert sorted(editing.feature(BlocksFeature).table.selected()) == sorted(document.selected)
    click(editing, (5, 24), Qt.KeyboardModifier.ControlModifier)
    assert document.selected == [int(document.labels[24, 50])]


def test_choosing_in_the_table_chooses_in_the_views(editing: MainWindow) -> None:
    editing.feature(BlocksFeature).table.select([])
    editing.feature(BlocksFeature).table.view.selectRow(1)
    assert editing.workspace.current.selected == editing.feature(BlocksFeature).table.selected()
    assert len(editing.workspace.current.selected) == 1


def test_a_stroke_paints_what_the_brush_sweeps_and_is_one_undoable_step(editing: MainWindow) -> None:
    document = editing.workspace.current
    before = document.labels.copy()
    right = int(before[24, 50])
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    editing.editor.options.brush_radius = 3.0
    drag(editing, [(20, 24), (14, 24), (10, 30)])
    assert document.labels[24, 17] == right
    assert document.labels[27, 12] == right
    assert document.labels[40, 5] == before[40, 5]
    assert document.undo_stack.count() == 1
    assert document.undo_stack.undoText() == "Paint Block 1"
    painted = document.labels.copy()
    editing.workspace.undo_group.undo()
    assert np.array_equal(document.labels, before)
    editing.workspace.undo_group.redo()
    assert np.array_equal(document.labels, painted)


def test_erasing_takes_from_the_chosen_block_only_and_alt_swaps(editing: MainWindow) -> None:
    document = editing.workspace.current
    before = document.labels.copy()
    click(editing, (50, 24))
    editing.actions_["tool_erase"].trigger()
    editing.editor.options.brush_radius = 4.0
    drag(editing, [(26, 24), (34, 24)])
    changed = document.labels != before
    assert changed.any()
    assert (before[changed] == before[24, 50]).all()
    assert (document.labels[changed] == before[24, 5]).all(), "the neighbour gets them"
    editing.editor.set_option("to_no_block", True)
    drag(editing, [(40, 24), (48, 24)])
    assert document.labels[24, 44] == 0
    drag(editing, [(40, 24), (34, 24)], Qt.KeyboardModifier.AltModifier)
    assert document.labels[24, 34] == before[24, 50]


def test_escape_gives_a_stroke_up(editing: MainWindow, qtbot: QtBot) -> None:
    document = editing.workspace.current
    before = document.labels.copy()
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    drag(editing, [(10, 10), (14, 14)], release=False)
    assert not np.array_equal(document.labels, before)
    editing.actions_["cancel_stroke"].trigger()
    assert np.array_equal(document.labels, before)
    viewport = editing.views.cells["colour"].view.viewport()
    QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=place(editing, (14, 14)))
    assert document.undo_stack.count() == 0
    drag(editing, [(12, 12), (14, 14)])
    assert document.undo_stack.count() == 1


def test_splitting_by_a_line_and_merging_again(editing: MainWindow) -> None:
    document = editing.workspace.current
    before = document.labels.copy()
    editing.actions_["tool_split"].trigger()
    drag(editing, [(48, -1), (48, 20), (48, 49)])
    counts = document.counts()
    assert len(counts) == 3
    assert document.labels[10, 40] != document.labels[10, 60]
    editing.workspace.select([int(document.labels[10, 40]), int(document.labels[10, 60])])
    editing.actions_["merge_blocks"].trigger()
    assert np.array_equal(document.labels, before)
    assert document.undo_stack.undoText() == "Merge 2 blocks"


def test_a_line_that_parts_nothing_says_so(editing: MainWindow) -> None:
    said: list[str] = []
    editing.editor.message.connect(said.append)
    editing.actions_["tool_split"].trigger()
    drag(editing, [(-3, 10), (-3, 40)])
    assert said == ["The line crosses no block: draw it across one."]
    assert editing.workspace.current.undo_stack.count() == 0


def test_locked_blocks_cannot_be_painted_over_deleted_or_split(editing: MainWindow) -> None:
    document = editing.workspace.current
    before = document.labels.copy()
    left, right = int(before[24, 5]), int(before[24, 50])
    editing.workspace.current.set_lock(left, True)
    steps = document.undo_stack.count()
    editing.workspace.select([right])
    editing.actions_["tool_paint"].trigger()
    drag(editing, [(20, 24), (5, 24)])
    editing.actions_["tool_split"].trigger()
    editing.workspace.select([left])
    drag(editing, [(12, -1), (12, 49)])
    editing.actions_["delete_blocks"].trigger()
    assert np.array_equal(document.labels, before)
    assert document.undo_stack.count() == steps


def test_a_new_block_is_painted_with_a_number_of_its_own(editing: MainWindow) -> None:
    document = editing.workspace.current
    editing.workspace.select([2])
    editing.actions_["delete_blocks"].trigger()
    editing.actions_["new_block"].trigger()
    assert document.selected == [3], "the deleted block's number may come back by undo"
    drag(editing, [(5, 5), (20, 40)])
    assert document.labels[5, 5] == 3
    assert editing.feature(BlocksFeature).table.selected() == [3]


def test_renaming_recolouring_and_locking_are_undoable(editing: MainWindow) -> None:
    workspace, document = editing.workspace, editing.workspace.current
    editing.feature(BlocksFeature).table.renamed.emit(1, "Wall")
    editing.feature(BlocksFeature).table.lockChanged.emit(1, True)
    assert document.info(1).name == "Wall"
    assert document.locked == {1}
    assert document.undo_stack.undoText() == "Lock Wall"
    workspace.undo_group.undo()
    workspace.undo_group.undo()
    assert document.info(1).name == "Block 1"
    assert not document.locked


def test_extracting_again_keeps_locked_blocks_and_is_undoable(editing: MainWindow, qtbot: QtBot) -> None:
    workspace, document = editing.workspace, editing.workspace.current
    editing.editor.set_tool("split")
    drag(editing, [(48, -1), (48, 49)])
    new = int(document.labels[10, 60])
    workspace.current.edit_info(new, "Rename block", name="Mine")
    editing.workspace.current.set_lock(new, True)
    mask = document.labels == new
    edited = document.labels.copy()
    editing.workspace.parameters.set_extraction(BlockParameters(min_size=1.0))
    with qtbot.waitSignal(editing.loader.idle, timeout=60_000):
        editing.actions_["extract"].trigger()
    assert np.array_equal(document.labels == new, mask)
    assert document.info(new).name == "Mine"
    assert document.blocks.edited
    workspace.undo_group.undo()
    assert np.array_equal(document.labels, edited)


def test_hidden_blocks_are_transparent_but_still_there(editing: MainWindow) -> None:
    before = editing.workspace.current.labels.copy()
    editing.feature(BlocksFeature).table.visibilityChanged.emit(1, False)
    assert not editing.workspace.current.info(1).visible
    assert np.array_equal(editing.workspace.current.labels, before)
    assert editing.workspace.current.undo_stack.count() == 0


def test_readout_tells_block_and_depths(editing: MainWindow) -> None:
    editing.feature(StatusFeature).readout.point_at((50, 5))
    text = editing.feature(StatusFeature).bar.readout.text()
    assert "x 50, y 5" in text
    assert "in 2.650 m" in text
    editing.feature(StatusFeature).readout.point_at((45, 35))
    assert "in missing" in editing.feature(StatusFeature).bar.readout.text()
    document = editing.workspace.current
    rows, columns = document.frame.known.nonzero()
    row, column = int(rows[0]), int(columns[0])
    editing.workspace.current.set_lock(int(document.labels[row, column]), True)
    wrong = np.zeros(document.labels.shape, bool)
    wrong[row, column] = True
    editing.workspace.current.set_invalid_mask(wrong, "Distrust depth")
    editing.feature(StatusFeature).readout.point_at((column, row))
    assert "invalid " in editing.feature(StatusFeature).bar.readout.text()
    assert "(locked)" in editing.feature(StatusFeature).bar.readout.text()
    editing.feature(StatusFeature).readout.point_at(None)
    assert editing.feature(StatusFeature).bar.readout.text() == ""


def test_two_quick_dabs_are_two_undoable_steps(editing: MainWindow) -> None:
    document = editing.workspace.current
    before = document.labels.copy()
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    editing.editor.options.brush_radius = 2.0
    viewport = editing.views.cells["colour"].view.viewport()
    click(editing, (10, 10))
    QTest.mouseDClick(viewport, Qt.MouseButton.LeftButton, pos=place(editing, (20, 20)))
    QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=place(editing, (20, 20)))
    assert document.undo_stack.count() == 2
    editing.workspace.undo_group.undo()
    editing.workspace.undo_group.undo()
    assert np.array_equal(document.labels, before)


def test_undo_in_the_middle_of_a_stroke_gives_the_stroke_up(editing: MainWindow) -> None:
    document = editing.workspace.current
    before = document.labels.copy()
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    drag(editing, [(10, 10), (14, 14)])
    drag(editing, [(20, 30), (24, 34)], release=False)
    editing.workspace.undo_group.undo()
    assert np.array_equal(document.labels, before)
    viewport = editing.views.cells["colour"].view.viewport()
    QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=place(editing, (24, 34)))
    assert np.array_equal(document.labels, before)


def test_a_frame_that_opens_in_the_middle_of_a_stroke_stays_as_it_is(
    editing: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    first = editing.workspace.current
    before = first.labels.copy()
    folder = write_frame(tmp_path / "other", RGBDFrame(first.frame.rgb[:40], first.frame.depth[:40]))
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    drag(editing, [(10, 10), (14, 14)], release=False)
    open_frame(editing, qtbot, FrameRef(str(folder)))
    second = editing.workspace.current
    fresh = second.labels.copy()
    editing.actions_["cancel_stroke"].trigger()
    assert np.array_equal(first.labels, before)
    assert np.array_equal(second.labels, fresh)


def test_undoing_an_extraction_brings_names_parameters_and_origin_back(editing: MainWindow, qtbot: QtBot) -> None:
    workspace, document = editing.workspace, editing.workspace.current
    workspace.current.edit_info(1, "Rename block", name="Wall")
    workspace.parameters.set(preset(max_iterations=3), 1)
    used = document.blocks.extraction
    workspace.parameters.set_extraction(BlockParameters(min_size=48.0, use_depth=False))
    with qtbot.waitSignal(editing.loader.idle, timeout=60_000):
        editing.actions_["extract"].trigger()
    assert len(document.counts()) == 1
    assert document.info(1).name == "Block 1"
    assert document.parameters_of(1) == workspace.parameters.current
    assert not document.blocks.edited
    workspace.undo_group.undo()
    assert document.info(1).name == "Wall"
    assert document.parameters_of(1).max_iterations == 3
    assert document.blocks.extraction == used
    assert not document.blocks.edited


def test_undoing_a_rename_leaves_the_block_hidden(editing: MainWindow) -> None:
    workspace = editing.workspace
    workspace.current.edit_info(1, "Rename block", name="Wall")
    workspace.current.set_visible(1, False)
    workspace.undo_group.undo()
    assert workspace.current.info(1).name == "Block 1"
    assert not workspace.current.info(1).visible


def test_commands_are_enabled_by_what_is_chosen(editing: MainWindow) -> None:
    actions, workspace = editing.actions_, editing.workspace
    names = ("run_selected", "merge_blocks", "delete_blocks", "zoom_block")
    workspace.select([1])
    assert [actions[name].isEnabled() for name in names] == [True, False, True, True]
    workspace.select([1, 2])
    assert [actions[name].isEnabled() for name in names] == [True, True, True, True]
    editing.workspace.current.set_lock(1, True)
    assert [actions[name].isEnabled() for name in names] == [True, False, True, True]
    actions["new_block"].trigger()
    assert [actions[name].isEnabled() for name in names] == [False, False, False, False]
    editing.refresh.now()
    assert editing.feature(BlocksFeature).table.selected() == workspace.current.selected, (
        "a block to be painted has a row"
    )


def test_numbers_of_blocks_fit_the_export(editing: MainWindow) -> None:
    document = editing.workspace.current
    document.labels[0, 0] = 65535
    assert document.next_label() == 3


def test_closed_sessions_are_freed(editing: MainWindow, qtbot: QtBot) -> None:
    document = editing.workspace.current
    editing.actions_["select_all"].trigger()
    editing.actions_["merge_blocks"].trigger()
    watched = weakref.ref(document), weakref.ref(document.undo_stack)
    del document
    editing.actions_["close_frame"].trigger()
    editing.refresh.now()

    def is_freed() -> bool:
        gc.collect()
        return [watch() for watch in watched] == [None, None]

    qtbot.waitUntil(is_freed, timeout=WAIT_MS)  # the list of frames takes a while to let it go
