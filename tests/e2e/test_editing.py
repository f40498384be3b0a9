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
    counts = opened.workspace.session.counts()
    assert set(counts) == {1, 2}
    return opened


def test_clicking_chooses_and_control_adds(editing: MainWindow) -> None:
    session = editing.workspace.session
    click(editing, (50, 24))
    assert session.selected == [int(session.labels[24, 50])]
    click(editing, (5, 24), Qt.KeyboardModifier.ControlModifier)
    assert len(session.selected) == 2
    editing.refresh.now()
    assert sorted(editing.feature(BlocksFeature).table.selected()) == sorted(session.selected)
    click(editing, (5, 24), Qt.KeyboardModifier.ControlModifier)
    assert session.selected == [int(session.labels[24, 50])]


def test_choosing_in_the_table_chooses_in_the_views(editing: MainWindow) -> None:
    editing.feature(BlocksFeature).table.select([])
    editing.feature(BlocksFeature).table.view.selectRow(1)
    assert editing.workspace.session.selected == editing.feature(BlocksFeature).table.selected()
    assert len(editing.workspace.session.selected) == 1


def test_a_stroke_paints_what_the_brush_sweeps_and_is_one_undoable_step(editing: MainWindow) -> None:
    session = editing.workspace.session
    before = session.labels.copy()
    right = int(before[24, 50])
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    editing.editor.options.brush_radius = 3.0
    drag(editing, [(20, 24), (14, 24), (10, 30)])
    assert session.labels[24, 17] == right
    assert session.labels[27, 12] == right
    assert session.labels[40, 5] == before[40, 5]
    assert session.undo_stack.count() == 1
    assert session.undo_stack.undoText() == "Paint Block 1"
    painted = session.labels.copy()
    editing.workspace.undo_group.undo()
    assert np.array_equal(session.labels, before)
    editing.workspace.undo_group.redo()
    assert np.array_equal(session.labels, painted)


def test_erasing_takes_from_the_chosen_block_only_and_alt_swaps(editing: MainWindow) -> None:
    session = editing.workspace.session
    before = session.labels.copy()
    click(editing, (50, 24))
    editing.actions_["tool_erase"].trigger()
    editing.editor.options.brush_radius = 4.0
    drag(editing, [(26, 24), (34, 24)])
    changed = session.labels != before
    assert changed.any()
    assert (before[changed] == before[24, 50]).all()
    assert (session.labels[changed] == before[24, 5]).all(), "the neighbour gets them"
    editing.editor.set_option("to_no_block", True)
    drag(editing, [(40, 24), (48, 24)])
    assert session.labels[24, 44] == 0
    drag(editing, [(40, 24), (34, 24)], Qt.KeyboardModifier.AltModifier)
    assert session.labels[24, 34] == before[24, 50]


def test_escape_gives_a_stroke_up(editing: MainWindow, qtbot: QtBot) -> None:
    session = editing.workspace.session
    before = session.labels.copy()
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    drag(editing, [(10, 10), (14, 14)], release=False)
    assert not np.array_equal(session.labels, before)
    editing.actions_["cancel_stroke"].trigger()
    assert np.array_equal(session.labels, before)
    viewport = editing.views.cells["colour"].view.viewport()
    QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=place(editing, (14, 14)))
    assert session.undo_stack.count() == 0
    drag(editing, [(12, 12), (14, 14)])
    assert session.undo_stack.count() == 1


def test_splitting_by_a_line_and_merging_again(editing: MainWindow) -> None:
    session = editing.workspace.session
    before = session.labels.copy()
    editing.actions_["tool_split"].trigger()
    drag(editing, [(48, -1), (48, 20), (48, 49)])
    counts = session.counts()
    assert len(counts) == 3
    assert session.labels[10, 40] != session.labels[10, 60]
    editing.workspace.blocks.select([int(session.labels[10, 40]), int(session.labels[10, 60])])
    editing.actions_["merge_blocks"].trigger()
    assert np.array_equal(session.labels, before)
    assert session.undo_stack.undoText() == "Merge 2 blocks"


def test_a_line_that_parts_nothing_says_so(editing: MainWindow) -> None:
    said: list[str] = []
    editing.editor.message.connect(said.append)
    editing.actions_["tool_split"].trigger()
    drag(editing, [(-3, 10), (-3, 40)])
    assert said == ["The line crosses no block: draw it across one."]
    assert editing.workspace.session.undo_stack.count() == 0


