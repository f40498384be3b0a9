"""A user's hand in a window, and everything that the pins know of the window's inside: a redesign adapts this file."""

import importlib
import os
import pkgutil
import re
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import PySide6
from PySide6.QtCore import (
    QAbstractListModel,
    QCoreApplication,
    QEvent,
    QMimeData,
    QPoint,
    QPointF,
    QSettings,
    Qt,
    QTimer,
    QUrl,
)
from PySide6.QtGui import (
    QAction,
    QColor,
    QDragEnterEvent,
    QDropEvent,
    QKeySequence,
    QMouseEvent,
    QWheelEvent,
)
from PySide6.QtTest import QTest
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QColorDialog,
    QComboBox,
    QDialog,
    QDockWidget,
    QFileDialog,
    QInputDialog,
    QLabel,
    QLineEdit,
    QMenu,
    QTabBar,
    QWidget,
)

import gui
import ilf
from gui.app.main_window import MainWindow
from gui.state import parameters
from ilf.data.blocks import BlockInfo, block_colour

Point = tuple[float, float]
"""Image coordinates x, y [px]."""

_PLAIN = Qt.KeyboardModifier.NoModifier
_MODIFIERS = {
    "": _PLAIN,
    "Shift": Qt.KeyboardModifier.ShiftModifier,
    "Ctrl": Qt.KeyboardModifier.ControlModifier,
    "Alt": Qt.KeyboardModifier.AltModifier,
}
_LEFT = Qt.MouseButton.LeftButton
_LONGEST_S = 120.0
_LEAVING = {"Save the work?": "Discard", "Stop the work?": "Stop"}
"""Title of the question whether to leave -> the button that leaves."""
_PATIENCE_MS = 600
"""Timers that wait longer are no work in progress, but for example messages that disappear."""
_FOLDERS = {
    "HOME": "home",
    "XDG_STATE_HOME": "state",
    "XDG_CONFIG_HOME": "config",
    "ILF_MODELS": "models",
    "ILF_PRESETS": "presets",
    "ILF_AUTOSAVE": "autosave",
    "ILF_CACHE": "cache",
    "ILF_LOG": "faults.log",
}

_ANSWERS: deque[Any] = deque()


def _answer(*_: object, **__: object) -> Any:
    """What the user answers next; as by Cancel if there is nothing."""
    return _ANSWERS.popleft() if _ANSWERS else ""


_REPLACED: dict[tuple[Any, str], Any] = {
    (QFileDialog, "getOpenFileName"): lambda *_, **__: (_answer(), ""),
    (QFileDialog, "getSaveFileName"): lambda *_, **__: (_answer(), ""),
    (QFileDialog, "getExistingDirectory"): _answer,
    (QInputDialog, "getText"): lambda *_, **__: (_answer(), True),
    (QColorDialog, "getColor"): lambda *_, **__: QColor(*_answer()),
    (parameters, "DRAG_S"): -1.0,
}
"""Dialogs of the system, which would wait for a user; and no two changes are one drag, however quickly they follow."""


@contextmanager
def isolated(folder: Path) -> Iterator[QApplication]:
    """The application with home folder, settings, presets, models and autosave in a folder of the session's own."""
    (folder / "home").mkdir(exist_ok=True)
    QCoreApplication.setOrganizationName("ILF Studio")
    QCoreApplication.setApplicationName("ilf-studio-pins")
    QSettings.setDefaultFormat(QSettings.Format.IniFormat)
    QSettings.setPath(QSettings.Format.IniFormat, QSettings.Scope.UserScope, str(folder / "settings"))
    before = {name: os.environ.get(name) for name in (*_FOLDERS, "ILF_DEVICE")}
    os.environ.update({name: str(folder / place) for name, place in _FOLDERS.items()})
    os.environ.pop("ILF_DEVICE", None)
    replaced = {place: getattr(*place) for place in _REPLACED}
    for place, value in _REPLACED.items():
        setattr(*place, value)
    present = QApplication.instance()
    try:
        yield present if isinstance(present, QApplication) else QApplication(["ilf-studio-pins"])
    finally:
        for place, value in replaced.items():
            setattr(*place, value)
        for name, folder_before in before.items():
            if folder_before is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = folder_before


