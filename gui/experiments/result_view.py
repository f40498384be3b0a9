"""What an experiment gave: its figures, the paper beside it, its rows."""

from __future__ import annotations

import html
from pathlib import Path

from PySide6.QtCore import QEvent, Qt, Signal
from PySide6.QtWidgets import QFrame, QHBoxLayout, QTabWidget, QTextBrowser, QToolButton, QVBoxLayout, QWidget

from gui import theme
from gui.experiments.figure_view import FigureView
from gui.experiments.rows import RowTable
from gui.widgets.messages import Message
from gui.widgets.plain_text import PlainLabel
from ilf.experiments import EXPERIMENTS, Experiment
from ilf.experiments.files import StoredResult
from ilf.experiments.report import inline, paragraphs


class ResultView(QWidget):
    """One experiment: what it is, and its result in tabs where there is one.

    Signals
    -------
    save_wished(object)
        The Path of the PNG file of the figure that is seen.
    """

    save_wished = Signal(object)

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._title = PlainLabel()
        font = self._title.font()
        font.setBold(True)
        font.setPointSizeF(1.2 * font.pointSizeF())
        self._title.setFont(font)
        self._title.setWordWrap(True)
        self._about = Message()
        self.empty = Message()
        self.empty.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        self.tabs.currentChanged.connect(lambda _: self._show_tools())
        self._zoom = self._tool("Actual size: the figure in its own pixels (double-click)")
        self._zoom.setCheckable(True)
        self._zoom.toggled.connect(self._set_whole)
        self._save = self._tool("Save this figure as PNG or SVG…")
        self._save.clicked.connect(self._wish_save)
        corner = QWidget()
        row = QHBoxLayout(corner)
        row.setContentsMargins(0, 0, 8, 2)
        row.addWidget(self._zoom)
        row.addWidget(self._save)
        self.tabs.setCornerWidget(corner)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(4)
        head = QVBoxLayout()
        head.setContentsMargins(14, 12, 14, 6)
        head.addWidget(self._title)
        head.addWidget(self._about)
        layout.addLayout(head)
        layout.addWidget(self.tabs, 1)
        layout.addWidget(self.empty, 1)
        self._text: QTextBrowser | None = None
        self._result: StoredResult | None = None
        self._draw_icons()

    def _tool(self, hint: str) -> QToolButton:
        button = QToolButton()
        button.setAutoRaise(True)
        button.setToolTip(hint)
        button.setAccessibleName(hint)
        return button

    def show_experiment(self, experiment: Experiment, result: StoredResult | None, folder: Path) -> None:
        """Show an experiment and, if there is one, its result, whose figures lie in the folder."""
        kept = self.tabs.currentIndex() if self._result and self._result.experiment == experiment.name else 0
        self._result = result
        self._title.setText(f"{experiment.title} ({experiment.source})")
        self._about.say(experiment.about)
        self._clear()
        self.tabs.setVisible(result is not None)
        self.empty.setVisible(result is None)
        if result is None:
            return
        for figure in result.figures:
            name = figure.stem.removeprefix(f"{result.experiment}-").replace("-", " ").capitalize()
            self._add_figure(folder / f"{figure.stem}.png", figure.caption, name)
        self._text = QTextBrowser()
        self._text.setFrameShape(QFrame.Shape.NoFrame)
        self._text.document().setDocumentMargin(14)
        self._write_text()
        self.tabs.addTab(self._text, "Beside the paper")
        self.tabs.addTab(RowTable(result.rows), f"Rows ({len(result.rows)})")
        self.tabs.setCurrentIndex(min(kept, self.tabs.count() - 1))
        self._show_tools()

    def say(self, state: str) -> None:
        """Say something else where there is no result."""
        self.empty.say(state)

    def _add_figure(self, path: Path, caption: str, name: str) -> None:
        view = FigureView(path, caption)
        if not view.readable:
            view.deleteLater()
            missing = Message()
            missing.setAlignment(Qt.AlignmentFlag.AlignCenter)
            missing.say(f"{path} cannot be read. Run the experiment again.", "error")
            self.tabs.addTab(missing, "Figure")
            return
        view.set_whole(self._zoom.isChecked())
        view.zoom_wished.connect(self._zoom.toggle)
        self.tabs.addTab(view, name)

    def _wish_save(self) -> None:
        view = self.tabs.currentWidget()
        if isinstance(view, FigureView):
            self.save_wished.emit(view.path)

    def _clear(self) -> None:
        self._text = None
        while self.tabs.count():
            page = self.tabs.widget(0)
            self.tabs.removeTab(0)
            if page is not None:
                page.deleteLater()

    def _set_whole(self, whole: bool) -> None:
        for index in range(self.tabs.count()):
            if isinstance(view := self.tabs.widget(index), FigureView):
                view.set_whole(whole)

    def _show_tools(self) -> None:
        on_figure = isinstance(self.tabs.currentWidget(), FigureView)
        self._zoom.setEnabled(on_figure)
        self._save.setEnabled(on_figure)

    def _write_text(self) -> None:
        if self._text is not None and self._result is not None:
            self._text.setHtml(_page(self._result, theme.colours(self.palette())))

    def _draw_icons(self) -> None:
        self._zoom.setIcon(theme.icon("ph.frame-corners", self.palette()))
        self._save.setIcon(theme.icon("ph.floppy-disk", self.palette()))

    def changeEvent(self, event: QEvent) -> None:
        """Icons and text in the colours of another theme."""
        super().changeEvent(event)
        if event.type() == QEvent.Type.PaletteChange and hasattr(self, "_result"):
            self._draw_icons()
            self._write_text()


def _page(result: StoredResult, colours: theme.Colours) -> str:
    """What the paper says beside what came out, and what to know about the run."""
    comparisons = EXPERIMENTS[result.experiment].compare(result.rows)
    first, *others = paragraphs(result)
    muted, border, warning = (colour.name() for colour in (colours.muted, colours.grid, colours.warning))
    cell = f'style="padding: 6px 12px 6px 0; border-bottom: 1px solid {border};" valign="top"'
    head = "".join(
        f'<td width="{width}%" {cell}><span style="color: {muted};">{text}</span></td>'
        for width, text in ((16, ""), (18, "paper"), (20, "here"), (46, ""))
    )
    lines = "".join(
        f"<tr><td {cell}><b>{html.escape(item.label)}</b></td>"
        + "".join(f"<td {cell}>{html.escape(text)}</td>" for text in (item.paper, item.ours, item.text))
        + "</tr>"
        for item in comparisons
    )
    quick = f'<p style="color: {warning};"><b>A quick run: its numbers are not to be relied on.</b></p>'
    notes = "".join(f"<p>{inline(note)}</p>" for note in (first, *others))
    return (
        f"{quick if result.quick else ''}"
        f'<table width="100%" cellspacing="0" style="border-collapse: collapse;"><tr>{head}</tr>{lines}</table>'
        f'<div style="color: {muted};">{notes}</div>'
    )
