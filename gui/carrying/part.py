"""Blocks go from frame to frame: the commands, what is said of it, and what is to be looked at afterwards."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QSettings, Qt
from PySide6.QtWidgets import QMenu

from gui.carrying.carrier import Carrier, Journey
from gui.carrying.commands import COMMANDS, HOW
from gui.carrying.dialog import CarryDialog
from gui.carrying.strip import CarryStrip
from gui.carrying.texts import notes_of, summary, to_check
from gui.desk import Desk, Part, UnderWay
from gui.inventory import plain
from gui.menus import insert_menu
from gui.state.entries import Entry

_HOW_KEY = "carrying/how"
_PREFIX = "carry_"


class CarryingPart(Part):
    """Carries the present frame's blocks to others, and those of the frame before to it."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        workspace, actions = desk.workspace, desk.actions
        actions.add(COMMANDS)
        self.carrier = Carrier(workspace, desk.loader, self)
        self.strip = CarryStrip()
        desk.centre.add_strip(self.strip)
        self.strip.work.cancelled.connect(self.carrier.stop)
        self.carrier.changed.connect(self._show)
        self.carrier.changed.connect(self._allow)
        self.carrier.ended.connect(self._tell)
        handlers: dict[str, Callable[[], object]] = {
            "carry_next": self.carry_next,
            "carry_previous": self.carry_previous,
            "carry_through": self.ask_carry_through,
            "stop_carrying": self.carrier.stop,
        }
        for name, handler in handlers.items():
            actions[name].triggered.connect(lambda _=False, handler=handler: handler())
        remembered = str(QSettings().value(_HOW_KEY, HOW[0]))
        actions[remembered if remembered in HOW else HOW[0]].setChecked(True)
        for name in HOW:
            actions[name].triggered.connect(lambda _=False, name=name: QSettings().setValue(_HOW_KEY, name))
        entries = workspace.entries
        for signal in (workspace.session_changed, workspace.labels_changed, entries.added, entries.removed):
            signal.connect(lambda *_: self._allow())
        self._allow()

    def begin(self) -> None:
        """Put the choice of how blocks are carried into the menu."""
        menu = QMenu("H&ow blocks are carried", self.desk.window)
        menu.setToolTipsVisible(True)
        menu.addActions([self.desk.actions[name] for name in HOW])
        insert_menu(self.desk.window.menuBar(), menu, self.desk.actions["carry_through"])

    def under_way(self) -> list[UnderWay]:
        """The carrying to a frame, which must stay open meanwhile."""
        entry, journey = self.carrier.present, self.carrier.journey
        if entry is None or journey is None or entry is journey.source:
            return []
        return [UnderWay(f"carrying blocks to {entry.name}", entry.session)]

    def shutdown(self) -> bool:
        """Carry no further. True if no thread is left."""
        return self.carrier.shutdown()

    @property
    def how(self) -> str:
        """How blocks are carried."""
        name = next(name for name in HOW if self.desk.actions[name].isChecked())
        return name.removeprefix(_PREFIX)

    # commands

    def carry_next(self) -> None:
        """Carry the blocks to the next frame, and show it."""
        present, following = self._present(), self._following(1)
        if present is not None and following:
            self.carrier.start(present, following, self.how, replaces=True, shows=True)

    def carry_previous(self) -> None:
        """Carry the blocks of the frame before to the present one."""
        present, before = self._present(), self._preceding()
        if present is not None and before is not None:
            self.carrier.start(before, [present], self.how, replaces=True)

    def carry_through(self, count: int, replaces: bool = False) -> None:
        """Carry the blocks through so many of the next frames."""
        present = self._present()
        if present is not None:
            self.carrier.start(present, self._following(count), self.how, replaces)

    def ask_carry_through(self) -> None:
        """The same, by the dialog."""
        following, actions = self._following(), self.desk.actions
        ways = [(name, plain(actions[name].text()), actions[name].toolTip()) for name in HOW]
        how = _PREFIX + self.how
        name = self.desk.workspace.session.name
        dialog = CarryDialog(name, [entry.name for entry in following], ways, how, self.desk.window)
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)

        def take() -> None:
            actions[dialog.chosen_way].trigger()
            self.carry_through(dialog.count.value(), dialog.replaces.isChecked())

        dialog.accepted.connect(take)
        dialog.open()

    # what there is

    def _present(self) -> Entry | None:
        workspace = self.desk.workspace
        return workspace.entries.of(workspace.session.id) if workspace.has_session else None

    def _row(self) -> int:
        """Where the present frame stands in the list."""
        present = self._present()
        return 0 if present is None else self.desk.workspace.entries.row_of(present)

    def _following(self, most: int | None = None) -> list[Entry]:
        """The frames after the present one in the list, or so many of them."""
        first, entries = self._row() + 1, self.desk.workspace.entries
        end = len(entries) if most is None else min(first + most, len(entries))
        return [entries[row] for row in range(first, end)]

    def _preceding(self) -> Entry | None:
        row = self._row()
        return self.desk.workspace.entries[row - 1] if row > 0 else None

    def _allow(self) -> None:
        workspace, allow = self.desk.workspace, self.desk.actions.allow
        no_frame = "" if workspace.has_session else "Open a frame first."
        busy = no_frame or ("" if self.carrier.journey is None else "Blocks are being carried: wait, or stop it.")
        no_blocks = busy or ("" if workspace.session.counts() else "There are no blocks: extract or draw some first.")
        last = "" if self._following(1) else "This is the last frame of the list."
        first = "" if self._preceding() is not None else "This is the first frame of the list."
        allow(no_blocks or last, "carry_next", "carry_through")
        allow(busy or first, "carry_previous")
        allow("" if self.carrier.journey is not None else "No blocks are being carried.", "stop_carrying")

    # what is said

    def _show(self) -> None:
        journey = self.carrier.journey
        if journey is None:
            self.strip.end()
        elif self.carrier.present is not None and journey.total > 0:
            self.strip.show_progress(self.carrier.present.name, min(journey.over, journey.total - 1), journey.total)

    def _tell(self, journey: Journey) -> None:
        notes, text = self.desk.notes, summary(journey)
        if text:
            notes.tell(text)
        if to_check(journey) and self.desk.workspace.has_session and self.desk.workspace.session.to_check:
            notes.offer(text, self.desk.actions["next_suspect"])
        notes.warn("Carrying blocks", notes_of(journey))
