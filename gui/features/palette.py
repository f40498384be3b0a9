"""Command palette: type some letters of a command, and press Enter."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence

from PySide6.QtCore import QEvent, QObject, QPoint, QSettings, Qt, QTimer
from PySide6.QtGui import QBrush, QFocusEvent, QKeyEvent
from PySide6.QtWidgets import (
    QApplication,
    QFrame,
    QLineEdit,
    QMainWindow,
    QTreeWidget,
    QTreeWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ..base import theme
from ..base.commands import ActionEntry, action_entries
from ..widgets.basics import PlainLabel, lay_out, row_list

_WAYS = -200.0, 20.0, 30.0, 40.0
"""What a word counts by the way in which it fits, from letters in order, which comes after words of menu and hint."""
_LENGTH = 0.05
"""What a letter of the text counts less."""
_IN_MENU, _IN_HINT = -20.0, -40.0
_RECENT = 10.0
"""Bonus for the latest command, less for earlier ones."""
_BEGINNING = 1.0
"""Bonus for a text that begins with the whole query."""
_DISABLED = -8.0
"""Penalty for a disabled command."""


def match(query: str, text: str) -> float | None:
    """Return how well a text fits a query, higher is better; None if it does not.

    Each word of the query must begin a word of the text, or stand in it, or be initials in it, or have its letters in
    it, in order; the first of these counts most, and shorter texts more, and those that begin with the whole query.
    """
    score = -_LENGTH * len(text)
    for word in query.lower().split():
        letters = [re.escape(letter) for letter in word]
        whole = "".join(letters)
        ways = ".*".join(letters), ".*".join(rf"\b{letter}" for letter in letters), whole, rf"\b{whole}"
        fitting = [count for count, way in zip(_WAYS, ways, strict=True) if re.search(way, text.lower())]
        if not fitting:
            return None
        score += fitting[-1]
    return score + (_BEGINNING if text.lower().startswith(query.lower().strip()) else 0.0)


def offers(entries: Iterable[ActionEntry], query: str, recent: Sequence[str]) -> list[ActionEntry]:
    """Return the matching commands, best first; all for an empty query. Of commands that match as well, the last used
    ones come first; `recent` has their keys, the latest first."""
    ranks = {key: rank for rank, key in enumerate(recent)}
    if not query.strip():
        return sorted(entries, key=lambda entry: ranks.get(entry.key, len(ranks)))
    fitting = []
    for entry in entries:
        score = _score(entry, query)
        if score is not None:
            score += _RECENT / (1 + ranks[entry.key]) if entry.key in ranks else 0.0
            fitting.append((score + (_DISABLED if entry.why_not else 0.0), entry))
    return [entry for _, entry in sorted(fitting, key=lambda fit: -fit[0])]


def _score(entry: ActionEntry, query: str) -> float | None:
    """Return the best score by the text, or, for whole words, by text, menu and keys, or by the hint; None if none
    fits."""
    scores = [match(query, entry.text)]
    for penalty, text in ((_IN_MENU, f"{entry.text} {entry.where} {entry.keys}"), (_IN_HINT, entry.hint)):
        if all(word in text.lower() for word in query.lower().split()):
            scores.append(penalty - _LENGTH * len(text))
    return max((score for score in scores if score is not None), default=None)


_ENTRY = Qt.ItemDataRole.UserRole


def command_list() -> QTreeWidget:
    """Make a list of commands with their menus and keys."""
    return row_list("Commands and their keys", "", ("Command", "Menu", "Keys"), stretched=1)


def list_commands(
    rows: QTreeWidget, entries: Iterable[ActionEntry], query: str, recent: Sequence[str] = ()
) -> Iterator[tuple[QTreeWidgetItem, ActionEntry]]:
    """List the commands that match, as `offers`, the first of which becomes the current one; yield their rows."""
    rows.clear()
    for number, entry in enumerate(offers(entries, query, recent)):
        item = QTreeWidgetItem(rows, [entry.text, entry.where, entry.keys])
        item.setData(0, _ENTRY, entry)
        if number == 0:
            rows.setCurrentItem(item)
        yield item, entry


def listed(rows: QTreeWidget) -> list[ActionEntry]:
    """The listed commands."""
    return [item.data(0, _ENTRY) for item in map(rows.topLevelItem, range(rows.topLevelItemCount())) if item]


def current_entry(rows: QTreeWidget) -> ActionEntry | None:
    """The command of the current row."""
    item = rows.currentItem()
    return None if item is None else item.data(0, _ENTRY)


_RECENT_KEY = "palette/recent"
_MOST_RECENT = 30
_WIDTH, _ROWS = 560, 11
_TOP = 48
_STYLE = "#palette { background: palette(window); border: 1px solid palette(highlight); border-radius: 6px; }"
_MOVES = frozenset({Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown})
_ENTER = frozenset({Qt.Key.Key_Return, Qt.Key.Key_Enter})


class CommandPalette(QFrame):
    """Field and list at the top of the window; it closes after a command or by Escape. Commands that cannot be used are
    grey, with the reason instead of their menu.

    Parameters
    ----------
    window : QMainWindow
        The window with the actions.
    """

    def __init__(self, window: QMainWindow) -> None:
        super().__init__(window)
        self.setObjectName("palette")
        self.setAccessibleName("Command palette")
        self.hide()
        self._window = window
        kept = QSettings().value(_RECENT_KEY)
        self._recent = [kept] if isinstance(kept, str) else [str(key) for key in kept or []]
        """Keys of recently used commands, the latest first."""
        self._entries: list[ActionEntry] = []
        self._before: QWidget | None = None
        self.field = QLineEdit(placeholderText="Type a command", clearButtonEnabled=True)
        self.field.setAccessibleName("Command")
        self.field.setToolTip("Letters of a command; Up and Down select, Enter runs it")
        self.field.textChanged.connect(self._offer)
        self.list = command_list()
        self.list.setHeaderHidden(True)
        self.list.setFrameShape(QFrame.Shape.NoFrame)
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.itemClicked.connect(lambda _: self._run_command())
        self.list.currentItemChanged.connect(lambda *_: self._explain())
        self.hint = PlainLabel()
        self.hint.setWordWrap(True)
        self.hint.setMargin(4)
        lay_out(QVBoxLayout(self), self.field, self.list, self.hint, margins=(8, 8, 8, 4), spacing=4)

    def toggle(self) -> None:
        """Open or close the palette."""
        if self.isVisible():
            self.leave()
            return
        self._before = QApplication.focusWidget()
        self._entries = action_entries(self._window)
        self.field.clear()
        self._offer()
        self._place()
        self.setStyleSheet(_STYLE)  # with the colours of a theme that was chosen meanwhile
        self.show()
        self.raise_()
        self._listen(True)
        self.field.setFocus(Qt.FocusReason.PopupFocusReason)

    def leave(self) -> None:
        """Close the palette, and restore the focus."""
        if not self.isVisible():
            return
        self._listen(False)
        before, self._before = self._before, None
        had_focus = self.isAncestorOf(QApplication.focusWidget() or self._window)
        self.hide()
        if had_focus:
            (before if before is not None and before.isVisible() else self._window).setFocus()

    def _listen(self, on: bool) -> None:
        """Look at all events of the program, or no longer."""
        program = QApplication.instance()
        assert program is not None
        (program.installEventFilter if on else program.removeEventFilter)(self)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take the keys of the list from the field, before shortcuts of the window; close when the focus leaves it, and
        by a click on anything else, which may take no focus, as buttons of a tool bar."""
        if watched is not self.field:
            is_beside = isinstance(watched, QWidget) and watched is not self and not self.isAncestorOf(watched)
            if event.type() == QEvent.Type.MouseButtonPress and is_beside:
                self.leave()
            return False
        if isinstance(event, QKeyEvent) and event.key() in (_MOVES | _ENTER | {Qt.Key.Key_Escape}):
            event.accept()
            if event.type() == QEvent.Type.KeyPress:
                self._take_key(event)
            return True
        by_window = Qt.FocusReason.ActiveWindowFocusReason
        if isinstance(event, QFocusEvent) and event.lostFocus() and event.reason() != by_window:
            self.leave()
        return False

    def _take_key(self, event: QKeyEvent) -> None:
        if event.key() in _MOVES:
            QApplication.sendEvent(self.list, event)
        elif event.key() in _ENTER:
            self._run_command()
        else:
            self.leave()

    def _offer(self) -> None:
        muted = QBrush(theme.colours(self.palette()).muted)
        for item, entry in list_commands(self.list, self._entries, self.field.text(), self._recent):
            item.setText(1, entry.why_not or entry.where)
            item.setText(2, f"{entry.keys} ✓" if entry.is_on else entry.keys)
            item.setIcon(0, entry.icon)
            for column in range(0 if entry.why_not else 1, 3):
                item.setForeground(column, muted)
        self._explain()

    def _explain(self) -> None:
        entry = current_entry(self.list)
        text = "No command matches." if entry is None else " ".join(filter(None, (entry.why_not, entry.hint)))
        self.hint.setText(text)

    def _run_command(self) -> None:
        chosen = current_entry(self.list)
        key = "" if chosen is None else chosen.key
        entry = next((entry for entry in action_entries(self._window) if entry.key == key), None)
        if entry is None or entry.why_not:
            return
        self._recent = [key, *(other for other in self._recent if other != key)][:_MOST_RECENT]
        QSettings().setValue(_RECENT_KEY, self._recent)
        self.leave()
        QTimer.singleShot(0, entry.action, entry.action.trigger)  # after the key event

    def _place(self) -> None:
        width = min(_WIDTH, self._window.width() - 40)
        row = self.list.sizeHintForRow(0) if self._entries else 28
        self.list.setFixedHeight(min(_ROWS * row, self._window.height() - 2 * _TOP - 100))
        self.hint.setFixedHeight(2 * self.fontMetrics().lineSpacing() + 2 * self.hint.margin())
        self.setFixedWidth(width)
        self.adjustSize()
        self.move(QPoint((self._window.width() - width) // 2, _TOP))
