"""Statistics and measurements of the current frame: computed, shown in their panel, copied, saved and deleted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QApplication

from ilf._runtime.formatting import counted
from ilf._runtime.writing import write_bytes
from ilf.data.camera import Camera
from ilf.errors import InputError
from ilf.evaluation.measuring import (
    NEEDS_INTRINSICS,
    Line,
    Measured,
    angle_between,
    measure,
    measurements_csv,
)
from ilf.evaluation.statistics import PlaneFit, SurfaceStatistics, surface_statistics
from ilf.project.frame_state import Point

from ...state.document import Document
from ...state.inspection import Inspection
from ...widgets.file_choice import ask_path, save
from ...work.latest_request import LatestRequest
from ..context import Context
from .measure_panel import MeasurePanel, metres

# Measurements as rows of a list, and as texts over the views.


def measured_rows(
    lines: Sequence[Line], found: Sequence[Measured], known: NDArray[np.bool_]
) -> list[tuple[str, str, str, bool]]:
    """Return a row per measurement: number, distance, height, and whether an end lies on filled depth; `known`, bool
    (H, W), is True where depth was measured."""
    return [
        (
            f"{number}",
            metres(measured.distance) if math.isfinite(measured.distance) else "no depth",
            f"{measured.height:+.3f} m" if math.isfinite(measured.height) else "–",
            any(not known[math.floor(y), math.floor(x)] for x, y in line),
        )
        for number, (line, measured) in enumerate(zip(lines, found, strict=True), 1)
    ]


def texts_of(lines: Sequence[Line], found: Sequence[Measured]) -> list[tuple[Point, str]]:
    """Return the texts at the middle of every measurement."""
    texts = []
    for number, (((x0, y0), (x1, y1)), measured) in enumerate(zip(lines, found, strict=True), 1):
        name = f"{number}: " if len(lines) > 1 else ""
        length = metres(measured.distance) if math.isfinite(measured.distance) else "no depth"
        texts.append((((x0 + x1) / 2, (y0 + y1) / 2), f"{name}{length}"))
    return texts


# Requests for statistics, and their computation.

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class StatisticsRequest:
    """Request for statistics: depth and regions; its arrays are not changed any more.

    Attributes
    ----------
    raw, result : ndarray of float32, shape (H, W)
        [m]; the second is None if there is no result.
    intrinsics : Camera or None
    subject, other : ndarray of bool, shape (H, W), or None
        Region of the statistics; second block, for the angle between both.
    """

    raw: NDArray[np.float32]
    result: NDArray[np.float32] | None
    intrinsics: Camera | None
    subject: Mask | None
    other: Mask | None


@dataclass(frozen=True)
class StatisticsResult:
    """Computed statistics.

    Attributes
    ----------
    raw, result : SurfaceStatistics or None
        Statistics of the subject.
    angle : float or None
        Angle between the planes of both blocks [degrees]; None if not requested or not defined.
    reason : str
        Why there is no angle.
    """

    raw: SurfaceStatistics | None = None
    result: SurfaceStatistics | None = None
    angle: float | None = None
    reason: str = ""


def find(question: StatisticsRequest) -> StatisticsResult:
    """Compute the requested statistics; called in a worker thread."""
    present = question.raw if question.result is None else question.result

    def of(depth: NDArray[np.float32], mask: Mask) -> SurfaceStatistics:
        return surface_statistics(depth, mask, question.intrinsics)

    raw = result = angle = None
    reason = ""
    if question.subject is not None:
        raw = of(question.raw, question.subject)
        result = None if question.result is None else of(question.result, question.subject)
    if question.other is not None:
        try:
            angle = angle_between(_plane(result or raw), _plane(of(present, question.other)))
        except InputError as error:
            reason = str(error)
    return StatisticsResult(raw, result, angle, reason)


def _plane(found: SurfaceStatistics | None) -> PlaneFit:
    if found is None or found.plane is None:
        raise InputError("There is no plane." if found is None else found.reason)
    return found.plane


_NO_SUBJECT = "Select a block, or draw a rectangle (Ctrl+R)"


class MeasurePresenter(QObject):
    """Presenter of the statistics of the selected block or the rectangle, and of distances, heights and angles.

    Signals
    -------
    found()
        Statistics have been computed.
    failed(object)
        The exception raised during the computation.
    """

    found = Signal()
    failed = Signal(object)

    def __init__(self, context: Context, inspection: Inspection, panel: MeasurePanel) -> None:
        super().__init__(panel)
        self._context = context
        self._workspace = context.workspace
        self._inspection = inspection
        self._panel = panel
        self._of_region = False
        self._numbers: StatisticsResult | None = None
        self._deleted: WeakKeyDictionary[Document, tuple[Line, ...]] = WeakKeyDictionary()
        self._questions = LatestRequest[StatisticsRequest, StatisticsResult](find, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(lambda _, error: self.failed.emit(error))
        panel.subject_requested.connect(self._set_subject)
        self._workspace.blocks.region_changed.connect(self._turn_to_region)
        self._workspace.frames.session_changed.connect(self._turn_to_frame)

    @property
    def busy(self) -> bool:
        """Whether statistics are pending."""
        return self._questions.busy

    def ask(self) -> None:
        """Request the statistics of the selection if the panel is visible."""
        if not self._panel.isVisible():
            return
        document = self._workspace.current if self._workspace.has_current else None
        if document is None:
            self._panel.show_subject(False, "")
            self._panel.show_statistics(None, None, "")
            return
        self._panel.show_subject(self._of_region, self._subject_name(document))
        subject = self._subject(document)
        if subject is None:
            self._questions.forget()
            self._numbers = None
            self._panel.show_statistics(None, None, _NO_SUBJECT)
            return
        depth = self._depth(document)
        self._questions.ask(
            StatisticsRequest(
                document.frame.depth,
                None if depth is None else depth.copy(),  # it changes in place
                document.frame.intrinsics,
                subject,
                self._other(document),
            )
        )

    def show(self) -> None:
        """Show the measurements."""
        if self._panel.isVisible() and self._workspace.has_current:
            document = self._workspace.current
            lines, found = self.measured()
            message = "" if document.frame.intrinsics is not None else NEEDS_INTRINSICS
            self._panel.show_measured(
                measured_rows(lines, found, document.frame.known), message or self._iteration_text()
            )

    def texts(self) -> list[tuple[Point, str]]:
        """Return the distances to write over the views."""
        return texts_of(*self.measured())

    def measured(self) -> tuple[Sequence[Line], list[Measured]]:
        """Return all measurements with their points, in the depth that the views show."""
        if not self._workspace.has_current or self._workspace.current.frame.intrinsics is None:
            return (), []
        document, lines = self._workspace.current, self._inspection.measurements
        depth = self._depth(document) if lines else None
        values = document.frame.depth if depth is None else depth
        return lines, [measure(values, line, document.frame.intrinsics) for line in lines]

    def copy_statistics(self) -> None:
        """Copy the statistics to the clipboard as a tab-separated table."""
        if self._numbers is None or self._numbers.raw is None:
            self._context.notes.show_message(f"There are no statistics. {_NO_SUBJECT}.")
            return
        QApplication.clipboard().setText(self._panel.statistics.as_text())
        self._context.notes.show_message("Statistics copied.")

    def copy(self) -> None:
        """Copy the measurements to the clipboard as a tab-separated table."""
        table = self._table()
        if table:
            QApplication.clipboard().setText(table.replace(",", "\t"))
            self._context.notes.show_message(f"Copied {counted(len(self._inspection.measurements), 'measurement')}.")

    def save(self) -> None:
        """Write the measurements to a CSV file that the user chooses."""
        table = self._table()
        if table:
            name = f"{self._workspace.current.name}-measurements.csv"
            path = ask_path(self._context.window, "Save measurements", name, "Table (*.csv)")
            if path:
                save(self._context.notes, path, lambda: write_bytes(path, table.encode()))

    def delete(self) -> None:
        """Delete the measurements selected in the list, or all; they can be restored."""
        lines = self._inspection.measurements
        chosen = self._panel.chosen() or set(range(len(lines)))
        if not lines:
            self._context.notes.show_message("There are no measurements to delete.")
            return
        self._deleted[self._workspace.current] = lines
        self._inspection.set_measurements([line for number, line in enumerate(lines) if number not in chosen])
        text = f"Deleted {counted(len(chosen), 'measurement')}."
        self._context.notes.offer(text, self._context.actions["restore_measurements"])

    def restore(self) -> None:
        """Restore the measurements that were deleted last."""
        before = self._deleted.pop(self._workspace.current, None) if self._workspace.has_current else None
        if before is None:
            self._context.notes.show_message("No measurements of this frame have been deleted.")
            return
        later = (one for one in self._inspection.measurements if one not in before)
        self._inspection.set_measurements([*before, *later])

    def _table(self) -> str:
        lines, found = self.measured()
        if not lines:
            self._context.notes.show_message(
                "There are no measurements. Select the tool Measure (Ctrl+D) and click two points."
            )
            return ""
        return measurements_csv(lines, found)

    def _take(self, question: StatisticsRequest, numbers: StatisticsResult) -> None:
        self._numbers = numbers
        notes = [found.reason for found in (numbers.raw, numbers.result) if found is not None and found.reason]
        if numbers.angle is not None:
            notes.insert(0, f"Angle between the planes of both selected blocks: {numbers.angle:.1f}°")
        if numbers.reason:
            notes.append(numbers.reason)
        notes.append(self._iteration_text())
        self._panel.show_statistics(numbers.raw, numbers.result, " ".join(filter(None, dict.fromkeys(notes))))
        self.found.emit()

    def _depth(self, document: Document) -> NDArray[np.float32] | None:
        """Return completed depth as the views show it: the current one, or that of the iteration being viewed."""
        viewed_iteration = self._workspace.viewed_iteration
        return document.current_depth() if viewed_iteration is None else viewed_iteration.depth

    def _iteration_text(self) -> str:
        """Describe the iteration being viewed; "" for the current result."""
        viewed_iteration = self._workspace.viewed_iteration
        return "" if viewed_iteration is None else f"The result is {viewed_iteration.text}."

    def _subject(self, document: Document) -> Mask | None:
        if self._of_region and document.state.looked.region is not None:
            mask = np.zeros(document.frame.shape, bool)
            mask[document.state.looked.region] = True
            return mask
        chosen = self._workspace.chosen
        return None if self._of_region or chosen not in document.counts() else document.labels == chosen

    def _other(self, document: Document) -> NDArray[np.bool_] | None:
        """Return the mask of the second selected block, None if there is none."""
        chosen = [label for label in document.selected if label in document.counts()]
        return document.labels == chosen[1] if len(chosen) > 1 and not self._of_region else None

    def _subject_name(self, document: Document) -> str:
        if self._of_region and document.state.looked.region is not None:
            rows, columns = document.state.looked.region
            size = f"{columns.stop - columns.start} × {rows.stop - rows.start} px"
            return f"{size} at x {columns.start}, y {rows.start}"
        chosen = self._workspace.chosen
        if self._of_region or not chosen:
            return ""
        two = [document.info(label).name for label in document.selected[:2]]
        return " and ".join(two)

    def _set_subject(self, of_region: bool) -> None:
        self._of_region = of_region
        self.ask()

    def _turn_to_frame(self) -> None:
        """Discard the statistics of the previous frame."""
        self._numbers = None
        self._questions.forget()
        self._turn_to_region()

    def _turn_to_region(self) -> None:
        """Show statistics of the rectangle if there is one."""
        self._of_region = self._workspace.has_current and self._workspace.current.state.looked.region is not None
