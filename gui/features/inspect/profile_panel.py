"""Panel of the depth profile: legend with values, plot, unit of the horizontal axis, and commands to save it."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Qt, Signal
from PySide6.QtGui import QAction, QColor, QFont, QHideEvent, QResizeEvent, QShowEvent, QTextDocument
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QLabel, QStackedWidget, QToolButton, QVBoxLayout, QWidget

from ilf._runtime.writing import write_bytes
from ilf.project.frame_state import Point

from ...base import theme
from ...state.inspection import Inspection
from ...tools.line import REACH, off_line, share_along
from ...widgets.basics import PlainLabel, Themed
from ...widgets.file_choice import ask_path, save
from ..context import Context
from .profile_plot import ProfileData, ProfilePlot, profile_data, raw_colour, result_colour

EMPTY_TEXT = "Draw a profile line (Ctrl+I) in a view to see the depth along it"

_DOT, _LINE, _DASHES = "●", "━", "┅"
_MAX_LINES = 3


class ProfilePanel(Themed, QWidget):
    """Panel with the depth along the profile line.

    Parameters
    ----------
    actions : sequence of QAction
        Buttons beside the legend.

    Signals
    -------
    shown(), hidden()
        The panel has become visible, so that it must be updated; or hidden.
    pointed(object)
        Number of the sample under the mouse, or None.
    """

    shown = Signal()
    hidden = Signal()
    pointed = Signal(object)

    def __init__(self, actions: Sequence[QAction], parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._data: ProfileData | None = None
        self._x: NDArray[np.float64] = np.zeros(0)
        self._sample: int | None = None
        self._names: dict[int, str] = {}
        self._lines = 1
        self.plot = ProfilePlot()
        self.plot.hovered.connect(self._hover)
        self._legend = QLabel()
        self._legend.setTextFormat(Qt.TextFormat.RichText)
        self._legend.setWordWrap(True)
        self._legend.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.axis = QComboBox()
        self.axis.addItems(["Pixels", "Metres"])
        self.axis.setAccessibleName("Unit of the horizontal axis of the profile")
        self.axis.setToolTip("Distance along the line: in pixels of the image, or in metres along the surface")
        self.axis.currentIndexChanged.connect(self._change_axis)
        header = QHBoxLayout()
        header.setContentsMargins(8, 3, 4, 1)
        header.setSpacing(2)
        header.addWidget(self._legend, 1)
        header.addWidget(self.axis, 0, Qt.AlignmentFlag.AlignTop)
        for action in actions:
            button = QToolButton()
            button.setDefaultAction(action)
            button.setAutoRaise(True)
            header.addWidget(button, 0, Qt.AlignmentFlag.AlignTop)
        self._hint = PlainLabel(EMPTY_TEXT)
        self._hint.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._hint.setWordWrap(True)
        self._pages = QStackedWidget()
        self._pages.addWidget(self._hint)
        self._pages.addWidget(self.plot)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addLayout(header)
        layout.addWidget(self._pages, 1)
        self.setMinimumSize(240, 110)
        self._take_theme()

    @property
    def data(self) -> ProfileData | None:
        """The plotted data; None for none."""
        return self._data

    def show_data(self, data: ProfileData | None, names: dict[int, str] | None = None) -> None:
        """Plot depth, None for none, with the names of the blocks by label."""
        self._data, self._names = data, names or {}
        if data is None:
            self._sample = None
            self.plot.clear_data()
            self._pages.setCurrentIndex(0)
        else:
            metres = data.profile.metres
            self.axis.setEnabled(metres is not None)
            in_metres = metres is not None and self.axis.currentIndex() == 1
            self._x = metres if metres is not None and in_metres else data.profile.pixels
            self.plot.show_data(
                data, self._x, "Along the surface from A to B [m]" if in_metres else "Along the line from A to B [px]"
            )
            self._pages.setCurrentIndex(1)
        # the marked sample stays: its depth may change during a run
        self.point_at(self._sample if data is not None and (self._sample or 0) < len(data.profile) else None)

    def point_at(self, sample: int | None) -> None:
        """Mark a sample in the plot and show its values; None for none."""
        self._sample = sample
        self.plot.point_at(math.nan if sample is None else float(self._x[sample]))
        self._write_legend()

    @property
    def sample(self) -> int | None:
        """Number of the marked sample; None for none."""
        return self._sample

    def legend_names(self) -> list[tuple[str, str]]:
        """Return the plotted items by the keys of `ProfilePlot.picture`, and their names."""
        data = self._data
        if data is None:
            return []
        there = [("raw", "raw"), *([("result", data.name)] if data.result is not None else [])]
        there += [(str(number), name) for number, (name, _, _) in enumerate(data.runs)]
        return there + ([("ground_truth", "ground truth")] if data.ground_truth is not None else [])

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.shown.emit()

    def hideEvent(self, event: QHideEvent) -> None:
        super().hideEvent(event)
        self.hidden.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self._lines = 1
        self._write_legend()

    def _change_axis(self) -> None:
        self.plot.fit()
        self.show_data(self._data, self._names)

    def _hover(self, x: float) -> None:
        known = np.isfinite(self._x)
        if self._data is None or not math.isfinite(x) or not known.any():
            sample = None
        else:
            sample = int(np.nanargmin(np.abs(self._x - x)))
        if sample != self._sample:
            self.point_at(sample)
            self.pointed.emit(sample)

    def _write_legend(self) -> None:
        text = "&nbsp;&nbsp; ".join(self._entries())
        self._legend.setText(text)
        # keep the largest number of lines so far, so that the plot stays still while the mouse moves over it
        document = QTextDocument()
        document.setDefaultFont(self._legend.font())
        document.setDocumentMargin(0)
        document.setHtml(text)
        document.setTextWidth(max(self._legend.width(), 100))
        height = self._legend.fontMetrics().lineSpacing()
        self._lines = min(max(self._lines, round(document.size().height() / height)), _MAX_LINES)
        self._legend.setFixedHeight(self._lines * height + 2)

    def _entries(self) -> list[str]:
        data, n = self._data, self._sample
        if data is None:
            return []
        colours = theme.colours(self.palette())
        entries = [_entry(_DOT, raw_colour(colours), "raw", data.raw, n)]
        if data.result is not None:
            entry = _entry(_LINE, result_colour(colours), data.name, data.result, n)
            if n is not None and data.error is not None and math.isfinite(data.error[n]):
                entry += f"&nbsp;±&nbsp;{1000 * data.error[n]:.0f}&nbsp;mm"
            entries.append(entry)
        entries += [_entry(_LINE, QColor(*colour), name, depth, n) for name, colour, depth in data.runs]
        if data.ground_truth is not None:
            entries.append(_entry(_DASHES, colours.text, "ground truth", data.ground_truth, n))
        if n is not None:
            x, y, label = int(data.profile.columns[n]), int(data.profile.rows[n]), int(data.labels[n])
            block = html.escape(self._names.get(label, "no block")).replace(" ", "&nbsp;")
            entries.insert(0, f"<span style='color:{colours.muted.name()}'>x&nbsp;{x}, y&nbsp;{y}&nbsp; {block}</span>")
        return entries

    def _take_theme(self) -> None:
        colours = theme.colours(self.palette())
        small = QFont(self.font())
        small.setPointSizeF(small.pointSizeF() * 0.85)
        tabular = QFont(self.font())
        tabular.setFeature(QFont.Tag("tnum"), 1)  # figures of equal width keep the legend still
        self._legend.setFont(tabular)
        self.plot.set_colours(colours, small)
        self._hint.setStyleSheet(f"color: {colours.muted.name()};")
        self.show_data(self._data, self._names)


def _entry(mark: str, colour: QColor, name: str, depth: NDArray[np.float32], sample: int | None) -> str:
    """Return mark, name and value of a curve as HTML."""
    value = ""
    if sample is not None:
        value = f"&nbsp;{depth[sample]:.3f}&nbsp;m" if math.isfinite(depth[sample]) else "&nbsp;missing"
    name = html.escape(name).replace(" ", "&nbsp;")
    return f"<span style='color:{colour.name()}'>{mark}</span>&nbsp;{name}{value}"


# Presenter of the depth along the profile line.


class ProfilePresenter(QObject):
    """Presenter of the depth along the current frame's profile line: the current result, or the iteration being viewed.

    Signals
    -------
    place_changed()
        `place` has changed.
    """

    place_changed = Signal()

    def __init__(self, context: Context, inspection: Inspection, panel: ProfilePanel) -> None:
        super().__init__(panel)
        self._context = context
        self._inspection = inspection
        self._panel = panel
        self._pixel: tuple[int, int] | None = None
        self.place: Point | None = None
        """Place under the mouse, in the plot or on the line in a view, in image coordinates; None for none."""
        panel.pointed.connect(self._point)
        context.views.cursorMoved.connect(self._hover)

    @property
    def is_seen(self) -> bool:
        """Whether the plot is visible."""
        return self._panel.isVisible()

    def show(self) -> None:
        """Plot the depth along the line if the panel is visible."""
        if not self.is_seen:
            return
        line, workspace = self._inspection.line, self._context.workspace
        if line is None:
            self._panel.show_data(None)
        else:
            document = workspace.current
            data = profile_data(document, line, workspace.viewed_iteration)
            names = {label: document.info(label).name for label in set(data.labels.tolist()) if label}
            self._panel.show_data(data, names)
        if self._pixel is None:
            self._point(self._panel.sample)
        else:
            self.follow()

    def save_table(self) -> None:
        """Write the samples to a CSV file that the user chooses."""
        path = self._ask("Save profile as table", ".csv", "Table (*.csv)")
        data = self._panel.data
        if path and data is not None:
            save(self._context.notes, path, lambda: write_bytes(path, data.profile.to_csv().encode()))

    def save_picture(self) -> None:
        """Write the plot to a picture that the user chooses."""
        path = self._ask("Save profile as picture", ".png", "PNG picture (*.png);;SVG picture (*.svg)")
        if path:
            as_svg = path.lower().endswith(".svg")
            content = self._panel.plot.picture(self._panel.legend_names(), as_svg)
            save(self._context.notes, path, lambda: write_bytes(path, content))

    def _ask(self, title: str, suffix: str, kinds: str) -> str:
        if self._panel.data is None:
            self._context.notes.show_message("There is no profile to write. Draw a profile line first.")
            return ""
        name = f"{self._context.workspace.current.name}-profile{suffix}"
        return ask_path(self._context.window, title, name, kinds)

    def _point(self, sample: int | None) -> None:
        data = self._panel.data
        if data is None or sample is None:
            self._set_place(None)
        else:
            self._set_place((int(data.profile.columns[sample]) + 0.5, int(data.profile.rows[sample]) + 0.5))

    def _hover(self, pixel: tuple[int, int] | None) -> None:
        self._pixel = pixel

    def follow(self) -> None:
        """Mark the sample under the mouse in the plot while the mouse is on the line in a view."""
        line, data = self._inspection.line, self._panel.data
        if line is None or data is None or not self.is_seen:
            return
        sample = None
        if self._pixel is not None:
            at = self._pixel[0] + 0.5, self._pixel[1] + 0.5
            if off_line(at, *line) <= REACH * self._context.views.pixel_size:
                sample = min(max(round(share_along(at, *line) * (len(data.profile) - 1)), 0), len(data.profile) - 1)
        self._panel.point_at(sample)
        self._point(sample)

    def _set_place(self, place: Point | None) -> None:
        if place != self.place:
            self.place = place
            self.place_changed.emit()
