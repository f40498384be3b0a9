"""Tables: what keys do."""

from PySide6.QtCore import Qt

from gui.widgets.row_table import NumberRow, NumberTable


def test_f2_changes_nothing_in_a_table_without_names(qtbot, shown):
    table = shown(NumberTable("Errors", [("RMSE", "Root mean square error")]))
    table.set_rows([NumberRow("Current", ("12",))])
    table.setCurrentIndex(table.model().index(0, 1))
    qtbot.keyClick(table, Qt.Key.Key_F2)
    assert table.state() is NumberTable.State.NoState
