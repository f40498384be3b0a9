"""The panel *Inspect*: depth along a line, statistics of a block or a rectangle, and measured distances."""

from __future__ import annotations

import math
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QApplication,
    QHBoxLayout,
    QTabWidget,
    QToolButton,
    QWidget,
)

from ilf._runtime.formatting import UNKNOWN, counted
from ilf._runtime.writing import write_bytes
from ilf.evaluation.measuring import NEEDS_INTRINSICS, Line, Measured, measure, measurements_csv
from ilf.project.frame_state import InspectionState, Point

from ...base.commands import command
from ...base.needs import Need
from ...state.document import Document
from ...state.parts import NO_PART, Part
from ...tools.line import REACH, off_line, share_along
from ...widgets.basics import ElidedLabel, Message, combo, command_button, lay_out, page
from ...widgets.docks import PanelGroup
from ...widgets.file_choice import ask_path, save
from ...widgets.row_table import NumberRow, NumberTable
from ..cloud import CloudPanel
from ..context import Context
from ..expected_error import ErrorFeature
from ..panel import Panel
from .marks import Marks
from .profile import ProfilePage, profile_data
from .statistics import COLUMNS, Mask, metres, statistics_of

PROFILE, STATISTICS, MEASUREMENTS = range(3)
"""The pages."""

TOOLS = "profile", "rectangle", "measure"
"""The tools of the pages."""

_DEPTH = Part.DEPTH | Part.SOME_RESULTS | Part.PREVIEWS
"""The parts that the depth shown depends on."""
_OF_STATISTICS = (_DEPTH & ~Part.PREVIEWS) | Part.SELECTION | Part.INFOS | Part.REGION
"""Those that the statistics depend on; not previews, to leave the processor to the run."""

_NO_LINE = "Draw a profile line in a view to see the depth along it."
_NO_SUBJECT = "Select a block, or draw a rectangle."
_NO_MEASUREMENTS = "Click two points with the tool Measure."
_MEASURED = (
    ("Distance", "Straight-line distance of the end points"),
    ("Height", "Height of the second point above the first, along the image's vertical"),
)


