"""The window without a mouse: a crosshair that keys move, letters for the tools, and where the focus is."""

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QDialog,
    QDockWidget,
    QDoubleSpinBox,
    QFileDialog,
    QLineEdit,
    QPushButton,
    QWidget,
)

from gui.base import theme
from gui.base.commands import plain
from gui.features.blocks.feature import BlocksFeature
from gui.features.blocks.table import BlockColumn
from gui.features.cloud import CloudPanel
from gui.features.status import StatusFeature
from gui.tools.kinds import KINDS
from gui.views.image_view import ImageView

from .conftest import activate, in_front, open_frame
from .hand import CTRL, PLAIN, SHIFT, hover, key

_Key = Qt.Key


@pytest.fixture
def typing(opened, qtbot):
    """The window on a frame of two blocks that meet at x = 30; the focus is in the colour view."""
    opened.editor.set_option("leash", 0)
    activate(opened, qtbot)
    qtbot.waitUntil(lambda: opened.editor.edge_data is not None)
    opened.views.cells["colour"].view.setFocus()
    return opened


def _go(window, x: int, y: int):
    """Move the crosshair to a pixel with the arrow keys, in long steps first."""
    if window.views.navigation.pixel is None:
        key(window, _Key.Key_Right)
    for axis, (back, on) in enumerate(((_Key.Key_Left, _Key.Key_Right), (_Key.Key_Up, _Key.Key_Down))):
        left = (x, y)[axis] - _at(window)[axis]
        for step, modifier in ((10, SHIFT), (1, PLAIN)):
            for _ in range(abs(left) // step):
                key(window, on if left > 0 else back, modifier)
            left = (x, y)[axis] - _at(window)[axis]
    assert window.views.navigation.pixel == (x, y)


def _at(window) -> tuple[int, int]:
    return window.views.navigation.pixel


def _drag(window, *points: tuple[int, int]):
    """Hold Space from the first point to the last."""
    _go(window, *points[0])
    QTest.keyPress(_focus(), _Key.Key_Space)
    for point in points[1:]:
        _go(window, *point)
    QTest.keyRelease(_focus(), _Key.Key_Space)


def _focus() -> QWidget:
    return QApplication.focusWidget()


def test_a_block_is_split_along_a_line_of_keys(typing):
    document = typing.workspace.current
    key(typing, _Key.Key_S)
    _go(typing, 10, 24)
    key(typing, _Key.Key_Left, CTRL)
    assert typing.views.navigation.pixel == (0, 24), "to the end of the frame, for want of a border"
    _drag(typing, (0, 24), (40, 24))
    assert document.undo_stack.undoText().startswith("Split")
    assert document.labels[5, 5] != document.labels[40, 5]
    key(typing, _Key.Key_Up, CTRL)
    assert typing.views.navigation.pixel == (40, 0)
    _go(typing, 63, 47)
    for end in (_Key.Key_Right, _Key.Key_Down):
        key(typing, end)
    assert typing.views.navigation.pixel == (63, 47), "the last pixel of the frame"
    _go(typing, 40, 0)
    key(typing, _Key.Key_Left, CTRL)
    assert document.labels[0, _at(typing)[0]] != document.labels[0, 40]


def test_an_object_is_selected_by_a_click_of_keys(typing, qtbot):
    document = typing.workspace.current
    typing.workspace.select([])
    key(typing, _Key.Key_W)
    _go(typing, 45, 20)
    key(typing, _Key.Key_Return)
    assert typing.editor.busy, "Enter clicks while there is nothing to finish"
    key(typing, _Key.Key_Return)
    qtbot.waitUntil(lambda: not typing.editor.busy)
    assert document.labels[20, 45] == document.selected[0]
    assert document.undo_stack.undoText().startswith("Smart select")


def test_a_stroke_is_painted_by_keys_and_given_up_by_escape(typing):
    document = typing.workspace.current
    before = document.labels.copy()
    key(typing, _Key.Key_A)
    _go(typing, 50, 40)
    key(typing, _Key.Key_Space)
    assert document.selected == [int(before[40, 50])]
    key(typing, _Key.Key_B)
    _go(typing, 5, 5)
    QTest.keyPress(_focus(), _Key.Key_Space)
    _go(typing, 12, 5)
    assert not np.array_equal(document.labels, before)
    key(typing, _Key.Key_Escape)
    QTest.keyRelease(_focus(), _Key.Key_Space)
    assert np.array_equal(document.labels, before)
    _drag(typing, (5, 5), (12, 5))
    assert (document.labels[5, 5:13] == document.selected[0]).all()


def test_the_crosshair_stays_in_sight_and_gives_way_to_the_mouse(typing):
    view = typing.views.cells["colour"].view
    typing.views.transform.look_at(10, 10, 8 * typing.views.transform.scale)
    _go(typing, 60, 40)
    rows, columns = view.visible_box()
    assert rows.start <= 40 < rows.stop
    assert columns.start <= 60 < columns.stop
    typing.feature(StatusFeature).show_readout()
    assert "x 60, y 40" in typing.feature(StatusFeature).bar.readout.text()
    hover(typing, (58.5, 38.5))
    QTest.keyPress(view, _Key.Key_Space)
    assert view.viewport().cursor().shape() is Qt.CursorShape.OpenHandCursor
    QTest.keyRelease(view, _Key.Key_Space)


def test_a_letter_takes_a_tool_stands_in_its_tooltip_and_does_nothing_while_a_name_is_typed(typing, qtbot):
    for kind in KINDS:
        typing.editor.set_tool("give" if kind.name == "select" else "select")
        QTest.keyClick(_focus(), kind.key.lower())
        assert typing.editor.tool_name == kind.name
        tip = typing.actions_[f"tool_{kind.name}"].toolTip()
        assert tip.startswith(f"<b>{plain(kind.text)} ({kind.key})</b>")

    typing.editor.set_tool("select")
    table = typing.feature(BlocksFeature).table
    table.selectRow(0)
    table.setFocus()
    key(typing, _Key.Key_F2)
    field = table.findChild(QLineEdit)
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "table z")
    QTest.keyClick(field, _Key.Key_Return)
    document = typing.workspace.current
    qtbot.waitUntil(lambda: "table z" in [info.name for info in document.blocks.infos.values()])
    assert typing.editor.tool_name == "select"
    assert not typing.actions_["show_before_edit"].isChecked()