def dragged(
    kind: type[QDropEvent],
    data: QMimeData,
    actions: Qt.DropAction = Qt.DropAction.CopyAction,
    keys: Qt.KeyboardModifier = _PLAIN,
) -> QDropEvent:
    """Return an event of a drag."""
    # positions of all kinds are QPointF from Qt 6.12 on
    place = QPointF(9, 9) if kind is QDropEvent or PySide6.__version_info__ >= (6, 12) else QPoint(9, 9)
    return kind(place, actions, data, _LEFT, keys)


def wheel(target: QWidget, at: QPointF, notches: int = 1, modifier: Qt.KeyboardModifier = _PLAIN) -> None:
    """Turn the wheel over a place of a widget."""
    turn, none, phase = QPoint(0, 120 * notches), Qt.MouseButton.NoButton, Qt.ScrollPhase.NoScrollPhase
    event = QWheelEvent(at, target.mapToGlobal(at), QPoint(), turn, none, modifier, phase, False)
    QApplication.sendEvent(target, event)


def plain(text: str) -> str:
    """A text without its mnemonic mark and dots."""
    return text.replace("&", "").rstrip("…").strip()


class Hand:
    """A user who works in one window.

    Parameters
    ----------
    folder : Path
        Where the session's files are.
    autosaves : bool
        Whether the window saves its work by itself and offers to recover what was left.
    """

    def __init__(self, folder: Path, autosaves: bool = False) -> None:
        self.folder = folder
        self.kept: dict[str, object] = {}
        """What the session has got so far: what -> value, see `table.digest`."""
        self._begin(autosaves)

    def _begin(self, autosaves: bool) -> None:
        self.window = MainWindow(persistent=autosaves)
        self.window.resize(1440, 900)
        self.window.show()
        self.window.activateWindow()
        self.settle()

    def restart(self, autosaves: bool = False) -> None:
        """Close the window, and start the next one."""
        self.close()
        self._begin(autosaves)

    # Commands.

    def action(self, name: str) -> QAction:
        """The action of a command."""
        found: QAction | None = self.window.findChild(QAction, name)
        assert found is not None, f"there is no command {name}"
        return found

    def do(self, name: str) -> None:
        """Give a command, and wait until the work that it starts has ended."""
        self.start(name)
        self.settle()

    def start(self, name: str) -> None:
        """Give a command without waiting."""
        action = self.action(name)
        assert action.isEnabled(), f"{name} is off: {action.toolTip()}. The log:\n{self.window.log.text.toPlainText()}"
        action.trigger()

    def tool(self, name: str) -> None:
        """Take a tool."""
        self.do(f"tool_{name}")
        self._view().setFocus()

    def select(self, point: Point) -> None:
        """Select the block at a point."""
        self.tool("select")
        self.click(point)

    def choose(self, *way: str) -> None:
        """Choose an entry of the menu bar by its texts."""
        actions = self.window.menuBar().actions()
        for step in way:
            found = [action for action in actions if plain(action.text()) == step]
            assert found, f"{' > '.join(way)}: there is no {step}"
            menu = found[0].menu()
            if isinstance(menu, QMenu):
                menu.aboutToShow.emit()
                actions = menu.actions()
        assert found[0].isEnabled(), f"{' > '.join(way)} is off"
        found[0].trigger()
        self.settle()

    def drop(self, *paths: Path) -> None:
        """Drop files on the window."""
        data = QMimeData()
        data.setUrls([QUrl.fromLocalFile(str(path)) for path in paths])
        for kind in (QDragEnterEvent, QDropEvent):
            QApplication.sendEvent(self.window, dragged(kind, data))
        self.settle()

    def open(self, path: Path) -> None:
        """Drop something that can be opened on the window, and show its pixels as pixels of the screen."""
        self.drop(path)
        self.do("one_to_one")

    # Mouse and keys in the colour view.

    def _view(self) -> Any:
        return self.window.views.cells["colour"].view

    def _place(self, point: Point) -> QPointF:
        half = 0.5 / self._view().devicePixelRatioF()
        return self._view().transform.map(QPointF(*point)) - QPointF(half, half)

    def _mouse(self, kind: QEvent.Type, point: Point, modifier: str, down: bool) -> None:
        target, at = self._view().viewport(), self._place(point)
        button = Qt.MouseButton.NoButton if kind == QEvent.Type.MouseMove else _LEFT
        buttons = _LEFT if down else Qt.MouseButton.NoButton
        everywhere = QPointF(target.mapToGlobal(at))
        QApplication.sendEvent(target, QMouseEvent(kind, at, everywhere, button, buttons, _MODIFIERS[modifier]))

    def hover(self, point: Point, modifier: str = "") -> None:
        """Move the mouse."""
        self._mouse(QEvent.Type.MouseMove, point, modifier, down=False)
        self.settle()

    def click(self, point: Point, modifier: str = "") -> None:
        """Click in the colour view."""
        self.drag([point], modifier)

    def drag(self, points: Sequence[Point], modifier: str = "", release: bool = True) -> None:
        """Press, move along a line, and let go."""
        self._mouse(QEvent.Type.MouseButtonPress, points[0], modifier, down=True)
        for (x0, y0), (x1, y1) in pairwise(points):
            for step in (0.5, 1):
                self._mouse(QEvent.Type.MouseMove, (x0 + step * (x1 - x0), y0 + step * (y1 - y0)), modifier, down=True)
        if release:
            self._mouse(QEvent.Type.MouseButtonRelease, points[-1], modifier, down=False)
        self.settle()

    def double_click(self, point: Point) -> None:
        """A click, and the second one as a window sends it."""
        self.click(point)
        self._mouse(QEvent.Type.MouseButtonDblClick, point, "", down=True)
        self._mouse(QEvent.Type.MouseButtonRelease, point, "", down=False)
        self.settle()

    def wheel(self, point: Point, notches: int, modifier: str = "") -> None:
        """Turn the wheel."""
        wheel(self._view().viewport(), self._place(point), notches, _MODIFIERS[modifier])
        self.settle()

    def key(self, keys: str) -> None:
        """Press keys, such as "Ctrl+Z", where the focus is."""
        pressed = QKeySequence(keys)[0]
        QTest.keyClick(QApplication.focusWidget() or self._view(), pressed.key(), pressed.keyboardModifiers())
        self.settle()

    # Panels, dialogs and their controls.

    def panel(self, title: str, page: str = "") -> QWidget:
        """Show a panel, at a page if one is given, and return it."""
        dock = next(dock for dock in self.window.findChildren(QDockWidget) if dock.windowTitle() == title)
        if not dock.isVisible():
            dock.toggleViewAction().trigger()
        dock.raise_()
        self.settle()
        if page:
            self.tab(page, dock)
        return dock

    def tab(self, title: str, within: QWidget | None = None) -> None:
        """Turn to a tab."""
        for bar in (within or self.window).findChildren(QTabBar):
            for number in range(bar.count()):
                if plain(bar.tabText(number)) == title:
                    bar.setCurrentIndex(number)
                    self.settle()
                    return
        raise AssertionError(f"there is no tab {title}")

    def dialog(self, title: str, command: str = "") -> QWidget:
        """The dialog whose title begins so: that is open, or that a command opens."""
        if command:
            self.start(command)
        self.settle()
        shown = [widget for widget in QApplication.topLevelWidgets() if widget.isVisible() and widget.isWindow()]
        found = [widget for widget in shown if widget.windowTitle().startswith(title)]
        assert found, f"there is no dialog {title}, but {[widget.windowTitle() for widget in shown]}"
        return found[-1]

    def use_dialog(self, title: str, command: str, values: Mapping[str, object], *buttons: str) -> None:
        """Fill the controls of a dialog that a command opens, and press buttons of it."""
        dialog = self.dialog(title, command)
        for name, value in values.items():
            self.fill(name, value, dialog)
        for button in buttons:
            self.press(button, dialog)

    def control(self, name: str, within: QWidget | None = None, kind: type[Any] = QWidget) -> Any:
        """The control that is called so: by accessible name, text, label, placeholder, or first words of its hint."""
        owner = within or self.window
        found = [widget for widget in owner.findChildren(kind) if name in _names(widget)]
        found.sort(key=lambda widget: (not widget.isVisible(), not widget.isEnabled()))
        assert found, f"there is no control {name} in {owner.windowTitle()}"
        return found[0]

    def press(self, name: str, within: QWidget | None = None) -> None:
        """Press a button, and wait until the work that it starts has ended."""
        button = self.control(name, within, QAbstractButton)
        assert button.isEnabled(), f"the button {name} is off"
        button.click()
        self.settle()

    def fill(self, name: str, value: object, within: QWidget | None = None) -> None:
        """Type, choose or tick a control's value; for a parameter that is not shown, all are for a moment."""
        if not self._has(name, within, QWidget):
            more = [one for one in self.window.findChildren(QAbstractButton) if _MORE.fullmatch(one.text())]
            for button in (*more, *more):
                button.click()
        found = [self.control(name, within, kind) for kind in _FILLED if self._has(name, within, kind)]
        assert found, f"there is no control {name} to fill"
        control = found[0]
        if isinstance(control, QComboBox) and not control.isEditable():
            texts = [plain(control.itemText(number)) for number in range(control.count())]
            fitting = [number for number, text in enumerate(texts) if text.startswith(str(value))]
            assert fitting, f"{name} has no {value}, but {texts}"
            number = fitting[0]
            control.setCurrentIndex(number)
            control.activated.emit(number)
        elif isinstance(control, QAbstractButton):
            if control.isChecked() != value:
                control.click()
        elif isinstance(control, QAbstractSlider):
            control.setValue(int(str(value)))
        else:
            line = control if isinstance(control, QLineEdit) else control.lineEdit()
            line.setFocus()
            line.selectAll()
            QTest.keyClicks(line, str(value))
            if isinstance(control, QAbstractSpinBox):  # Enter would press a dialog's first button, too
                QTest.keyClick(line, Qt.Key.Key_Return if control.window() is self.window else Qt.Key.Key_Tab)
        self.settle()

    def _has(self, name: str, within: QWidget | None, kind: type[Any]) -> bool:
        return any(name in _names(widget) for widget in (within or self.window).findChildren(kind))

    def set_filter(self, preset: str, iterations: int) -> None:
        """Choose a preset and the largest number of iterations."""
        self.tab("Filter", self.panel("Parameters"))
        self.fill("Preset", preset)
        self.fill("Max. iterations", iterations)

    def rows(self, name: str, within: QWidget | None = None) -> list[list[str]]:
        """The texts of a list or table."""
        model = self.control(name, within, QAbstractItemView).model()
        return [
            [str(model.index(row, column).data() or "") for column in range(_columns(model))]
            for row in range(model.rowCount())
        ]

    def click_row(
        self, name: str, row: int, column: str = "", within: QWidget | None = None, twice: bool = False
    ) -> None:
        """Click a row of a list or table, or double-click it; `column` begins its header or the header's hint."""
        view = self.control(name, within, QAbstractItemView)
        model, roles = view.model(), (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.ToolTipRole)
        heads = [
            [str(model.headerData(place, Qt.Orientation.Horizontal, role) or "") for role in roles]
            for place in range(_columns(model))
        ]
        index = model.index(row, next(place for place, head in enumerate(heads) if _begins(head, column)))
        view.scrollTo(index)
        at = view.visualRect(index).center()
        QTest.mouseClick(view.viewport(), _LEFT, _PLAIN, at)
        if twice:
            QTest.mouseDClick(view.viewport(), _LEFT, _PLAIN, at)
        view.setFocus()
        self.settle()

    def answer(self, title: str, text: str) -> None:
        """Type a text into a small dialog that asks for nothing else."""
        dialog = self.dialog(title)
        line: QLineEdit | None = dialog.findChild(QLineEdit)
        assert line is not None, f"{title} asks for no text"
        line.setText(text)
        self.press("OK", dialog)

    def write(self, text: str) -> None:
        """Type a text and Enter where the focus is, for example in a cell of a table."""
        field = QApplication.focusWidget()
        assert isinstance(field, QLineEdit), f"the focus is in {field}"
        field.selectAll()
        QTest.keyClicks(field, text)
        QTest.keyClick(field, Qt.Key.Key_Return)
        self.settle()

    @contextmanager
    def answering(self, *answers: object) -> Iterator[None]:
        """Answer the system's dialogs for files, texts and colours in this order."""
        _ANSWERS.extend(str(answer) if isinstance(answer, Path) else answer for answer in answers)
        yield
        assert not _ANSWERS, f"nobody asked for {list(_ANSWERS)}"

    def dismiss_messages(self) -> None:
        """Remove the messages that disappear by themselves."""
        self.window.notes.clear()

    # Waiting.

    def settle(self, patience_ms: int = _PATIENCE_MS) -> None:
        """Wait until no thread of the program works, and no timer is about to start more."""
        self.wait(lambda: not self._works(patience_ms), turns=3)

    def wait(self, condition: Callable[[], bool], turns: int = 1) -> None:
        """Handle events until a condition holds in that many turns of the event loop one after the other."""
        begun, held = time.monotonic(), 0
        while held < turns:
            QApplication.processEvents()
            QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
            held = held + 1 if condition() else 0
            if not held:
                time.sleep(0.002)
            assert time.monotonic() - begun < _LONGEST_S, "the window is still at work"

    def _works(self, patience_ms: int) -> bool:
        timers = self.window.findChildren(QTimer)
        waits = any(timer.isActive() and timer.isSingleShot() and timer.interval() <= patience_ms for timer in timers)
        return waits or any(thread.name.startswith("ilf-") for thread in threading.enumerate())

    # What a user gets.

    def keep(self, what: str, value: object) -> None:
        """Keep a value, or the files of a folder, for the table."""
        if isinstance(value, Path) and value.is_dir():
            for path in sorted(path for path in value.rglob("*") if path.is_file()):
                self.kept[f"{what}/{path.relative_to(value)}"] = path
        else:
            self.kept[what] = value

    def keep_undo(self, what: str = "undo") -> None:
        """Keep the undo texts of the frame, and the title of the window."""
        within = self.panel("History")
        self.kept[what] = self.rows("History", within)
        self.kept[f"{what}, next"] = [self.action(name).text() for name in ("undo", "redo")]
        self.kept[f"{what}, title"] = self.title()

    def title(self) -> str:
        """The title of the window, without the folder of the session."""
        return self.window.windowTitle().replace(str(self.folder), "~")

    def copied(self) -> str:
        """What was copied to the clipboard."""
        return QApplication.clipboard().text()

    def save(self, name: str = "work", embed: bool = False) -> Path:
        """Save the project to another file, with the frames' files if wished."""
        path = self.folder / f"{name}.ilf"
        _ANSWERS.append(str(path))
        self.start("save_project_as")
        self.press("Include them" if embed else "Leave them out", self.dialog("Include the frames' files"))
        return path

    def keep_project(self, what: str = "end") -> None:
        """Save the project, and keep what the library reads of it."""
        for part, value in project_content(self.save(what)).items():
            self.kept[f"{what}: {part}"] = value

    def close(self) -> None:
        """Close the window. Work that is left is discarded."""
        self.window.close()
        QApplication.processEvents()
        for widget in QApplication.topLevelWidgets():
            if widget.isVisible() and widget.windowTitle() in _LEAVING:
                self.press(_LEAVING[widget.windowTitle()], widget)
        self.wait(lambda: not self.window.isVisible())
        self.window.deleteLater()
        QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def _columns(model: Any) -> int:
    """The columns of a model; those of a list are not public."""
    return 1 if isinstance(model, QAbstractListModel) else int(model.columnCount())


