"""The window fits the screen, at the first start and when its last place has another screen; full screen."""

import pytest
from PySide6.QtCore import QRect, QSettings, QSize, Qt
from PySide6.QtGui import QGuiApplication
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDockWidget, QToolButton, QWidget

from gui.app.main_window import MainWindow
from gui.features.status import StatusFeature
from gui.widgets import docks
from gui.widgets.docks import PanelTitle


@pytest.fixture
def window(shown):
    return shown(MainWindow(), 1280, 800)


@pytest.mark.parametrize(
    ("window", "room", "expected"),
    [
        (QRect(100, 80, 800, 500), QRect(0, 0, 1920, 1080), QRect(100, 80, 800, 500)),
        (QRect(0, 0, 800, 500), QRect(0, 0, 1920, 1080), QRect(0, 40, 800, 500)),
        (QRect(100, 80, 1440, 900), QRect(0, 0, 1066, 666), QRect(0, 40, 1066, 626)),
        (QRect(1500, 900, 800, 500), QRect(0, 0, 1920, 1080), QRect(1120, 580, 800, 500)),
        (QRect(0, 0, 3000, 500), QRect(1920, 30, 1280, 690), QRect(1920, 70, 1280, 500)),
    ],
    ids=["fits", "title bar", "too large", "sticks out", "second screen"],
)
def test_a_window_is_moved_into_the_room_and_made_no_larger(window, room, expected):
    assert docks.fit(window, room) == expected


def test_damaged_settings_do_not_keep_the_window_from_opening(qtbot):
    screen = QGuiApplication.primaryScreen().availableGeometry()
    place = f"window/geometry-{screen.width()}x{screen.height()}"
    for key in (place, "frames/film_strip", "layouts", "theme"):
        QSettings().setValue(key, "damaged" if key != "layouts" else "[" * 10**5)
    window = MainWindow()
    qtbot.addWidget(window)
    assert window.size() == docks.DEFAULT_SIZE.boundedTo(docks.available_geometry(window).size() - QSize(0, 40))


def test_each_screen_keeps_its_own_size_of_the_window(shown, monkeypatch):
    large, small = QRect(0, 0, 800, 800), QRect(0, 0, 800, 610)
    room = [large]
    monkeypatch.setattr(docks, "available_geometry", lambda _: room[0])

    first = shown(MainWindow())
    first.setGeometry(5, 45, 790, 720)
    first.close()
    room[0] = small
    second = shown(MainWindow())
    assert small.contains(second.geometry())
    second.setGeometry(0, 45, 780, 560)
    second.close()
    for room[0], size in ((large, QSize(790, 720)), (small, QSize(780, 560))):
        again = shown(MainWindow())
        assert again.size() == size
        again.close()


def test_the_panels_let_the_window_become_small(window, qtbot):
    window.feature(StatusFeature).bar.hint.setText("long " * 200)
    window.feature(StatusFeature).bar.readout.setText("long " * 200)
    window.setWindowTitle("long " * 200)
    window.resize(800, 560)
    qtbot.waitUntil(lambda: window.size() == QSize(800, 560))


def _click(window, title: str):
    next(action for action in window.panels.toggles() if action.text() == title).trigger()


def test_panels_open_and_close_and_one_key_folds_all_of_them(window, qtbot):
    assert window.panels.open == ["Blocks", "Parameters"]
    qtbot.waitUntil(lambda: window.findChild(QDockWidget, "Blocks").width() == round(0.26 * window.width()))
    before = window.views.width()
    _click(window, "Parameters")
    _click(window, "Log")
    assert window.panels.open == ["Blocks", "Log"]
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    qtbot.keyClick(window, Qt.Key.Key_F9)
    assert window.panels.open == []
    qtbot.waitUntil(lambda: window.views.width() > before + 200)
    qtbot.keyClick(window, Qt.Key.Key_F9)
    assert window.panels.open == ["Blocks", "Log"]


def test_panels_of_one_purpose_share_a_place(window, qtbot):
    _click(window, "Accuracy")
    docks = {title: window.findChild(QDockWidget, title) for title in ("Accuracy", "Parameters", "Blocks")}
    neighbours = [tab.objectName() for tab in window.tabifiedDockWidgets(docks["Accuracy"]) if not tab.isHidden()]
    assert neighbours == ["Parameters"]
    assert window.panels.open == ["Blocks", "Parameters", "Accuracy"]
    qtbot.waitUntil(lambda: not docks["Accuracy"].visibleRegion().isEmpty())
    assert docks["Parameters"].visibleRegion().isEmpty()
    qtbot.waitUntil(lambda: type(docks["Accuracy"].titleBarWidget()) is QWidget)  # its tab has the title
    qtbot.waitUntil(lambda: [title for title, dock in docks.items() if dock.findChildren(PanelTitle)] == ["Blocks"])
    _click(window, "Accuracy")
    qtbot.waitUntil(lambda: isinstance(docks["Parameters"].titleBarWidget(), PanelTitle))
    QTest.mouseClick(docks["Parameters"].findChild(QToolButton, "close"), Qt.MouseButton.LeftButton)
    assert window.panels.open == ["Blocks"]
    docks["Blocks"].setFloating(True)
    qtbot.waitUntil(lambda: docks["Blocks"].titleBarWidget() is None)  # its window has one


def test_full_screen_by_f11_and_back_and_escape_does_not_quit(window, qtbot):
    window.activateWindow()
    qtbot.waitUntil(window.isActiveWindow)
    assert not window.actions_["full_screen"].isChecked()
    qtbot.keyClick(window, Qt.Key.Key_F11)
    assert window.isFullScreen()
    assert window.actions_["full_screen"].isChecked()
    qtbot.keyClick(window, Qt.Key.Key_Escape)
    assert window.isVisible()
    qtbot.keyClick(window, Qt.Key.Key_F11)
    assert not window.isFullScreen()
    window.showFullScreen()
    qtbot.waitUntil(window.actions_["full_screen"].isChecked)
