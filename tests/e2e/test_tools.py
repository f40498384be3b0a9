"""Every tool in the real window, and the keys that mean the same wherever the focus is."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QCheckBox, QToolButton, QWidget

from gui.features.blocks.feature import BlocksFeature
from gui.features.status import StatusFeature
from gui.features.tools import ToolsFeature
from gui.tools.kinds import KINDS

from .conftest import activate
from .hand import CTRL, click, double_click, drag, key, let_go, turn_wheel

_Key = Qt.Key


@pytest.fixture
def editing(opened, qtbot):
    """The window on a frame of two blocks that meet at x = 30, with its edges found; lines are taken as drawn."""
    opened.editor.options.leash = 0
    activate(opened, qtbot)
    qtbot.waitUntil(lambda: opened.editor.edge_data is not None)
    return opened


def _take(window, tool: str):
    window.actions_[f"tool_{tool}"].trigger()
    window.views.cells["colour"].view.setFocus()
    window.refresh.now()


def test_an_outline_is_clicked_and_closed_by_enter(editing):
    document = editing.workspace.current
    editing.workspace.select([])
    _take(editing, "outline")
    for corner in ((40, 6), (56, 6), (56, 20), (44, 26)):
        click(editing, corner)
    assert "Enter" in editing.editor.tool.hint
    editing.refresh.now()
    assert editing.feature(StatusFeature).bar.hint.text() == editing.editor.tool.hint
    key(editing, _Key.Key_Backspace)
    click(editing, (40, 20))
    key(editing, _Key.Key_Return)
    new = document.selected[0]
    assert (document.labels[8:18, 42:54] == new).all()
    assert not (document.labels[22:] == new).any(), "the corner that was taken back"
    assert document.undo_stack.count() == 1
    double_click(editing, (5, 5))
    key(editing, _Key.Key_Escape)
    assert document.undo_stack.count() == 1
    assert document.selected == [new], "Escape has given up the outline alone"
    key(editing, _Key.Key_Escape)
    assert document.selected == []


def test_a_click_suggests_a_split_and_enter_takes_it(editing, qtbot):
    document = editing.workspace.current
    before = document.labels.copy()
    editing.workspace.select([1, 2])
    editing.actions_["merge_blocks"].trigger()
    _take(editing, "split")
    click(editing, (10, 5))
    qtbot.waitUntil(lambda: editing.editor.tool.hint.startswith("Click or Enter"))
    assert document.undo_stack.undoText() == "Merge 2 blocks"
    editing.refresh.now()
    assert editing.feature(StatusFeature).bar.hint.text() == editing.editor.tool.hint
    key(editing, _Key.Key_Enter)
    assert document.undo_stack.undoText().startswith("Split")
    parts = document.labels == document.labels[5, 5]
    assert np.count_nonzero(parts != (before == before[5, 5])) < 100


def test_wheel_with_control_and_keys_change_the_brush_and_zoom_where_there_is_none(editing):
    _take(editing, "paint")
    view = editing.views.cells["colour"].view
    scale, radius = view.transform.m11(), editing.editor.options.brush_radius
    turn_wheel(editing, (30, 20), 1, CTRL)
    assert editing.editor.options.brush_radius > radius
    assert view.transform.m11() == scale
    editing.refresh.now()
    assert editing.feature(ToolsFeature).options.brush.value() == editing.editor.options.brush_radius
    for code, step in ((_Key.Key_BracketRight, 1), (_Key.Key_BracketLeft, -1)):
        radius = editing.editor.options.brush_radius
        key(editing, code)
        assert (editing.editor.options.brush_radius - radius) * step > 0
    turn_wheel(editing, (30, 20), 1)
    assert view.transform.m11() > scale
    _take(editing, "border")
    scale = view.transform.m11()
    turn_wheel(editing, (30, 20), 1, CTRL)
    assert view.transform.m11() > scale


def test_options_show_for_the_tool_that_has_them_and_stay(editing):
    row, options = editing.feature(ToolsFeature).options, editing.editor.options
    assert not row.amount.isVisible(), "no block is selected"
    editing.workspace.select([1])
    shown = {}
    for kind in KINDS:
        _take(editing, kind.name)
        shown[kind.name] = row.brush.isVisible(), row.leash.isVisible(), row.amount.isVisible()
    assert shown["paint"] == shown["erase"] == shown["mark_invalid"] == (True, False, False)
    assert shown["border"] == shown["outline"] == shown["split"] == (False, True, False)
    assert shown["select"] == (False, False, True)
    icons = Qt.ToolButtonStyle.ToolButtonIconOnly
    assert not [button.text() for button in row.findChildren(QToolButton) if button.toolButtonStyle() is icons]
    assert row.amount.text() == "by 2 px", "beside Grow, Shrink and Smooth"
    row.leash.setValue(11)
    row.amount.setValue(4)
    editing.actions_["similar_only"].trigger()
    assert (options.leash, options.amount, options.similar_only) == (11, 4, True)
    _take(editing, "border")
    assert row.leash.value() == 11


def test_keys_work_wherever_the_focus_is_but_not_where_numbers_are_typed(editing):
    viewport = editing.views.cells["colour"].view.viewport()
    views, table = editing.views.cells["depth-in"].view, editing.feature(BlocksFeature).table
    for widget in (views, table, editing.feature(ToolsFeature).options.amount):
        _take(editing, "select")
        editing.workspace.select([1])
        editing.refresh.now()
        widget.setFocus()
        assert widget.hasFocus()
        key(editing, _Key.Key_D)
        assert editing.editor.tool_name == ("border" if widget in (views, table) else "select")
        if widget not in (views, table):
            continue
        view = editing.views.active.view
        assert view.hasFocus(), "a tool leads to the views"
        key(editing, _Key.Key_Comma)
        assert editing.editor.tool_name == "smart_select"
        key(editing, _Key.Key_Period)
        assert editing.editor.tool_name == "border"
        QTest.keyPress(view, _Key.Key_Space)
        assert viewport.cursor().shape() is Qt.CursorShape.OpenHandCursor
        QTest.keyRelease(view, _Key.Key_Space)
        assert viewport.cursor().shape() is Qt.CursorShape.CrossCursor
        assert all(editing.workspace.current.info(label).visible for label in (1, 2)), "space hides no block"


def test_who_goes_through_the_panels_by_keys_has_space_there(editing):
    _take(editing, "select")
    focus = QApplication.focusWidget
    editing.views.cells["colour"].view.setFocus()
    seen: list[QWidget | None] = [focus()]
    while not isinstance(focus(), QCheckBox):
        key(editing, _Key.Key_Tab)
        assert focus() not in seen, "the focus goes on and on"
        seen.append(focus())
    check = focus()
    before = check.isChecked()
    key(editing, _Key.Key_Space)
    assert check.isChecked() != before


def test_undo_gives_up_what_is_under_way_only(editing):
    document = editing.workspace.current
    click(editing, (50, 24))
    _take(editing, "paint")
    drag(editing, [(10, 10), (14, 14)])
    first = document.labels.copy()
    drag(editing, [(20, 30), (24, 34)], release=False)
    assert not np.array_equal(document.labels, first)
    key(editing, _Key.Key_Z, CTRL)
    assert np.array_equal(document.labels, first)
    let_go(editing, (24, 34))
    assert document.undo_stack.index() == 1
    key(editing, _Key.Key_Z, CTRL)
    assert document.undo_stack.index() == 0

    # the button gives up what is under way, too
    editing.workspace.select([])
    _take(editing, "outline")
    drag(editing, [(40, 10), (50, 10), (50, 20), (40, 20), (40, 11)])
    click(editing, (5, 5))
    key(editing, _Key.Key_Backspace)
    assert editing.views.cells["colour"].view.preview.extent is None
    click(editing, (5, 5))
    click(editing, (15, 5))
    for index in (1, 0):
        editing.actions_["undo"].trigger()
        assert (editing.editor.busy, document.undo_stack.index()) == (False, index)


def test_slivers_are_said_unless_they_were_there_before_and_cleaned_up_by_what_is_offered(editing, qtbot):
    document = editing.workspace.current
    click(editing, (50, 24))
    _take(editing, "paint")
    editing.editor.set_option("brush_radius", 1.0)
    click(editing, (10, 24))
    assert editing.notes.message == "1 sliver left."
    QTest.mouseClick(editing.notes.toast.commands[0], Qt.MouseButton.LeftButton)
    assert document.undo_stack.undoText() == "Clean up"
    assert document.labels[24, 10] == document.labels[5, 5]
    assert "1 sliver" in editing.notes.message
    assert not editing.notes.toast.commands, "what was offered is done"

    editing.notes.clear()
    labels = document.labels.copy()
    labels[24, 10] = labels[24, 50]
    editing.workspace.current.replace_blocks(labels, "A sliver")
    click(editing, (50, 40))
    editing.editor.set_option("brush_radius", 3.0)
    drag(editing, [(50, 30), (8, 30), (8, 40)])
    assert document.undo_stack.undoText() == f"Paint {document.info(document.selected[0]).name}"
    assert document.labels[24, 10] == document.labels[24, 50] != document.labels[24, 12]
    assert "sliver" not in editing.notes.message


def test_blocks_grow_shrink_and_become_smooth_by_the_amount_and_merging_says_that_parts_do_not_touch(editing):
    document = editing.workspace.current
    counts = document.counts()
    editing.workspace.select([1])
    editing.editor.set_option("amount", 3)
    editing.actions_["grow_blocks"].trigger()
    assert document.counts()[1].pixels == counts[1].pixels + 3 * 48
    assert document.undo_stack.undoText() == "Grow Block 1 by 3 px"
    editing.actions_["shrink_blocks"].trigger()
    assert document.counts()[1].pixels == counts[1].pixels
    editing.actions_["smooth_blocks"].trigger()
    assert document.counts()[1].pixels == counts[1].pixels

    labels = np.ones_like(document.labels)
    labels[:10, :10], labels[-10:, -10:] = 2, 3
    editing.workspace.current.replace_blocks(labels, "Corners")
    editing.workspace.select([2, 3])
    editing.actions_["merge_blocks"].trigger()
    assert "do not touch" in editing.notes.message
    assert document.labels[-1, -1] == document.labels[0, 0]


def test_the_menu_offers_what_can_be_done_here(editing, qtbot):
    document = editing.workspace.current
    before = document.labels.copy()
    left, right = int(before[5, 5]), int(before[5, 50])
    editing.workspace.select([left])
    menu = editing.feature(BlocksFeature).menu_at(50, 5)
    texts = {action.text(): action for action in menu.actions()}
    assert document.selected == [right]
    texts[f"Merge Block {right} into Block {left}"].trigger()
    assert (document.labels == left).all()
    editing.actions_["undo"].trigger()
    editing.workspace.select([left])
    menu = editing.feature(BlocksFeature).menu_at(50, 5)
    next(action for action in menu.actions() if action.text().startswith("Give this piece")).trigger()
    assert document.selected == [left]
    assert (document.labels == left).all()
    menu = editing.feature(BlocksFeature).menu_at(50, 5)
    next(action for action in menu.actions() if action.text().startswith("Split")).trigger()
    qtbot.waitUntil(lambda: not editing.editor.working)
    assert document.labels[5, 5] != document.labels[5, 50]
    assert editing.actions_["zoom_block"] in menu.actions()


def test_the_rest_of_a_covered_block_goes_in_the_same_undo_step(editing):
    document = editing.workspace.current
    before = document.labels.copy()
    height, width = before.shape
    covered = document.info(int(before[24, 50])).name
    editing.workspace.select([])
    _take(editing, "outline")
    drag(editing, [(31, -1), (width, -1), (width, height), (31, height), (31, 0)])
    assert len(document.counts()) == 2
    assert covered in editing.notes.message
    assert (document.labels[:, 30:] == document.selected[0]).all()
    assert document.undo_stack.count() == 1
    editing.actions_["undo"].trigger()
    assert np.array_equal(document.labels, before)


def test_a_part_that_could_not_be_completed_is_not_cut_off(editing):
    document = editing.workspace.current
    mask = np.zeros(document.labels.shape, bool)
    mask[:6, 58:] = True
    editing.workspace.current.set_invalid_mask(mask, "Mark depth as invalid")
    document.change_blocks(extraction=document.blocks.extraction.changed(min_size=2))
    _take(editing, "split")
    drag(editing, [(60, -1), (60, 4), (65, 4)])
    assert len(document.counts()) == 2
    assert "without known depth" in editing.notes.message
    assert document.undo_stack.undoText() == "Mark depth as invalid"