def _begins(texts: Sequence[str], start: str) -> bool:
    return any(text.startswith(start) for text in texts)


_MORE = re.compile(r"All \d+ parameters")
"""The button that shows the other parameters of a form."""

_FILLED = (QAbstractSpinBox, QComboBox, QLineEdit, QAbstractButton, QAbstractSlider)


def _names(widget: QWidget) -> set[str]:
    """What a control may be called."""
    names = {widget.accessibleName(), widget.toolTip().split("\n")[0]}
    if isinstance(widget, QAbstractButton):
        names.add(widget.text())
    if isinstance(widget, QLineEdit):
        names.add(widget.placeholderText())
    parent = widget.parentWidget()
    labels = parent.findChildren(QLabel) if parent is not None else []
    names |= {label.text() for label in labels if label.buddy() is widget}
    return {plain(name) for name in names if name}


# What the library reads of a project file.


def project_content(path: Path) -> dict[str, object]:
    """Everything that a project file says, by number and name of the frame; what is empty is left out."""
    found: dict[str, object] = {}
    with ilf.open_project(path) as opened:
        project = opened.project
        found["frames"] = [[frame.name, str(frame.summary.stage)] for frame in project.frames]
        found["present"] = next((frame.name for frame in project.frames if frame.id == project.present), "")
        found["settings"] = [project.for_all, project.extraction.to_dict(), project.keeps_handmade]
        found["parameters"] = project.common.to_dict()
        found["problems"] = list(opened.problems)
        for number, frame in enumerate(project.frames, 1):
            for part, value in frame_content(opened.state(frame.id).state).items():
                found[f"{number} {frame.name}, {part}"] = value
    return found


