"""Tables: what keys do, and how wide columns are."""

from PySide6.QtCore import Qt

from gui.widgets.row_table import NumberRow, NumberTable


def test_f2_changes_nothing_in_a_table_without_names(qtbot, shown):
    table = shown(NumberTable("Errors", [("RMSE", "Root mean square error")]))
    table.set_rows([NumberRow("Current", ("12",))])
    table.setCurrentIndex(table.model().index(0, 1))
    qtbot.keyClick(table, Qt.Key.Key_F2)
    assert table.state() is NumberTable.State.NoState


def test_a_new_row_of_numbers_is_not_cut_off(shown):
    table = shown(NumberTable("Errors", [("RMSE", "Root mean square error")]))
    table.set_rows([NumberRow("Current", ("12",))])
    table.set_rows([NumberRow("Current", ("12",)), NumberRow("Preset best", ("1,234,567.8 m",))])
    assert table.columnWidth(1) >= table.sizeHintForColumn(1)
