"""Propagation of blocks from frame to frame: commands, progress, and summary of the blocks to check."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial

from PySide6.QtCore import QSettings, Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QSpinBox,
    QWidget,
)

from ilf._runtime.formatting import counted

from ...base.commands import Command, command, plain
from ...base.needs import Need
from ...state.entries import Entry
from ...widgets.basics import Message, PlainLabel, answers, combo, form, lay_out, open_once, stack
from ...widgets.work_row import WorkRow
from ..context import Context, Feature, PendingWork
from .propagator import PropagationRun, Propagator

_WAYS = {
    "auto": (
        "&Automatic",
        "By the camera poses if known; otherwise copy unchanged pixels and follow optical flow elsewhere",
    ),
    "copied": ("&Copied", "Every pixel keeps its block: for a static camera"),
    "flow": (
        "Optical &flow",
        "Follow the motion in the image, then snap to the edges of the new frame: for a moving camera",
    ),
}
"""The propagation methods by their name in the library, with text and hint of the command that chooses one."""
_COMMAND = "propagate_{}".format

# The dialog: number of frames, method, and whether to replace existing work.

_USUAL = 30


class PropagateDialog(QDialog):
    """Dialog for the number of frames and the method of a propagation.

    Parameters
    ----------
    frame_name : str
        The frame with the original blocks.
    names : sequence of str
        Names of the frames after it.
    how : str
        The initial method.
    """

    def __init__(self, frame_name: str, names: Sequence[str], how: str, parent: QWidget) -> None:
        super().__init__(parent)
        self.setWindowTitle(f"Propagate Blocks of {frame_name}")
        self._names = names
        about = Message(lines=3)
        about.show_message(
            "The blocks are propagated from each frame to the next, with names, locks, parameters and drawn borders. "
            "Blocks that need a check are marked. In frames that are still open, this can be undone."
        )
        self.count = QSpinBox(minimum=1, maximum=len(names), value=min(_USUAL, len(names)))
        self.count.setToolTip("Number of following frames in the list")
        texts = {name: plain(text) for name, (text, _) in _WAYS.items()}
        self.how = combo(texts, "Method that transfers the blocks to the next frame")
        for number, (_, hint) in enumerate(_WAYS.values()):
            self.how.setItemData(number, hint, Qt.ItemDataRole.ToolTipRole)
        self.how.setCurrentIndex(self.how.findData(how))
        self.replaces = QCheckBox("&Replace blocks that have been edited or run")
        self.replaces.setToolTip(
            "Also replace the blocks of frames that have been worked on. Otherwise these frames keep their blocks, "
            "which are propagated further."
        )
        self.last = PlainLabel()
        hint = "Start in the background; a line under the views shows the progress"
        buttons, _ = answers(self, QDialogButtonBox.StandardButton.Ok, "&Propagate", hint)
        self.count.valueChanged.connect(lambda _: self._describe())
        choices = form(("&Frames", self.count), ("", self.last), ("&Method", self.how))
        stack(self, about, choices, self.replaces, buttons)
        self._describe()
        self.resize(430, self.heightForWidth(430))  # its text wraps

    def _describe(self) -> None:
        self.last.setText(
            f"up to {self._names[self.count.value() - 1]}, of {counted(len(self._names), 'following frame')}"
        )


# Messages after a propagation.

_DONE = {"copied": "copied", "flow": "propagated along optical flow", "pose": "propagated by the camera pose"}
_MAX_NAMED = 3


def summary(run: PropagationRun) -> str:
    """Summarise a propagation in a few sentences; "" if nothing was done."""
    texts = []
    if run.done:
        ways = [one.how for one in run.done]
        how = " and ".join(f"{ways.count(way)} {_DONE[way]}" for way in _DONE if way in ways)
        texts.append(f"Blocks of {run.source.name} propagated to {_named([one.name for one in run.done])}: {how}.")
        counts = {"new": sum(one.new for one in run.done), "gone": sum(one.gone for one in run.done)}
        parts = [f"{count} {what}" for what, count in counts.items() if count]
        texts.append(", ".join([f"{counted(to_check(run), 'block')} to check", *parts]) + ".")
    if run.kept:
        texts.append(f"{_named(run.kept)} had been edited or run: their blocks were kept and propagated further.")
    if run.stopped:
        texts.append(f"Stopped after {run.processed} of {counted(run.total, 'frame')}.")
    return " ".join(texts)


def _named(names: Sequence[str]) -> str:
    """Return the number of frames, with the first names."""
    return f"{counted(len(names), 'frame')} ({', '.join(names[:_MAX_NAMED])}{', …' * (len(names) > _MAX_NAMED)})"


def notes_of(run: PropagationRun) -> list[str]:
    """Return notes on single frames, a sentence each."""
    return [*run.problems, *(f"{one.name}: {note}" for one in run.done for note in one.notes)]


def to_check(run: PropagationRun) -> int:
    """Count the blocks that need a check."""
    return sum(one.to_check for one in run.done)


_MIN_TEXT_WIDTH = 120
_HOW_KEY = "carrying/how"


class PropagationFeature(Feature):
    """Propagates the current frame's blocks to other frames, and those of the previous frame to the current one."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        actions = context.actions
        actions.add(
            Command(_COMMAND(how), text, hint, group="propagate_how", handler=partial(self._remember, how))
            for how, (text, hint) in _WAYS.items()
        )
        self.label, self.work = PlainLabel(), WorkRow("propagation of blocks")
        self.label.setMinimumWidth(_MIN_TEXT_WIDTH)
        self.strip = QWidget()
        """Line under the views during a propagation: target frame, progress, and a button to stop."""
        parts = self.label, self.work
        lay_out(QHBoxLayout(self.strip), *parts, margins=(8, 2, 8, 2), stretched=parts)
        self.strip.hide()
        context.centre.add_strip(self.strip)
        self.work.cancelled.connect(self._stop)
        menu = actions.menu("Pr&opagation method", context.window, " ".join(map(_COMMAND, _WAYS)))
        actions.adopt("propagation_menu", menu.menuAction())
        remembered = str(QSettings().value(_HOW_KEY))
        actions[_COMMAND(remembered if remembered in _WAYS else "auto")].setChecked(True)

    @cached_property
    def propagator(self) -> Propagator:
        """What propagates blocks, made on first use."""
        propagator = Propagator(self.context.workspace, self.context.loader, self)
        propagator.changed.connect(self._show)
        propagator.changed.connect(self.context.actions.refresh)
        propagator.ended.connect(self._tell)
        return propagator

    def _remember(self, how: str) -> None:
        QSettings().setValue(_HOW_KEY, how)

    @command(
        "stop_propagation",
        "&Stop",
        icon="ph.stop",
        why_off=lambda self: "" if self.propagator.propagation_run else "No propagation is in progress.",
    )
    def _stop(self) -> None:
        """Stop the propagation; frames that have the blocks keep them."""
        self.propagator.stop()

    def pending_work(self) -> list[PendingWork]:
        """The propagation to a frame, which must stay open meanwhile."""
        run = self.propagator.propagation_run
        if run is None or run.present is run.source:
            return []
        return [PendingWork(f"propagation of blocks to {run.present.name}", run.present.document)]

    @property
    def how(self) -> str:
        """The selected method."""
        return next(how for how in _WAYS if self.context.actions[_COMMAND(how)].isChecked())

    # commands

    @command(
        "propagate_next",
        "Propagate blocks to the next &frame",
        icon="ph.arrow-bend-down-right",
        keys="Alt+PgDown",
        needs=Need.BLOCKS,
        why_off=lambda self: self._why_busy() or self._why_last(),
    )
    def propagate_next(self) -> None:
        """Propagate the blocks to the next frame of the list, with names, locks and parameters, and show it."""
        present, following = self._present(), self._following(1)
        self.propagator.start(present, following, self.how, replaces=True, shows=True)

    @command(
        "propagate_previous",
        "Propaga&te blocks from the previous frame",
        icon="ph.arrow-bend-right-down",
        keys="Alt+PgUp",
        needs=Need.FRAME,
        why_off=lambda self: self._why_busy() or self._why_first(),
    )
    def propagate_previous(self) -> None:
        """Propagate the blocks of the previous frame of the list to this one, with names, locks and parameters."""
        (before,) = self._preceding()
        self.propagator.start(before, [self._present()], self.how, replaces=True)

    def propagate_through(self, count: int, replaces: bool = False) -> None:
        """Propagate the blocks through the next `count` frames."""
        self.propagator.start(self._present(), self._following(count), self.how, replaces)

    @command(
        "propagate_through",
        "Propagate t&hrough the next frames…",
        icon="ph.fast-forward",
        needs=Need.BLOCKS,
        why_off=lambda self: self._why_busy() or self._why_last(),
    )
    def ask_propagate_through(self) -> None:
        """Propagate the blocks through a number of following frames."""
        names = [entry.name for entry in self._following()]
        dialog = PropagateDialog(self._present().name, names, self.how, self.context.window)

        def take() -> None:
            self.context.actions[_COMMAND(dialog.how.currentData())].trigger()
            self.propagate_through(dialog.count.value(), dialog.replaces.isChecked())

        open_once(dialog, take)

    # frames of the list

    def _present(self) -> Entry:
        """The current frame."""
        present = self.context.workspace.current_entry
        assert present is not None
        return present

    def _following(self, most: int | None = None) -> list[Entry]:
        """Return the frames after the current one in the list, at most `most` of them."""
        entries = list(self.context.workspace.entries)
        return entries[entries.index(self._present()) + 1 :][:most]

    def _preceding(self) -> list[Entry]:
        """Return the frame before the current one in the list, if there is one."""
        entries = list(self.context.workspace.entries)
        row = entries.index(self._present())
        return entries[max(row - 1, 0) : row]

    # why a command cannot be used

    def _why_busy(self) -> str:
        return "A propagation is in progress: wait, or stop it." if self.propagator.propagation_run else ""

    def _why_last(self) -> str:
        return "" if self._following(1) else "This is the last frame of the list."

    def _why_first(self) -> str:
        return "" if self._preceding() else "This is the first frame of the list."

    # messages

    def _show(self) -> None:
        run = self.propagator.propagation_run
        if run is None:
            self.strip.hide()
        elif run.total > 0:
            if self.strip.isHidden():
                self.work.begin()
                self.strip.show()
            done = min(run.processed, run.total - 1)
            self.label.setText(f"Propagating blocks to {run.present.name} ({done + 1} of {run.total})")
            self.work.show_share(done / run.total)

    def _tell(self, run: PropagationRun) -> None:
        notes, workspace, text = self.context.notes, self.context.workspace, summary(run)
        if text:
            notes.show_message(text)
        if to_check(run) and workspace.has_current and workspace.current.state.to_check:
            notes.offer(text, self.context.actions["next_check"])
        notes.warn("Propagation of blocks", notes_of(run))
