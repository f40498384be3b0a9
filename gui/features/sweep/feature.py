"""The sweep: many values of one or two parameters, each evaluated and shown; a click applies one."""

from __future__ import annotations

from functools import cached_property

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QMenu

from ilf.data.parameters import Parameters
from ilf.errors import IlfError
from ilf.evaluation.evaluation import Progress
from ilf.evaluation.sweep import Sweep, SweepPoint, SweepResult, can_be_swept, sweep_steps

from ...work.frame_runs import RunState
from ...work.jobs import Worker, spare_cores
from ..context import Context, Feature, PendingWork
from ..filter.feature import FilterFeature
from .state import SweepState
from .window import SweepWindow


class SweepFeature(Feature):
    """Runs sweeps in the background, one at a time, and shows the results in their window."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._filter = context.feature(FilterFeature)
        self.found: SweepState | None = None
        self.worker = Worker(self)
        self.worker.progressed.connect(self._take_steps)
        self.worker.finished.connect(self._finish)
        self.worker.failed.connect(self._fail)
        self.worker.cancelled.connect(lambda: self.window_.end("Cancelled. Results so far are kept."))
        workspace = context.workspace
        turned, values, chosen = (
            workspace.frames.session_changed,
            workspace.parameters.changed,
            workspace.blocks.selection_changed,
        )
        frame = turned, values, chosen, workspace.blocks.infos_changed, workspace.blocks.ground_truth_changed
        context.refresh.add("sweep", self.show, (*frame, context.views.ranges.changed))
        workspace.frames.sessions_changed.connect(self._cancel_closed)

    @cached_property
    def window_(self) -> SweepWindow:
        """The window, created on first use."""
        window, mark = SweepWindow(self.context.window), self.context.refresh.mark
        window.begun.connect(self.start)
        window.cancelled.connect(self.worker.cancel)
        window.taken.connect(self.take)
        window.criterion.changed.connect(lambda: mark("sweep"))
        window.became_visible.connect(lambda: mark("sweep"))
        return window

    @property
    def _is_visible(self) -> bool:
        return "window_" in vars(self) and self.window_.isVisible()

    def open(self, name: str = "") -> None:
        """Open the window, with a parameter if one is given."""
        if not self.context.workspace.has_current:
            return
        self.window_.show()
        self.window_.raise_()
        self.window_.activateWindow()
        self.show()
        if name and not self.worker.busy:
            if self._filter.panel.for_selected:
                self.window_.criterion.blocks.setCurrentIndex(1)
                self.show()
            self.window_.choose(name)

    def show(self) -> None:
        """Update the window for the current frame, if it is visible."""
        workspace = self.context.workspace
        if not self._is_visible or not workspace.has_current:
            return
        document, chosen = workspace.current, workspace.chosen
        name = document.info(chosen).name if chosen else ""
        for_selected = bool(chosen) and self.window_.criterion.for_selected
        parameters = document.parameters_of(chosen) if for_selected else workspace.parameters.current
        self.window_.set_frame(parameters, document.frame.ground_truth is not None, name)
        self.window_.set_colour_map(self.context.views.ranges.depth_map)

    def start(self) -> None:
        """Start a sweep with the settings of the window."""
        workspace = self.context.workspace
        if self.worker.busy or not workspace.has_current:
            return
        document = workspace.current
        label = workspace.chosen if self.window_.criterion.for_selected else 0
        run = document.run(workspace.parameters.current)
        try:
            sweep = Sweep(
                run, self.window_.variation(), criterion=self.window_.criterion.test(), only=[label] if label else None
            )
        except IlfError as error:
            self.window_.state.show_message(str(error), "error")
            return
        self.found = SweepState(document, sweep, label)
        self.window_.begin(self.found)
        self.worker.start(lambda: sweep_steps(sweep, threads=spare_cores()))

    def take(self, number: int) -> None:
        """Apply the values of a point to all blocks, or to the only block swept."""
        found, workspace = self.found, self.context.workspace
        if found is None or found.document not in workspace.open:
            return
        workspace.show(found.document)
        if found.label and found.label not in found.document.counts():
            self.window_.state.show_message("The swept block no longer exists.", "warning")
            return
        self._filter.set_values(found.values(number), found.label)
        where = found.document.info(found.label).name if found.label else "all blocks"
        text = f"{found.text_of(number)} applied to {where}."
        if found.document.changed_blocks() and self.context.runs.state is RunState.IDLE:
            self.context.notes.offer(text, self.context.actions["run"])
        else:
            self.context.notes.show_message(text)

    def pending_work(self) -> list[PendingWork]:
        """The sweep in progress, if any."""
        if self.found is None or not self.worker.busy:
            return []
        return [PendingWork(f"a sweep of {self.found.document.name}", self.found.document)]

    def _take_steps(self, batch: list[Progress | SweepPoint]) -> None:
        found = self.found
        if found is None:
            return
        points = [item for item in batch if isinstance(item, SweepPoint)]
        for point in points:
            found.add(point)
        if points:
            self.window_.show_found()
        shares = [item.share for item in batch if isinstance(item, Progress)]
        if shares:
            self.window_.work.show_share(shares[-1])

    def _finish(self, result: SweepResult) -> None:
        if self.found is not None:
            self.found.finish(result)
        self.window_.end()

    def _fail(self, error: Exception) -> None:
        self.window_.end()
        if isinstance(error, IlfError):
            self.window_.state.show_message(str(error), "error")
        else:
            self.context.notes.report("The sweep stopped", error)

    def _cancel_closed(self) -> None:
        """Cancel the sweep if its frame was closed."""
        if self.found is not None and self.found.document not in self.context.workspace.open:
            self.worker.cancel()
            self.found = None
            self.window_.forget()

    def show_menu(self, name: str, place: QPoint) -> None:
        """Show the context menu of a parameter of the filter form."""
        declaration = Parameters.declarations()[name]
        menu = QMenu(self.context.window)
        action = menu.addAction(f"Sweep {declaration.label}…")
        action.setToolTip("Test many values and find the best")
        action.setEnabled(can_be_swept(declaration) and self.context.workspace.has_current)
        action.triggered.connect(lambda _=False: self.open(name))
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(place)
