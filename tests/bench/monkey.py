"""Random keys, clicks, drags and commands in the whole window: no exception may come of them.

    python -m tests.bench.monkey [--steps 3000] [--seeds 1 2 3 4 5]

Prints the exceptions of each seed, with the steps before them; the exit status is 1 if there is one.
"""

import argparse
import os
import random
import sys
import tempfile
import traceback
from collections import deque
from collections.abc import Callable
from contextlib import chdir
from pathlib import Path
from types import TracebackType

os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
os.environ.setdefault("QT_LOGGING_RULES", "*.warning=false")

from PySide6.QtCore import QPoint, Qt, QTimer
from PySide6.QtGui import QAction
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialog, QWidget
from shiboken6 import isValid

from gui.app.main_window import MainWindow
from gui.base.commands import action_entries
from gui.features.shortcuts import ShortcutsFeature
from tests.pins.window.hand import isolated

from .samples import write_sample
from .window import end, new_window, open_frame, pause

_LEFT = {"quit", "full_screen", "about", "show_project", "open_sample"}
"""Commands that are not given: they end the program or leave it, or work beside its own files."""

_Key, _Modifier = Qt.Key, Qt.KeyboardModifier
_KEYS = [
    *(_Key.Key_Return, _Key.Key_Escape, _Key.Key_Space, _Key.Key_Tab, _Key.Key_Delete, _Key.Key_Backspace),
    *(_Key.Key_Up, _Key.Key_Down, _Key.Key_Left, _Key.Key_Right, _Key.Key_PageDown, _Key.Key_F2, _Key.Key_BracketLeft),
    *(_Key(code) for code in range(_Key.Key_0, _Key.Key_9 + 1)),
    *(_Key(code) for code in range(_Key.Key_A, _Key.Key_Z + 1)),
]
_MODIFIERS = [
    *[_Modifier.NoModifier] * 4,
    *(_Modifier.ControlModifier, _Modifier.ShiftModifier, _Modifier.ControlModifier | _Modifier.ShiftModifier),
]
_LONGEST_MS = 300
"""Menus and dialogs that are open for longer, and would wait for a user, are closed."""


