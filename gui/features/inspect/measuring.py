"""Brings statistics and measurements of the present frame to their panel, and takes measurements away."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QApplication

from ilf._runtime.files import write_bytes
from ilf.data.camera import CameraIntrinsics
from ilf.errors import InputError
from ilf.evaluation.measuring import CAMERA_UP, NEEDS_CAMERA, Measured, angle_between, measure, measurements_csv
from ilf.evaluation.statistics import PlaneFit, SurfaceStatistics, surface_statistics

from ...state.inspection import Inspection
from ...state.session import Point, Session
from ...work.latest_question import LatestQuestion
from ..context import Desk
from ..documents.file_dialogs import ask_path, save
from .measure_panel import MeasuredRow, MeasurePanel, degrees, metres

# What has been measured: as rows of a list, as texts over the pictures, as a table for other programs.

Chain = Sequence[Point]
Length = tuple[Point, str]
Angle = tuple[Point, Point, str]


def measured_rows(chains: Sequence[Chain], found: Sequence[Measured], known: NDArray[np.bool_]) -> list[MeasuredRow]:
    """A row for every stretch; `known`, bool (H, W), says where depth was measured."""
    rows = []
    for number, (chain, measured) in enumerate(zip(chains, found, strict=True)):
        several = len(chain) > 2
        for n, (distance, height) in enumerate(zip(measured.distances, measured.heights, strict=True)):
            ends = (chain[n], chain[n + 1])
            rows.append(
                MeasuredRow(
                    number,
                    f"{number + 1}.{n + 1}" if several else f"{number + 1}",
                    metres(distance) if math.isfinite(distance) else "no depth",
                    f"{height:+.3f} m" if math.isfinite(height) else "–",
                    degrees(measured.angles[n]) if n else "",
                    any(not known[math.floor(y), math.floor(x)] for x, y in ends),
                )
            )
        if several:
            rows.append(MeasuredRow(number, f"{number + 1}  all", metres(measured.length), "", "", False))
    return rows


def texts_of(chains: Sequence[Chain], found: Sequence[Measured]) -> tuple[list[Length], list[Angle]]:
    """What is written at the middle of every stretch, and what at every corner, outside of it."""
    lengths: list[Length] = []
    angles: list[Angle] = []
    for number, (chain, measured) in enumerate(zip(chains, found, strict=True)):
        for n, distance in enumerate(measured.distances):
            name = f"{number + 1}: " if n == 0 and len(chains) > 1 else ""
            length = metres(distance) if math.isfinite(distance) else "no depth"
            lengths.append((_middle(chain[n], chain[n + 1]), f"{name}{length}"))
        for n in range(1, len(chain) - 1):
            if math.isfinite(measured.angles[n]):
                angles.append((chain[n], _middle(chain[n - 1], chain[n + 1]), degrees(measured.angles[n])))
    return lengths, angles


def _middle(one: Point, other: Point) -> Point:
    return (one[0] + other[0]) / 2, (one[1] + other[1]) / 2


# Statistics that are asked for, and how they are found.

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Question:
    """Depth, and where statistics of it are wanted; nobody changes its arrays any more.

    Attributes
    ----------
    raw, result : ndarray of float32, shape (H, W)
        [m]; the second is None if there is no result.
    intrinsics : CameraIntrinsics or None
    subject, other, reference : ndarray of bool, shape (H, W), or None
        What statistics are of; a second block, for the angle between the two; the block that heights are measured over.
    """

    raw: NDArray[np.float32]
    result: NDArray[np.float32] | None
    intrinsics: CameraIntrinsics | None
    subject: Mask | None
    other: Mask | None
    reference: Mask | None


@dataclass(frozen=True)
class Numbers:
    """What has been found.

    Attributes
    ----------
    raw, result : SurfaceStatistics or None
        Of the subject.
    angle : float or None
        Between the planes of both blocks [degrees]; None if they were not asked for or have none.
    up : (float, float, float) or None
        Normal of the reference; None if it has none.
    why : str
        Why there is no angle, or no normal.
    """

    raw: SurfaceStatistics | None = None
    result: SurfaceStatistics | None = None
    angle: float | None = None
    up: tuple[float, float, float] | None = None
    why: str = ""


def find(question: Question) -> Numbers:
    """Answer a question, off the GUI's thread."""
    present = question.raw if question.result is None else question.result

    def of(depth: NDArray[np.float32], mask: Mask) -> SurfaceStatistics:
        return surface_statistics(depth, mask, question.intrinsics)

    raw = result = angle = up = None
    why = ""
    if question.subject is not None:
        raw = of(question.raw, question.subject)
        result = None if question.result is None else of(question.result, question.subject)
    if question.other is not None:
        try:
            angle = angle_between(_plane(result or raw), _plane(of(present, question.other)))
        except InputError as error:
            why = str(error)
    if question.reference is not None:
        try:
            up = _plane(of(present, question.reference)).normal
        except InputError as error:
            why = str(error)
    return Numbers(raw, result, angle, up, why)


