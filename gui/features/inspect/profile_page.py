"""Page of the depth profile: legend with values, plot, and unit of the horizontal axis."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import Qt, Signal
from PySide6.QtGui import QColor, QFont, QResizeEvent
from PySide6.QtWidgets import QHBoxLayout, QLabel, QSizePolicy, QStackedWidget, QVBoxLayout, QWidget

from ...base import theme
from ...widgets.basics import Message, Themed, combo, lay_out, use_even_digits
from .profile_plot import ProfileData, ProfilePlot, raw_colour

_LONGEST_NAME = 130
"""Width [px] to which the name of a curve is elided in the legend."""
_DOT, _LINE, _DASHES = "●", "━", "┅"


class ProfilePage(Themed, QWidget):
    """Page with the depth along the profile line.

    Parameters
    ----------
    buttons : sequence of QWidget
        Beside the legend.

    Signals
    -------
    pointed(object)
        Number of the sample under the mouse, or None.
    """

    pointed = Signal(object)

    def __init__(self, buttons: Sequence[QWidget]) -> None:
        super().__init__()
        self.data: ProfileData | None = None
        """The plotted data; None for none."""
        self.sample: int | None = None
        """Number of the marked sample; None for none."""
        self._x: NDArray[np.float64] = np.zeros(0)
        self.plot = ProfilePlot()
        self.plot.hovered.connect(self._hover)
        self.legend = QLabel(wordWrap=True)
        self.legend.setTextFormat(Qt.TextFormat.RichText)
        self.legend.setAlignment(Qt.AlignmentFlag.AlignTop)
        self.legend.setSizePolicy(QSizePolicy.Policy.Ignored, QSizePolicy.Policy.Minimum)
        hint = "Distance along the line: in pixels of the image, or in metres along the surface"
        self.axis = combo(["Pixels", "Metres"], hint, "Unit of the horizontal axis of the profile")
        self.axis.currentIndexChanged.connect(self._change_axis)
        header = lay_out(QHBoxLayout(), self.legend, margins=(8, 3, 4, 1), spacing=2, stretched=self.legend)
        for widget in (self.axis, *buttons):
            header.addWidget(widget, 0, Qt.AlignmentFlag.AlignTop)
        self._hint = Message()
        self._hint.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._pages = QStackedWidget()
        self._pages.addWidget(self._hint)
        self._pages.addWidget(self.plot)
        lay_out(QVBoxLayout(self), header, self._pages, spacing=0, stretched=self._pages)
        self._take_theme()

    def show_hint(self, text: str) -> None:
        """Show how to draw a line instead of a plot."""
        self.data = None
        self._hint.show_message(text)
        self._pages.setCurrentIndex(0)
        self.point_at(None)

    def show_data(self, data: ProfileData) -> None:
        """Plot depth."""
        self.data = data
        self._pages.setCurrentIndex(1)
        metres = data.profile.metres
        self.axis.setEnabled(metres is not None)
        if metres is not None and self.axis.currentIndex() == 1:
            self._x, unit = metres, "Along the surface from A to B [m]"
        else:
            self._x, unit = data.profile.pixels, "Along the line from A to B [px]"
        self.plot.show_data(data, self._x, unit)
        # the marked sample stays: its depth may change during a run
        self.point_at(self.sample if (self.sample or 0) < len(data.profile) else None)

    def point_at(self, sample: int | None) -> None:
        """Mark a sample in the plot and show its values; None for none."""
        self.sample = sample
        self.plot.point_at(math.nan if sample is None else float(self._x[sample]))
        self.legend.setText("&nbsp;&nbsp; ".join(self._entries()))
        # as high as it was so far, so that the plot stays still while the mouse moves over it
        height = self.legend.heightForWidth(self.legend.width())
        self.legend.setMinimumHeight(max(height, self.legend.minimumHeight()))

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        self.legend.setMinimumHeight(0)

    def _change_axis(self) -> None:
        self.plot.fit()
        self._show_again()

    def _show_again(self) -> None:
        if self.data is not None:
            self.show_data(self.data)

    def _hover(self, x: float) -> None:
        sample = None
        if self.data is not None and math.isfinite(x) and np.isfinite(self._x).any():
            sample = int(np.nanargmin(np.abs(self._x - x)))
        if sample != self.sample:
            self.point_at(sample)
            self.pointed.emit(sample)

    def _entries(self) -> list[str]:
        """The legend: where the marked sample is, and each curve with its value there."""
        data, n = self.data, self.sample
        if data is None:
            return []
        colours, metrics = theme.colours(self.palette()), self.fontMetrics()
        entries = []
        if n is not None:
            x, y, label = int(data.profile.columns[n]), int(data.profile.rows[n]), int(data.labels[n])
            block = html.escape(data.names.get(label, "no block")).replace(" ", "&nbsp;")
            entries.append(f"<span style='color:{colours.muted.name()}'>x&nbsp;{x}, y&nbsp;{y}&nbsp; {block}</span>")
        entries.append(_entry(_DOT, raw_colour(colours), "raw", data.raw, n))
        for number, curve in enumerate(data.curves):
            mark = _DASHES if curve.is_reference else _LINE
            name = metrics.elidedText(curve.name, Qt.TextElideMode.ElideRight, _LONGEST_NAME)
            entry = _entry(mark, curve.drawn_in(colours), name, curve.depth, n)
            if n is not None and not number and data.error is not None and math.isfinite(data.error[n]):
                entry += f"&nbsp;±&nbsp;{1000 * data.error[n]:.0f}&nbsp;mm"
            entries.append(entry)
        return entries

    def _take_theme(self) -> None:
        small = QFont(self.font())
        small.setPointSizeF(small.pointSizeF() * 0.85)
        use_even_digits(self.legend)  # they keep it still
        self.plot.set_colours(theme.colours(self.palette()), small)
        self._show_again()


def _entry(mark: str, colour: QColor, name: str, depth: NDArray[np.float32], sample: int | None) -> str:
    """Return mark, name and value of a curve as HTML."""
    value = ""
    if sample is not None:
        value = f"&nbsp;{depth[sample]:.3f}&nbsp;m" if math.isfinite(depth[sample]) else "&nbsp;missing"
    name = html.escape(name).replace(" ", "&nbsp;")
    return f"<span style='color:{colour.name()}'>{mark}</span>&nbsp;{name}{value}"
