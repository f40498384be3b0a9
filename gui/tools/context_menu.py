"""What a right click offers: something with what is under it, and the commands on the chosen blocks."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QObject, QPoint
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QWidget

from gui.state.workspace import Workspace
from gui.tools.editor import Editor
from gui.tools.give import give_piece
from gui.tools.split import suggested_cut
from ilf.ebs.edit import merge
from ilf.ebs.pieces import piece_at


class ContextMenu(QObject):
    """The menu of a place in the views.

    The block under it is chosen, unless it is already; what was chosen before can still take it in, all or in part.

    Parameters
    ----------
    commands : sequence of QAction or None
        On the chosen blocks; None separates them.
    """

    def __init__(
        self, workspace: Workspace, editor: Editor, commands: Sequence[QAction | None], parent: QWidget
    ) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._editor = editor
        self._commands = commands
        self._parent = parent

    def show(self, place: QPoint, x: float, y: float) -> None:
        """Open the menu at a place of the screen, which is at x, y in the image."""
        if not self._workspace.has_session:
            return
        menu = self.menu(x, y)
        menu.exec(place)
        menu.deleteLater()

    def menu(self, x: float, y: float) -> QMenu:
        """The menu of a place in the image."""
        menu = QMenu(self._parent)
        menu.setToolTipsVisible(True)
        for text, act in self._here(x, y):
            menu.addAction(text).triggered.connect(lambda _=False, act=act: act())
        menu.addSeparator()
        for command in self._commands:
            if command is None:
                menu.addSeparator()
            else:
                menu.addAction(command)
        return menu

    def _here(self, x: float, y: float) -> list[tuple[str, Callable[[], object]]]:
        self._editor.cancel()
        session = self._workspace.session
        before, label = list(session.selected), session.label_at(x, y)
        if label not in before:
            self._workspace.select([label] if label else [])
        if label == 0:
            return []
        name = session.info(label).name
        offers: list[tuple[str, Callable[[], object]]] = []
        if before and label != before[0]:
            taker = session.info(before[0]).name
            offers = [
                (f"Give this piece to {taker}", lambda: self._give(x, y, before)),
                (f"Merge {name} into {taker}", lambda: self._merge(before[0], label)),
            ]
        return [*offers, (f"Split {name} where it suggests itself", lambda: suggested_cut(self._editor, label))]

    def _give(self, x: float, y: float, chosen: list[int]) -> None:
        session = self._workspace.session
        source = session.label_at(x, y)
        self._workspace.select(chosen)
        give_piece(self._editor, piece_at(session.labels, x, y), source)

    def _merge(self, taker: int, other: int) -> None:
        session = self._workspace.session
        for label in (taker, other):
            if label in session.locked:
                self._editor.say(f"{session.info(label).name} is locked. Unlock it to merge it.")
                return
        self._editor.commit(
            merge(session.labels, [taker, other], session.locked), f"Merge into {session.info(taker).name}"
        )
        self._workspace.select([taker])