def test_locked_blocks_cannot_be_painted_over_deleted_or_split(editing: MainWindow) -> None:
    session = editing.workspace.session
    before = session.labels.copy()
    left, right = int(before[24, 5]), int(before[24, 50])
    editing.workspace.blocks.set_lock(left, True)
    steps = session.undo_stack.count()
    editing.workspace.blocks.select([right])
    editing.actions_["tool_paint"].trigger()
    drag(editing, [(20, 24), (5, 24)])
    editing.actions_["tool_split"].trigger()
    editing.workspace.blocks.select([left])
    drag(editing, [(12, -1), (12, 49)])
    editing.actions_["delete_blocks"].trigger()
    assert np.array_equal(session.labels, before)
    assert session.undo_stack.count() == steps


def test_a_new_block_is_painted_with_a_number_of_its_own(editing: MainWindow) -> None:
    session = editing.workspace.session
    editing.workspace.blocks.select([2])
    editing.actions_["delete_blocks"].trigger()
    editing.actions_["new_block"].trigger()
    assert session.selected == [3], "the deleted block's number may come back by undo"
    drag(editing, [(5, 5), (20, 40)])
    assert session.labels[5, 5] == 3
    assert editing.feature(BlocksFeature).table.selected() == [3]


def test_renaming_recolouring_and_locking_are_undoable(editing: MainWindow) -> None:
    workspace, session = editing.workspace, editing.workspace.session
    editing.feature(BlocksFeature).table.renamed.emit(1, "Wall")
    editing.feature(BlocksFeature).table.lockChanged.emit(1, True)
    assert session.info(1).name == "Wall"
    assert session.locked == {1}
    assert session.undo_stack.undoText() == "Lock Wall"
    workspace.undo_group.undo()
    workspace.undo_group.undo()
    assert session.info(1).name == "Block 1"
    assert not session.locked


def test_extracting_again_keeps_locked_blocks_and_is_undoable(editing: MainWindow, qtbot: QtBot) -> None:
    workspace, session = editing.workspace, editing.workspace.session
    editing.editor.set_tool("split")
    drag(editing, [(48, -1), (48, 49)])
    new = int(session.labels[10, 60])
    workspace.blocks.edit_info(new, "Rename block", name="Mine")
    editing.workspace.blocks.set_lock(new, True)
    mask = session.labels == new
    edited = session.labels.copy()
    editing.workspace.parameters.set_extraction(BlockParameters(min_size=1.0))
    with qtbot.waitSignal(editing.loader.idle, timeout=60_000):
        editing.actions_["extract"].trigger()
    assert np.array_equal(session.labels == new, mask)
    assert session.info(new).name == "Mine"
    assert session.blocks.edited
    workspace.undo_group.undo()
    assert np.array_equal(session.labels, edited)


def test_hidden_blocks_are_transparent_but_still_there(editing: MainWindow) -> None:
    before = editing.workspace.session.labels.copy()
    editing.feature(BlocksFeature).table.visibilityChanged.emit(1, False)
    assert not editing.workspace.session.info(1).visible
    assert np.array_equal(editing.workspace.session.labels, before)
    assert editing.workspace.session.undo_stack.count() == 0


def test_readout_tells_block_and_depths(editing: MainWindow) -> None:
    editing.feature(StatusFeature).readout.point_at((50, 5))
    text = editing.feature(StatusFeature).bar.readout.text()
    assert "x 50, y 5" in text
    assert "in 2.650 m" in text
    editing.feature(StatusFeature).readout.point_at((45, 35))
    assert "in missing" in editing.feature(StatusFeature).bar.readout.text()
    session = editing.workspace.session
    rows, columns = session.frame.known.nonzero()
    row, column = int(rows[0]), int(columns[0])
    editing.workspace.blocks.set_lock(int(session.labels[row, column]), True)
    wrong = np.zeros(session.labels.shape, bool)
    wrong[row, column] = True
    editing.workspace.blocks.set_invalid_mask(wrong, "Distrust depth")
    editing.feature(StatusFeature).readout.point_at((column, row))
    assert "invalid " in editing.feature(StatusFeature).bar.readout.text()
    assert "(locked)" in editing.feature(StatusFeature).bar.readout.text()
    editing.feature(StatusFeature).readout.point_at(None)
    assert editing.feature(StatusFeature).bar.readout.text() == ""


def test_two_quick_dabs_are_two_undoable_steps(editing: MainWindow) -> None:
    session = editing.workspace.session
    before = session.labels.copy()
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    editing.editor.options.brush_radius = 2.0
    viewport = editing.views.cells["colour"].view.viewport()
    click(editing, (10, 10))
    QTest.mouseDClick(viewport, Qt.MouseButton.LeftButton, pos=place(editing, (20, 20)))
    QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=place(editing, (20, 20)))
    assert session.undo_stack.count() == 2
    editing.workspace.undo_group.undo()
    editing.workspace.undo_group.undo()
    assert np.array_equal(session.labels, before)