def test_f2_renames_the_selected_block_but_not_from_another_list(typing, qtbot):
    document = typing.workspace.current
    typing.workspace.select([2])
    typing.panels.enter("Runs")
    key(typing, _Key.Key_F2)
    assert not typing.feature(BlocksFeature).table.findChildren(QLineEdit)
    typing.views.active.view.setFocus()
    key(typing, _Key.Key_F9)
    key(typing, _Key.Key_F2)
    (field,) = typing.feature(BlocksFeature).table.findChildren(QLineEdit)
    QTest.keyClicks(field, "table")
    QTest.keyClick(field, _Key.Key_Return)
    qtbot.waitUntil(lambda: document.info(2).name == "table")


def test_a_block_that_a_click_deselects_is_not_the_one_that_is_renamed(typing, qtbot):
    key(typing, _Key.Key_F9)
    table = typing.feature(BlocksFeature).table
    first, second = (table.visualRect(table.model().index(row, BlockColumn.NAME)).center() for row in (0, 1))
    QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=first)
    for _ in range(2):
        QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, CTRL, second)
    assert typing.workspace.current.selected == [1]
    typing.actions_["rename_block"].trigger()
    (field,) = table.findChildren(QLineEdit)
    assert field.text() == "Block 1"


def test_the_focus_is_where_a_frame_is_opened_and_then_in_its_views(window, qtbot, frame_folder):
    activate(window, qtbot)
    assert _focus().text() == "Open"
    for code in (_Key.Key_Tab, _Key.Key_Backtab):
        key(window, code)
    open_frame(window, qtbot, frame_folder)
    assert isinstance(_focus(), ImageView)
    assert window.views.navigation.pixel is None, "nothing is pointed at before the frame has its place"