def frame_content(state: Any) -> dict[str, object]:
    """Everything that the state of a frame says, by name; what is empty or as at first is left out."""
    frame, notes, looked = state.frame, state.blocks, state.looked
    content = {
        "labels": notes.labels,
        "extracted": notes.extracted,
        "blocks": {
            label: [info.name, list(info.colour), info.visible, info.locked]
            for label, info in sorted(notes.infos.items())
            if info != BlockInfo(f"Block {label}", block_colour(label))
        },
        "own parameters": {label: dict(own) for label, own in notes.own.items() if own},
        "drawn borders": notes.drawn,
        "extraction": None if notes.extraction is None else notes.extraction.to_dict(),
        "handmade": [sorted(notes.kept), sorted(notes.handmade)] if notes.kept or notes.handmade else None,
        "propagated": [notes.propagated_from, notes.reasons] if notes.propagated_from else None,
        "known depth": frame.depth,
        "invalid depth": frame.invalid_mask,
        "ground truth": frame.ground_truth,
        "guide": None if frame.guide is None else frame.guide.values,
        "neighbours": frame.from_neighbours,
        "depth by hand": None if notes.by_hand is None else notes.by_hand.depth,
        "parameters": [state.common.to_dict(), state.extrapolate, state.own_parameters],
        "results": _results(state.results),
        "runs": [_run(run) for run in state.runs],
        "next number": state.next_number,
        "compared": list(state.compared),
        "line": looked.line,
        "rectangle": None if looked.region is None else str(looked.region),
        "measured": [list(map(list, line)) for line in looked.measurements] or None,
        "note": [state.note, state.done] if state.note or state.done else None,
        "to check": sorted(state.to_check),
        "ignored": [repr(place) for place in state.ignored],
        "selected": list(state.selected),
    }
    return {part: value for part, value in content.items() if not _is_empty(value)}


