"""View of the result of an experiment: figures, comparison with the paper, and rows."""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TypeGuard

from PySide6.QtCore import (
    QAbstractTableModel,
    QEvent,
    QModelIndex,
    QPersistentModelIndex,
    QRectF,
    QSize,
    QSortFilterProxyModel,
    Qt,
    Signal,
)
from PySide6.QtGui import QColor, QImage, QMouseEvent, QPainter, QPaintEvent, QPixmap, QResizeEvent
from PySide6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QScrollArea,
    QTableView,
    QTabWidget,
    QTextBrowser,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from ilf.lab.experiments.experiment import Experiment, Row
from ilf.lab.experiments.files import StoredResult
from ilf.lab.experiments.registry import EXPERIMENTS
from ilf.lab.experiments.report import inline, paragraphs, shown

from ...base import theme
from ...widgets.basics import Message, PlainLabel, Themed, literal_text

# A figure on white paper, fitted to the width, with its caption below.

_PAPER = QColor("#ffffff")
_EDGE = 10
"""Margin around the figure [px]."""

_MIN_WIDTH = 200


class FigureView(QScrollArea):
    """View of a PNG file. Figures are drawn for white paper, also in the dark theme.

    Signals
    -------
    zoom_requested()
        A double-click: actual size instead of fitted, or back.
    """

    zoom_requested = Signal()

    def __init__(self, path: Path, caption: str, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.path = path
        self._whole = False
        self.paper = _Paper(QImage(str(path)))
        self.paper.double_clicked.connect(self.zoom_requested)
        self._caption = Message()
        self._caption.show_message(caption)
        self._caption.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        content = QWidget()
        self._column = QVBoxLayout(content)
        self._column.setContentsMargins(14, 12, 14, 12)
        self._column.setSpacing(8)
        self._column.addWidget(self.paper, 0, Qt.AlignmentFlag.AlignLeft)
        self._column.addWidget(self._caption)
        self._column.addStretch()
        self.setWidget(content)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self._fit()

    @property
    def readable(self) -> bool:
        """Whether the file could be read as a picture."""
        return not self.paper.image.isNull()

    def set_whole(self, whole: bool) -> None:
        """Show the figure in actual size, scrollable, or fitted to the width."""
        self._whole = whole
        self._fit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        """Fit again."""
        super().resizeEvent(event)
        self._fit()

    def _fit(self) -> None:
        margins = self._column.contentsMargins()
        # always leave room for the scroll bar: otherwise showing it would change the fit, and so whether it is needed
        room = self.width() - self.verticalScrollBar().sizeHint().width() - margins.left() - margins.right()
        self.paper.fit(None if self._whole else max(room, _MIN_WIDTH))
        self._column.invalidate()  # its cached heights are for the old width; a fixed size does not invalidate them


class _Paper(QWidget):
    """The figure."""

    double_clicked = Signal()

    def __init__(self, image: QImage) -> None:
        super().__init__()
        self.image = image
        self._scaled = QPixmap()
        self.setToolTip("Double-click: actual size or fitted")

    def fit(self, width: int | None) -> None:
        """Set the maximum width, or None for the figure's own."""
        own = self.image.width() + 2 * _EDGE
        width = own if width is None else min(width, own)
        height = round((width - 2 * _EDGE) * self.image.height() / max(self.image.width(), 1)) + 2 * _EDGE
        if self.size() != QSize(width, height):
            self.setFixedSize(width, height)
            self._scaled = QPixmap()

    def event(self, event: QEvent) -> bool:
        """Rescale for another device pixel ratio."""
        if event.type() == QEvent.Type.DevicePixelRatioChange:
            self._scaled = QPixmap()
        return super().event(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:
        """Zoom."""
        self.double_clicked.emit()

    def paintEvent(self, event: QPaintEvent) -> None:
        """Draw the paper with rounded corners and a thin edge, and the figure in device pixels."""
        if self._scaled.isNull():
            size = (self.size() - QSize(2 * _EDGE, 2 * _EDGE)) * self.devicePixelRatioF()
            smooth = Qt.TransformationMode.SmoothTransformation
            scaled = self.image.scaled(size, Qt.AspectRatioMode.IgnoreAspectRatio, smooth)
            scaled.setDevicePixelRatio(self.devicePixelRatioF())
            self._scaled = QPixmap.fromImage(scaled)
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(theme.colours(self.palette()).grid)
        painter.setBrush(_PAPER)
        painter.drawRoundedRect(QRectF(self.rect()).adjusted(0.5, 0.5, -0.5, -0.5), 5, 5)
        painter.drawPixmap(_EDGE, _EDGE, self._scaled)
        painter.end()


# The table of an experiment's rows.

_MAX_COLUMN_WIDTH = 220

_SHARES = ("defect_rate",)
"""Columns of shares, shown as percentages."""


class RowTable(QTableView):
    """Table of rows with a column per name; click a heading to sort."""

    def __init__(self, rows: Sequence[Row], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        proxy = _Sorted(self)
        proxy.setSourceModel(_RowModel(rows, self))
        self.setModel(proxy)
        self.setAlternatingRowColors(True)
        self.setShowGrid(False)
        self.setWordWrap(False)
        self.setFrameShape(QTableView.Shape.NoFrame)
        self.setSelectionBehavior(QTableView.SelectionBehavior.SelectRows)
        self.setHorizontalScrollMode(QTableView.ScrollMode.ScrollPerPixel)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(24)
        header = self.horizontalHeader()
        header.setSortIndicator(-1, Qt.SortOrder.AscendingOrder)
        header.setSortIndicatorClearable(True)
        header.setMaximumSectionSize(_MAX_COLUMN_WIDTH)
        header.setHighlightSections(False)
        self.setSortingEnabled(True)
        self.resizeColumnsToContents()


class _RowModel(QAbstractTableModel):
    def __init__(self, rows: Sequence[Row], parent: QWidget) -> None:
        super().__init__(parent)
        self._rows = rows
        self._names = list(dict.fromkeys(name for row in rows for name in row))

    def rowCount(self, parent: QModelIndex | QPersistentModelIndex | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(self._rows)

    def columnCount(self, parent: QModelIndex | QPersistentModelIndex | None = None) -> int:
        return 0 if parent is not None and parent.isValid() else len(self._names)

    def data(self, index: QModelIndex | QPersistentModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        name = self._names[index.column()]
        value = self._rows[index.row()].get(name)
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.ToolTipRole):
            text = f"{shown(100.0 * value)} %" if name in _SHARES and value is not None else shown(value)
            return text if role == Qt.ItemDataRole.DisplayRole else literal_text(text)
        if role == Qt.ItemDataRole.UserRole:
            return value
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _alignment(_is_number(value))
        return None

    def headerData(self, section: int, orientation: Qt.Orientation, role: int = Qt.ItemDataRole.DisplayRole) -> Any:
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.DisplayRole:
            return self._names[section]
        if orientation == Qt.Orientation.Horizontal and role == Qt.ItemDataRole.TextAlignmentRole:
            numbers = any(_is_number(row.get(self._names[section])) for row in self._rows)
            return _alignment(numbers)
        return None


class _Sorted(QSortFilterProxyModel):
    """Sorts empty cells first, then numbers, then text."""

    def lessThan(self, left: QModelIndex | QPersistentModelIndex, right: QModelIndex | QPersistentModelIndex) -> bool:
        return _order(left.data(Qt.ItemDataRole.UserRole)) < _order(right.data(Qt.ItemDataRole.UserRole))


def _order(value: object) -> tuple[int, float, str]:
    if value is None:
        return 0, 0.0, ""
    return (1, float(value), "") if _is_number(value) else (2, 0.0, str(value))


def _alignment(is_number: bool) -> Qt.AlignmentFlag:
    side = Qt.AlignmentFlag.AlignRight if is_number else Qt.AlignmentFlag.AlignLeft
    return side | Qt.AlignmentFlag.AlignVCenter


def _is_number(value: object) -> TypeGuard[int | float]:
    return isinstance(value, int | float) and not isinstance(value, bool)


class ResultView(Themed, QWidget):
    """View of one experiment: description, and its result in tabs if there is one.

    Signals
    -------
    save_requested(object)
        Path of the PNG file of the visible figure.
    """

    save_requested = Signal(object)

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
        self._zoom = self._tool("Actual size (double-click)")
        self._zoom.setCheckable(True)
        self._zoom.toggled.connect(self._set_whole)
        self._save = self._tool("Save this figure as PNG or SVG…")
        self._save.clicked.connect(self._request_save)
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
        """Show an experiment and its result, if there is one, with figures from the folder."""
        kept = self.tabs.currentIndex() if self._result and self._result.experiment == experiment.name else 0
        self._result = result
        self._title.setText(f"{experiment.title} ({experiment.source})")
        self._about.show_message(experiment.about)
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
        self.tabs.addTab(self._text, "Comparison with the paper")
        self.tabs.addTab(RowTable(result.rows), f"Rows ({len(result.rows)})")
        self.tabs.setCurrentIndex(min(kept, self.tabs.count() - 1))
        self._show_tools()

    def show_message(self, state: str) -> None:
        """Set the text shown without a result."""
        self.empty.show_message(state)

    def _add_figure(self, path: Path, caption: str, name: str) -> None:
        view = FigureView(path, caption)
        if not view.readable:
            view.deleteLater()
            missing = Message()
            missing.setAlignment(Qt.AlignmentFlag.AlignCenter)
            missing.show_message(f"{path} cannot be read. Run the experiment again.", "error")
            self.tabs.addTab(missing, "Figure")
            return
        view.set_whole(self._zoom.isChecked())
        view.zoom_requested.connect(self._zoom.toggle)
        self.tabs.addTab(view, name)

    def _request_save(self) -> None:
        view = self.tabs.currentWidget()
        if isinstance(view, FigureView):
            self.save_requested.emit(view.path)

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

    def _take_theme(self) -> None:
        if hasattr(self, "_result"):
            self._draw_icons()
            self._write_text()


def _page(result: StoredResult, colours: theme.Colours) -> str:
    """HTML page: comparison of the paper with the result, and notes on the run."""
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
    quick = f'<p style="color: {warning};"><b>Quick run: the numbers are not reliable.</b></p>'
    notes = "".join(f"<p>{inline(note)}</p>" for note in (first, *others))
    return (
        f"{quick if result.quick else ''}"
        f'<table width="100%" cellspacing="0" style="border-collapse: collapse;"><tr>{head}</tr>{lines}</table>'
        f'<div style="color: {muted};">{notes}</div>'
    )