def _plane(found: SurfaceStatistics | None) -> PlaneFit:
    if found is None or found.plane is None:
        raise InputError("There is no plane." if found is None else found.reason)
    return found.plane


_NO_SUBJECT = "Choose a block, or draw a rectangle (Ctrl+R)"


class MeasurePresenter(QObject):
    """Statistics of the chosen block, or of the rectangle if there is one; distances, heights and angles.

    Signals
    -------
    found()
        Numbers have come.
    failed(object)
        The exception that kept them from being found.
    """

    found = Signal()
    failed = Signal(object)

    def __init__(self, desk: Desk, inspection: Inspection, panel: MeasurePanel) -> None:
        super().__init__(panel)
        self._desk = desk
        self._workspace = desk.workspace
        self._inspection = inspection
        self._measurements = inspection.measurements
        self._panel = panel
        self._of_region = False
        self._numbers: Numbers | None = None
        self._deleted: WeakKeyDictionary[Session, list[tuple[Point, ...]]] = WeakKeyDictionary()
        self._questions = LatestQuestion[Question, Numbers](find, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(lambda _, error: self.failed.emit(error))
        panel.subject_wished.connect(self._set_subject)
        panel.reference_wished.connect(self._set_reference)
        self._workspace.region_changed.connect(self._turn_to_region)
        self._workspace.session_changed.connect(self._turn_to_frame)

    @property
    def busy(self) -> bool:
        """Whether numbers are to come."""
        return self._questions.busy

    def ask(self) -> None:
        """Have the statistics of what is chosen worked out, for those who look at them."""
        if not self._panel.isVisible():
            return
        session = self._workspace.session if self._workspace.has_session else None
        if session is None:
            self._panel.show_subject(False, "")
            self._panel.show_statistics(None, None, "")
            return
        self._panel.show_subject(self._of_region, self._subject_name(session))
        reference = self._measurements.reference
        self._panel.show_reference(session.info(reference).name if reference else "")
        subject = self._subject(session)
        if subject is None and not reference:
            self._questions.forget()
            self._numbers = None
            self._panel.show_statistics(None, None, _NO_SUBJECT)
            return
        depth = self._depth(session)
        self._questions.ask(
            Question(
                session.frame.depth,
                None if depth is None else depth.copy(),  # it changes in place
                session.frame.intrinsics,
                subject,
                self._other(session),
                session.labels == reference if reference else None,
            )
        )

    def show(self) -> None:
        """Write what has been measured."""
        if self._panel.isVisible() and self._workspace.has_session:
            session = self._workspace.session
            chains, found = self.measured()
            message = "" if session.frame.intrinsics is not None else NEEDS_CAMERA
            self._panel.show_measured(measured_rows(chains, found, session.frame.known), message or self._moment())

    def texts(self) -> tuple[list[Length], list[Angle]]:
        """Lengths and angles that are written over the pictures."""
        return texts_of(*self.measured())

    def measured(self) -> tuple[list[Chain], list[Measured]]:
        """All measurements with their points, in the depth that the views show."""
        if not self._workspace.has_session or self._workspace.session.frame.intrinsics is None:
            return [], []
        session, chains = self._workspace.session, self._measurements.chains
        depth = self._depth(session) if chains else None
        values = session.frame.depth if depth is None else depth
        up = CAMERA_UP if not self._measurements.reference else self._numbers.up if self._numbers else None
        found = [measure(values, chain, session.frame.intrinsics, up or CAMERA_UP) for chain in chains]
        if up is None:  # the plane has not been found yet, or there is none
            found = [replace(one, heights=np.full_like(one.heights, np.nan)) for one in found]
        return list(chains), found

    def copy_statistics(self) -> None:
        """Put the statistics on the clipboard, as a table that spreadsheets take."""
        if self._numbers is None or self._numbers.raw is None:
            self._desk.notes.tell(f"There are no statistics. {_NO_SUBJECT}.")
            return
        QApplication.clipboard().setText(self._panel.statistics.as_text())
        self._desk.notes.tell("Copied the statistics.")

    def copy(self) -> None:
        """Put the measurements on the clipboard, as a table that spreadsheets take."""
        table = self._table()
        if table:
            QApplication.clipboard().setText(table.replace(",", "\t"))
            self._desk.notes.tell(f"Copied {len(self._measurements.chains)} measurements.")

    def save(self) -> None:
        """Write the measurements to a CSV file that the user chooses."""
        table = self._table()
        if table:
            name = f"{self._workspace.session.name}-measurements.csv"
            path = ask_path(self._desk.window, "Save measurements", name, "Table (*.csv)")
            if path:
                save(self._desk.notes, path, lambda: write_bytes(path, table.encode()))

    def delete(self) -> None:
        """Delete the measurements that are chosen in the list, or all; they can be taken back."""
        chains = self._measurements.chains
        chosen = self._panel.chosen() or set(range(len(chains)))
        if not chains:
            self._desk.notes.tell("There are no measurements to delete.")
            return
        self._deleted[self._workspace.session] = chains
        self._measurements.replace([chain for number, chain in enumerate(chains) if number not in chosen])
        text = f"Deleted {len(chosen)} measurement{'s' * (len(chosen) != 1)}."
        self._desk.notes.offer(text, self._desk.actions["restore_measurements"])

    def restore(self) -> None:
        """Have the measurements that were deleted last again."""
        before = self._deleted.pop(self._workspace.session, None) if self._workspace.has_session else None
        if before is None:
            self._desk.notes.tell("No measurements of this frame have been deleted.")
            return
        self._measurements.replace([*before, *(one for one in self._measurements.chains if one not in before)])

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if the thread has ended."""
        return self._questions.shutdown()

    def _table(self) -> str:
        chains, found = self.measured()
        if not chains:
            self._desk.notes.tell("There are no measurements. Choose the tool (Ctrl+D) and click on two points.")
            return ""
        return measurements_csv(zip(chains, found, strict=True))

    def _take(self, question: Question, numbers: Numbers) -> None:
        self._numbers = numbers
        notes = [found.reason for found in (numbers.raw, numbers.result) if found is not None and found.reason]
        if numbers.angle is not None:
            notes.insert(0, f"Angle between the planes of both chosen blocks: {numbers.angle:.1f}°")
        if question.subject is None:
            notes.insert(0, _NO_SUBJECT)
        if numbers.why:
            notes.append(numbers.why)
        notes.append(self._moment())
        self._panel.show_statistics(numbers.raw, numbers.result, " ".join(filter(None, dict.fromkeys(notes))))
        self.found.emit()

    def _depth(self, session: Session) -> NDArray[np.float32] | None:
        """Completed depth as the views show it: now, or in the past."""
        past = self._workspace.past
        return session.present_depth() if past is None else past.depth

    def _moment(self) -> str:
        """When that was."""
        past = self._workspace.past
        return "" if past is None else f"The result is {past.text}."

    def _subject(self, session: Session) -> Mask | None:
        if self._of_region and session.region is not None:
            mask = np.zeros(session.frame.shape, bool)
            mask[session.region] = True
            return mask
        chosen = self._workspace.chosen
        return None if self._of_region or chosen not in session.counts() else session.labels == chosen

    def _other(self, session: Session) -> NDArray[np.bool_] | None:
        """The second chosen block."""
        chosen = [label for label in session.selected if label in session.counts()]
        return session.labels == chosen[1] if len(chosen) > 1 and not self._of_region else None

    def _subject_name(self, session: Session) -> str:
        if self._of_region and session.region is not None:
            rows, columns = session.region
            size = f"{columns.stop - columns.start} × {rows.stop - rows.start} px"
            return f"{size} at x {columns.start}, y {rows.start}"
        chosen = self._workspace.chosen
        if self._of_region or not chosen:
            return ""
        two = [session.info(label).name for label in session.selected[:2]]
        return " and ".join(two)

    def _set_subject(self, of_region: bool) -> None:
        self._of_region = of_region
        self.ask()

    def _set_reference(self, of_block: bool) -> None:
        chosen = self._workspace.chosen
        if of_block and not chosen:
            self._desk.notes.tell("Choose the block first whose plane heights are to be measured over.")
        self._measurements.set_reference(chosen if of_block else 0)
        self.ask()

    def _turn_to_frame(self) -> None:
        """What was found is of the frame before."""
        self._numbers = None
        self._questions.forget()
        self._turn_to_region()

    def _turn_to_region(self) -> None:
        """Who draws a rectangle wants to know of it."""
        self._of_region = self._workspace.has_session and self._workspace.session.region is not None
