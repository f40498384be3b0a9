"""The sweep: values of a parameter or two, with errors and pictures, in a window of its own; a click applies one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPoint, Qt
from PySide6.QtGui import QColor, QIcon, QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QHBoxLayout,
    QMenu,
    QPushButton,
    QSplitter,
    QStackedWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import counted, millimetres
from ilf.data.parameters import Parameters
from ilf.drawing.colours import to_indices
from ilf.errors import IlfError, InputError
from ilf.evaluation.hold_out import untrusted_note
from ilf.evaluation.sweep import Sweep, can_be_swept

from ...base import theme
from ...state.parts import Part
from ...views.colour_bar import ColourBar
from ...views.colours import error_table
from ...views.drawings import rgb_image
from ...widgets.basics import Message, PlainLabel, combo, give_size, label_of, lay_out, scrolled
from ...widgets.notices import error_text
from ...work.frame_runs import RunState
from ..context import Context
from ..filter import FilterPanel
from ..panel import Panel
from .cells import PointCells, point_cell
from .curve import ErrorCurve
from .options import CriterionBox, RangeBox
from .state import Picture, SweepState

_WIDTH, _HEIGHT, _LEFT = 1040, 660, 300
_DEPTH, _DIFFERENCE = 0, 1
_FULL_COVERAGE = 0.95
"""Share of filled pixels above which the coverage is not shown."""
_HINT = "The error of each value is plotted here,\nwith a picture of each. Click one to apply it."


class SweepFeature(Panel):
    """Window that runs sweeps in the background, one at a time, and shows their results.

    Attributes
    ----------
    found : SweepState or None
        The results of the last sweep so far.
    """

    title, group = "Sweep", None
    parts = Part.FRAME | Part.LIST | Part.PARAMETERS | Part.SELECTION | Part.INFOS | Part.GROUND_TRUTH
    what = "sweep"

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        _ = self.widget
        self.requests.ended.connect(self._end)
        self.work.cancelled.connect(lambda: self.state.show_message("Cancelled. Results so far are kept."))
        for changed in (context.views.ranges.changed, self.criterion.changed):
            changed.connect(self.redraw)
        context.refresh.add("frame of the sweep", self._follow_frames, Part.LIST)

    def make(self) -> QWidget:
        self._filter = self.context.feature(FilterPanel)
        self.found: SweepState | None = None
        self._icons: dict[int, QIcon] = {}
        """Pictures by the number of their points, as long as `_coloured` is the same."""
        self._coloured: tuple[object, ...] = ()
        window = QDialog(self.context.window)
        window.setWindowTitle("Sweep")
        window.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint)
        give_size(window, _WIDTH, _HEIGHT)
        self.first, self.second = RangeBox("First parameter"), RangeBox("Second parameter", optional=True)
        self.criterion = CriterionBox()
        self.curve, self.pictures = ErrorCurve(), PointCells("Pictures of the values")
        for shown in (self.curve, self.pictures):
            shown.taken.connect(self.apply)
        splitter = QSplitter(Qt.Orientation.Horizontal)
        hint = PlainLabel(_HINT, alignment=Qt.AlignmentFlag.AlignCenter)
        self._outcomes = QStackedWidget()
        self._outcomes.addWidget(hint)
        self._outcomes.addWidget(self._right_side())
        splitter.addWidget(self._left_side())
        splitter.addWidget(self._outcomes)
        splitter.setStretchFactor(1, 1)
        splitter.setSizes([_LEFT, _WIDTH - _LEFT])
        splitter.setChildrenCollapsible(False)
        lay_out(QVBoxLayout(window), splitter)
        for box in (self.first, self.second, self.criterion):
            box.changed.connect(lambda: self._describe(edited=True))
        return window

    def _left_side(self) -> QWidget:
        self.start_button = QPushButton("&Sweep", default=True)
        self.start_button.setToolTip("Complete the frame with every value and compare the errors")
        self.start_button.clicked.connect(lambda _: self.start())
        self.state = Message(lines=2)
        self.apply_button = QPushButton("&Apply best", autoDefault=False)
        self.apply_button.setToolTip("Apply the value with the smallest error; undo it with Ctrl+Z in the main window")
        self.apply_button.setEnabled(False)
        self.apply_button.clicked.connect(lambda _: self.apply(self.found.best if self.found else None))
        content = QWidget()
        settings = self.first, self.second, self.criterion, self.start_button
        below = self.work, self.state, self.apply_button, None
        lay_out(QVBoxLayout(content), *settings, *below, margins=(10, 10, 8, 10), spacing=8)
        return scrolled(content)

    def _right_side(self) -> QWidget:
        hint = "Content of the pictures, all in one colour scale; black: missing"
        self.content = combo(["Depth", "Difference"], hint)
        self.content.activated.connect(lambda _: self._show_found())
        self.bar = ColourBar()
        self.bar.setAccessibleName("Colours of the pictures")
        choice = label_of("Pict&ures of", self.content), self.content
        head = lay_out(QHBoxLayout(), *choice, None, self.bar, margins=(8, 4, 8, 0))
        self._names = PlainLabel(alignment=Qt.AlignmentFlag.AlignCenter)
        below = QWidget()
        lay_out(QVBoxLayout(below), head, self._names, self.pictures, spacing=2, stretched=self.pictures)
        splitter = QSplitter(Qt.Orientation.Vertical)
        splitter.addWidget(self.curve)
        splitter.addWidget(below)
        splitter.setSizes([260, 400])
        splitter.setChildrenCollapsible(False)
        return splitter

    # settings of the sweep

    def open(self, name: str = "") -> None:
        """Open the window, with a parameter unless it is ""."""
        was_open = self.widget.isVisible()
        self.widget.show()
        self.widget.raise_()
        self.widget.activateWindow()
        self._show_frame()
        for box in () if was_open or self.busy else (self.first, self.second):
            box.cover_present()
        if name and not self.busy:
            if self._filter.for_selected:
                self.criterion.blocks.setCurrentIndex(1)
                self._show_frame()
            self.second.setChecked(False)
            self.first.choose(name)

    def show_menu(self, name: str, place: QPoint) -> None:
        """Show the context menu of a parameter of the filter form."""
        declaration = Parameters.declarations()[name]
        menu = QMenu(self.context.window)
        action = menu.addAction(f"Sweep {declaration.label}…")
        action.setToolTip("Test many values and find the best")
        action.setEnabled(can_be_swept(declaration) and self.workspace.shown is not None)
        action.triggered.connect(lambda _=False: self.open(name))
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(place)

    def _boxes(self) -> list[RangeBox]:
        return [self.first, *([self.second] if self.second.isChecked() else [])]

    def _sweep(self) -> Sweep | None:
        """The sweep of the settings; None if there is none, which is told."""
        workspace, variation = self.workspace, {box.declaration.name: box for box in self._boxes()}
        try:
            if workspace.shown is None:
                raise InputError("Open a frame first.")
            if len(variation) < len(self._boxes()):
                raise InputError("Select two different parameters, or switch the second one off.")
            values = {name: box.values() for name, box in variation.items()}
            only = [workspace.chosen] if workspace.chosen and self.criterion.for_selected else None
            run = workspace.current.run(workspace.parameters.current)
            return Sweep(run, values, criterion=self.criterion.test(), only=only)
        except IlfError as error:
            self.state.show_message(str(error), "error")
            return None

    def refresh(self, parts: Part) -> None:
        self._show_frame()

    def _show_frame(self) -> None:
        """Show the current values of the frame or its selected block, and what can be swept."""
        if self.workspace.shown is None:
            return
        document, chosen = self.workspace.current, self.workspace.chosen
        for_selected = bool(chosen) and self.criterion.for_selected
        parameters = document.parameters_of(chosen) if for_selected else self.workspace.parameters.current
        self.first.set_parameters(parameters)
        self.second.set_parameters(parameters)
        self.criterion.set_frame(document.frame.ground_truth is not None, document.info(chosen).name if chosen else "")
        self._describe()
        self._show_found()

    def _describe(self, edited: bool = False) -> None:
        """Show why the settings are invalid; or the result of the last sweep or, if `edited`, the size of the next."""
        if self.busy:
            return
        sweep = self._sweep()
        self.start_button.setEnabled(sweep is not None)
        if sweep is not None:
            values, test = len(sweep.points), sweep.criterion
            runs = values * (1 if test is None else len(test.seeds) + 1)
            outcome = "" if edited else self._outcome()
            self.state.show_message(outcome or f"{counted(values, 'value')}, {counted(runs, 'run')}.")

    # the sweep

    def start(self) -> None:
        """Start a sweep with the settings."""
        sweep = None if self.busy else self._sweep()
        if sweep is None:
            return
        document = self.workspace.current
        self.found = found = SweepState(document, sweep)
        self._lay_out(found)
        self.requests.ask(
            found.steps,
            partial(self._take, found.finish),
            step=partial(self._take, found.add),
            what=f"a sweep of {document.name}",
            about=document,
        )
        self.state.show_message("Running the first values…")
        self._allow(False)
        self._show_found()

    def apply(self, number: int | None) -> None:
        """Apply the values of a point to all blocks, or to the only block swept."""
        found, workspace = self.found, self.workspace
        if found is None or number is None:
            return
        workspace.show(found.document)
        if found.label and found.label not in found.document.counts():
            self.state.show_message("The swept block no longer exists.", "warning")
            return
        self._filter.set_values(found.points[number], found.label)
        where = found.document.info(found.label).name if found.label else "all blocks"
        text = f"{found.text_of(number)} applied to {where}."
        if found.document.changed_blocks() and self.context.runs.state is RunState.IDLE:
            self.notes.offer(text, self.context.actions["run"])
        else:
            self.notes.show_message(text)

    def _take(self, add: Callable[[Any], None], what: object) -> None:
        """Add a point to the results, or all of them in the end."""
        add(what)
        self._show_found()
        self.state.show_message(self._outcome())

    def fail(self, error: Exception) -> None:
        self.state.show_message(error_text(error), "error")

    def _end(self) -> None:
        self._allow(True)
        if self.found is None:  # its frame was closed
            self._describe()
        self._show_found()

    def _follow_frames(self) -> None:
        """Stop the sweep of a frame that was closed, and clear its results."""
        if self.found is None or self.found.document in self.workspace.open:
            return
        self.requests.cancel()
        self.found = None
        self._outcomes.setCurrentIndex(0)
        self.pictures.show_cells(())
        self.apply_button.setEnabled(False)
        self._describe()

    def _allow(self, settings: bool) -> None:
        for widget in (self.first, self.second, self.criterion, self.start_button):
            widget.setEnabled(settings)

    # results

    def _lay_out(self, found: SweepState) -> None:
        """Make room for the results of a sweep."""
        self._outcomes.setCurrentIndex(1)
        self._icons.clear()
        values = [sorted(float(value) for value in values) for values in found.sweep.values.values()]
        declarations = [box.declaration for box in self._boxes()]
        names = [f"{one.label} [{one.unit}]" if one.unit else one.label for one in declarations]
        alone, heads = len(names) == 1, None
        if alone:
            self.curve.set_scale(names[0], values[0], self.first.logarithmic)
        else:
            heads = [f"{value:g}" for value in values[0]], [f"{value:g}" for value in values[1]]
            self._names.setText(f"{names[0]} to the right, {names[1]} upwards; dark: small error")
        self.curve.setVisible(alone)
        self._names.setVisible(not alone)
        self.pictures.arrange(heads, found.picture_size)
        name = "Error" if found.document.frame.ground_truth is not None else "Difference to the result"
        self.content.setItemText(_DIFFERENCE, name)
        self.content.setEnabled(found.reference is not None)
        if found.reference is None:
            self.content.setCurrentIndex(_DEPTH)

    def _show_found(self) -> None:
        """Draw the results so far."""
        found = self.found
        if found is None:
            return
        differences = self.content.currentIndex() == _DIFFERENCE
        colours = differences, self.views.data.depth_map, theme.is_dark(self.widget.palette())
        pictures, (table, levels) = found.pictures(*colours)
        if (coloured := (*colours, levels)) != self._coloured:
            self._icons.clear()
            self._coloured = coloured
        self.bar.show_scale(table, levels, "mm" if differences else "m")
        self.bar.show()
        tints: Sequence[QColor | None] = [None] * len(found.points)
        if len(found.sweep.values) == 1:
            (present,) = found.present_values.values()
            self.curve.draw(found.errors, found.marked, float(present))
        else:
            tints = _error_colours([*found.errors, *[math.nan] * (len(found.points) - len(found.errors))])
        icons = (self._icon(number, pictures, table, levels) for number in range(len(tints)))
        cells = [self._cell(found, number, *shown) for number, shown in enumerate(zip(icons, tints, strict=True))]
        self.pictures.show_cells(cells)
        self.apply_button.setEnabled(found.best is not None and found.best != found.present)

    def _cell(self, found: SweepState, number: int, picture: QIcon, tint: QColor | None) -> QTableWidgetItem:
        text = "…" if self.busy else "not run"
        if number < len(found.errors):
            text = _millimetres(found.errors[number])
            if found.coverage[number] <= _FULL_COVERAGE:
                text += f", fills {found.coverage[number]:.0%}"
        best, present = number in found.marked, number == found.present
        marks = ["best" if len(found.marked) == 1 else "equal"] * best + ["current"] * present
        values = " · ".join(f"{value:g}" for value in found.points[number].values())
        hint = f"{', '.join([values, text, *marks])}. Click to apply."
        caption = "\n".join((values, text, ", ".join(marks)))
        return point_cell(caption, hint, best, present, picture, tint)

    def _icon(
        self, number: int, pictures: Sequence[Picture], table: NDArray[np.uint8], levels: tuple[float, float]
    ) -> QIcon:
        """The picture of a point, made once for a colour scale; an empty one until there is a result."""
        size = self.pictures.iconSize() * 2  # for screens of twice the resolution
        if number >= len(pictures):
            blank = QPixmap(size)
            blank.fill(theme.colours(self.widget.palette()).panel)
            return QIcon(blank)
        if number not in self._icons:
            image = rgb_image(table[to_indices(pictures[number], *levels)][..., :3])
            image = image.scaled(size, Qt.AspectRatioMode.KeepAspectRatio, Qt.TransformationMode.SmoothTransformation)
            self._icons[number] = QIcon(QPixmap.fromImage(image))
        return self._icons[number]

    def _outcome(self) -> str:
        found = self.found
        best = None if found is None else found.best
        if found is None or best is None:
            return "Nothing could be evaluated." if found is not None and found.errors else ""
        where = found.document.info(found.label).name if found.label else "all blocks"
        over = "so far" if found.result is None else "over the pixels that all values filled"
        text, present = f"best at {found.text_of(best)}, {_millimetres(found.errors[best])}", found.present
        if found.result is not None and found.result.ties:
            within = millimetres(found.result.ties.within)
            text = f"{len(found.marked)} of {counted(len(found.points), 'point')} are equal within {within} mm"
            text += ", the current value among them" * (present in found.marked)
        if present is not None and present < len(found.errors) and present not in found.marked:
            text += f" (current: {_millimetres(found.errors[present])})"
        left_out = "" if found.sweep.criterion is None else untrusted_note(found.document.frame)
        return f"{found.document.name}, {where}: {text}, {over}. {left_out}".rstrip()


def _error_colours(errors: Sequence[float]) -> list[QColor | None]:
    """Colours of errors on a logarithmic scale from the smallest to the largest; None without an error."""
    logs = np.log(np.maximum(errors, 1e-6))
    known = logs[np.isfinite(logs)]
    if not known.size:
        return [None] * len(errors)
    low, table = known.min(), error_table()
    indices = to_indices(logs, low, max(known.max(), low + 1e-6))
    return [QColor(*table[index, :3].tolist()) if index else None for index in indices]


def _millimetres(error: float) -> str:
    return f"{millimetres(error)} mm" if math.isfinite(error) else "not evaluated"
