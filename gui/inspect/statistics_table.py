"""Statistics of raw depth and of the result, side by side."""

from __future__ import annotations

import math

from PySide6.QtCore import Qt
from PySide6.QtGui import QFont, QShowEvent
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableWidget, QTableWidgetItem, QWidget

from ilf.inspection import SurfaceStatistics
from ilf.number_words import UNKNOWN, millimetres

_ROWS = (
    ("Pixels", "How many there are"),
    ("Missing", "Share of them without depth"),
    ("Mean", "Of the known depth"),
    ("Median", "Of the known depth"),
    ("Std. deviation", "Standard deviation of the known depth"),
    ("Range", "Least and largest known depth"),
    (
        "Noise",
        "What differs from pixel to pixel, whatever the surface's shape: from the median second difference of "
        "neighbours. Depth that comes in steps shows less than it has",
    ),
    ("Plane RMS", "Root mean square distance from the plane that fits best, without outliers"),
    ("Outliers", "Share of the known depth that is farther from that plane than 3.5 robust deviations"),
    ("Tilt", "Angle between that plane's normal and the camera's axis: 0° faces the camera"),
    ("Quadric RMS", "Root mean square distance from the quadric that fits best, without outliers"),
)


class StatisticsTable(QTableWidget):
    """A row for each number, a column for raw depth and one for the result."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(len(_ROWS), 2, parent)
        self.setHorizontalHeaderLabels(["Raw", "Result"])
        self.setAccessibleName("Statistics of raw depth and result")
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setFocusPolicy(Qt.FocusPolicy.ClickFocus)
        self.setShowGrid(False)
        self.setAlternatingRowColors(True)
        self.setFrameShape(QTableWidget.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        height = self.fontMetrics().height() + 3
        for header in (self.horizontalHeader(), self.verticalHeader()):
            header.setSectionsClickable(False)
            header.setHighlightSections(False)
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        self.verticalHeader().setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self.verticalHeader().setDefaultSectionSize(height)
        self.verticalHeader().setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        tabular = QFont(self.font())
        tabular.setFeature(QFont.Tag("tnum"), 1)
        self._cells: list[list[QTableWidgetItem]] = []
        for row, (name, help) in enumerate(_ROWS):
            title = QTableWidgetItem(name)
            title.setToolTip(help)
            self.setVerticalHeaderItem(row, title)
            self._cells.append([QTableWidgetItem(), QTableWidgetItem()])
            for column, item in enumerate(self._cells[row]):
                item.setFont(tabular)
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
                item.setToolTip(f"{name}: {help[0].lower()}{help[1:]}")
                self.setItem(row, column, item)

    def showEvent(self, event: QShowEvent) -> None:
        """All rows are to be seen: the panel around it scrolls."""
        super().showEvent(event)
        self.setFixedHeight(self.verticalHeader().length() + self.horizontalHeader().height() + 2 * self.frameWidth())

    def show_statistics(self, raw: SurfaceStatistics | None, result: SurfaceStatistics | None) -> None:
        """Write numbers; nothing where there are none."""
        for column, found in enumerate((raw, result)):
            texts = [""] * len(_ROWS) if found is None else _texts(found)
            for cells, text in zip(self._cells, texts, strict=True):
                cells[column].setText(text)

    def as_text(self) -> str:
        """The numbers as lines with tabs between columns."""
        lines = ["\tRaw\tResult"]
        for (name, _), cells in zip(_ROWS, self._cells, strict=True):
            lines.append("\t".join([name, *(cell.text() for cell in cells)]))
        return "\n".join(lines)


def _texts(found: SurfaceStatistics) -> list[str]:
    plane, quadric = found.plane, found.quadric
    return [
        f"{found.pixels:,}",
        f"{100 * found.missing_share:.1f} %",
        metres(found.mean),
        metres(found.median),
        _millimetres(found.deviation),
        f"{found.least:.2f}–{found.largest:.2f} m" if found.known else "–",
        _millimetres(found.noise),
        "–" if plane is None else _millimetres(plane.rms),
        "–" if plane is None else f"{100 * plane.outliers:.1f} %",
        "–" if plane is None else degrees(plane.tilt),
        "–" if quadric is None else _millimetres(quadric.rms),
    ]


def metres(length: float) -> str:
    """A length in metres, a dash for none."""
    return f"{length:.3f} m" if math.isfinite(length) else "–"


def _millimetres(length: float) -> str:
    """A small length with its unit, a dash for none."""
    return f"{millimetres(length)} mm" if math.isfinite(length) else UNKNOWN


def degrees(angle: float) -> str:
    """An angle, a dash for none."""
    return f"{angle:.1f}°" if math.isfinite(angle) else "–"
