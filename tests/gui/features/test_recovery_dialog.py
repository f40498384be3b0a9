"""The dialog that offers unsaved work."""

from datetime import UTC, datetime, timedelta

from PySide6.QtWidgets import QWidget

from gui.features.project.autosave import RecoveryDialog, UnsavedWorkInfo
from gui.widgets.basics import PlainLabel


def test_each_work_is_told_apart_by_name_age_and_content(qtbot):
    parent = QWidget()
    qtbot.addWidget(parent)
    changed = datetime.now(UTC) - timedelta(minutes=5)
    works = [
        UnsavedWorkInfo("Kitchen", changed, ("3 frames", "2 runs")),
        UnsavedWorkInfo("Hall", None, (), problem="It is damaged."),
    ]
    dialog = RecoveryDialog(works, parent)
    dialog.show()
    qtbot.waitExposed(dialog)
    kitchen, hall = (
        [label.text() for label in row.findChildren(PlainLabel) if label.isVisible()] for row in dialog.rows.values()
    )
    assert {"Kitchen", "3 frames\n2 runs"} <= set(kitchen)
    assert any(text.startswith("Last change 5 minutes ago") for text in kitchen)
    assert {"Hall", "It is damaged."} <= set(hall)
    dialog.reject()
