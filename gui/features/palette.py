"""Command palette: type some letters of a command, and press Enter."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape
from itertools import groupby
from typing import NamedTuple

from PySide6.QtCore import (
    QEvent,
    QModelIndex,
    QObject,
    QPersistentModelIndex,
    QPoint,
    QRect,
    QSettings,
    QSize,
    Qt,
    QTimer,
)
from PySide6.QtGui import QFocusEvent, QIcon, QKeyEvent, QPainter, QPalette, QStaticText, QTextOption
from PySide6.QtWidgets import (
    QApplication,
    QFrame,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QMainWindow,
    QStyle,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QVBoxLayout,
    QWidget,
)

from ..base import theme
from ..base.commands import ActionEntry, action_entries
from ..widgets.basics import PlainLabel, lay_out
from .context import Context, Feature

# Letters that are found in a text.

_WORD_START, _RUN, _LETTER = 12.0, 6.0, 1.0
_GAP = 0.4
_WHOLE = 20.0
"""Bonus if the text contains the whole query."""


class Match(NamedTuple):
    """Score of a match, higher is better, and the positions of the matched letters."""

    score: float
    letters: tuple[int, ...]


def match(query: str, text: str) -> Match | None:
    """Match the letters of a query in a text, in order, separately for each word of the query.

    Word starts and consecutive letters score higher, and so do shorter texts.

    Returns
    -------
    Match or None
        None if not all letters are found.
    """
    low = text.lower()
    score, letters = 0.0, set[int]()
    for word in query.lower().split():
        found = _best(word, low)
        if found is None:
            return None
        score += found.score
        letters.update(found.letters)
    if query.strip() and query.lower().strip() in low:
        score += _WHOLE
    return Match(score - 0.05 * len(text), tuple(sorted(letters)))


def _best(word: str, text: str) -> Match | None:
    """Return the best match of a word's letters in a text, by dynamic programming over the letters."""
    starts = {found.start() for found in re.finditer(r"\b\w", text)}
    # best[place]: best match of the word so far with its last letter at that place
    best: dict[int, tuple[float, tuple[int, ...]]] = {}
    for number, letter in enumerate(word):
        there = [place for place, other in enumerate(text) if other == letter]
        following: dict[int, tuple[float, tuple[int, ...]]] = {}
        for place in there:
            own = _LETTER + (_WORD_START if place in starts else 0.0)
            if number == 0:
                following[place] = own, (place,)
                continue
            before = [
                (score + own + (_RUN if last == place - 1 else -_GAP * (place - last)), (*path, place))
                for last, (score, path) in best.items()
                if last < place
            ]
            if before:
                following[place] = max(before)
        best = following
    return Match(*max(best.values())) if best else None


# Recently used commands.

_RECENT_KEY = "palette/recent"
_MOST = 30


class RecentCommands:
    """Keys of recently used commands, the latest first.

    Parameters
    ----------
    persistent : bool
        Whether they are stored between program starts.
    """

    def __init__(self, persistent: bool) -> None:
        self._persistent = persistent
        kept = QSettings().value(_RECENT_KEY) if persistent else None
        self._keys = [kept] if isinstance(kept, str) else [str(key) for key in kept or []]

    def note(self, key: str) -> None:
        """Add a command as the latest."""
        self._keys = [key, *(other for other in self._keys if other != key)][:_MOST]
        if self._persistent:
            QSettings().setValue(_RECENT_KEY, self._keys)

    def rank(self, key: str) -> float:
        """Return the rank of a command: 0 for the latest; infinite if it is not among them."""
        return self._keys.index(key) if key in self._keys else math.inf


# Commands that match a query, in order.

_IN_HINT = -30.0
"""Penalty for a match in the tooltip only."""
_SCATTERED = -100.0
"""Penalty for letters of a word that stand apart, partly in the menu: any other match comes first."""
_RECENT = 10.0
"""Bonus for the latest command, less for earlier ones."""
_DISABLED = -8.0
"""Penalty for a disabled command."""


@dataclass(frozen=True, eq=False)
class Offer:
    """A command, and the positions of the matched letters in its text."""

    entry: ActionEntry
    letters: tuple[int, ...]


def offers(entries: Iterable[ActionEntry], query: str, recent: RecentCommands) -> list[Offer]:
    """Return the matching commands, best first; all commands for an empty query, recently used ones first."""
    if not query.strip():
        return [Offer(entry, ()) for entry in sorted(entries, key=lambda entry: recent.rank(entry.key))]
    fitting = []
    for entry in entries:
        found = _score(entry, query)
        if found is not None:
            score, letters = found
            score += _RECENT / (1 + recent.rank(entry.key)) + (_DISABLED if entry.why_not else 0.0)
            fitting.append((score, Offer(entry, letters)))
    return [offer for _, offer in sorted(fitting, key=lambda fit: -fit[0])]


