"""Depth of neighbours of a frame: dialog to use it, and command to remove it."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from PySide6.QtCore import QSettings, Qt
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QPushButton,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import millimetres
from ilf.data.frame import RGBDFrame
from ilf.data.neighbours import NeighbourDepth
from ilf.evaluation.hold_out import HoldOutResult, comparison_steps
from ilf.run.run import Run
from ilf.sources.frame_ref import FrameRef
from ilf.sources.neighbours import around, neighbour_steps

from ..base.commands import Command
from ..base.needs import Need
from ..state.document import Document
from ..state.entries import Entry
from ..widgets.basics import Message
from ..widgets.notices import error_text
from ..widgets.work_row import WorkRow
from ..work.jobs import Worker, spare_cores
from .context import Context, Feature
from .documents.file_dialogs import Preview
from .sequence.moments import place_of

Sides = tuple[Sequence[FrameRef], Sequence[FrameRef]]
"""Frames before a frame and after it, the nearest first."""

# The dialog: how many neighbours, how far apart, and what they add.

_COUNT_KEY, _STEP_KEY = "neighbours/count", "neighbours/step"
_COUNT, _MAX_COUNT, _STEP = 2, 10, 1


class NeighboursDialog(QDialog):
    """Dialog to use depth of neighbours. It is found whenever a number changes; *Use* is enabled once it is there.

    Parameters
    ----------
    session : Session
        The frame, with its blocks for the hold-out test.
    sides : Sides
        The other frames of its sequence.
    worker : Worker
        Finds the depth, and tests it.

    Attributes
    ----------
    found : NeighbourDepth or None
    """

    def __init__(self, document: Document, sides: Sides, worker: Worker, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Use Neighbours of {document.name}")
        self.found: NeighbourDepth | None = None
        self.note = ""
        """What was found, and which frames were left out."""
        self._frame, self._run, self._sides, self._worker = (
            document.frame,
            document.run(document.state.common),
            sides,
            worker,
        )
        self._waiting: tuple[Callable[[], Generator[Any, None, Any]], Callable[[Any], None]] | None = None
        self._take: Callable[[Any], None] | None = None
        """What takes the result of the work in progress; None once it is cancelled."""
        reach = max(map(len, sides))
        settings = QSettings()
        self.count, self.step = (
            QSpinBox(minimum=1, maximum=most, value=int(str(settings.value(key, usual, int))))
            for key, usual, most in ((_COUNT_KEY, _COUNT, min(_MAX_COUNT, reach)), (_STEP_KEY, _STEP, reach))
        )
        self.count.setToolTip("Number of frames before this one, and as many after it, whose depth is used")
        self.step.setToolTip("Use every so many frames: a camera that moves slowly shows more from frames farther away")
        for number in (self.count, self.step):
            number.setKeyboardTracking(False)
            number.valueChanged.connect(lambda _: self.search())
        self.before, self.after = Preview("Depth in"), Preview("With depth of neighbours")
        self.before.show_depth(self._frame.own_depth)
        self.message, self.errors = Message(lines=3), Message(lines=2)
        self.work = WorkRow("search for depth of neighbours", "the frame stays as it is")
        self.test_button = QPushButton("&Hold-out test", autoDefault=False)
        self.test_button.setToolTip("Hide known depth, complete the blocks with neighbours and without, and compare")
        self.test_button.clicked.connect(self.test)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel)
        self.use_button = buttons.button(QDialogButtonBox.StandardButton.Ok)
        self.use_button.setText("&Use")
        self.use_button.setToolTip("Use this depth in the next runs")
        buttons.button(QDialogButtonBox.StandardButton.Cancel).setText("Close")  # the work has a button Cancel
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        buttons.addButton(self.test_button, QDialogButtonBox.ButtonRole.ActionRole)
        self._lay_out(buttons)
        worker.progressed.connect(self._show_progress)
        worker.finished.connect(self._finish)
        worker.failed.connect(self._fail)
        worker.cancelled.connect(self._go_on)
        self.work.cancelled.connect(self._cancel)
        self.search()

    def _lay_out(self, buttons: QDialogButtonBox) -> None:
        form = QFormLayout()
        form.addRow("Frames &before and after", self.count)
        form.addRow("Every so &many frames", self.step)
        pictures = QHBoxLayout()
        pictures.setSpacing(12)
        pictures.addWidget(self.before)
        pictures.addWidget(self.after)
        column = QVBoxLayout(self)
        column.setContentsMargins(14, 14, 14, 14)
        column.setSpacing(12)
        column.addLayout(form)
        column.addLayout(pictures)
        for part in (self.message, self.errors, self.work):
            column.addWidget(part)
        column.addStretch(1)
        column.addWidget(buttons)

    def search(self) -> None:
        """Find the depth of these neighbours."""
        self.found = None
        self.after.show_depth(None)
        self.errors.show_message("")
        count, step = self.count.value(), self.step.value()
        before, after = (side[: count * step] for side in self._sides)
        self.message.show_message("Reading the neighbours…")
        self._start(lambda: neighbour_steps(self._frame, before, after, step=step), self._take_found)

    def test(self) -> None:
        """Compare the errors of hidden depth with neighbours and without."""
        runs = [replace(self._run, frame=self._frame.with_neighbours(one)) for one in (None, self.found)]
        self.errors.show_message("Testing on hidden depth…")
        self._start(lambda: _test_steps(runs), self._take_errors)

    def accept(self) -> None:
        QSettings().setValue(_COUNT_KEY, self.count.value())
        QSettings().setValue(_STEP_KEY, self.step.value())
        super().accept()

    def done(self, result: int) -> None:
        self._waiting = self._take = None
        self._worker.cancel()
        super().done(result)

    def _start(self, make: Callable[[], Generator[Any, None, Any]], take: Callable[[Any], None]) -> None:
        """Start work in place of that in progress."""
        self._waiting, self._take = (make, take), None
        self._enable()
        self.work.begin()
        if self._worker.busy:
            self._worker.cancel()
        else:
            self._go_on()

    def _go_on(self) -> None:
        """Start the work that waits for the end of the former one."""
        if self._waiting is not None:
            (make, self._take), self._waiting = self._waiting, None
            self._worker.start(make)

    def _show_progress(self, shares: Sequence[float]) -> None:
        if self._take is not None:
            self.work.show_share(shares[-1])

    def _finish(self, result: Any) -> None:
        take, self._take = self._take, None
        if take is not None:
            self.work.end()
            take(result)
            self._enable()

    def _fail(self, error: Exception) -> None:
        if self._take is not None:
            message = self.message if self.found is None else self.errors
            message.show_message(error_text(error), "error")
            self._end()

    def _cancel(self) -> None:
        """Cancel the work at the user's request."""
        if self.found is None:
            self.message.show_message("Cancelled. Change a number to search again.", "warning")
        else:
            self.errors.show_message("Cancelled.")
        self._waiting = None
        self._end()
        self._worker.cancel()

    def _end(self) -> None:
        self._take = None
        self.work.end()
        self._enable()

    def _take_found(self, frame: RGBDFrame) -> None:
        self.note = frame.notes[-1]
        some = frame.from_neighbours is not None
        self.found = frame.neighbours if some else None
        self.after.show_depth(frame.depth)
        self.message.show_message(self.note, "good" if some else "warning")

    def _take_errors(self, results: Sequence[HoldOutResult]) -> None:
        alone, together = (result.whole for result in results)
        was, now = (f"{millimetres(one.mae)} mm (RMSE {millimetres(one.rmse)})" for one in (alone, together))
        self.errors.show_message(
            f"Mean error of hidden depth, at {together.pixels:,} pixels: {was} without neighbours, {now} with them.",
            "good" if together.mae < alone.mae else "warning",
        )

    def _enable(self) -> None:
        idle = self._take is None and self._waiting is None
        self.use_button.setEnabled(self.found is not None)
        self.test_button.setEnabled(idle and self.found is not None and bool(np.any(self._run.blocks.labels)))


