"""Driver that performs and counts a user's mouse and keyboard actions in the real window."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PySide6.QtCore import QPoint, QPointF, Qt
from PySide6.QtGui import QKeySequence
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QWidget

from gui.app.main_window import MainWindow
from gui.state.session import Session
from gui.work.frame_runs import RunState
from ilf.run.run import Run

from .hand import Action, Brush, Click, Command, Key, Stroke, Use, Wasted, by_hand
from .targets import Correction, Point

_MARGIN = 12
"""Margin shown around a region [image px]."""
_PATIENCE_S = 20.0
"""Longest waits for the window's own work: on opening a frame, and after an edit."""
_Modifier = Qt.KeyboardModifier
_LEFT = Qt.MouseButton.LeftButton


@dataclass
class Count:
    """Numbers of clicks, strokes and keys; a key with Ctrl counts as one."""

    clicks: int = 0
    strokes: int = 0
    keys: int = 0
    wasted: int = 0
    """Inputs of all kinds that were in vain."""


class Driver:
    """A visible window of 1280 x 800, whose tool and brush stay from correction to correction."""

    def __init__(self) -> None:
        self.window = MainWindow(persistent=False)
        self.window.documents.discard_silently = True
        self.window.resize(1280, 800)
        self.window.show()
        self.window.activateWindow()
        QTest.qWaitForWindowActive(self.window)

    def open(self, run: Run, correction: Correction) -> Session:
        """Open a frame with its blocks, and show the region with its surroundings."""
        workspace = self.window.workspace
        for before in list(workspace.frames.sessions):
            workspace.frames.close(before)
        session = Session.of(run, None, f"{run.frame.name}: {correction.name}")
        workspace.add_session(session)
        self._settle()
        rows, columns = correction.box
        self.window.views.zoom_to(
            slice(rows.start - _MARGIN, rows.stop + _MARGIN), slice(columns.start - _MARGIN, columns.stop + _MARGIN)
        )
        self._settle()
        self._wait(lambda: self.window.editor.edge_data is not None, "The edges for snapping were not found")
        return session

    def close(self) -> None:
        """Close the window."""
        self.window.close()

    def do(self, actions: Sequence[Action], name: str) -> Count:
        """Perform actions in turn; the tremor of the hand depends on the name."""
        count = Count()
        for number, action in enumerate(actions):
            self._do(action, count, f"{name}:{number}")
            self._settle()
            self._wait(lambda: not self.window.editor.working, "The tool did not come to a result")
        self._wait(lambda: self.window.runs.state is RunState.IDLE, "The blocks were not solved")
        return count

    def _do(self, action: Action, count: Count, name: str) -> None:
        match action:
            case Use(tool):
                if self.window.editor.tool_name != tool:
                    self._command(f"tool_{tool}", count)
            case Brush(radius):
                self._size_brush(radius, count)
            case Click():
                self._click(action)
                count.clicks += 1
            case Stroke():
                self._draw(action, name)
                count.strokes += 1
            case Command(command):
                self._command(command, count)
            case Key(key):
                QTest.keySequence(QApplication.focusWidget() or self.window, QKeySequence(key))
                count.keys += 1
            case Wasted(inputs):
                count.wasted += inputs

    def _command(self, name: str, count: Count) -> None:
        keys = self.window.actions_[name].shortcut()
        if keys.isEmpty():
            raise ValueError(f"The action {name} has no key.")
        QTest.keySequence(self.window, keys)
        count.keys += 1

    def _size_brush(self, radius: float, count: Count) -> None:
        options = self.window.editor.options
        while options.brush_radius != radius:
            before = options.brush_radius
            self._command("brush_smaller" if before > radius else "brush_larger", count)
            if (options.brush_radius - radius) * (before - radius) < 0 or options.brush_radius == before:
                raise ValueError(f"There is no brush of {radius:g} px.")

    def _click(self, action: Click) -> None:
        button = Qt.MouseButton.RightButton if action.right else _LEFT
        modifiers = _modifiers(action.ctrl, action.shift, action.alt)
        where = self._viewport, button, modifiers, self._place((action.x, action.y))
        QTest.mouseClick(*where)
        if action.double:  # events of a mouse: press, release, double click, release
            QTest.mouseDClick(*where)
            QTest.mouseRelease(*where)

    def _draw(self, action: Stroke, name: str) -> None:
        places = [self._place(point) for point in by_hand(action.path, name)]
        modifiers = _modifiers(action.ctrl, action.shift, action.alt)
        QTest.mousePress(self._viewport, _LEFT, modifiers, places[0])
        for place in places[1:]:
            QTest.mouseMove(self._viewport, place)
        QTest.mouseRelease(self._viewport, _LEFT, modifiers, places[-1])

    @property
    def _viewport(self) -> QWidget:
        return self.window.views.cells["colour"].view.viewport()

    def _place(self, point: Point) -> QPoint:
        return self.window.views.cells["colour"].view.viewportTransform().map(QPointF(*point)).toPoint()

    def _wait(self, done: Callable[[], bool], failure: str) -> None:
        end = time.monotonic() + _PATIENCE_S
        while not done():
            if time.monotonic() > end:
                raise TimeoutError(f"{failure}, after a long wait.")
            QApplication.processEvents()
            time.sleep(0.01)  # unlike QTest.qWait it lets other threads run

    def _settle(self) -> None:
        QApplication.processEvents()
        self.window.refresh.now()


def _modifiers(ctrl: bool = False, shift: bool = False, alt: bool = False) -> Qt.KeyboardModifier:
    chosen = _Modifier.NoModifier
    for wanted, modifier in (
        (ctrl, _Modifier.ControlModifier),
        (shift, _Modifier.ShiftModifier),
        (alt, _Modifier.AltModifier),
    ):
        if wanted:
            chosen |= modifier
    return chosen
