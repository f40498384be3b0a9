"""Propagation of blocks from frame to frame: commands, the work, its progress, and a summary."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QHBoxLayout,
    QSpinBox,
    QWidget,
)

from ilf._runtime.formatting import counted
from ilf.data.blocks import Blocks
from ilf.errors import InputError
from ilf.project.frame_state import FrameState
from ilf.project.project import Stage
from ilf.project.propagation import Propagated, propagate_state
from ilf.project.recorded_frames import measured_frame
from ilf.project.state_codec import Decoded
from ilf.sources.frame_ref import FrameRef

from ..base.commands import Command, command, plain
from ..base.needs import Need
from ..project.loading import state_reader
from ..project.store import WorkStore
from ..state.workspace import Entry
from ..widgets.basics import Message, PlainLabel, answers, combo, form, lay_out, open_once, stack
from ..widgets.notices import error_text
from ..widgets.work_row import WorkRow
from ..work.steps import Ask, Steps, in_steps
from .context import Context, Feature

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
        self.setWindowTitle(f"Propagate blocks of {frame_name}")
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
        self.count.selectAll()  # what is typed replaces it
        self.resize(430, self.heightForWidth(430))  # its text wraps

    def _describe(self) -> None:
        self.last.setText(
            f"up to {self._names[self.count.value() - 1]}, of {counted(len(self._names), 'following frame')}"
        )


# One propagation.


@dataclass(eq=False)
class PropagationRun:
    """What has come of a propagation through frames. They may be many: their arrays are not kept.

    Attributes
    ----------
    source, how : str
        Name of the frame with the original blocks; "auto", "copied" or "flow".
    total : int
        Number of frames after the source.
    present : Entry
        The frame that is read, and propagated to.
    done, kept : list of str
        Names of the frames that have received blocks, and of those that have been worked on and kept theirs.
    ways : list of str
        The method used for each of the former.
    to_check : int
        Number of blocks that need a check.
    notes : list of str
        Sentences on single frames.
    stopped : bool
    """

    source: str
    how: str
    total: int
    present: Entry
    done: list[str] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    ways: list[str] = field(default_factory=list)
    to_check: int = 0
    notes: list[str] = field(default_factory=list)
    stopped: bool = False


_DONE = {"copied": "copied", "flow": "propagated along optical flow", "pose": "propagated by the camera pose"}
_MAX_NAMED = 3


def summary(run: PropagationRun) -> str:
    """Summarise a propagation in a few sentences; "" if nothing was done."""
    texts = []
    if run.done:
        how = " and ".join(f"{run.ways.count(way)} {_DONE[way]}" for way in _DONE if way in run.ways)
        texts.append(f"Blocks of {run.source} propagated to {_named(run.done)}: {how}.")
        texts.append(f"{counted(run.to_check, 'block')} to check.")
    if run.kept:
        texts.append(f"{_named(run.kept)} had been edited or run: their blocks were kept and propagated further.")
    if run.stopped:
        texts.append(f"Stopped after {len(run.done + run.kept)} of {counted(run.total, 'frame')}.")
    return " ".join(texts)


def _named(names: Sequence[str]) -> str:
    """Return the number of frames, with the first names."""
    return f"{counted(len(names), 'frame')} ({', '.join(names[:_MAX_NAMED])}{', …' * (len(names) > _MAX_NAMED)})"


def _of_files(entry: Entry, store: WorkStore) -> Decoded:
    """Read the files of a frame of the list that has no state, in any thread."""
    frame = measured_frame(entry.source or FrameRef(entry.key), store.places)
    return Decoded(FrameState(entry.id, frame, Blocks(np.zeros(frame.shape, np.int32))))


_MIN_TEXT_WIDTH = 120


class PropagationFeature(Feature):
    """Propagates the current frame's blocks to other frames, and those of the previous frame to the current one.

    One propagation runs at a time: each frame is opened and gets the blocks of the previous one as an undoable step.
    """

    more_commands = tuple(
        Command(
            f"propagate_{how}", text, hint, group="propagate_how", on=how == "auto", remembered=f"propagation/{how}"
        )
        for how, (text, hint) in _WAYS.items()
    )

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.run: PropagationRun | None = None
        """The propagation in progress; None for none."""
        self.label, self.work = PlainLabel(), WorkRow("propagation of blocks")
        self.label.setMinimumWidth(_MIN_TEXT_WIDTH)
        self.strip = QWidget()
        """Line under the views during a propagation: target frame, progress, and a button to stop."""
        parts = self.label, self.work
        lay_out(QHBoxLayout(self.strip), *parts, margins=(8, 2, 8, 2), stretched=parts)
        self.strip.hide()
        context.centre.add_strip(self.strip)
        self.work.cancelled.connect(self.stop)

    @property
    def how(self) -> str:
        """The selected method."""
        return next(how for how in _WAYS if self.context.actions[f"propagate_{how}"].isChecked())

    # commands

    def _frames(self) -> tuple[list[Entry], int]:
        """Return the frames of the list, and the row of the current one."""
        entries, present = list(self.workspace.entries), self.workspace.current_entry
        assert present is not None
        return entries, entries.index(present)

    def _why_not(self, last: bool) -> str:
        """Why there is no other frame to propagate to, or from: this is the last one, or the first one."""
        if self.run is not None:
            return "A propagation is in progress: wait, or cancel it."
        entries, row = self._frames()
        if row == (len(entries) - 1 if last else 0):
            return f"This is the {'last' if last else 'first'} frame of the list."
        return ""

    @command(
        "propagate_next",
        "Propagate blocks to the next &frame",
        icon="ph.arrow-bend-down-right",
        keys="Alt+PgDown",
        needs=Need.BLOCKS,
        why_off=lambda self: self._why_not(last=True),
    )
    def propagate_next(self) -> None:
        """Propagate the blocks to the next frame of the list, with names, locks and parameters, and show it."""
        self.propagate_through(1, replaces=True, shows=True)

    @command(
        "propagate_previous",
        "Propaga&te blocks from the previous frame",
        icon="ph.arrow-bend-right-down",
        keys="Alt+PgUp",
        needs=Need.FRAME,
        why_off=lambda self: self._why_not(last=False),
    )
    def propagate_previous(self) -> None:
        """Propagate the blocks of the previous frame of the list to this one, with names, locks and parameters."""
        entries, row = self._frames()
        self._start(entries[row - 1 : row + 1], replaces=True)

    def propagate_through(self, count: int, replaces: bool = False, shows: bool = False) -> None:
        """Propagate the blocks through the next `count` frames."""
        entries, row = self._frames()
        self._start(entries[row : row + count + 1], replaces, shows)

    @command(
        "propagate_through",
        "Propagate t&hrough the next frames…",
        icon="ph.fast-forward",
        needs=Need.BLOCKS,
        why_off=lambda self: self._why_not(last=True),
    )
    def ask_propagate_through(self) -> None:
        """Propagate the blocks through a number of following frames."""
        entries, row = self._frames()
        names = [entry.name for entry in entries[row + 1 :]]
        dialog = PropagateDialog(entries[row].name, names, self.how, self.context.window)

        def take() -> None:
            self.context.actions[f"propagate_{dialog.how.currentData()}"].trigger()
            self._start(entries[row : row + dialog.count.value() + 1], dialog.replaces.isChecked())

        open_once(dialog, take)

    def stop(self) -> None:
        """Stop the propagation; frames that have the blocks keep them."""
        if self.run is not None:
            self.run.stopped = True
            self.requests.cancel()
            self._end(self.run)

    # from frame to frame

    @in_steps
    def _start(self, frames: Sequence[Entry], replaces: bool, shows: bool = False) -> Steps[None]:
        """Propagate the blocks of the first frame through the others, and show each if `shows`; do nothing if a
        propagation is in progress. An error costs its frame alone, unless it is the first."""
        if self.run is not None or len(frames) < 2:
            return
        run = self.run = PropagationRun(frames[0].name, self.how, len(frames) - 1, frames[0])
        before: FrameState | None = None
        for number, entry in enumerate(frames):
            if entry not in self.workspace.entries:  # it has been removed from the list meanwhile
                run.total -= 1
                if number == 0:
                    break
                continue
            run.present = entry
            self._show(run, number)
            worked_on = entry.summary.blocks > 0 and entry.summary.stage in (Stage.EDITED, Stage.RUN, Stage.FAILED)
            keeps = before is None or (worked_on and not replaces)
            try:
                before = yield from self._to(run, entry, None if keeps else before, shows)
                run.kept += [entry.name] * (keeps and number > 0)
            except Exception as error:
                run.notes.append(f"{entry.name}: {error_text(error)}")
            if before is None:
                break
        self._end(run)

    def _to(self, run: PropagationRun, entry: Entry, before: FrameState | None, shows: bool) -> Steps[FrameState]:
        """Read a frame and propagate the blocks of the one before to it, unless it keeps its own; return its state."""
        workspace, store = self.workspace, self.context.loader.store
        try:
            read: Decoded = yield self._found(entry, state_reader(entry, store) or partial(_of_files, entry, store))
        except Exception as error:
            workspace.note_problem(entry, error_text(error))
            raise
        if before is None:
            if not read.state.blocks.labels.any():
                raise InputError("It has no blocks to propagate. Extract or draw some first.")
            return read.state
        found: Propagated = yield self._found(entry, partial(propagate_state, before, read.state, run.how))
        if entry not in workspace.entries:
            return before
        document = entry.document or self.context.loader.open_state(entry, read, show=False)
        workspace.take_propagated(document, found.state, f"Propagate blocks from {found.state.blocks.propagated_from}")
        if shows:
            workspace.show(document)
        run.done.append(document.name)
        run.ways.append(found.followed.how)
        run.to_check += len(found.state.to_check)
        run.notes += [f"{document.name}: {note}" for note in found.followed.notes]
        return found.state

    def _found(self, entry: Entry, find: Callable[[], object]) -> Ask:
        """Ask a worker to find something for a frame, which must stay open meanwhile."""
        what = f"propagation of blocks to {entry.name}"
        return lambda again: self.requests.ask(find, again, again, what=what, about=entry.document)

    def _end(self, run: PropagationRun) -> None:
        """Say what has been done."""
        self.run = None
        self.strip.hide()
        self.context.actions.refresh()
        notes, workspace, text = self.notes, self.workspace, summary(run)
        if text:
            notes.show_message(text)
        if run.to_check and workspace.shown is not None and workspace.shown.state.to_check:
            notes.offer(text, self.context.actions["next_check"])
        notes.warn("Propagation of blocks", run.notes)

    def _show(self, run: PropagationRun, number: int) -> None:
        """Show how far it is: at which frame, the source of which is 0."""
        if self.strip.isHidden():
            self.work.begin()
            self.strip.show()
        self.label.setText(
            f"Propagating blocks to {run.present.name} ({min(max(number, 1), run.total)} of {run.total})"
        )
        self.work.show_share(max(number - 1, 0) / run.total)
        self.context.actions.refresh()
