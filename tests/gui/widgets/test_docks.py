"""The window fits the screen, at the first start and when its last place has another screen; full screen."""

import pytest
from PySide6.QtCore import QPoint, QRect, QSettings, QSize, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QDockWidget, QToolButton, QWidget

from gui.app.main_window import MainWindow
from gui.features.status import StatusFeature
from gui.widgets import docks
from gui.widgets.docks import PanelTitle


@pytest.fixture
def window(shown):
    return shown(MainWindow(), 1280, 800)


def test_damaged_settings_do_not_keep_the_window_from_opening(qtbot):
    for key in ("window/geometry", "frames/film_strip", "layouts", "theme"):
        QSettings().setValue(key, "damaged" if key != "layouts" else "[" * 10**5)
    window = MainWindow()
    qtbot.addWidget(window)
    assert window.size() == docks.DEFAULT_SIZE.boundedTo(window.screen().availableSize() - QSize(0, 40))


@pytest.mark.parametrize(
    ("place", "fits"),
    [(QRect(5, 45, 790, 720), True), (QRect(5, 3, 790, 720), True), (QRect(300, 45, 2000, 1500), False)],
    ids=["fits", "at the top", "too large"],
)
def test_the_window_opens_where_it_was_as_far_as_there_is_room(shown, place, fits):
    first = shown(MainWindow())
    first.setGeometry(place)
    first.close()
    again = shown(MainWindow())
    assert again.screen().availableGeometry().contains(again.geometry())
    assert (again.geometry() == place) is fits


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


def test_a_panel_follows_the_mouse_out_of_the_window_and_has_a_frame_once_it_is_let_go(window, qtbot):
    dock, handle = window.findChild(QDockWidget, "Blocks"), window.windowHandle()
    qtbot.waitUntil(lambda: isinstance(dock.titleBarWidget(), PanelTitle))
    start = dock.titleBarWidget().mapTo(window, QPoint(40, 8))
    QTest.mousePress(handle, Qt.MouseButton.LeftButton, pos=start)
    for distance in range(20, 400, 20):
        QTest.mouseMove(handle, start - QPoint(distance, -distance))
        qtbot.wait(5)
    assert dock.isFloating()
    assert isinstance(dock.titleBarWidget(), PanelTitle), "the drag goes on by it"
    QTest.mouseRelease(handle, Qt.MouseButton.LeftButton, pos=start - QPoint(400, -400))
    qtbot.waitUntil(lambda: dock.titleBarWidget() is None)


def test_panels_outside_the_window_are_shown_after_it(window, qtbot):
    window.findChild(QDockWidget, "Blocks").setFloating(True)
    again = MainWindow()
    qtbot.addWidget(again)
    again.panels.take(window.panels.open, window.panels.places())
    again.show()
    blocks = again.findChild(QDockWidget, "Blocks")
    assert not blocks.isVisible()
    qtbot.waitUntil(blocks.isVisible)
    assert blocks.isFloating()


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
