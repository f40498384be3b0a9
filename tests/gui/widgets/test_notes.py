"""What the window says in passing."""

import pytest
from PySide6.QtCore import QEvent, QPoint, QPointF
from PySide6.QtGui import QAction, QEnterEvent, QHelpEvent
from PySide6.QtWidgets import QApplication, QLineEdit, QMainWindow

from gui.widgets.basics import Message
from gui.widgets.notes import Notes, Toast
from gui.widgets.notices import LogPanel, ProblemBox


@pytest.fixture
def window(shown):
    window = QMainWindow()
    window.setCentralWidget(QLineEdit())
    window.statusBar()
    return shown(window, 600, 400)


@pytest.fixture
def notes(window):
    notes = Notes(window, LogPanel(window))
    window.statusBar().setFixedHeight(28)
    yield notes
    notes.clear()


def test_options_of_the_command_line_are_not_told_in_a_window(window, notes, qtbot):
    label = Message()
    qtbot.addWidget(label)
    notes.show_message("There are two cameras (--topics COLOUR,DEPTH).")
    notes.warn("Open", ["Give the key of a frame (--frame)."])
    label.show_message("Rename the file (command line: --name, or --replace).")
    assert notes.message == "There are two cameras."
    (box,) = window.findChildren(ProblemBox)
    assert box.text() == "Give the key of a frame."
    assert label.text() == "Rename the file."
    box.close()


@pytest.mark.parametrize(("text", "is_cut"), [("Saved", False), ("Exported 9 files to /home/me/room " * 9, True)])
def test_what_is_cut_is_a_tool_tip(window, notes, monkeypatch, text, is_cut):
    said: list[str] = []
    monkeypatch.setattr("gui.widgets.basics.QToolTip.showText", lambda at, text, widget: said.append(text))
    notes.show_message(text)
    QApplication.processEvents()
    label = notes.toast.label
    QApplication.sendEvent(label, QHelpEvent(QEvent.Type.ToolTip, QPoint(3, 3), label.mapToGlobal(QPoint(3, 3))))
    assert said == [text if is_cut else ""]


def test_one_takes_the_place_of_another_and_an_offer_goes_as_it_is_taken_elsewhere(window, notes):
    undo = QAction("Undo", window)
    notes.show_message("Saved")
    notes.offer("Deleted", undo)
    QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
    assert [toast.message for toast in window.findChildren(Toast)] == ["Deleted"]
    undo.trigger()
    assert notes.message == ""


def _over(toast: Toast, kind: type[QEvent] = QEvent) -> QEvent:
    at = QPointF(3, 3)
    return QEnterEvent(at, at, at) if kind is QEnterEvent else QEvent(QEvent.Type.Leave)


def test_one_stays_while_the_pointer_is_on_it(notes, qtbot, monkeypatch):
    monkeypatch.setattr("gui.widgets.notes._MIN_STAY_MS", 50)
    monkeypatch.setattr("gui.widgets.notes._MESSAGE_MS", 30)
    notes.show_message("read me")
    toast = notes.toast
    QApplication.sendEvent(toast, _over(toast, QEnterEvent))
    qtbot.wait(100)
    assert notes.message == "read me"
    QApplication.sendEvent(toast, _over(toast))
    with qtbot.waitSignal(toast.gone):
        pass
    assert notes.message == ""