def _test_steps(runs: Sequence[Run]) -> Generator[float, None, list[HoldOutResult]]:
    steps = comparison_steps(runs, threads=spare_cores())
    while True:
        try:
            yield next(steps).share
        except StopIteration as end:
            results: list[HoldOutResult] = end.value
            return results


# The commands.


class NeighboursFeature(Feature):
    """The commands on depth of neighbours."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        context.actions.add(
            (
                Command(
                    "use_neighbours",
                    "Use &neighbours…",
                    "Use depth that the frames before and after have measured where this one has none",
                    icon="ph.stack",
                    handler=self.ask,
                    needs=Need.FRAME,
                    why_off=self._why_off,
                ),
                Command(
                    "remove_neighbours",
                    "Remove depth of neighbours",
                    "Complete the frame with its own depth alone",
                    icon="ph.x-circle",
                    handler=self.remove,
                    needs=Need.NEIGHBOURS,
                ),
            )
        )
        self._worker = Worker(self)

    def ask(self) -> None:
        """Use depth of neighbours in the current frame by the dialog."""
        document = self.context.workspace.current
        dialog = NeighboursDialog(document, self._sides(), self._worker, self.context.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._take(document, dialog.found, dialog.note))
        dialog.open()

    def remove(self) -> None:
        """Complete the current frame without depth of neighbours."""
        self.context.workspace.current.set_neighbours(None, "Remove depth of neighbours")
        self.context.notes.show_message("Depth of neighbours removed.")

    def _take(self, document: Document, found: NeighbourDepth | None, note: str) -> None:
        workspace = self.context.workspace
        if document not in workspace.open or found is None:
            return
        workspace.show(document)  # another frame may have been opened meanwhile
        workspace.current.set_neighbours(found, "Use neighbours")
        self.context.notes.show_message(f"{document.name}: {note}")

    def _sides(self) -> Sides:
        """The other frames of the current frame's folder or recording."""
        entry, place = self._entry(), place_of(self._entry())
        same = [one for one in self.context.workspace.entries if place_of(one) == place]
        return around([one.source for one in same if one.source is not None], same.index(entry), len(same))

    def _entry(self) -> Entry:
        entry = self.context.workspace.entries.of(self.context.workspace.current.id)
        assert entry is not None  # every open frame is in the list
        return entry

    def _why_off(self) -> str:
        entry, place = self._entry(), place_of(self._entry())
        others = (one for one in self.context.workspace.entries if one is not entry)
        if place is None or all(place_of(one) != place for one in others):
            return "The list has no other frame of this sequence: open its folder or recording."
        if self.context.workspace.current.frame.intrinsics is None:
            return "The camera's intrinsics of this frame are not known: open it with intrinsics."
        return ""