def _results(results: Mapping[int, Any]) -> dict[int, object]:
    return {
        int(label): [result.outcome.iterations, str(result.outcome.status), result.depth]
        for label, result in sorted(results.items())
    }


def _run(run: Any) -> list[object]:
    return [run.number, run.name, run.note, run.how, sorted(run.done), run.run.blocks.labels, run.completion.depth]


def _is_empty(value: object) -> bool:
    if isinstance(value, np.ndarray):
        return value.dtype == bool and not value.any()
    return value is None or (isinstance(value, list | dict) and not value)


# All that a window has, to check that sessions leave nothing out.

DIALOGS = {
    "AboutDialog": "About ILF Studio",
    "CloseDialog": "Save the work?",
    "GroundTruthDialog": "Load ground truth for room",
    "GuideNetworksDialog": "Guide by network",
    "HoldOutDialog": "Hold-out test of room",
    "LoadBlocksDialog": "Load blocks for room",
    "OpenDialog": "Open",
    "ProblemBox": "Open",
    "PropagateDialog": "Propagate blocks of",
    "SavePresetDialog": "Save preset",
    "ShortcutsDialog": "Keyboard shortcuts",
}
"""Class of each dialog that has one -> how its title begins in the sessions."""

_NO_DIALOGS = {"PreviewDialog"}
"""A base class."""


def commands(window: MainWindow) -> list[str]:
    """The names of all commands, tools among them."""
    return list(window.actions_.commands)


def panels(window: MainWindow) -> list[str]:
    """The titles of all panels."""
    return [dock.windowTitle() for dock in window.findChildren(QDockWidget)]


def dialog_classes() -> set[str]:
    """The names of all classes of dialogs."""
    for module in pkgutil.walk_packages(gui.__path__, "gui."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    found, waiting = set(), [QDialog]
    while waiting:
        classes = waiting.pop().__subclasses__()
        waiting += classes
        found |= {one.__name__ for one in classes if one.__module__.startswith("gui.")}
    return found - _NO_DIALOGS
