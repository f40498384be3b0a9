"""Propagation of blocks from frame to frame: commands, the work, its progress, and a summary."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from PySide6.QtCore import QSettings, Qt, Signal
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
from ..state.document import Document
from ..state.entries import Entry
from ..widgets.basics import Message, PlainLabel, answers, combo, form, lay_out, open_once, stack
from ..widgets.notices import error_text
from ..widgets.work_row import WorkRow
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


# One propagation.


class PropagatedFrame(NamedTuple):
    """What is told of a frame that has received blocks; its arrays are not kept, since frames may be many.

    Attributes
    ----------
    name, how : str
        Of the frame, and of the method used.
    to_check, new, gone : int
        Numbers of blocks.
    notes : tuple of str
    """

    name: str
    how: str
    to_check: int
    new: int
    gone: int
    notes: tuple[str, ...]


@dataclass(eq=False)
class PropagationRun:
    """A propagation of blocks through frames of the list.

    Attributes
    ----------
    source : Entry
        The frame with the original blocks.
    how : str
        "auto", "copied" or "flow".
    replaces : bool
        Whether blocks of frames that have been worked on are replaced; otherwise these frames keep their blocks, which
        are propagated further.
    shows : bool
        Whether each frame is shown as soon as it is read.
    waiting : deque of Entry
        Frames that follow; the source is the first.
    total : int
        Number of frames after the source.
    present : Entry
        The target frame; the source while that is read.
    before : FrameState or None
        State of the frame whose blocks are propagated next; None before the source was read.
    done : list of PropagatedFrame
    kept : list of str
        Names of frames that have kept their blocks.
    problems : list of str
        A sentence for each frame that could not be read or propagated to.
    """

    source: Entry
    how: str
    replaces: bool
    shows: bool
    waiting: deque[Entry]
    total: int
    present: Entry
    before: FrameState | None = None
    done: list[PropagatedFrame] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    stopped: bool = False

    @property
    def processed(self) -> int:
        """Number of processed frames."""
        return len(self.done) + len(self.kept) + len(self.problems)

    @property
    def to_check(self) -> int:
        """Number of blocks that need a check."""
        return sum(frame.to_check for frame in self.done)

    @property
    def notes(self) -> list[str]:
        """Notes on single frames, a sentence each."""
        return [*self.problems, *(f"{frame.name}: {note}" for frame in self.done for note in frame.notes)]

    def keeps(self, entry: Entry) -> bool:
        """Whether a frame keeps its blocks."""
        summary = entry.summary
        return not self.replaces and summary.blocks > 0 and summary.stage in (Stage.EDITED, Stage.RUN, Stage.FAILED)


_DONE = {"copied": "copied", "flow": "propagated along optical flow", "pose": "propagated by the camera pose"}
_MAX_NAMED = 3


def summary(run: PropagationRun) -> str:
    """Summarise a propagation in a few sentences; "" if nothing was done."""
    texts = []
    if run.done:
        ways = [frame.how for frame in run.done]
        how = " and ".join(f"{ways.count(way)} {_DONE[way]}" for way in _DONE if way in ways)
        texts.append(f"Blocks of {run.source.name} propagated to {_named([frame.name for frame in run.done])}: {how}.")
        counts = {"new": sum(frame.new for frame in run.done), "gone": sum(frame.gone for frame in run.done)}
        parts = [f"{count} {what}" for what, count in counts.items() if count]
        texts.append(", ".join([f"{counted(run.to_check, 'block')} to check", *parts]) + ".")
    if run.kept:
        texts.append(f"{_named(run.kept)} had been edited or run: their blocks were kept and propagated further.")
    if run.stopped:
        texts.append(f"Stopped after {run.processed} of {counted(run.total, 'frame')}.")
    return " ".join(texts)


def _named(names: Sequence[str]) -> str:
    """Return the number of frames, with the first names."""
    return f"{counted(len(names), 'frame')} ({', '.join(names[:_MAX_NAMED])}{', …' * (len(names) > _MAX_NAMED)})"


def _read_without_blocks(entry: Entry, store: WorkStore) -> Decoded:
    """Read the files of a frame of the list that has no state, in any thread."""
    frame = measured_frame(entry.source or FrameRef(entry.key), store.places)
    return Decoded(FrameState(entry.id, frame, Blocks(np.zeros(frame.shape, np.int32))))


_MIN_TEXT_WIDTH = 120
_HOW_KEY = "carrying/how"


class PropagationFeature(Feature):
    """Propagates the current frame's blocks to other frames, and those of the previous frame to the current one.

    One propagation runs at a time: each frame is opened and gets the blocks of the previous one as an undoable step.

    Signals
    -------
    changed()
        A propagation has started, has reached another frame, or has ended.
    ended(object)
        The `PropagationRun` that has ended.
    """

    changed = Signal()
    ended = Signal(object)

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.run: PropagationRun | None = None
        """The propagation in progress; None for none."""
        actions = context.actions
        actions.add(
            Command(
                _COMMAND(how), text, hint, group="propagate_how", handler=partial(QSettings().setValue, _HOW_KEY, how)
            )
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

    @property
    def how(self) -> str:
        """The selected method."""
        return next(how for how in _WAYS if self.context.actions[_COMMAND(how)].isChecked())

    # commands

    def _frames(self) -> tuple[list[Entry], int]:
        """Return the frames of the list, and the row of the current one."""
        entries, present = list(self.context.workspace.entries), self.context.workspace.current_entry
        assert present is not None
        return entries, entries.index(present)

    def _why_not(self, last: bool) -> str:
        """Why there is no other frame to propagate to, or from: this is the last one, or the first one."""
        if self.run is not None:
            return "A propagation is in progress: wait, or stop it."
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
            self.context.actions[_COMMAND(dialog.how.currentData())].trigger()
            self.propagate_through(dialog.count.value(), dialog.replaces.isChecked())

        open_once(dialog, take)

    @command(
        "stop_propagation",
        "&Stop",
        icon="ph.stop",
        why_off=lambda self: "" if self.run else "No propagation is in progress.",
    )
    def _stop(self) -> None:
        """Stop the propagation; frames that have the blocks keep them."""
        if self.run is not None:
            self.run.stopped = True
            self.requests.cancel()
            self._end(self.run)

    # from frame to frame

    def _start(self, frames: Sequence[Entry], replaces: bool, shows: bool = False) -> None:
        """Propagate the blocks of the first frame through the others; do nothing if a propagation is in progress."""
        if self.run is None and len(frames) > 1:
            source, waiting = frames[0], deque(frames)
            self.run = PropagationRun(source, self.how, replaces, shows, waiting, len(frames) - 1, source)
            self._next(self.run)

    def _next(self, run: PropagationRun) -> None:
        """Read the next frame that is still listed."""
        while run.waiting and run.waiting[0] not in self.context.workspace.entries:
            run.waiting.popleft()
            run.total -= 1
        if not run.waiting:
            self._end(run)
            return
        entry = run.present = run.waiting.popleft()
        store = self.context.loader.store
        read = state_reader(entry, store) or partial(_read_without_blocks, entry, store)
        self._ask(run, read, partial(self._take_read, run), None)
        self._show()

    def _ask(
        self, run: PropagationRun, find: Callable[[], Any], take: Callable[[Any], None], read: Decoded | None
    ) -> None:
        """Ask for what the propagation to the present frame needs, which must stay open meanwhile."""
        present = run.present
        what = "" if present is run.source else f"propagation of blocks to {present.name}"
        fail = partial(self._take_error, run, read)
        self.requests.ask(find, take, fail, what=what, about=present.document)

    def _take_read(self, run: PropagationRun, read: Decoded) -> None:
        """Propagate the blocks of the frame before to one that has been read, and show it meanwhile."""
        entry, before, workspace = run.present, run.before, self.context.workspace
        if run.shows and entry is not run.source and entry in workspace.entries:
            workspace.show(self._open(entry, read))
        if before is None or (entry is not run.source and run.keeps(entry)):
            self._take(run, read, read.state)
        else:
            found = partial(propagate_state, before, read.state, run.how)
            self._ask(run, found, partial(self._take, run, read), read)

    def _take(self, run: PropagationRun, read: Decoded, outcome: Propagated | FrameState) -> None:
        entry, workspace = run.present, self.context.workspace
        if entry not in workspace.entries:  # it has been removed from the list meanwhile
            run.total -= 1
            if entry is run.source:
                run.waiting.clear()
        elif isinstance(outcome, Propagated):
            document, source = self._open(entry, read), outcome.state.blocks.propagated_from
            workspace.take_propagated(document, outcome.state, f"Propagate blocks from {source}")
            found, to_check = outcome.followed, len(outcome.state.to_check)
            done = PropagatedFrame(document.name, found.how, to_check, len(found.new), len(found.gone), found.notes)
            run.done.append(done)
            run.before = outcome.state
        elif outcome.blocks.labels.any():
            if entry is not run.source:
                run.kept.append(entry.name)
            run.before = outcome
        else:
            run.problems.append(f"{entry.name} has no blocks to propagate: extract or draw some first.")
            run.waiting.clear()
        self._next(run)

    def _open(self, entry: Entry, found: Decoded) -> Document:
        """Return the document of a frame, which is opened if necessary."""
        return entry.document or self.context.loader.open_state(entry, found, show=False)

    def _take_error(self, run: PropagationRun, read: Decoded | None, error: Exception) -> None:
        run.problems.append(f"{run.present.name}: {error_text(error)}")
        if read is None:
            self.context.workspace.note_problem(run.present, error_text(error))
        if run.before is None:
            run.waiting.clear()
        self._next(run)

    def _end(self, run: PropagationRun) -> None:
        """Say what has been done."""
        self.run = None
        self._show()
        self.ended.emit(run)
        notes, workspace, text = self.context.notes, self.context.workspace, summary(run)
        if text:
            notes.show_message(text)
        if run.to_check and workspace.has_current and workspace.current.state.to_check:
            notes.offer(text, self.context.actions["next_check"])
        notes.warn("Propagation of blocks", run.notes)

    def _show(self) -> None:
        """Show how far it is."""
        run = self.run
        if run is None:
            self.strip.hide()
        elif run.total > 0:
            if self.strip.isHidden():
                self.work.begin()
                self.strip.show()
            done = min(run.processed, run.total - 1)
            self.label.setText(f"Propagating blocks to {run.present.name} ({done + 1} of {run.total})")
            self.work.show_share(done / run.total)
        self.context.actions.refresh()
        self.changed.emit()
