"""The sweep window: parameters at the left, errors and pictures at the right."""

from __future__ import annotations

import math

from PySide6.QtCore import QSize, Qt, Signal
from PySide6.QtGui import QShowEvent
from PySide6.QtWidgets import (
    QComboBox,
    QDialog,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QScrollArea,
    QSplitter,
    QStackedWidget,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import counted, millimetres
from ilf.data.declarations import Value
from ilf.data.parameters import Parameters
from ilf.errors import IlfError
from ilf.evaluation.hold_out import untrusted_note

from ...base import theme
from ...widgets.basics import Message, PlainLabel, Themed
from ...widgets.work_row import WorkRow
from .charts import ErrorCurve, ErrorGrid
from .multiples import Multiples, ScaleBar
from .options import CriterionBox, RangeBox, captions
from .state import SweepState

_SIZE = QSize(1040, 660)
_LEFT = 300
_DEPTH, _DIFFERENCE = 0, 1
_FULL_COVERAGE = 0.95
"""Share of filled pixels above which the coverage is not shown."""


class SweepWindow(Themed, QDialog):
    """Window of a sweep; emits the user's requests.

    Signals
    -------
    begun()
        The user started the sweep.
    cancelled()
    taken(int)
        The user applied the values of this point.
    became_visible()
        The window became visible: show what changed meanwhile.
    """

    begun = Signal()
    cancelled = Signal()
    taken = Signal(int)
    became_visible = Signal()

    def __init__(self, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle("Sweep")
        self.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint)
        self.resize(_SIZE)
        self._found: SweepState | None = None
        self._colour_map = "turbo"
        self.first, self.second = RangeBox("Parameter"), RangeBox("Second parameter", optional=True)
        self.criterion = CriterionBox()
        self.start_button = QPushButton("&Sweep", default=True)
        self.start_button.setToolTip("Complete the frame with every value and compare the errors")
        self.start_button.clicked.connect(lambda _: self.begun.emit())
        self.work = WorkRow("sweep")
        self.work.cancelled.connect(self.cancelled)
        self.state = Message(lines=2)
        self.apply_button = QPushButton("&Apply best", autoDefault=False)
        self.apply_button.setToolTip("Apply the value with the smallest error; undo it with Ctrl+Z in the main window")
        self.apply_button.clicked.connect(lambda _: self._apply_best())
        self.apply_button.setEnabled(False)
        self.curve, self.grid, self.multiples = ErrorCurve(), ErrorGrid(), Multiples()
        for shown in (self.curve, self.grid, self.multiples):
            shown.taken.connect(self.taken)
        self.pictures = QComboBox()
        self.pictures.setAccessibleName("What the pictures show")
        self.pictures.setToolTip("Content of the pictures, all in one colour scale")
        self.pictures.addItems(["Depth", "Difference"])
        self.pictures.activated.connect(lambda _: self.show_found())
        self.bar = ScaleBar()
        splitter = QSplitter(Qt.Orientation.Horizontal)
        self._outcomes = QStackedWidget()
        self._outcomes.addWidget(_hint())
        self._outcomes.addWidget(self._right_side())
        splitter.addWidget(self._left_side())
        splitter.addWidget(self._outcomes)
        splitter.setStretchFactor(1, 1)
        splitter.setSizes([_LEFT, _SIZE.width() - _LEFT])
        splitter.setChildrenCollapsible(False)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(splitter)
        for box in (self.first, self.second, self.criterion):
            box.changed.connect(lambda: self.describe(edited=True))

    def _left_side(self) -> QWidget:
        content = QWidget()
        column = QVBoxLayout(content)
        column.setContentsMargins(10, 10, 8, 10)
        column.setSpacing(8)
        for widget in (self.first, self.second, self.criterion, self.start_button, self.work, self.state):
            column.addWidget(widget)
        column.addWidget(self.apply_button)
        column.addStretch(1)
        area = QScrollArea()
        area.setWidget(content)
        area.setWidgetResizable(True)
        area.setFrameShape(QScrollArea.Shape.NoFrame)
        area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        area.setMinimumWidth(content.minimumSizeHint().width() + area.verticalScrollBar().sizeHint().width())
        return area

    def _right_side(self) -> QWidget:
        self._plots = QStackedWidget()
        self._plots.addWidget(self.curve)
        self._plots.addWidget(self.grid)
        below = QWidget()
        head = QHBoxLayout()
        head.setContentsMargins(8, 4, 8, 0)
        label = PlainLabel("&Pictures of")
        label.setBuddy(self.pictures)
        head.addWidget(label)
        head.addWidget(self.pictures)
        head.addStretch(1)
        head.addWidget(self.bar, 1)
        column = QVBoxLayout(below)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        column.addLayout(head)
        column.addWidget(self.multiples, 1)
        splitter = QSplitter(Qt.Orientation.Vertical)
        splitter.addWidget(self._plots)
        splitter.addWidget(below)
        splitter.setStretchFactor(0, 2)
        splitter.setStretchFactor(1, 3)
        splitter.setSizes([260, 400])
        splitter.setChildrenCollapsible(False)
        return splitter

    # settings of the sweep

    def variation(self) -> dict[str, tuple[Value, ...]]:
        """Name -> values to test; raises ParameterError with a message for invalid ranges."""
        boxes = [self.first, *([self.second] if self.second.isChecked() else [])]
        return {box.declaration.name: box.values() for box in boxes}

    def set_frame(self, parameters: Parameters, has_ground_truth: bool, chosen: str) -> None:
        """Set the current values of the frame or its selected block, whether there is ground truth, and the name."""
        self.first.set_parameters(parameters)
        self.second.set_parameters(parameters)
        self.criterion.set_frame(has_ground_truth, chosen)
        self.describe()
        self._show_marks()

    def choose(self, name: str) -> None:
        """Select the parameter to sweep."""
        self.second.setChecked(False)
        self.first.choose(name)

    def describe(self, edited: bool = False) -> None:
        """Show why the settings are invalid; or the result of the last sweep or, if `edited`, the size of the next."""
        if self.work.isVisible():
            return
        try:
            values = self.variation()
        except IlfError as error:
            self.state.show_message(str(error), "error")
            self.start_button.setEnabled(False)
            return
        if self.second.isChecked() and self.first.declaration.name == self.second.declaration.name:
            self.state.show_message("Select two different parameters, or switch the second one off.", "error")
            self.start_button.setEnabled(False)
            return
        self.start_button.setEnabled(True)
        count = math.prod(len(one) for one in values.values())
        test = self.criterion.test()
        runs = count * (1 if test is None else len(test.seeds) + 1)
        outcome = "" if edited else self._outcome()
        self.state.show_message(outcome or f"{counted(count, 'value')}, {counted(runs, 'run')}.")

    # results

    def begin(self, found: SweepState) -> None:
        """Show that a sweep has started."""
        self._found = found
        self._outcomes.setCurrentIndex(1)
        names, points = list(found.sweep.points[0]), found.sweep.points
        boxes = [self.first, self.second][: len(names)]
        two = len(names) > 1
        self._plots.setCurrentWidget(self.grid if two else self.curve)
        values = [sorted({float(point[name]) for point in points}) for name in names]
        labels = [_with_unit(box) for box in boxes]
        if two:
            self.grid.set_scale((labels[0], labels[1]), (values[0], values[1]))
        else:
            self.curve.set_scale(labels[0], values[0], boxes[0].logarithmic)
        self.multiples.set_captions(captions(names, points), found.shape, len(values[1]) if two else 0)
        name = "Error" if found.document.frame.ground_truth is not None else "Difference to the result"
        self.pictures.setItemText(_DIFFERENCE, name)
        self.pictures.setEnabled(found.has_differences)
        if not found.has_differences:
            self.pictures.setCurrentIndex(_DEPTH)
        self.work.begin()
        self.state.show_message("Running the first values…")
        self._set_busy(True)
        self.show_found()

    def end(self, text: str = "", tone: str = "muted") -> None:
        """Show that the sweep has ended; `text` is a message, if not successful."""
        self.work.end()
        self._set_busy(False)
        self.show_found()
        if text:
            self.state.show_message(text, tone)

    def forget(self) -> None:
        """Clear the results of a frame that was closed."""
        self._found = None
        self._outcomes.setCurrentIndex(0)
        self.multiples.set_captions([])
        self.curve.set_points([], [], ())
        self.grid.set_errors({}, ())
        self.describe()
        self.apply_button.setEnabled(False)

    def set_colour_map(self, name: str) -> None:
        """Set the depth colour map."""
        if name != self._colour_map:
            self._colour_map = name
            self.show_found()

    def show_found(self) -> None:
        """Draw the results so far."""
        found = self._found
        if found is None:
            return
        differences = self.pictures.currentIndex() == _DIFFERENCE
        pictures, scale = found.pictures(differences, self._colour_map, theme.is_dark(self.palette()))
        self.multiples.set_pictures(pictures, scale)
        self.bar.set_scale(scale if pictures else None, "mm" if differences else "m")
        if self._plots.currentWidget() is self.grid:
            self.grid.set_errors(dict(found.errors), found.marked)
        else:
            self.curve.set_points(list(found.errors), list(found.errors.values()), found.marked)
        self._show_marks()
        if found.errors:
            self.state.show_message(self._outcome())

    def _show_marks(self) -> None:
        found = self._found
        if found is None:
            return
        present = found.present
        self.grid.set_present(present)
        self.curve.set_present(float(next(iter(found.present_values.values()))))
        for number, tile in enumerate(self.multiples.tiles):
            error = _millimetres(found.errors.get(number))
            coverage = found.coverage.get(number, 1.0)
            text = error if coverage > _FULL_COVERAGE else f"{error}, fills {coverage:.0%}"
            mark = "best" if found.ties is None else "equal"
            tile.set_marks(text, mark * (number in found.marked), number == present)
        self.apply_button.setEnabled(found.best is not None and found.best != present)

    def _outcome(self) -> str:
        found = self._found
        best = None if found is None else found.best
        if found is None or best is None:
            return "Nothing could be evaluated." if found is not None and found.errors else ""
        where = found.document.info(found.label).name if found.label else "all blocks"
        over = "over the pixels that all values filled" if found.is_over_all else "so far"
        if found.ties is not None:
            text = f"{found.text_of_several(found.ties.equal)} are equal within {millimetres(found.ties.within)} mm"
            text += ", the current value among them" * (found.present in found.ties.equal)
        else:
            text = f"best at {found.text_of(best)}, {_millimetres(found.errors[best])}"
        if found.present in found.errors and found.present not in found.marked:
            text += f" (current: {_millimetres(found.errors[found.present])})"
        left_out = "" if found.sweep.criterion is None else untrusted_note(found.document.frame)
        return f"{found.document.name}, {where}: {text}, {over}. {left_out}".rstrip()

    def _apply_best(self) -> None:
        if self._found is not None and self._found.best is not None:
            self.taken.emit(self._found.best)

    def _set_busy(self, busy: bool) -> None:
        for widget in (self.first, self.second, self.criterion, self.start_button):
            widget.setEnabled(not busy)

    def showEvent(self, event: QShowEvent) -> None:
        super().showEvent(event)
        self.became_visible.emit()

    def _take_theme(self) -> None:
        if hasattr(self, "bar"):
            self.show_found()


def _hint() -> QLabel:
    """Placeholder before the first sweep."""
    label = PlainLabel("The error of each value is plotted here,\nwith a picture of each. Click one to apply it.")
    label.setAlignment(Qt.AlignmentFlag.AlignCenter)
    label.setEnabled(False)
    return label


def _with_unit(box: RangeBox) -> str:
    declaration = box.declaration
    return f"{declaration.label} [{declaration.unit}]" if declaration.unit else declaration.label


def _millimetres(error: float | None) -> str:
    if error is None:
        return "…"
    return f"{millimetres(error)} mm" if math.isfinite(error) else "not evaluated"
