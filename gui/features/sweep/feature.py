"""The sweep: many values of one or two parameters, each evaluated and shown; a click applies one."""

from __future__ import annotations

from PySide6.QtCore import QPoint, Qt
from PySide6.QtWidgets import QMenu

from ilf.data.parameters import Parameters
from ilf.evaluation.sweep import can_be_swept

from ..context import Context, Feature, PendingWork
from .window import SweepWindow


class SweepFeature(Feature):
    """Opens the window of sweeps."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.window_ = SweepWindow(context)

    def open(self, name: str = "") -> None:
        """Open the window, with a parameter if one is given."""
        if self.context.workspace.has_current:
            self.window_.open_with(name)

    def pending_work(self) -> list[PendingWork]:
        """The sweep in progress, if any."""
        found = self.window_.found
        if found is None or not self.window_.busy:
            return []
        return [PendingWork(f"a sweep of {found.document.name}", found.document)]

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
