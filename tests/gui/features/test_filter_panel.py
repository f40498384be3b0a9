"""The panel of the filter."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QToolButton
from pytestqt.qtbot import QtBot

from gui.features.filter.panel import Sharing, SharingRow


def test_commands_for_parameters_of_one_frame_are_offered_only_where_it_has_them(qtbot: QtBot) -> None:
    actions = [QAction("Give to all"), QAction("Take those of all")]
    row = SharingRow(actions)
    qtbot.addWidget(row)
    for sharing, offered in ((Sharing.EACH, []), (Sharing.ALONE, actions), (Sharing.ALL, [])):
        row.show_sharing(sharing)
        buttons = [button for button in row.findChildren(QToolButton) if button.isVisibleTo(row)]
        assert [button.defaultAction() for button in buttons] == offered
        assert row.box.currentText() == sharing.value