class InspectPanel(Panel):
    """The panel with a page for each, and their marks over the views."""

    title, icon, group = "Inspect", "ph.ruler", PanelGroup.INSPECTION
    parts = Part.DEPTH | Part.EXPECTED_ERROR | Part.GROUND_TRUTH | Part.COMPARED | Part.INFOS | Part.SELECTION
    parts |= Part.REGION | Part.MARKS
    deferred = Part.SOME_RESULTS | Part.PREVIEWS
    what = "computation of statistics"

    def __init__(self, context: Context) -> None:
        self._place: Point | None = None
        """The place of the marked sample of the profile, in image coordinates."""
        self._deleted: WeakKeyDictionary[Document, tuple[Line, ...]] = WeakKeyDictionary()
        self._marks = [Marks(cell.view) for cell in context.views.cells.values()]
        super().__init__(context)
        shown = Part.FRAME | Part.REGION | Part.MARKS
        also = context.editor.tool_changed, context.centre.turned
        context.refresh.add("inspect marks", self._show_marks, shown, also=also)

    def make(self) -> QWidget:
        self.pages = QTabWidget(documentMode=True)
        self.pages.setAccessibleName("Inspection")
        self.profile = ProfilePage(self._buttons("tool_profile", "save_profile", "save_profile_picture"))
        self.profile.pointed.connect(self._point)
        self.pages.addTab(self.profile, "Profile")
        self.pages.addTab(self._statistics_page(), "Statistics")
        self.pages.addTab(self._measurements_page(), "Measurements")
        self.pages.setMinimumSize(240, 120)
        self.pages.currentChanged.connect(lambda _: self.redraw())
        self.context.feature(ErrorFeature).watch(self.profile.plot.isVisible)
        self.views.cursorMoved.connect(lambda _: self._hover())
        self.context.refresh.add("profile place", self._follow, NO_PART)
        return self.pages

    def _buttons(self, *commands: str) -> list[QToolButton]:
        return [command_button(self.context.actions[command]) for command in commands]

    def _statistics_page(self) -> QWidget:
        hint = "Statistics of the selected block, or of the rectangle if there is one"
        self.subject = combo(["Selected block", "Rectangle"], hint, "Region of the statistics")
        self.subject.activated.connect(self.redraw)
        self.subject_name = ElidedLabel()
        self.statistics = NumberTable("Statistics of raw depth and result", COLUMNS)
        self.statistics_note = Message()
        name, buttons = self.subject_name, self._buttons("tool_rectangle", "copy_statistics")
        row = lay_out(QHBoxLayout(), self.subject, name, *buttons, spacing=3, stretched=name)
        return page(row, self.statistics_note, self.statistics)

    def _measurements_page(self) -> QWidget:
        self.measurements_note = Message()
        self.measurements = NumberTable("Measurements", _MEASURED)
        self.measurements.setToolTip("Measurements; Delete removes the selected ones, or all")
        delete = QShortcut(QKeySequence(Qt.Key.Key_Delete), self.measurements, self._delete_measurements)
        delete.setContext(Qt.ShortcutContext.WidgetShortcut)
        commands = "tool_measure", "copy_measurements", "save_measurements", "delete_measurements"
        return page(
            lay_out(QHBoxLayout(), None, *self._buttons(*commands), spacing=3),
            self.measurements_note,
            self.measurements,
        )

    def refresh(self, parts: Part) -> None:
        document = self.workspace.shown
        if parts & (Part.FRAME | Part.REGION):
            self.subject.setCurrentIndex(int(self._looked.region is not None))
        if parts & Part.FRAME:
            self.requests.forget()
            self.statistics.set_rows([])
        if self.pages.currentIndex() == PROFILE:
            self._plot(document)
        elif self.pages.currentIndex() == MEASUREMENTS:
            self._list_measurements(document)
        elif not parts or parts & _OF_STATISTICS:
            self._ask_statistics(document)

    def reveal_page(self, number: int) -> None:
        """Open the panel at a page."""
        self.reveal()
        self.pages.setCurrentIndex(number)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Draw the marks of the panel when it is opened and closed."""
        if watched is self.widget and event.type() in (QEvent.Type.Show, QEvent.Type.Hide):
            self.context.refresh.mark("inspect marks")
        return super().eventFilter(watched, event)

    def _depth(self, document: Document) -> NDArray[np.float32] | None:
        """Return completed depth as the views show it: the current one, or that of the iteration being viewed."""
        viewed_iteration = self.workspace.viewed_iteration
        return document.current_depth() if viewed_iteration is None else viewed_iteration.depth

    def _iteration_note(self) -> str:
        """Describe the iteration being viewed; "" for the current result."""
        viewed_iteration = self.workspace.viewed_iteration
        return "" if viewed_iteration is None else f"The result is {viewed_iteration.text}."

    @property
    def _looked(self) -> InspectionState:
        return self.workspace.shown.state.looked if self.workspace.shown is not None else InspectionState()

    # marks over the views, while the panel is open or their tool is selected

    def _show_marks(self) -> None:
        tool, looked = self.context.editor.tool_name, self._looked
        measured = self._measured() if self.visible or tool == "measure" else []
        lines, texts = [line for line, _ in measured], [_distance(found) for _, found in measured]
        if len(lines) > 1:
            texts = [f"{number}: {text}" for number, text in enumerate(texts, 1)]
        line = looked.line if self.visible or tool == "profile" else None
        for marks in self._marks:
            marks.show(line, self._place, looked.region, lines, texts)
        if (cloud := self.context.made(CloudPanel)) is not None:
            cloud.view.canvas.set_lines(lines, texts)
        self.context.refresh.defer("inspect marks", _DEPTH if lines else NO_PART)  # distances follow the depth

    @command("remove_marks", "Remo&ve line and rectangle", icon="ph.x", needs=Need.FRAME)
    def _remove_marks(self) -> None:
        """Remove the profile line and the rectangle."""
        document = self.workspace.current
        document.look(Part.MARKS, line=None)
        document.look(Part.REGION, region=None)

    # profile

    def _plot(self, document: Document | None) -> None:
        line = self._looked.line
        if document is None or line is None:
            self.profile.show_hint(_NO_LINE)
        else:
            data = profile_data(document, line, self.workspace.viewed_iteration)
            self.profile.show_data(data)
            if data.error is None:
                self.context.refresh.mark("error")
        if self.views.navigation.pixel is None:
            self._point(self.profile.sample)
        else:
            self._follow()

    def _hover(self) -> None:
        if self.profile.plot.isVisible():
            self.context.refresh.mark("profile place")

    def _follow(self) -> None:
        """Mark the sample under the mouse while it is on the line in a view."""
        line, data = self._looked.line, self.profile.data
        if line is None or data is None:
            return
        sample = None
        if (pixel := self.views.navigation.pixel) is not None:
            at = pixel[0] + 0.5, pixel[1] + 0.5
            if off_line(at, *line) <= REACH / self.views.transform.scale:
                sample = min(max(round(share_along(at, *line) * (len(data.profile) - 1)), 0), len(data.profile) - 1)
        self.profile.point_at(sample)
        self._point(sample)

    def _point(self, sample: int | None) -> None:
        data, place = self.profile.data, None
        if data is not None and sample is not None:
            place = int(data.profile.columns[sample]) + 0.5, int(data.profile.rows[sample]) + 0.5
        if place != self._place:
            self._place = place
            self.context.refresh.mark("inspect marks")

    @command("save_profile", "Save profile as &table…", icon="ph.table", needs=Need.FRAME)
    def _save_profile(self) -> None:
        """Write the depth along the profile line as CSV."""
        path, data = self._ask_path("Save profile as table", ".csv", "Table (*.csv)"), self.profile.data
        if path and data is not None:
            save(self.notes, path, lambda: write_bytes(path, data.profile.to_csv().encode()))

    @command("save_profile_picture", "Save profile as p&icture…", icon="ph.image", needs=Need.FRAME)
    def _save_picture(self) -> None:
        """Write the plot as PNG or SVG."""
        path = self._ask_path("Save profile as picture", ".png", "PNG picture (*.png);;SVG picture (*.svg)")
        if path:
            content = self.profile.plot.picture(as_svg=path.lower().endswith(".svg"))
            save(self.notes, path, lambda: write_bytes(path, content))

    def _ask_path(self, title: str, suffix: str, kinds: str) -> str:
        self.reveal_page(PROFILE)
        self.context.refresh.now()
        if self.profile.data is None:
            self.notes.show_message("There is no profile to write. Draw a profile line first.")
            return ""
        name = f"{self.workspace.current.name}-profile{suffix}"
        return ask_path(self.context.window, title, name, kinds)

    # statistics

    def _ask_statistics(self, document: Document | None) -> None:
        mask, name = (None, "") if document is None else self._subject(document)
        self.subject_name.setText(name)
        if document is None or mask is None:
            self.requests.forget()
            self.statistics.set_rows([], _NO_SUBJECT)
            _tell(self.statistics_note, "")
            return
        depth = self._depth(document)
        chosen = [label for label in document.selected if label in document.counts()]
        other = document.labels == chosen[1] if len(chosen) > 1 and not self.subject.currentIndex() else None
        result = None if depth is None else depth.copy()  # it changes in place
        frame = document.frame
        self.requests.ask(
            lambda: statistics_of(frame.depth, result, frame.intrinsics, mask, other), self._show_statistics
        )

    def _subject(self, document: Document) -> tuple[Mask | None, str]:
        """Return the region of the statistics, and its name; None without one."""
        region, of_region = document.state.looked.region, self.subject.currentIndex() == 1
        if of_region and region is not None:
            rows, columns = region
            mask = np.zeros(document.frame.shape, bool)
            mask[region] = True
            size = f"{columns.stop - columns.start} × {rows.stop - rows.start} px"
            return mask, f"{size} at x {columns.start}, y {rows.start}"
        chosen = self.workspace.chosen
        if of_region or chosen not in document.counts():
            return None, ""
        return document.labels == chosen, " and ".join(document.info(label).name for label in document.selected[:2])

    def _show_statistics(self, found: tuple[list[NumberRow], list[str]]) -> None:
        rows, notes = found
        self.statistics.set_rows(rows)
        _tell(self.statistics_note, " ".join(filter(None, (*notes, self._iteration_note()))))

    @command("copy_statistics", "Copy &statistics", icon="ph.copy", needs=Need.FRAME)
    def _copy_statistics(self) -> None:
        """Copy the statistics as a tab-separated table."""
        if not self.made or not self.statistics.numbers:
            self.reveal_page(STATISTICS)
            self.notes.show_message(f"There are no statistics. {_NO_SUBJECT}")
            return
        QApplication.clipboard().setText(self.statistics.text())
        self.notes.show_message("Statistics copied.")

    # measurements

    def _measured(self) -> list[tuple[Line, Measured]]:
        """Return all measurements with their points, in the depth that the views show; none without intrinsics."""
        lines = self._looked.measurements
        if not lines or self.workspace.current.frame.intrinsics is None:
            return []
        document = self.workspace.current
        depth = self._depth(document)
        values = document.frame.depth if depth is None else depth
        return [(line, measure(values, line, document.frame.intrinsics)) for line in lines]

    def _list_measurements(self, document: Document | None) -> None:
        rows = []
        for number, (line, measured) in enumerate(self._measured(), 1):
            filled = document is not None and not all(document.frame.known[int(y), int(x)] for x, y in line)
            height = f"{measured.height:+.3f} m" if math.isfinite(measured.height) else UNKNOWN
            hint = "An end point lies on filled depth, not measured depth" if filled else ""
            rows.append(NumberRow(str(number), (_distance(measured), height), hint, is_italic=filled))
        self.measurements.set_rows(rows, _NO_MEASUREMENTS)
        blind = document is not None and document.frame.intrinsics is None
        _tell(self.measurements_note, NEEDS_INTRINSICS if blind else self._iteration_note())

    def _table(self) -> str:
        """Return the measurements as CSV; "" with a message if there are none."""
        measured = self._measured()
        if not measured:
            self.notes.show_message(f"There are no measurements. {_NO_MEASUREMENTS}")
            return ""
        return measurements_csv([line for line, _ in measured], [found for _, found in measured])

    @command("copy_measurements", "&Copy measurements", icon="ph.copy", needs=Need.FRAME)
    def _copy_measurements(self) -> None:
        """Copy the measurements as a tab-separated table."""
        table = self._table()
        if table:
            QApplication.clipboard().setText(table.replace(",", "\t"))
            count = counted(len(self._looked.measurements), "measurement")
            self.notes.show_message(f"Copied {count}.")

    @command("save_measurements", "Save m&easurements…", icon="ph.floppy-disk", needs=Need.FRAME)
    def _save_measurements(self) -> None:
        """Write the measurements as CSV."""
        table = self._table()
        if table:
            name = f"{self.workspace.current.name}-measurements.csv"
            path = ask_path(self.context.window, "Save measurements", name, "Table (*.csv)")
            if path:
                save(self.notes, path, lambda: write_bytes(path, table.encode()))

    @command("delete_measurements", "&Delete measurements", icon="ph.trash", needs=Need.FRAME)
    def _delete_measurements(self) -> None:
        """Delete the measurements selected in the list, or all if none is selected.

        They can be restored.
        """
        lines, chosen = self._looked.measurements, self.measurements.chosen() if self.made else []
        if not lines:
            self.notes.show_message("There are no measurements to delete.")
            return
        self._deleted[self.workspace.current] = lines
        left = [line for number, line in enumerate(lines) if chosen and number not in chosen]
        self.workspace.current.set_measurements(left)
        text = f"Deleted {counted(len(lines) - len(left), 'measurement')}."
        self.notes.offer(text, self.context.actions["restore_measurements"])

    @command("restore_measurements", "Restore measurements", needs=Need.FRAME)
    def _restore_measurements(self) -> None:
        """Restore the measurements that were deleted last."""
        before = self._deleted.pop(self.workspace.current, None)
        if before is None:
            self.notes.show_message("No measurements of this frame have been deleted.")
            return
        later = (one for one in self._looked.measurements if one not in before)
        self.workspace.current.set_measurements([*before, *later])


def _distance(measured: Measured) -> str:
    return metres(measured.distance) if math.isfinite(measured.distance) else "no depth"


def _tell(note: Message, text: str) -> None:
    note.setVisible(bool(text))
    note.show_message(text)
