"""Brings the filter's parameters to their panel, and what is set there to the workspace and to the chosen block."""

from __future__ import annotations

from PySide6.QtCore import QObject, QSettings
from PySide6.QtGui import QAction

from gui.filtering.filter_panel import FilterPanel
from gui.state.workspace import Workspace
from gui.work.runs import RunController
from ilf.parameters import Parameters


class FilterPresenter(QObject):
    """Parameters of all blocks, or of the chosen one, which is solved anew as they change.

    Parameters
    ----------
    live : QAction
        Whether the chosen block is to be solved anew; the choice is remembered.
    """

    def __init__(self, workspace: Workspace, runs: RunController, panel: FilterPanel, live: QAction) -> None:
        super().__init__(panel)
        self._workspace = workspace
        self._runs = runs
        self._panel = panel
        self._live = live
        live.setChecked(bool(QSettings().value("live", True, type=bool)))
        live.toggled.connect(lambda on: QSettings().setValue("live", on))
        panel.edited.connect(self.take)

    def show(self) -> None:
        """The parameters of all blocks, or of the chosen one."""
        label = self._workspace.chosen
        name = self._workspace.session.info(label).name if label else None
        common = self._workspace.parameters
        own = label and self._panel.for_chosen_block
        shown = self._workspace.session.parameters_of(label, common) if own else common
        self._panel.show_parameters(shown, name)

    def take(self, parameters: Parameters) -> None:
        """Values set in the form go to all blocks or to the chosen one, and that is solved anew if it is wanted."""
        label = self._workspace.chosen
        self._workspace.set_parameters(parameters, label if label and self._panel.for_chosen_block else None)
        if label and self._live.isChecked() and label in self._workspace.session.counts():
            self._runs.resolve([label])
