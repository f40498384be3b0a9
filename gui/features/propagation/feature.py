"""Blocks go from frame to frame: the commands, what is said of it, and what is to be looked at afterwards."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from PySide6.QtCore import QSettings, Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QMenu,
    QSpinBox,
    QVBoxLayout,
    QWidget,
)

from ilf._runtime.formatting import counted

from ...base.commands import Command, plain
from ...state.entries import Entry
from ...widgets.basics import Message, PlainLabel
from ...widgets.work_row import WorkRow
from ..context import Desk, Part, UnderWay
from ..menus import insert_menu
from .carrier import Arrival, Carrier, Journey

# Commands on blocks that go from frame to frame.

HOW = "carry_auto", "carry_copied", "carry_flow"
"""Commands that choose how blocks are carried; what comes after `carry_` is what the library calls it."""

COMMANDS = (
    Command(
        "carry_next",
        "Carry blocks to the next &frame",
        "ph.arrow-bend-down-right",
        "Alt+PgDown",
        "Carry the blocks to the next frame of the list, with names, locks and values, and show it",
    ),
    Command(
        "carry_previous",
        "&Take blocks from the previous frame",
        "ph.arrow-bend-right-down",
        "Alt+PgUp",
        "Carry the blocks of the frame before in the list to this one, with names, locks and values",
    ),
    Command(
        "carry_through",
        "Carry t&hrough the next frames…",
        "ph.fast-forward",
        "",
        "Carry the blocks from frame to frame, through as many as you choose",
    ),
    Command("stop_carrying", "&Stop", "ph.stop", "", "Carry no further; frames that have the blocks keep them"),
    Command(
        "carry_auto",
        "&Automatic",
        "",
        "",
        "By the camera's poses where files tell them; else copy what has not changed, and follow what has moved",
        group="carry_how",
    ),
    Command(
        "carry_copied",
        "&Copied",
        "",
        "",
        "Every pixel keeps its block: for frames from the very same camera position",
        group="carry_how",
    ),
    Command(
        "carry_flow",
        "Optical &flow",
        "",
        "",
        "Follow what moves in the picture, then snap to the edges of the new frame: for a moving camera",
        group="carry_how",
    ),
)


# The dialog that sends blocks through the next frames: how many, how, and what becomes of work that is there.

_USUAL = 30


class CarryDialog(QDialog):
    """How many frames, and how.

    Parameters
    ----------
    frame_name : str
        Whose blocks are carried.
    names : sequence of str
        The frames after it.
    ways : sequence of (str, str, str)
        How blocks can be carried: name, text and explanation.
    how : str
        The name that is chosen at first.
    """

    def __init__(
        self, frame_name: str, names: Sequence[str], ways: Sequence[tuple[str, str, str]], how: str, parent: QWidget
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Carry Blocks of {frame_name}")
        self._names = names
        about = Message(lines=3)
        about.say(
            "The blocks go from each frame to the next, with names, locks, values and drawn borders. Blocks that need "
            "a look are marked. As long as a frame stays open, undo brings back what it had."
        )
        self.count = QSpinBox(minimum=1, maximum=len(names), value=min(_USUAL, len(names)))
        self.count.setToolTip("Through how many of the next frames of the list the blocks are carried")
        self.how = QComboBox()
        self.how.setToolTip("How blocks find their place in the next frame")
        for number, (name, text, hint) in enumerate(ways):
            self.how.addItem(text, name)
            self.how.setItemData(number, hint, Qt.ItemDataRole.ToolTipRole)
        self.how.setCurrentIndex(max(self.how.findData(how), 0))
        self.replaces = QCheckBox("&Replace blocks that have been edited or run")
        self.replaces.setToolTip(
            "Also in frames that have been worked on. Otherwise they stay as they are, and their blocks are carried on "
            "from there."
        )
        self.last = PlainLabel()
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel)
        carry = buttons.button(QDialogButtonBox.StandardButton.Ok)
        carry.setText("&Carry")
        carry.setToolTip("Begin, in the background; a line under the views shows how far it is")
        buttons.accepted.connect(self.accept)
        buttons.rejected.connect(self.reject)
        self.count.valueChanged.connect(lambda _: self._describe())
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.AllNonFixedFieldsGrow)
        form.addRow("&Frames", self.count)
        form.addRow("", self.last)
        form.addRow("&How", self.how)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(14, 14, 14, 14)
        layout.setSpacing(10)
        layout.addWidget(about)
        layout.addLayout(form)
        layout.addWidget(self.replaces)
        layout.addWidget(buttons)
        self.resize(430, 0)
        self._describe()

    @property
    def chosen_way(self) -> str:
        """How blocks are carried."""
        return str(self.how.currentData())

    def _describe(self) -> None:
        self.last.setText(f"up to {self._names[self.count.value() - 1]}, of {len(self._names)} that follow")


# A line under the views while blocks are carried: to which frame, how far it is, and a button that ends it.

_LEAST_TEXT = 120


class CarryStrip(QWidget):
    """Hidden while nothing is carried."""

    def __init__(self) -> None:
        super().__init__()
        self.label = PlainLabel()
        self.label.setTextFormat(Qt.TextFormat.PlainText)
        self.label.setMinimumWidth(_LEAST_TEXT)
        self.work = WorkRow("carrying of blocks")
        layout = QHBoxLayout(self)
        layout.setContentsMargins(8, 2, 8, 2)
        layout.addWidget(self.label, 1)
        layout.addWidget(self.work, 1)
        self.hide()

    def show_progress(self, name: str, done: int, total: int) -> None:
        """Blocks are on their way to a frame, after so many of all."""
        if self.isHidden():
            self.work.begin()
            self.show()
        self.label.setText(f"Carrying blocks to {name} ({done + 1} of {total})")
        self.work.show_share(done / total)

    def end(self) -> None:
        """Nothing is carried any more."""
        self.work.end()
        self.hide()


# What is said when blocks have been carried.

_DONE = {"copied": "copied", "flow": "carried along optical flow", "pose": "carried by the camera's pose"}
_MOST_NAMED = 3


def summary(journey: Journey) -> str:
    """What has come of a journey, in a few sentences; "" for nothing."""
    texts = [_of_one(journey.done[0]) if len(journey.done) == 1 else _of_many(journey)] if journey.done else []
    if journey.kept:
        kept = counted(len(journey.kept), "frame")
        texts.append(f"{kept} ({_named(journey.kept)}) had been edited or run: blocks were carried on from there.")
    if journey.stopped:
        texts.append(f"Stopped after {journey.over} of {counted(journey.total, 'frame')}.")
    return " ".join(texts)


def notes_of(journey: Journey) -> list[str]:
    """What the user should know of single frames, a sentence each."""
    return [*journey.problems, *(f"{one.name}: {note}" for one in journey.done for note in one.notes)]


def to_check(journey: Journey) -> int:
    """Blocks that need a look."""
    return sum(one.to_check for one in journey.done)


def _of_one(one: Arrival) -> str:
    parts = [f"{one.name}: {counted(one.blocks, 'block')} {_DONE[one.how]}"]
    parts += [f"{one.new} of them new"] * (one.new > 0) + [f"{one.gone} gone"] * (one.gone > 0)
    parts += [f"{one.to_check} need{'s' * (one.to_check == 1)} a look"] if one.to_check else ["none needs a look"]
    return ", ".join(parts) + "."


def _of_many(journey: Journey) -> str:
    ways = [one.how for one in journey.done]
    how = " and ".join(f"{ways.count(way)} {_DONE[way]}" for way in _DONE if way in ways)
    text = f"Blocks of {journey.source.name} are in {counted(len(ways), 'further frame')}: {how}."
    look, marked = to_check(journey), sum(one.to_check > 0 for one in journey.done)
    need = f"{counted(look, 'block')} in {counted(marked, 'frame')} need{'s' * (look == 1)} a look."
    return f"{text} {need if look else 'No block needs a look.'}"


def _named(names: list[str]) -> str:
    return ", ".join(names[:_MOST_NAMED]) + ", …" * (len(names) > _MOST_NAMED)


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
