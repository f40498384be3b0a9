"""Shows the parameters of the filter in their panel, and applies changes to the workspace and the selected blocks."""

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
    """Presenter of the parameters of all blocks, or of the selected ones, which are completed again on changes.

    Parameters
    ----------
    live : QAction
        Whether selected blocks are completed again on changes; the setting is stored.

    Signals
    -------
    message(str)
        A message that needs no answer.
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
        """The parameters that the panel shows: those of all blocks, or of the first selected one."""
        common = self._workspace.parameters.current
        return (
            self._workspace.session.parameters_of(self._workspace.blocks.chosen, common)
            if self._for_selected
            else common
        )

    def show(self) -> None:
        """Show the parameters of all blocks, or of the first selected one."""
        workspace = self._workspace
        chosen = workspace.session.selected if workspace.has_session else []
        names = [workspace.session.info(label).name for label in chosen]
        alone = workspace.parameters.shared.on and workspace.has_session and workspace.session.own_parameters
        of_all = workspace.parameters.shared.values if alone else None
        self._panel.show_parameters(self.shown, workspace.parameters.current, names, of_all)

    def take(self, parameters: Parameters) -> None:
        """Apply edited parameters to all blocks or to the selected ones, and complete these again if that is on."""
        if self._for_selected:
            self._workspace.parameters.set_own(own_values(parameters, self.shown), self._workspace.session.selected)
        else:
            self._workspace.parameters.set(parameters)
        self._resolve()

    def set_values(self, values: OwnValues, label: int = 0) -> None:
        """Apply some parameters to all blocks or to one (selected or not), as if they were edited in the form."""
        workspace = self._workspace
        if label:
            workspace.parameters.set_own(values, [label])
            if self._live.isChecked():
                self._runs.resolve([label])
        else:
            workspace.parameters.set(workspace.parameters.current.replace(**values))
            self._resolve()

    def take_preset(self, parameters: Parameters) -> None:
        """Apply all parameters of a preset; per-block parameters stay, which a message reports."""
        if self._for_selected:
            self._workspace.parameters.set(parameters, self._workspace.session.selected)
        else:
            self._workspace.parameters.set(parameters)
            left = _describe_own(self._workspace.session) if self._workspace.has_session else ""
            if left:
                self.message.emit(f"Per-block parameters are kept: {left}.")
        self._resolve()

    def reset_own(self) -> None:
        """Remove the per-block parameters of the selected blocks."""
        self._workspace.parameters.reset_own(self._workspace.session.selected)
        self._resolve()

    def copy_own(self) -> None:
        """Copy the per-block parameters of the first selected block to the others."""
        first, *others = self._workspace.session.selected
        self._workspace.parameters.copy_own(first, others)
        self._resolve()

    @property
    def _for_selected(self) -> bool:
        return bool(self._workspace.blocks.chosen) and self._panel.for_selected

    def _resolve(self) -> None:
        if self._workspace.blocks.chosen and self._live.isChecked():
            there = self._workspace.session.counts()
            wanted = [label for label in self._workspace.session.selected if label in there]
            if wanted:
                self._runs.resolve(wanted)


def _describe_own(session: Session) -> str:
    """Describe which blocks have which per-block parameters."""
    there = session.counts()
    return "; ".join(
        f"{session.info(label).name} ({', '.join(parameter_labels(values))})"
        for label, values in sorted(session.notes.own.items())
        if label in there
    )
