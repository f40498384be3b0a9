"""One line under the views that says what the last edit has done, until the next."""

from __future__ import annotations

import html
from typing import NamedTuple

from PySide6.QtCore import QEvent, Qt
from PySide6.QtGui import QResizeEvent, QTextDocument
from PySide6.QtWidgets import QHBoxLayout, QLabel, QWidget

from gui import theme
from ilf.number_words import grouped, millimetres
from ilf.run import Effect

_EQUAL = 0.05
"""Errors that differ by a smaller share are as good as equal."""

_MARGIN = 8


class _Words(NamedTuple):
    moved: str
    filled: str
    by_truth: str
    expected: str
    held_out: str


_LONG = _Words("{} px moved", "filled {}", "RMSE against the truth {}", "expected error, RMS {}", "on hidden depth {}")
_SHORT = _Words("{} px", "filled {}", "truth {}", "expected RMS {}", "hidden {}")


class EffectLine(QWidget):
    """What the last edit was, and whether it was for the better.

    It has its place before there is an edit: the pictures would move under the pointer otherwise.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.label = QLabel()
        self.label.setTextFormat(Qt.TextFormat.RichText)
        self.label.setMinimumWidth(1)
        self.label.setToolTip(
            "What the last edit has done. Against the truth, where the frame has one: root mean square error of what "
            "the touched blocks fill, before and after. On hidden depth: the known depth near the border is hidden, "
            "and the blocks there are completed without it: mean absolute error, a hint, right in about two of three "
            "cases. "
            "Hold B to look at the state before the edit."
        )
        layout = QHBoxLayout(self)
        layout.setContentsMargins(_MARGIN, 2, _MARGIN, 2)
        layout.addWidget(self.label, 1)
        self._said: tuple[str, Effect | None, str] | None = None
        self._looks = False
        self._write()

    def say(self, text: str, effect: Effect | None = None, note: str = "") -> None:
        """Show what an edit is called, what it has done as far as that is known, and a note."""
        self._said = text, effect, note
        self._write()

    def mark_look(self, on: bool) -> None:
        """Say that the state before the edit is what is to be seen, or no longer."""
        self._looks = on
        self._write()

    def clear(self) -> None:
        """There has been no edit."""
        self._said = None
        self._write()

    def changeEvent(self, event: QEvent) -> None:
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange:
            self._write()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._write()

    def _write(self) -> None:
        if self._said is None:
            tone = theme.colours(self.palette()).muted.name()
            self.label.setText(f'<span style="color:{tone}">What an edit does to the depth is said here.</span>')
            return
        text, effect, note = self._said
        if self._looks:
            tone = theme.colours(self.palette()).accent.name()
            self.label.setText(f'<span style="color:{tone}"><b>The state before: {html.escape(text)}</b></span>')
            return
        words = self._words(_LONG, text, effect, note)
        if effect is not None and _width(words, self.label) > self.contentsRect().width() - 2 * _MARGIN:
            words = self._words(_SHORT, text, effect, note)
        self.label.setText(words)

    def _words(self, names: _Words, text: str, effect: Effect | None, note: str) -> str:
        parts = [f"<b>{html.escape(text)}</b>"]
        if effect is not None:
            parts.append(names.moved.format(grouped(effect.moved)))
            if effect.filled is not None and effect.filled[0] != effect.filled[1]:
                before, after = effect.filled
                parts.append(names.filled.format(self._tinted(grouped(before), f"{grouped(after)} px", after > before)))
            for name in ("by_truth", "expected", "held_out"):
                if (error := getattr(effect, name)) is not None:
                    parts.append(getattr(names, name).format(self._change(*error)))
        if note:
            parts.append(html.escape(note))
        return " &nbsp;·&nbsp; ".join(parts)

    def _change(self, before: float, after: float) -> str:
        """Two errors [m] as text, in the colour of better or worse."""
        differ = abs(after - before) > _EQUAL * max(before, after)
        better = after < before if differ else None
        return self._tinted(millimetres(before), f"{millimetres(after)} mm", better)

    def _tinted(self, before: str, after: str, better: bool | None) -> str:
        """Two values; None where neither is the better one."""
        colours = theme.colours(self.palette())
        tone = {True: colours.good, False: colours.error, None: colours.text}[better]
        return f'{before} → <span style="color:{tone.name()}"><b>{after}</b></span>'


def _width(text: str, label: QLabel) -> float:
    """How wide rich text is in a label's font [px]."""
    document = QTextDocument()
    document.setDocumentMargin(0)
    document.setDefaultFont(label.font())
    document.setHtml(text)
    return document.idealWidth()
