"""What went wrong can be handed on: details folded, all of it copied with the versions; so can the log."""

import PySide6
import pytest
from PySide6.QtCore import Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMessageBox, QTextEdit, QWidget

import ilf
from gui.features.about import AboutDialog
from gui.widgets.notes import Notes
from gui.widgets.notices import LogPanel, ProblemBox
from ilf._runtime.termination import error_log_path
from ilf.errors import InputError


@pytest.fixture
def window(shown):
    return shown(QWidget())


def _reported(window, error: Exception) -> ProblemBox:
    try:
        raise error
    except Exception as raised:
        Notes(window, LogPanel(window)).report("Open frame", raised)
    (box,) = window.findChildren(ProblemBox)
    return box


def _copied(button: QWidget) -> str:
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    return QGuiApplication.clipboard().text()


def test_an_unexpected_error_has_its_traceback_folded_and_copied(window):
    box = _reported(window, ZeroDivisionError("nothing to divide by"))
    assert "ZeroDivisionError: nothing to divide by" in box.text()
    assert str(error_log_path()) in box.text()
    assert "nothing to divide by" in error_log_path().read_text()
    assert not any(text.isVisible() for text in box.findChildren(QTextEdit)), "details are folded"
    copied = _copied(box.copy_button)
    assert box.isVisible()
    assert "in _reported" in copied
    assert f"ILF Studio: {ilf.__version__}" in copied
    assert f"PySide6: {PySide6.__version__}" in copied
    box.close()


def test_an_expected_error_has_nothing_to_unfold_but_can_be_copied(window):
    box = _reported(window, InputError("a.png: no such file."))
    assert box.detailedText() == ""
    assert _copied(box.copy_button).startswith("Open frame\n\na.png: no such file.\n\nILF Studio")
    QTest.mouseClick(box.button(QMessageBox.StandardButton.Ok), Qt.MouseButton.LeftButton)


def test_the_log_is_copied_and_cleared(qtbot):
    log = LogPanel()
    qtbot.addWidget(log)
    log.add("one")
    log.add("two")
    assert _copied(log.copy_button) == log.text.toPlainText()
    cursor = log.text.textCursor()
    cursor.movePosition(cursor.MoveOperation.End)
    cursor.movePosition(cursor.MoveOperation.PreviousWord, cursor.MoveMode.KeepAnchor)
    log.text.setTextCursor(cursor)
    assert _copied(log.copy_button) == "two"
    QTest.mouseClick(log.clear_button, Qt.MouseButton.LeftButton)
    assert log.text.toPlainText() == ""


def test_about_copies_all_versions(shown):
    dialog = shown(AboutDialog())
    copied = dict(line.split(": ", 1) for line in _copied(dialog.copy_button).splitlines())
    assert copied["ILF Studio"] == ilf.__version__
    assert {"Python", "Qt", "PySide6", "numpy", "scipy", "OpenCV", "pyqtgraph", "Open3D", "System"} <= set(copied)
    dialog.close()
