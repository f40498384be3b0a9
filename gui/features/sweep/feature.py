"""The sweep: many values of one or two parameters, each evaluated and shown; a click applies one."""

from __future__ import annotations

from functools import cached_property

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QMenu

from ilf.data.parameters import Parameters
from ilf.errors import IlfError
from ilf.evaluation.evaluation import Step
from ilf.evaluation.sweep import Sweep, SweepPoint, SweepResult, can_be_swept, sweep_steps

from ...base.commands import Command
from ...work.frame_runs import RunState
from ...work.jobs import Worker, spare_cores
from ..context import Desk, Part, UnderWay
from .found import Found
from .window import SweepWindow

# Commands of the sweep.

COMMANDS = (
    Command(
        "sweep",
        "S&weep a parameter…",
        "ph.chart-bar",
        "",
        "Test many values of a parameter, or of two, and compare their errors against ground truth or on hold-outs",
    ),
)


class SweepPart(Part):
    """Runs sweeps in the background, one at a time, and shows the results in their window."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        desk.actions.add(COMMANDS)
        self.found: Found | None = None
        self.worker = Worker(self)
        self.worker.progressed.connect(self._take_steps)
        self.worker.finished.connect(self._finish)
        self.worker.failed.connect(self._fail)
        self.worker.cancelled.connect(lambda: self.window_.end("Cancelled. Results so far are kept."))
        desk.actions["sweep"].triggered.connect(lambda _=False: self.open())
        desk.filter_panel.form.menu_wished.connect(self._show_menu)
        workspace = desk.workspace
        turned, values, chosen = workspace.session_changed, workspace.parameters_changed, workspace.selection_changed
        frame = turned, values, chosen, workspace.infos_changed, workspace.truth_changed
        desk.refresh.add("sweep", self.show, (*frame, desk.views.ranges.changed))
        workspace.sessions_changed.connect(self._leave_closed)
        workspace.session_changed.connect(self._allow)
        self._allow()

    @cached_property
    def window_(self) -> SweepWindow:
        """The window, created on first use."""
        window, mark = SweepWindow(self.desk.window), self.desk.refresh.mark
        window.begun.connect(self.start)
        window.cancelled.connect(self.worker.cancel)
        window.taken.connect(self.take)
        window.criterion.changed.connect(lambda: mark("sweep"))
        window.looked_at.connect(lambda: mark("sweep"))
        return window

    @property
    def _is_looked_at(self) -> bool:
        return "window_" in vars(self) and self.window_.isVisible()

    def open(self, name: str = "") -> None:
        """Open the window, with a parameter if one is given."""
        if not self.desk.workspace.has_session:
            return
        self.window_.show()
        self.window_.raise_()
        self.window_.activateWindow()
        self.show()
        if name and not self.worker.busy:
            if self.desk.filter_panel.for_chosen:
                self.window_.criterion.blocks.setCurrentIndex(1)
                self.show()
            self.window_.choose(name)

    def show(self) -> None:
        """Update the window for the current frame, if it is visible."""
        workspace = self.desk.workspace
        if not self._is_looked_at or not workspace.has_session:
            return
        session, chosen = workspace.session, workspace.chosen
        name = session.info(chosen).name if chosen else ""
        for_chosen = bool(chosen) and self.window_.criterion.for_chosen
        parameters = session.parameters_of(chosen, workspace.parameters) if for_chosen else workspace.parameters
        self.window_.set_frame(parameters, session.frame.truth is not None, name)
        self.window_.set_colour_map(self.desk.views.ranges.depth_map)

    def start(self) -> None:
        """Start a sweep with the settings of the window."""
        workspace = self.desk.workspace
        if self.worker.busy or not workspace.has_session:
            return
        session = workspace.session
        label = workspace.chosen if self.window_.criterion.for_chosen else 0
        run = session.run(workspace.parameters)
        try:
            sweep = Sweep(
                run, self.window_.variation(), criterion=self.window_.criterion.test(), only=[label] if label else None
            )
        except IlfError as error:
            self.window_.state.say(str(error), "error")
            return
        self.found = Found(session, sweep, label)
        self.window_.begin(self.found)
        self.worker.start(lambda: sweep_steps(sweep, threads=spare_cores()))

    def take(self, number: int) -> None:
        """Apply the values of a point to all blocks, or to the only block swept."""
        found, workspace = self.found, self.desk.workspace
        if found is None or found.session not in workspace.sessions:
            return
        workspace.show_session(found.session)
        if found.label and found.label not in found.session.counts():
            self.window_.state.say("The swept block no longer exists.", "warning")
            return
        self.desk.filter_presenter.set_values(found.values(number), found.label)
        where = found.session.info(found.label).name if found.label else "all blocks"
        text = f"{found.text_of(number)} applied to {where}."
        if found.session.changed_blocks() and self.desk.runs.state is RunState.IDLE:
            self.desk.notes.offer(text, self.desk.actions["run"])
        else:
            self.desk.notes.tell(text)

    def under_way(self) -> list[UnderWay]:
        """The sweep in progress, if any."""
        if self.found is None or not self.worker.busy:
            return []
        return [UnderWay(f"a sweep of {self.found.session.name}", self.found.session)]

    def shutdown(self) -> bool:
        """Stop permanently before the window closes. True if the thread has ended."""
        ended = self.worker.shutdown()
        if self._is_looked_at:
            self.window_.close()
        return ended

    def _take_steps(self, batch: list[Step | SweepPoint]) -> None:
        found = self.found
        if found is None:
            return
        points = [item for item in batch if isinstance(item, SweepPoint)]
        for point in points:
            found.add(point)
        if points:
            self.window_.show_found()
        shares = [item.share for item in batch if isinstance(item, Step)]
        if shares:
            self.window_.work.show_share(shares[-1])

    def _finish(self, result: SweepResult) -> None:
        if self.found is not None:
            self.found.finish(result)
        self.window_.end()

    def _fail(self, error: Exception) -> None:
        self.window_.end()
        if isinstance(error, IlfError):
            self.window_.state.say(str(error), "error")
        else:
            self.desk.notes.report("The sweep stopped", error)

    def _leave_closed(self) -> None:
        """Cancel the sweep if its frame was closed."""
        if self.found is not None and self.found.session not in self.desk.workspace.sessions:
            self.worker.cancel()
            self.found = None
            self.window_.forget()

    def _allow(self) -> None:
        self.desk.actions.allow("" if self.desk.workspace.has_session else "Open a frame first.", "sweep")

    def _show_menu(self, name: str, place: QPoint) -> None:
        """Show the context menu of a parameter of the filter form."""
        declaration = Parameters.declarations()[name]
        menu = QMenu(self.desk.window)
        action = menu.addAction(f"Sweep {declaration.label}…")
        action.setToolTip("Test many values and find the best")
        action.setEnabled(can_be_swept(declaration) and self.desk.workspace.has_session)
        action.triggered.connect(lambda _=False: self.open(name))
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.popup(place)
