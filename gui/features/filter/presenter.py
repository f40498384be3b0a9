"""Brings the filter's parameters to their panel, and what is set there to the workspace and to the chosen blocks."""

from __future__ import annotations

from PySide6.QtCore import QObject, QSettings, Signal
from PySide6.QtGui import QAction

from ilf.data.parameters import Parameters
from ilf.project.frame_state import OwnValues, own_values, parameter_labels

from ...state.session import Session
from ...state.workspace import Workspace
from ...work.runs import RunController
from .panel import FilterPanel


class FilterPresenter(QObject):
    """Parameters of all blocks, or of the chosen ones, which are solved anew as they change.

    Parameters
    ----------
    live : QAction
        Whether chosen blocks are to be solved anew; the choice is remembered.

    Signals
    -------
    message(str)
        Something that needs no answer.
    """

    message = Signal(str)

    def __init__(self, workspace: Workspace, runs: RunController, panel: FilterPanel, live: QAction) -> None:
        super().__init__(panel)
        self._workspace = workspace
        self._runs = runs
        self._panel = panel
        self._live = live
        live.setChecked(bool(QSettings().value("live", True, type=bool)))
        live.toggled.connect(lambda on: QSettings().setValue("live", on))
        panel.edited.connect(self.take)
        panel.preset_chosen.connect(self.take_preset)

    @property
    def shown(self) -> Parameters:
        """The values that the panel shows: those of all blocks, or of the first chosen one."""
        common = self._workspace.parameters
        return self._workspace.session.parameters_of(self._workspace.chosen, common) if self._for_chosen else common

    def show(self) -> None:
        """The parameters of all blocks, or of the chosen ones: the first of them."""
        workspace = self._workspace
        chosen = workspace.session.selected if workspace.has_session else []
        names = [workspace.session.info(label).name for label in chosen]
        alone = workspace.shared.on and workspace.has_session and workspace.session.own_parameters
        of_all = workspace.shared.values if alone else None
        self._panel.show_parameters(self.shown, workspace.parameters, names, of_all)

    def take(self, parameters: Parameters) -> None:
        """A value set in the form goes to all blocks or to the chosen ones, which are solved anew if it is wanted."""
        if self._for_chosen:
            self._workspace.set_own(own_values(parameters, self.shown), self._workspace.session.selected)
        else:
            self._workspace.set_parameters(parameters)
        self._resolve()

    def set_values(self, values: OwnValues, label: int = 0) -> None:
        """Some values go to all blocks, or to one, which need not be chosen, as if they were set in the form."""
        workspace = self._workspace
        if label:
            workspace.set_own(values, [label])
            if self._live.isChecked():
                self._runs.resolve([label])
        else:
            workspace.set_parameters(workspace.parameters.replace(**values))
            self._resolve()

    def take_preset(self, parameters: Parameters) -> None:
        """The same with all values of a preset; what blocks have of their own stays, and that is said."""
        if self._for_chosen:
            self._workspace.set_parameters(parameters, self._workspace.session.selected)
        else:
            self._workspace.set_parameters(parameters)
            left = _left_alone(self._workspace.session) if self._workspace.has_session else ""
            if left:
                self.message.emit(f"Values of their own stay: {left}.")
        self._resolve()

    def reset_own(self) -> None:
        """The chosen blocks have no values of their own any more."""
        self._workspace.reset_own(self._workspace.session.selected)
        self._resolve()

    def copy_own(self) -> None:
        """The other chosen blocks get the very own values of the first one."""
        first, *others = self._workspace.session.selected
        self._workspace.copy_own(first, others)
        self._resolve()

    @property
    def _for_chosen(self) -> bool:
        return bool(self._workspace.chosen) and self._panel.for_chosen

    def _resolve(self) -> None:
        if self._workspace.chosen and self._live.isChecked():
            there = self._workspace.session.counts()
            wanted = [label for label in self._workspace.session.selected if label in there]
            if wanted:
                self._runs.resolve(wanted)


def _left_alone(session: Session) -> str:
    """Which blocks have which values of their own, in words."""
    there = session.counts()
    return "; ".join(
        f"{session.info(label).name} ({', '.join(parameter_labels(values))})"
        for label, values in sorted(session.notes.own.items())
        if label in there
    )
