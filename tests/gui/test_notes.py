"""What the window says in passing."""

from __future__ import annotations

from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QLabel, QMainWindow, QVBoxLayout, QWidget
from pytestqt.qtbot import QtBot

from gui.widgets.log import LogPanel
from gui.widgets.message_strip import MessageStrip
from gui.widgets.notes import Notes


def test_what_is_of_no_interest_takes_the_place_of_nothing_but_its_like(qtbot: QtBot) -> None:
    window = QMainWindow()
    qtbot.addWidget(window)
    window.show()
    strip, log = MessageStrip(window), LogPanel()
    qtbot.addWidget(log)
    notes = Notes(window, strip, log)
    notes.glimpse("3 blocks in 20 ms")
    notes.glimpse("3 blocks in 25 ms")
    assert strip.message == "3 blocks in 25 ms"
    notes.tell("Values of their own stay.")
    notes.glimpse("3 blocks in 21 ms")
    assert strip.message == "Values of their own stay."
    strip.hide()
    notes.glimpse("3 blocks in 22 ms")
    assert strip.message == "3 blocks in 22 ms"


def test_a_message_covers_no_strip_also_if_that_comes_later(qtbot: QtBot) -> None:
    window, centre, strip = QMainWindow(), QWidget(), QLabel("Where next?")
    column = QVBoxLayout(centre)
    column.addStretch()
    column.addWidget(strip)
    strip.hide()
    window.setCentralWidget(centre)
    window.statusBar()
    qtbot.addWidget(window)
    window.resize(500, 300)
    window.show()
    qtbot.waitExposed(window)
    messages = MessageStrip(window, (strip,))
    messages.tell("Done", 10_000)
    strip.show()
    qtbot.waitUntil(lambda: messages.geometry().bottom() < strip.mapTo(window, QPoint()).y())
    messages.hide()
