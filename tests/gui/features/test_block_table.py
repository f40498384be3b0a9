"""The block table keeps its place while rows change, and reports what the user wants."""

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import QColorDialog, QLineEdit

from gui.features.blocks.table import BlockColumn, BlockTable, block_cells
from gui.state.frame_data import BlockCounts
from gui.widgets.row_table import TableCells
from ilf.data.blocks import BlockInfo


def _rows(*labels: int, **more: object) -> dict[int, TableCells]:
    """Rows of blocks, of which the last has more than name and pixels."""
    return {
        label: block_cells(
            BlockInfo(f"Block {label}", (200, 80, 40)),
            BlockCounts(1000 * label, 750 * label),
            **(more if label == labels[-1] else {}),
        )
        for label in labels
    }


class _Edits:
    """Takes down what the table does to the current frame."""

    def __init__(self) -> None:
        self.made = []
        self.current = self

    def info(self, label):
        return BlockInfo(f"Block {label}", (200, 80, 40))

    def set_visible(self, label, on):
        self.made.append((label, on))

    def set_lock(self, label, on):
        self.made.append((label, "locked" if on else "unlocked"))

    def edit_info(self, label, text, **changes):
        self.made.append((label, changes))


@pytest.fixture
def edits():
    return _Edits()


@pytest.fixture
def table(shown, edits):
    table = BlockTable(edits)
    table.set_rows(_rows(*range(1, 13)))
    return shown(table, 700, 300)


def _centre(table: BlockTable, row: int, column: BlockColumn) -> QPoint:
    return table.visualRect(table.model().index(row, column)).center()


def _names(table: BlockTable) -> list[str]:
    model = table.model()
    return [model.index(row, BlockColumn.NAME).data() for row in range(model.rowCount())]


def test_only_a_block_that_needs_a_look_says_why(table):
    table.set_rows(_rows(1, 2, look="It is new.") | _rows(3))
    names = [table.model().index(row, BlockColumn.NAME) for row in range(3)]
    assert ["It is new." in name.data(Qt.ItemDataRole.ToolTipRole) for name in names] == [False, True, False]
    assert [name.data(Qt.ItemDataRole.DecorationRole) is not None for name in names] == [False, True, False]


def test_selection_and_sorting_outlive_new_rows(table, qtbot):
    table.sortByColumn(BlockColumn.PIXELS, Qt.SortOrder.DescendingOrder)
    with qtbot.assertNotEmitted(table.labelsSelected):
        table.select([3, 5, 99])
        table.set_rows(_rows(*{*range(1, 15)} - {7}))
        assert table.chosen() == [5, 3]
        table.set_rows(_rows(*{*range(1, 15)} - {5, 7}))
    assert table.chosen() == [3]
    assert _names(table)[0] == "Block 14"
    assert "Block 7" not in _names(table)


def test_swatch_opens_the_colour_dialog(table, edits, qtbot, monkeypatch):
    answers = [QColor(), QColor(*edits.info(1).colour), QColor(1, 2, 3)]
    monkeypatch.setattr(QColorDialog, "getColor", lambda *_: answers.pop(0))
    viewport, at = table.viewport(), _centre(table, 0, BlockColumn.COLOUR)
    for _ in answers[:2]:  # cancelled, and left as it was
        qtbot.mouseClick(viewport, Qt.MouseButton.LeftButton, pos=at)
    assert edits.made == []
    qtbot.mouseClick(viewport, Qt.MouseButton.LeftButton, pos=at)
    assert edits.made == [(1, {"colour": (1, 2, 3)})]


def test_keyboard_renames_and_shows_and_space_changes_nothing(table, edits, qtbot):
    table.select([2, 3])
    qtbot.keyClick(table, Qt.Key.Key_F2)
    editor = table.viewport().findChild(QLineEdit)
    assert editor.text() == table.model().index(1, BlockColumn.NAME).data()
    qtbot.keyClicks(editor, "Context")
    with qtbot.assertNotEmitted(table.shown, wait=50):
        qtbot.keyClick(editor, Qt.Key.Key_Return)
    qtbot.waitUntil(lambda: edits.made == [(2, {"name": "Context"})])
    qtbot.keyClick(table, Qt.Key.Key_Space)
    assert len(edits.made) == 1
    assert table.chosen() == [2, 3]
    with qtbot.waitSignal(table.shown) as shown:
        qtbot.keyClick(table, Qt.Key.Key_Return)
    assert shown.args == [2]


def test_the_rest_of_the_columns_comes_on_demand_and_is_remembered(table, edits, qtbot):
    assert [column for column in BlockColumn if not table.isColumnHidden(column)] == list(BlockColumn)[:7]
    entries = {action.text(): action for action in table.column_menu().actions()}
    entries["Pixels"].setChecked(True)
    entries["Locked"].setChecked(False)
    assert table.columnWidth(BlockColumn.NAME) + sum(
        table.columnWidth(column) for column in BlockColumn if column != BlockColumn.NAME
    ) == pytest.approx(table.viewport().width(), abs=2)
    other = BlockTable(edits)
    qtbot.addWidget(other)
    assert not other.isColumnHidden(BlockColumn.PIXELS)
    assert other.isColumnHidden(BlockColumn.LOCKED)


def test_names_sort_by_number_and_missing_sigma_comes_last(table):
    table.sortByColumn(BlockColumn.NAME, Qt.SortOrder.AscendingOrder)
    assert _names(table)[1::8] == ["Block 2", "Block 10"]
    table.set_rows(_rows(1, 2, sigma_i=0.2) | _rows(3, sigma_i=0.1))
    table.sortByColumn(BlockColumn.SIGMA, Qt.SortOrder.AscendingOrder)
    assert _names(table) == ["Block 3", "Block 2", "Block 1"]
