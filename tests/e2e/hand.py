"""What a hand does with mouse and keys in the colour view of the window."""

from collections.abc import Sequence

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from gui.app.main_window import MainWindow
from tests.pins.window.hand import wheel

Point = tuple[float, float]
PLAIN = Qt.KeyboardModifier.NoModifier
SHIFT, CTRL, ALT = (
    Qt.KeyboardModifier.ShiftModifier,
    Qt.KeyboardModifier.ControlModifier,
    Qt.KeyboardModifier.AltModifier,
)
LEFT = Qt.MouseButton.LeftButton


def viewport(window: MainWindow) -> QWidget:
    return window.views.cells["colour"].view.viewport()


def place(window: MainWindow, point: Point) -> QPoint:
    """Where image coordinates are in the colour view."""
    return window.views.cells["colour"].view.transform.map(QPointF(*point)).toPoint()


def click(window: MainWindow, point: Point, modifier: Qt.KeyboardModifier = PLAIN) -> None:
    QTest.mouseClick(viewport(window), LEFT, modifier, place(window, point))


def double_click(window: MainWindow, point: Point) -> None:
    """A click, and the second one as a window sends it."""
    click(window, point)
    QTest.mouseDClick(viewport(window), LEFT, PLAIN, place(window, point))
    QTest.mouseRelease(viewport(window), LEFT, PLAIN, place(window, point))


def drag(
    window: MainWindow, points: Sequence[Point], modifier: Qt.KeyboardModifier = PLAIN, release: bool = True
) -> None:
    QTest.mousePress(viewport(window), LEFT, modifier, place(window, points[0]))
    for point in points[1:]:
        hover(window, point)
    if release:
        let_go(window, points[-1], modifier)


def let_go(window: MainWindow, point: Point, modifier: Qt.KeyboardModifier = PLAIN) -> None:
    QTest.mouseRelease(viewport(window), LEFT, modifier, place(window, point))


def hover(window: MainWindow, point: Point) -> None:
    QTest.mouseMove(viewport(window), place(window, point))


def key(window: MainWindow, code: Qt.Key, modifier: Qt.KeyboardModifier = PLAIN) -> None:
    """A key, wherever the focus is."""
    QTest.keyClick(QApplication.focusWidget() or window, code, modifier)


def turn_wheel(window: MainWindow, point: Point, notches: int, modifier: Qt.KeyboardModifier = PLAIN) -> None:
    wheel(viewport(window), QPointF(place(window, point)), notches, modifier)
