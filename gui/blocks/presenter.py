"""Brings the blocks of the present frame to their table, and what is done there to the workspace."""

from __future__ import annotations

import random
from collections.abc import Sequence

from PySide6.QtCore import QObject, QPoint
from PySide6.QtGui import QAction, QColor
from PySide6.QtWidgets import QMenu

from gui.blocks.block_rows import block_rows
from gui.blocks.block_table import BlockTable
from gui.state.workspace import Workspace
from gui.work.runs import RunController
from ilf.drawing.block_pictures import block_colour

_COLOURS = 1000
"""Numbers that shuffled colours start from."""


class BlocksPresenter(QObject):
    """The table of blocks with its menu.

    Parameters
    ----------
    commands : sequence of QAction or None
        Entries of the menu on blocks; None separates them.
    """

    def __init__(
        self, workspace: Workspace, runs: RunController, table: BlockTable, commands: Sequence[QAction | None]
    ) -> None:
        super().__init__(table)
        self._workspace = workspace
        self._runs = runs
        self._table = table
        self._commands = commands
        table.selectionChanged.connect(workspace.select)
        table.renamed.connect(lambda label, name: workspace.edit_info(label, "Rename block", name=name))
        table.recoloured.connect(self._recolour)
        table.visibilityChanged.connect(workspace.set_visible)
        table.lockChanged.connect(workspace.set_lock)
        table.contextMenuRequested.connect(lambda place, _: self.show_menu(place))

    def show(self) -> None:
        """A row per block, and the chosen ones selected."""
        if self._workspace.has_session:
            session = self._workspace.session
            rows = block_rows(session, self._runs)
            self._table.set_error_source(session.block_errors.source)
            self._table.set_rows(rows)
            if self._table.selected() != [label for label in self._table.labels() if label in session.selected]:
                self._table.select(session.selected)
        else:
            self._table.set_rows([])

    def show_menu(self, place: QPoint) -> None:
        """Commands on the chosen blocks."""
        menu = QMenu(self._table)
        for command in self._commands:
            if command is None:
                menu.addSeparator()
            else:
                menu.addAction(command)
        menu.exec(place)
        menu.deleteLater()

    def shuffle_colours(self) -> None:
        """Other colours for all blocks, far from each other in hue as before, as one undoable step."""
        if not self._workspace.has_session:
            return
        session = self._workspace.session
        labels = list(session.counts())
        start = random.randrange(1, _COLOURS)
        numbers = random.sample(range(start, start + len(labels)), len(labels))
        session.undo_stack.beginMacro("Shuffle colours")
        for label, number in zip(labels, numbers, strict=True):
            self._workspace.edit_info(label, "Recolour block", colour=block_colour(number))
        session.undo_stack.endMacro()

    def _recolour(self, label: int, colour: QColor) -> None:
        self._workspace.edit_info(label, "Recolour block", colour=(colour.red(), colour.green(), colour.blue()))