def _has_frame(cell):
    return cell.view.grab().toImage().pixelColor(0, 0) == theme.colours(cell.palette()).accent


def test_the_view_with_the_focus_has_a_frame_and_tab_leaves_it(typing):
    seen: list[QWidget] = []
    for name in ("colour", "depth-in", "depth-out"):
        cell = typing.views.cells[name]
        assert cell.view.hasFocus()
        assert _has_frame(cell)
        assert typing.views.active is cell
        seen.append(cell.view)
        key(typing, _Key.Key_Tab)
        assert not _has_frame(cell)
    while isinstance(_focus(), ImageView):
        key(typing, _Key.Key_Tab)
    assert _focus() is typing.feature(BlocksFeature).table


@pytest.mark.parametrize("panels", [(), ("History", "Log", "Frames"), ("Inspect", "Range", "Accuracy")])
def test_every_stop_of_the_tab_key_is_in_sight(typing, panels):
    for title in panels:
        typing.panels.reveal(title)
    QApplication.processEvents()
    first, stops = _focus(), list[QWidget]()
    while not stops or stops[-1] is not first:
        key(typing, _Key.Key_Tab)
        stops.append(_focus())
        assert len(stops) < 100
    assert all(typing.rect().contains(stop.mapTo(typing, stop.rect().center())) for stop in stops)
    assert len(stops) == len(set(stops)) > 10


def test_enter_is_the_default_button_of_a_dialog_wherever_the_focus_is(typing):
    for command in ("open", "export", "hold_out_test", "report", "save_preset", "load_ground_truth"):
        typing.actions_[command].trigger()
        dialog = in_front(typing, QDialog)
        focusable = [
            widget
            for widget in dialog.findChildren(QWidget)
            if widget.isVisible()
            and widget.isEnabled()
            and widget.focusPolicy() & Qt.FocusPolicy.TabFocus
            and not isinstance(widget, QAbstractButton)
        ]
        assert focusable, command
        for widget in focusable:
            _assert_enter_is_default(dialog, widget)
        dialog.close()


def _assert_enter_is_default(dialog: QDialog, widget: QWidget):
    widget.setFocus()
    if not widget.hasFocus():
        return
    if isinstance(widget, QComboBox) and widget.isEditable():
        QTest.keyClicks(widget, "mm")
    accepted = []
    dialog.accept = lambda: accepted.append(True)
    (default,) = (button for button in dialog.findChildren(QPushButton) if button.isDefault())
    default.setEnabled(True)
    default.clicked.disconnect()
    default.clicked.connect(lambda: accepted.append(True))
    QTest.keyClick(widget, _Key.Key_Return)
    assert accepted, (widget, widget.accessibleName())


@pytest.mark.parametrize(
    ("command", "text", "asks"),
    [
        ("open", "File…", "getOpenFileName"),
        ("export", "Browse…", "getExistingDirectory"),
        ("load_blocks", "Folder…", "getExistingDirectory"),
    ],
)
def test_enter_uses_the_button_that_has_the_focus(typing, monkeypatch, command, text, asks):
    asked, nothing = [], "" if asks == "getExistingDirectory" else ("", "")
    monkeypatch.setattr(QFileDialog, asks, lambda *where, **how: asked.append(where) or nothing)
    typing.actions_[command].trigger()
    (dialog,) = (found for found in typing.findChildren(QDialog) if found.isVisible())
    button = next(one for one in dialog.findChildren(QPushButton) if one.text() == text and one.isVisible())
    button.setFocus()
    QTest.keyClick(button, _Key.Key_Return)
    assert len(asked) == 1
    assert dialog.isVisible()
    dialog.close()


