"""Propagation of blocks from frame to frame: commands, the work, its progress, and a summary."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np
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
from ilf.data.blocks import Blocks
from ilf.errors import IlfError
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


@dataclass(eq=False)
class PropagationRun:
    """A propagation of blocks through frames of the list. Frames may be many: their arrays are not kept.

    Attributes
    ----------
    source : str
        Name of the frame with the original blocks.
    how : str
        "auto", "copied" or "flow".
    replaces : bool
        Whether blocks of frames that have been worked on are replaced; otherwise these frames keep their blocks, which
        are propagated further.
    shows : bool
        Whether each frame is shown with its blocks.
    waiting : deque of Entry
        Frames that follow; the source is the first.
    total : int
        Number of frames after the source.
    present : Entry
        The frame that is read, and propagated to.
    before : FrameState or None
        State of the frame whose blocks are propagated next; None before the source was read.
    done, kept : list of str
        Names of the frames that have received blocks, and of those that have kept theirs.
    ways : list of str
        The method used for each of the former.
    to_check, new, gone : int
        Numbers of blocks.
    failed : int
        Number of frames that could not be read or propagated to.
    notes : list of str
        Sentences on single frames.
    """

    source: str
    how: str
    replaces: bool
    shows: bool
    waiting: deque[Entry]
    total: int
    present: Entry
    before: FrameState | None = None
    done: list[str] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    ways: list[str] = field(default_factory=list)
    to_check: int = 0
    new: int = 0
    gone: int = 0
    failed: int = 0
    notes: list[str] = field(default_factory=list)
    stopped: bool = False

    @property
    def processed(self) -> int:
        """Number of processed frames."""
        return len(self.done) + len(self.kept) + self.failed

    def keeps(self, entry: Entry) -> bool:
        """Whether a frame keeps its blocks, as the source does."""
        summary = entry.summary
        worked_on = summary.blocks > 0 and summary.stage in (Stage.EDITED, Stage.RUN, Stage.FAILED)
        return self.before is None or (worked_on and not self.replaces)


_DONE = {"copied": "copied", "flow": "propagated along optical flow", "pose": "propagated by the camera pose"}
_MAX_NAMED = 3


def summary(run: PropagationRun) -> str:
    """Summarise a propagation in a few sentences; "" if nothing was done."""
    texts = []
    if run.done:
        how = " and ".join(f"{run.ways.count(way)} {_DONE[way]}" for way in _DONE if way in run.ways)
        texts.append(f"Blocks of {run.source} propagated to {_named(run.done)}: {how}.")
        parts = [f"{count} {what}" for what, count in (("new", run.new), ("gone", run.gone)) if count]
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


def _read_and_propagate(
    read: Callable[[], Decoded], before: FrameState | None, how: str
) -> tuple[Decoded, Propagated | IlfError | None]:
    """Read a frame and propagate the blocks of another to it, if there is one; called in a worker thread."""
    found = read()
    try:
        return found, None if before is None else propagate_state(before, found.state, how)
    except IlfError as error:
        return found, error


_MIN_TEXT_WIDTH = 120
_HOW_KEY = "carrying/how"


class PropagationFeature(Feature):
    """Propagates the current frame's blocks to other frames, and those of the previous frame to the current one.

    One propagation runs at a time: each frame is opened and gets the blocks of the previous one as an undoable step.
    """

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
            self.run = PropagationRun(source.name, self.how, replaces, shows, waiting, len(frames) - 1, source)
            self._next(self.run)

    def _next(self, run: PropagationRun) -> None:
        """Read the next frame that is still listed, which must stay open meanwhile, and propagate blocks to it."""
        while run.waiting and run.waiting[0] not in self.context.workspace.entries:
            run.waiting.popleft()
            run.total -= 1
        if not run.waiting:
            self._end(run)
            return
        entry = run.present = run.waiting.popleft()
        store = self.context.loader.store
        read = state_reader(entry, store) or partial(_read_without_blocks, entry, store)
        before = None if run.keeps(entry) else run.before
        self.requests.ask(
            partial(_read_and_propagate, read, before, run.how),
            lambda found: self._take(run, *found),
            partial(self._take_error, run),
            what=f"propagation of blocks to {entry.name}" if before is not None else "",
            about=entry.document,
        )
        self._show()

    def _take(self, run: PropagationRun, read: Decoded, outcome: Propagated | IlfError | None) -> None:
        entry, workspace = run.present, self.context.workspace
        if entry not in workspace.entries:  # it has been removed from the list meanwhile
            run.total -= 1
            if run.before is None:
                run.waiting.clear()
        elif isinstance(outcome, Propagated):
            self._take_propagated(run, read, outcome)
        elif isinstance(outcome, IlfError):
            self._note_failed(run, f"{entry.name}: {error_text(outcome)}")
        elif read.state.blocks.labels.any():
            run.kept += [entry.name] * (run.before is not None)
            run.before = read.state
        else:
            self._note_failed(run, f"{entry.name} has no blocks to propagate: extract or draw some first.")
        self._next(run)

    def _take_propagated(self, run: PropagationRun, read: Decoded, outcome: Propagated) -> None:
        entry, workspace, found = run.present, self.context.workspace, outcome.followed
        document = entry.document or self.context.loader.open_state(entry, read, show=False)
        source = outcome.state.blocks.propagated_from
        workspace.take_propagated(document, outcome.state, f"Propagate blocks from {source}")
        if run.shows:
            workspace.show(document)
        run.done.append(document.name)
        run.ways.append(found.how)
        run.to_check += len(outcome.state.to_check)
        run.new += len(found.new)
        run.gone += len(found.gone)
        run.notes += [f"{document.name}: {note}" for note in found.notes]
        run.before = outcome.state

    def _take_error(self, run: PropagationRun, error: Exception) -> None:
        self.context.workspace.note_problem(run.present, error_text(error))
        self._note_failed(run, f"{run.present.name}: {error_text(error)}")
        self._next(run)

    def _note_failed(self, run: PropagationRun, note: str) -> None:
        run.failed += 1
        run.notes.append(note)
        if run.before is None:
            run.waiting.clear()

    def _end(self, run: PropagationRun) -> None:
        """Say what has been done."""
        self.run = None
        self._show()
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