class Monkey:
    """Acts at random in one window.

    Parameters
    ----------
    window : MainWindow
    seed : int
    """

    def __init__(self, window: MainWindow, seed: int) -> None:
        self._window = window
        self._chance = random.Random(seed)
        self.last = deque[str](maxlen=6)
        """What was done last."""
        self._acts: list[Callable[[], str]] = [
            *[self._key] * 3,
            *[self._click] * 4,
            self._drag,
            *[self._command] * 3,
            self._palette,
        ]
        self._closer = QTimer(window, interval=_LONGEST_MS)
        self._closer.timeout.connect(self._close_waiting)
        self._closer.start()

    def step(self) -> None:
        """Do one thing."""
        self.last.append(self._chance.choice(self._acts)())
        pause(self._chance.choice([0, 0, 1, 10]))

    def _key(self) -> str:
        widget = QApplication.focusWidget() or self._window
        key, modifier = self._chance.choice(_KEYS), self._chance.choice(_MODIFIERS)
        if (key, modifier) != (_Key.Key_Q, _Modifier.ControlModifier):
            QTest.keyClick(widget, key, modifier)
        return f"{modifier.name} {key.name} in {type(widget).__name__}"

    def _click(self) -> str:
        widget, place = self._place()
        button = self._chance.choice([Qt.MouseButton.LeftButton] * 5 + [Qt.MouseButton.RightButton])
        if self._chance.random() < 0.1:
            QTest.mouseDClick(widget, button, pos=place)
        else:
            QTest.mouseClick(widget, button, self._chance.choice(_MODIFIERS), place)
        return f"{button.name} at {place.toTuple()} of {type(widget).__name__}"

    def _drag(self) -> str:
        view = self._chance.choice([cell.view for cell in self._window.views.cells.values()]).viewport()
        places = [self._within(view) for _ in range(4)]
        QTest.mousePress(view, Qt.MouseButton.LeftButton, self._chance.choice(_MODIFIERS), places[0])
        for place in places:
            QTest.mouseMove(view, place)
        QTest.mouseRelease(view, Qt.MouseButton.LeftButton, pos=places[-1])
        return f"drag over {[place.toTuple() for place in places]}"

    def _command(self) -> str:
        name = self._chance.choice([name for name in self._window.actions_.commands if name not in _LEFT])
        found: list[QAction] = [self._window.actions_[name]]
        if self._chance.random() < 0.2:  # any entry of the menus, which are filled anew
            found = [entry.action for entry in action_entries(self._window) if entry.key not in _LEFT]
        action = self._chance.choice(found)
        if isValid(action):
            action.trigger()
        return f"command {name if len(found) == 1 else 'of a menu'}"

    def _palette(self) -> str:
        """Use the command palette, which may be open since other steps."""
        palette = self._window.feature(ShortcutsFeature).palette
        if not palette.isVisible():
            palette.toggle()
        QTest.keyClicks(palette.field, self._chance.choice("abcdefghilmnoprstuvw"))
        for _ in range(self._chance.randrange(4)):
            QTest.keyClick(palette.field, self._chance.choice([_Key.Key_Down, _Key.Key_Up, _Key.Key_PageDown]))
        if self._chance.random() < 0.3:
            QTest.keyClick(palette.field, self._chance.choice([_Key.Key_Return, _Key.Key_Escape]))
        return "palette"

    def _place(self) -> tuple[QWidget, QPoint]:
        """Return a visible widget of the window or of a dialog, and a place in it."""
        tops = [top for top in QApplication.topLevelWidgets() if top.isVisible()]
        top = QApplication.activeModalWidget() or self._chance.choice([self._window, self._window, *tops])
        shown = [one for one in top.findChildren(QWidget) if one.isVisible() and one.width() > 1 and one.height() > 1]
        widget = self._chance.choice(shown or [top])
        return widget, self._within(widget)

    def _within(self, widget: QWidget) -> QPoint:
        return QPoint(self._chance.randrange(max(widget.width(), 1)), self._chance.randrange(max(widget.height(), 1)))

    def _close_waiting(self) -> None:
        popup, modal = QApplication.activePopupWidget(), QApplication.activeModalWidget()
        if popup is not None:
            popup.close()
        elif isinstance(modal, QDialog) and self._chance.random() < 0.3:
            modal.reject()


def exceptions_of(seed: int, steps: int, folder: Path) -> list[str]:
    """Return the exceptions of a window in which a monkey acts, as texts."""
    met: list[str] = []
    with isolated(folder), chdir(folder):  # files that it names may be relative
        window = new_window()
        for number in range(3):
            open_frame(window, write_sample(folder / f"frame-{number}", (160, 120), number))
        monkey = Monkey(window, seed)

        def note(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
            text = "".join(traceback.format_exception(kind, error, trace))
            met.append(f"after {list(monkey.last)}:\n{text}")

        before, sys.excepthook = sys.excepthook, note
        try:
            for _ in range(steps):
                monkey.step()
                if not window.isVisible():
                    window.show()
            end(window)
        finally:
            sys.excepthook = before
    return met


def main() -> int:
    """Print the exceptions of all seeds."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--steps", type=int, default=3000)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1, 2, 3, 4, 5])
    options = parser.parse_args()
    total = 0
    for seed in options.seeds:
        with tempfile.TemporaryDirectory() as folder:
            met = exceptions_of(seed, options.steps, Path(folder))
        print(f"seed {seed}: {options.steps} steps, {len(met)} exceptions", *met, sep="\n", flush=True)
        total += len(met)
    return int(total > 0)


if __name__ == "__main__":
    sys.exit(main())
