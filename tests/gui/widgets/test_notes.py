"""What the window says in passing."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from PySide6.QtCore import QEvent, QPointF, QRect, Qt
from PySide6.QtGui import QAction, QEnterEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QMainWindow
from pytestqt.qtbot import QtBot

from gui.widgets.notices import MAX_NOTES, LogPanel, Notes, Toast, Toasts


@pytest.fixture
def window(qtbot: QtBot) -> QMainWindow:
    window = QMainWindow()
    window.setCentralWidget(QLineEdit())
    window.statusBar()
    qtbot.addWidget(window)
    window.resize(600, 400)
    window.show()
    qtbot.waitExposed(window)
    return window


@pytest.fixture
def toasts(window: QMainWindow) -> Iterator[Toasts]:
    toasts = Toasts(window, (window.centralWidget(),))
    yield toasts
    toasts.clear()


def test_what_is_of_no_interest_takes_the_place_of_nothing_but_its_like(
    window: QMainWindow, toasts: Toasts, qtbot: QtBot
) -> None:
    log = LogPanel()
    qtbot.addWidget(log)
    notes = Notes(window, toasts, log)
    notes.show_briefly("3 blocks in 20 ms")
    notes.show_briefly("3 blocks in 25 ms")
    assert [toast.message for toast in toasts.shown] == ["3 blocks in 25 ms"]
    notes.show_message("Values of their own stay.")
    notes.show_briefly("3 blocks in 21 ms")
    assert toasts.message == "Values of their own stay."
    toasts.clear()
    notes.show_briefly("3 blocks in 22 ms")
    assert toasts.message == "3 blocks in 22 ms"


def test_they_stack_in_the_corner_and_take_no_focus(window: QMainWindow, toasts: Toasts) -> None:
    field = window.centralWidget()
    field.setFocus()
    for message in ("one", "two", "three of them " * 20, "one", "four"):
        toasts.show_message(message, 10_000)
    assert [toast.message[:5] for toast in toasts.shown] == ["three", "one", "four"]
    assert len(toasts.shown) == MAX_NOTES
    room = QRect(field.mapTo(window, field.rect().topLeft()), field.size())
    boxes = [toast.geometry() for toast in toasts.shown]
    assert all(room.contains(box) for box in boxes)
    assert boxes[0].bottom() < boxes[1].top() < boxes[1].bottom() < boxes[2].top()
    assert boxes[0].height() > 2 * boxes[1].height(), "what is long is wrapped"
    QTest.mouseClick(toasts.shown[1].close_button, Qt.MouseButton.LeftButton)
    assert toasts.message == "four"
    assert len(toasts.shown) == 2
    assert QApplication.focusWidget() is field


def test_what_fits_on_a_line_takes_one(toasts: Toasts) -> None:
    for message in ("Saved", "Saved to the folder of the frame", "Exported 12 files to /home/me/room"):
        toasts.show_message(message, 10_000)
    word, sentence, path = (toast.height() for toast in toasts.shown)
    assert word == sentence == path


def _over(toast: Toast, kind: type[QEvent] = QEvent) -> QEvent:
    at = QPointF(3, 3)
    return QEnterEvent(at, at, at) if kind is QEnterEvent else QEvent(QEvent.Type.Leave)


def test_one_stays_while_the_pointer_is_on_it(toasts: Toasts, qtbot: QtBot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("gui.widgets.notices._MIN_STAY_MS", 50)
    toasts.show_message("read me", 30)
    (toast,) = toasts.shown
    QApplication.sendEvent(toast, _over(toast, QEnterEvent))
    toasts.show_message("gone soon", 30)
    qtbot.waitUntil(lambda: [toast.message for toast in toasts.shown] == ["read me"])
    QApplication.sendEvent(toast, _over(toast))
    with qtbot.waitSignal(toast.gone, timeout=60_000):
        pass


def test_a_command_is_offered_once(window: QMainWindow, toasts: Toasts) -> None:
    action = QAction("&Clean up…", window)
    given: list[bool] = []
    action.triggered.connect(lambda: given.append(True))
    toasts.show_message("3 slivers left.", 10_000, action)
    (toast,) = toasts.shown
    assert toast.commands[0].text() == "Clean up"
    QTest.mouseClick(toast.commands[0], Qt.MouseButton.LeftButton)
    assert given == [True]
    assert toasts.shown == []
    for left in (1, 2):
        toasts.show_message(f"{left} slivers left.", 10_000, action)
    assert [toast.message for toast in toasts.shown] == ["2 slivers left."]
    action.trigger()
    assert toasts.shown == []