def _score(entry: ActionEntry, query: str) -> tuple[float, tuple[int, ...]] | None:
    """Return the score by the text, by text and menu, or, for whole words only, by the tooltip."""
    found = match(query, entry.text)
    if found is not None:
        return found
    place, words = f"{entry.text} {entry.where}", query.lower().split()
    found = match(query, place)
    if found is not None:
        penalty = _IN_HINT / 2 if all(word in place.lower() for word in words) else _SCATTERED
        return found.score + penalty, tuple(letter for letter in found.letters if letter < len(entry.text))
    hint = entry.hint.lower()
    return (_IN_HINT - 0.05 * len(hint), ()) if all(word in hint for word in words) else None


# Painting of a row: icon, name with the matched letters in bold, menu or reason, keys.

OFFER_ROLE = int(Qt.ItemDataRole.UserRole)
_ICON, _MARGIN, _SPACE = 16, 8, 12


class OfferDelegate(QStyledItemDelegate):
    """Paints the rows; disabled commands are grey and show the reason instead of their menu."""

    def sizeHint(self, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex) -> QSize:
        return QSize(200, option.fontMetrics.height() + 12)

    def paint(
        self, painter: QPainter, option: QStyleOptionViewItem, index: QModelIndex | QPersistentModelIndex
    ) -> None:
        offer: Offer = index.data(OFFER_ROLE)
        entry, colours, metrics = offer.entry, theme.colours(option.palette), option.fontMetrics
        one_line = QTextOption()
        one_line.setWrapMode(QTextOption.WrapMode.NoWrap)
        painter.save()
        if option.state & QStyle.StateFlag.State_Selected:
            painter.fillRect(option.rect, theme.faded(option.palette.color(QPalette.ColorRole.Highlight), 60))
        row = option.rect.adjusted(_MARGIN, 0, -_MARGIN, 0)
        icon = QRect(row.left(), row.center().y() - _ICON // 2, _ICON, _ICON)
        entry.icon.paint(painter, icon, mode=QIcon.Mode.Disabled if entry.why_not else QIcon.Mode.Normal)
        row.setLeft(icon.right() + _MARGIN)
        keys = f"{entry.keys} ✓" if entry.is_on else entry.keys
        painter.setFont(option.font)
        painter.setPen(colours.muted)
        painter.drawText(row, Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter, keys)
        row.setRight(row.right() - metrics.horizontalAdvance(keys) - _SPACE)
        name = QStaticText("".join(f"<b>{part}</b>" if meant else part for part, meant in _parts(offer)))
        name.setTextFormat(Qt.TextFormat.RichText)
        name.setTextOption(one_line)
        name.prepare(font=option.font)
        painter.setPen(colours.muted if entry.why_not else colours.text)
        painter.drawStaticText(row.left(), row.center().y() - round(name.size().height() / 2), name)
        row.setLeft(row.left() + round(name.size().width()) + _SPACE)
        painter.setPen(colours.muted)
        about = metrics.elidedText(entry.why_not or entry.where, Qt.TextElideMode.ElideRight, row.width())
        painter.drawText(row, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, about)
        painter.restore()


def _parts(offer: Offer) -> Iterator[tuple[str, bool]]:
    """Divide a command's name into HTML parts that match and that do not."""
    meant = set(offer.letters)
    for matches, letters in groupby(enumerate(offer.entry.text), lambda letter: letter[0] in meant):
        yield escape("".join(letter for _, letter in letters)), matches


_WIDTH, _ROWS = 560, 11
_TOP = 48
_STYLE = "#palette { background: palette(window); border: 1px solid palette(highlight); border-radius: 6px; }"
_MOVES = frozenset({Qt.Key.Key_Up, Qt.Key.Key_Down, Qt.Key.Key_PageUp, Qt.Key.Key_PageDown})
_TAKEN = _MOVES | {Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Escape}


class CommandPalette(QFrame):
    """Field and list at the top of the window; it closes after a command or by Escape.

    Parameters
    ----------
    window : QMainWindow
        The window with the actions.
    persistent : bool
        Whether recently used commands are stored between program starts.
    """

    def __init__(self, window: QMainWindow, persistent: bool) -> None:
        super().__init__(window)
        self.setObjectName("palette")
        self.setAccessibleName("Command palette")
        self.hide()
        self._window = window
        self._recent = RecentCommands(persistent)
        self._entries: list[ActionEntry] = []
        self._before: QWidget | None = None
        self.field = QLineEdit(placeholderText="Type a command", clearButtonEnabled=True)
        self.field.installEventFilter(self)
        self.field.setAccessibleName("Command")
        self.field.setToolTip("Letters of a command; Up and Down select, Enter runs it")
        self.field.textChanged.connect(self._offer)
        self.list = QListWidget()
        self.list.setItemDelegate(OfferDelegate(self.list))
        self.list.setUniformItemSizes(True)
        self.list.setFrameShape(QListWidget.Shape.NoFrame)
        self.list.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.list.setAccessibleName("Commands")
        self.list.itemClicked.connect(lambda _: self._run_command())
        self.list.currentItemChanged.connect(lambda *_: self._explain())
        self.hint = PlainLabel()
        self.hint.setWordWrap(True)
        self.hint.setMargin(4)
        lay_out(QVBoxLayout(self), self.field, self.list, self.hint, margins=(8, 8, 8, 4), spacing=4)
        self.setStyleSheet(_STYLE)

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
        self.show()
        self.raise_()
        self.field.setFocus(Qt.FocusReason.PopupFocusReason)

    def leave(self) -> None:
        """Close the palette, and restore the focus."""
        if not self.isVisible():
            return
        before, self._before = self._before, None
        had_focus = self.isAncestorOf(QApplication.focusWidget() or self._window)
        self.hide()
        if had_focus:
            (before if before is not None and before.isVisible() else self._window).setFocus()

    def offered(self) -> list[Offer]:
        """Return the listed commands."""
        return [self.list.item(row).data(OFFER_ROLE) for row in range(self.list.count())]

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Take the keys of the list from the field, before shortcuts of the window; close when the focus leaves it."""
        if isinstance(event, QKeyEvent) and event.key() in _TAKEN:
            event.accept()
            if event.type() == QEvent.Type.KeyPress:
                self._take_key(Qt.Key(event.key()))
            return True
        by_window = Qt.FocusReason.ActiveWindowFocusReason
        if isinstance(event, QFocusEvent) and event.lostFocus() and event.reason() != by_window:
            self.leave()
        return False

    def _take_key(self, key: Qt.Key) -> None:
        if key == Qt.Key.Key_Escape:
            self.leave()
        elif key in _MOVES:
            self._move(key)
        else:
            self._run_command()

    def _offer(self) -> None:
        self.list.clear()
        for offer in offers(self._entries, self.field.text(), self._recent):
            item = QListWidgetItem(offer.entry.text, self.list)
            item.setData(OFFER_ROLE, offer)
            item.setData(Qt.ItemDataRole.AccessibleDescriptionRole, offer.entry.why_not or offer.entry.keys)
        self.list.setCurrentRow(0)
        self._explain()

    def _move(self, key: Qt.Key) -> None:
        count, row = self.list.count(), self.list.currentRow()
        if not count:
            return
        step = {Qt.Key.Key_Up: -1, Qt.Key.Key_Down: 1, Qt.Key.Key_PageUp: -_ROWS, Qt.Key.Key_PageDown: _ROWS}[key]
        row = (row + step) % count if abs(step) == 1 else min(max(row + step, 0), count - 1)
        self.list.setCurrentRow(row)

    def _explain(self) -> None:
        item = self.list.currentItem()
        if item is None:
            self.hint.setText("No command matches.")
            return
        entry = item.data(OFFER_ROLE).entry
        self.hint.setText(" ".join(filter(None, (entry.why_not, entry.hint))))

    def _run_command(self) -> None:
        item = self.list.currentItem()
        if item is None:
            return
        key = item.data(OFFER_ROLE).entry.key
        entry = next((entry for entry in action_entries(self._window) if entry.key == key), None)
        if entry is None or entry.why_not:
            return
        self._recent.note(key)
        self.leave()
        QTimer.singleShot(0, entry.action, entry.action.trigger)  # after the key event

    def _place(self) -> None:
        width = min(_WIDTH, self._window.width() - 40)
        row = self.list.sizeHintForRow(0) if self.list.count() else 28
        self.list.setFixedHeight(min(_ROWS * row, self._window.height() - 2 * _TOP - 100))
        self.hint.setFixedHeight(2 * self.fontMetrics().lineSpacing() + 2 * self.hint.margin())
        self.setFixedWidth(width)
        self.adjustSize()
        self.move(QPoint((self._window.width() - width) // 2, _TOP))


# The feature of the window.


class PaletteFeature(Feature):
    """Opens the palette on request."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.palette = CommandPalette(context.window, context.panels.persistent)