def test_enter_fetches_nothing(typing):
    typing.actions_["guide_by_network"].trigger()
    (dialog,) = (found for found in typing.findChildren(QDialog) if found.isVisible())
    (default,) = (button for button in dialog.findChildren(QPushButton) if button.isDefault())
    assert plain(default.text()) == "Close"
    dialog.close()


@pytest.mark.parametrize(("leaving", "expected"), [(_Key.Key_Return, 0.3), (_Key.Key_Escape, 0.03)])
def test_enter_takes_a_typed_number_and_escape_drops_it(typing, leaving, expected):
    field = typing.findChild(QDoubleSpinBox, "slope_weight")
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "0.3")
    key(typing, leaving)
    assert (field.value(), float(field.text())) == pytest.approx((expected, expected))
    assert isinstance(_focus(), ImageView)


def test_undo_in_a_number_field_is_of_what_is_typed_or_else_of_the_window(typing):
    field, undo = typing.findChild(QDoubleSpinBox, "slope_weight"), typing.actions_["undo"]
    field.setFocus()
    key(typing, _Key.Key_Up)
    stepped = field.value()
    QTest.keyClicks(field, "3")
    key(typing, _Key.Key_Z, CTRL)
    assert field.value() == stepped
    assert undo.isEnabled()
    key(typing, _Key.Key_Z, CTRL)
    typing.context.refresh.now()
    assert field.value() == pytest.approx(0.03)
    assert not undo.isEnabled()


def test_escape_drops_a_typed_number_in_each_panel(typing):
    seen = set()
    for dock in typing.findChildren(QDockWidget):
        typing.panels.enter(dock.windowTitle())
        for field in dock.findChildren(QAbstractSpinBox):
            if field.isVisible() and field.isEnabled():
                seen.add(dock.windowTitle())
                before = field.text()
                field.setFocus()
                field.selectAll()
                QTest.keyClicks(field, "3")
                key(typing, _Key.Key_Escape)
                assert field.text() == before, field.toolTip()
    assert len(seen) > 1


@pytest.mark.parametrize("title", ["Runs", "Accuracy", "Frames", "History"])
def test_a_panel_opened_by_its_command_has_the_focus(typing, title):
    toggle = next(action for action in typing.panels.toggles() if plain(action.text()) == title)
    toggle.trigger()
    assert _dock(typing, title).isAncestorOf(_focus())
    typing.panels.enter("Parameters" if title in ("Runs", "Accuracy") else "Blocks")  # the panel is behind a tab now
    toggle.trigger()
    assert toggle.isChecked(), "it is shown, not closed"
    assert _dock(typing, title).isAncestorOf(_focus())
    toggle.trigger()
    assert not toggle.isChecked()
    assert isinstance(_focus(), ImageView)


def _dock(window, title: str) -> QDockWidget:
    return window.findChild(QDockWidget, title)


def test_keys_turn_to_the_cloud_and_back(typing):
    key(typing, _Key.Key_3, CTRL)
    assert typing.centre.shows_cloud_alone
    assert _focus() is typing.feature(CloudPanel).view.canvas
    key(typing, _Key.Key_3, CTRL)
    assert isinstance(_focus(), ImageView)


@pytest.mark.parametrize(("tool", "name", "typed"), [(_Key.Key_H, "Depth", "1.5"), (_Key.Key_A, "Amount", "4")])
def test_the_number_of_a_tool_is_typed_without_a_mouse(typing, tool, name, typed):
    typing.workspace.select([2] if name == "Amount" else [])
    key(typing, tool)
    for _ in range(60):
        key(typing, _Key.Key_Tab)
        if _focus().accessibleName() == name:
            break
    _focus().selectAll()
    QTest.keyClicks(_focus(), typed)
    key(typing, _Key.Key_Return)
    options = typing.editor.options
    assert {"Depth": options.hand_depth, "Amount": options.amount}[name] == float(typed)
    assert isinstance(_focus(), ImageView)
