"""The kept runs of the present frame: their panel and their commands."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QMenu

from gui.desk import Desk, Part
from gui.dialogs.saving import ask_path, save
from gui.kept.commands import COMMANDS, RUN_MENU
from gui.kept.measuring import RunMeasurer
from gui.kept.run_files import write_runs
from gui.kept.run_model import Column
from gui.kept.run_rows import run_rows
from gui.kept.run_table import RunTable
from gui.state.kept_runs import MOST_COMPARED
from gui.state.run_names import title_of
from gui.work.keeping import RunKeeper
from ilf.project.kept_run import KeptRun

_TITLE = "Runs"


class KeptRunsPart(Part):
    """Runs are kept as they end, shown in a table with how good they are, compared, restored and accepted."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        workspace, actions = desk.workspace, desk.actions
        actions.add(COMMANDS)
        self.keeper = RunKeeper(workspace, desk.runs, self)
        self.measurer = RunMeasurer(workspace, desk.runs, self)
        names = ["compare_runs", "accept_run", "restore_run"]
        self.table = RunTable(
            [
                *((actions[name], True) for name in names),
                None,
                *((actions[name], False) for name in ("delete_runs", "export_runs")),
            ]
        )
        desk.panels.add(_TITLE, self.table, Qt.DockWidgetArea.BottomDockWidgetArea, "ph.list-numbers", 1.7)
        results = workspace.session_changed, workspace.kept_runs_changed, workspace.compared_changed
        desk.refresh.add(
            "runs",
            self.show,
            (*results, workspace.results_changed, workspace.infos_changed, self.table.shown),
            (workspace.results_added,),
        )
        handlers: dict[str, Callable[[], object]] = {
            "show_runs": lambda: desk.panels.reveal(_TITLE),
            "compare_runs": self.compare,
            "restore_run": self.restore,
            "accept_run": self.accept,
            "rename_run": lambda: self.table.edit(Column.NAME),
            "note_run": lambda: self.table.edit(Column.NOTE),
            "delete_runs": self.delete,
            "export_runs": self.ask_export,
            "clear_runs": self.clear,
        }
        for name, handler in handlers.items():
            actions[name].triggered.connect(lambda _=False, handler=handler: handler())
        self.table.edited.connect(self._edit)
        self.table.ticked.connect(self._tick)
        self.table.deleteWished.connect(self.delete)
        self.table.contextMenuRequested.connect(self._show_menu)
        self.table.selectionChanged.connect(self._allow)
        self.keeper.message.connect(desk.notes.tell)
        self.measurer.failed.connect(lambda error: desk.notes.report("How good a run is", error))
        for signal in (workspace.session_changed, workspace.kept_runs_changed, workspace.truth_changed):
            signal.connect(self._allow)
            signal.connect(self.measurer.go_on)
        desk.runs.state_changed.connect(self.measurer.go_on)
        self._allow()

    def show(self) -> None:
        """A row per run, if anybody looks."""
        if self.table.isVisible():
            workspace = self.desk.workspace
            self.table.set_rows(run_rows(workspace.session) if workspace.has_session else [])

    def shutdown(self) -> bool:
        """Keep and measure nothing any more. True if no thread is left."""
        return self.keeper.shutdown() and self.measurer.shutdown()

    # commands

    def compare(self) -> None:
        """Compare the chosen runs, and no others, with the present result; none if it is these already."""
        chosen = self._selected()[:MOST_COMPARED]
        compared = self.desk.workspace.session.compared
        same = len(chosen) == len(compared) and all(kept in compared for kept in chosen)
        self.desk.workspace.compare([] if same else chosen)
        if not same:
            first = chosen[0]
            title = title_of(first.name, self.desk.workspace.session, first.run)
            what = f"{title} is" if len(chosen) == 1 else f"{len(chosen)} runs are"
            text = f"{what} compared with the present result: held V shows it."
            self.desk.notes.offer(text, self.desk.actions["compare_two"])

    def restore(self) -> None:
        """Take the parameters of the chosen run."""
        kept = self._chosen()
        if kept is None:
            return
        if self.desk.workspace.restore_run(kept):
            left = len(self.desk.workspace.session.changed_blocks())
            more = f" {left} blocks have no result of them yet: run them (F5)." if left else ""
            self.desk.notes.tell(f"The parameters are those of {kept.name}.{more}")
        else:
            self.desk.notes.tell(f"The parameters are those of {kept.name} already.")

    def accept(self) -> None:
        """Have the results of the chosen run for the present ones, where they fit."""
        kept = self._chosen()
        if kept is None:
            return
        taken = len(self.desk.workspace.accept_run(kept))
        count = len(kept.results)
        if not taken:
            text = f"Nothing of {kept.name} can be accepted: all its blocks have other pixels or known depth since."
        elif taken < count:
            text = f"{kept.name} is the result now; {count - taken} of {count} blocks have other pixels since."
        else:
            text = f"{kept.name} is the result now."
        self.desk.notes.tell(text)

    def delete(self) -> None:
        """Keep the chosen runs no longer."""
        if self.desk.workspace.has_session:
            self.desk.workspace.delete_runs(self.desk.workspace.session, self._selected())

    def clear(self) -> None:
        """Keep none of the frame's runs."""
        session = self.desk.workspace.session
        self.desk.workspace.delete_runs(session, list(session.kept_runs))

    def ask_export(self) -> None:
        """Write the list as a file that the user chooses."""
        name = f"{self.desk.workspace.session.name}-runs.csv"
        path = ask_path(self.desk.window, "Export runs", name, "Table (*.csv)")
        if path:
            self.export(path)

    def export(self, path: str) -> bool:
        """Write the list as CSV; False, with a message, if the file cannot be written."""
        rows = run_rows(self.desk.workspace.session)
        return save(self.desk.notes, path, lambda: write_runs(path, rows))

    # what the table reports

    def _selected(self) -> list[KeptRun]:
        """The chosen runs of the present frame: while nobody looks, the table may have another's."""
        workspace = self.desk.workspace
        there = workspace.session.kept_runs if workspace.has_session else []
        return [kept for kept in self.table.selected() if kept in there]

    def _chosen(self) -> KeptRun | None:
        chosen = self._selected()
        return chosen[0] if len(chosen) == 1 else None

    def _edit(self, kept: KeptRun, what: str, text: str) -> None:
        self.desk.workspace.change_run(self.desk.workspace.session, kept, **{what: text})

    def _tick(self, kept: KeptRun, on: bool) -> None:
        others = [one for one in self.desk.workspace.session.compared if one is not kept]
        self.desk.workspace.compare([*others, kept] if on else others)

    def _allow(self) -> None:
        workspace, actions = self.desk.workspace, self.desk.actions
        there = bool(workspace.has_session and workspace.session.kept_runs)
        chosen = self._selected()
        none = "" if there else "There are no runs yet."
        actions.allow(none or ("" if chosen else "Choose a run first."), "compare_runs", "delete_runs")
        one = none or ("" if len(chosen) == 1 else "Choose one run first.")
        actions.allow(one, "restore_run", "accept_run", "rename_run", "note_run")
        actions.allow(none, "export_runs", "clear_runs")

    def _show_menu(self, place: QPoint) -> None:
        menu = QMenu(self.table)
        menu.setToolTipsVisible(True)
        for name in RUN_MENU.split():
            if name == "|":
                menu.addSeparator()
            else:
                menu.addAction(self.desk.actions[name])
        menu.exec(place)
        menu.deleteLater()