def test_undo_in_the_middle_of_a_stroke_gives_the_stroke_up(editing: MainWindow) -> None:
    session = editing.workspace.session
    before = session.labels.copy()
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    drag(editing, [(10, 10), (14, 14)])
    drag(editing, [(20, 30), (24, 34)], release=False)
    editing.workspace.undo_group.undo()
    assert np.array_equal(session.labels, before)
    viewport = editing.views.cells["colour"].view.viewport()
    QTest.mouseRelease(viewport, Qt.MouseButton.LeftButton, pos=place(editing, (24, 34)))
    assert np.array_equal(session.labels, before)


def test_a_frame_that_opens_in_the_middle_of_a_stroke_stays_as_it_is(
    editing: MainWindow, qtbot: QtBot, tmp_path: Path
) -> None:
    first = editing.workspace.session
    before = first.labels.copy()
    folder = write_frame(tmp_path / "other", RGBDFrame(first.frame.rgb[:40], first.frame.depth[:40]))
    click(editing, (50, 24))
    editing.actions_["tool_paint"].trigger()
    drag(editing, [(10, 10), (14, 14)], release=False)
    open_frame(editing, qtbot, FrameRef(str(folder)))
    second = editing.workspace.session
    fresh = second.labels.copy()
    editing.actions_["cancel_stroke"].trigger()
    assert np.array_equal(first.labels, before)
    assert np.array_equal(second.labels, fresh)


def test_undoing_an_extraction_brings_names_parameters_and_origin_back(editing: MainWindow, qtbot: QtBot) -> None:
    workspace, session = editing.workspace, editing.workspace.session
    workspace.blocks.edit_info(1, "Rename block", name="Wall")
    workspace.parameters.set(preset(max_iterations=3), 1)
    used = session.blocks.extraction
    workspace.parameters.set_extraction(BlockParameters(min_size=48.0, use_depth=False))
    with qtbot.waitSignal(editing.loader.idle, timeout=60_000):
        editing.actions_["extract"].trigger()
    assert len(session.counts()) == 1
    assert session.info(1).name == "Block 1"
    assert session.parameters_of(1) == workspace.parameters.current
    assert not session.blocks.edited
    workspace.undo_group.undo()
    assert session.info(1).name == "Wall"
    assert session.parameters_of(1).max_iterations == 3
    assert session.blocks.extraction == used
    assert not session.blocks.edited


def test_undoing_a_rename_leaves_the_block_hidden(editing: MainWindow) -> None:
    workspace = editing.workspace
    workspace.blocks.edit_info(1, "Rename block", name="Wall")
    workspace.blocks.set_visible(1, False)
    workspace.undo_group.undo()
    assert workspace.session.info(1).name == "Block 1"
    assert not workspace.session.info(1).visible


def test_commands_are_enabled_by_what_is_chosen(editing: MainWindow) -> None:
    actions, workspace = editing.actions_, editing.workspace
    names = ("run_selected", "merge_blocks", "delete_blocks", "zoom_block")
    workspace.blocks.select([1])
    assert [actions[name].isEnabled() for name in names] == [True, False, True, True]
    workspace.blocks.select([1, 2])
    assert [actions[name].isEnabled() for name in names] == [True, True, True, True]
    editing.workspace.blocks.set_lock(1, True)
    assert [actions[name].isEnabled() for name in names] == [True, False, True, True]
    actions["new_block"].trigger()
    assert [actions[name].isEnabled() for name in names] == [False, False, False, False]
    editing.refresh.now()
    assert editing.feature(BlocksFeature).table.selected() == workspace.session.selected, (
        "a block to be painted has a row"
    )


def test_numbers_of_blocks_fit_the_export(editing: MainWindow) -> None:
    session = editing.workspace.session
    session.labels[0, 0] = 65535
    assert session.next_label() == 3


def test_closed_sessions_are_freed(editing: MainWindow, qtbot: QtBot) -> None:
    session = editing.workspace.session
    editing.actions_["select_all"].trigger()
    editing.actions_["merge_blocks"].trigger()
    watched = weakref.ref(session), weakref.ref(session.undo_stack)
    del session
    editing.actions_["close_frame"].trigger()
    editing.refresh.now()

    def is_freed() -> bool:
        gc.collect()
        return [watch() for watch in watched] == [None, None]

    qtbot.waitUntil(is_freed, timeout=WAIT_MS)  # the list of frames takes a while to let it go
