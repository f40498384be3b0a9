"""The workspace: all frames of the window, open or not, the current one, and their parameters. No widgets."""

from __future__ import annotations

import os
import uuid
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Self
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject, Signal
from PySide6.QtGui import QUndoGroup, QUndoStack

from ilf.completion.block import Watch
from ilf.data.blocks import OwnValues
from ilf.project.frame_state import FrameState
from ilf.project.project import FrameSummary, Stage
from ilf.project.run_history import StoredRun
from ilf.run.run import Run
from ilf.segmentation.editing.patches import patch_between
from ilf.sources.frame_ref import FrameRef

from .document import Document
from .parameters import DocumentParameters
from .parts import Changes, Part, Swap
from .results import FrameResults, ViewedIteration


@dataclass(eq=False)
class Entry:
    """A frame of the list.

    Attributes
    ----------
    id : str
        Never changes for a frame.
    key : str
        The path of its depth file, or of the record that it was opened from.
    name : str
    source : FrameRef or None
        How to read it; None if it can only be read from its stored state.
    document : Document or None
        None while it is not open.
    has_state : bool
        Whether its state is stored and is opened instead of the source.
    from_folder : bool
        Whether it was found in a folder that the user opened.
    changes : int
        How often it was changed while it was not open.
    problem : str
        Why it could not be opened; "" if it was not tried.
    """

    id: str
    key: str
    name: str
    source: FrameRef | None = None
    document: Document | None = None
    has_state: bool = False
    from_folder: bool = False
    changes: int = 0
    problem: str = ""
    _summary: FrameSummary = field(default_factory=FrameSummary)
    _unsaved: str = ""
    """Its unsaved changes while it is not open."""

    @classmethod
    def of(cls, source: FrameRef, from_folder: bool = False) -> Self:
        """Make an entry for a frame that has not been read; its name comes from its files."""
        return cls(uuid.uuid4().hex, source.key, source.name, source, from_folder=from_folder)

    @property
    def summary(self) -> FrameSummary:
        """Summary of the frame, or of the problem with it."""
        stored = self.stored_summary
        return replace(stored, stage=Stage.FAILED, problem=self.problem) if self.problem else stored

    @property
    def stored_summary(self) -> FrameSummary:
        """Summary of the work on the frame; up to date if the frame is open."""
        return self._summary if self.document is None else self.document.summary()

    def set_summary(self, summary: FrameSummary) -> None:
        """Set the summary of a frame that is not open."""
        self._summary = summary

    @property
    def unsaved(self) -> bool:
        """Whether it has changes that are not in the project file."""
        return bool(self._unsaved) if self.document is None else self.document.unsaved

    def unsaved_summary(self) -> str:
        """Return a summary of the unsaved changes, as "3 edits, 1 run"; "" for none."""
        return self._unsaved if self.document is None else self.document.unsaved_summary()

    def set_unsaved(self, unsaved: bool) -> None:
        """Set whether a frame that is not open has unsaved changes."""
        self._unsaved = (self._unsaved or "changes") if unsaved else ""
        self.changes += unsaved

    @property
    def origin(self) -> object:
        """What it was or will be opened from."""
        return self.source if self.document is None else self.document.origin

    @property
    def place(self) -> str | None:
        """The recording or the folder that it is from; None if it was not opened from one."""
        source = self.source
        if source is None:
            return None
        return source.rgb if source.frame is not None else os.path.dirname(source.rgb)

    @property
    def note(self) -> str:
        """The user's note on it."""
        return self.summary.note


class Entries:
    """The frames in list order. Only the workspace changes the list, and tells of it."""

    def __init__(self) -> None:
        self._entries: list[Entry] = []
        self._by_id: dict[str, Entry] = {}
        self._by_key: dict[str, Entry] = {}

    def __len__(self) -> int:
        return len(self._entries)

    def __getitem__(self, row: int) -> Entry:
        return self._entries[row]

    def __contains__(self, entry: Entry) -> bool:
        return self._by_id.get(entry.id) is entry

    def __iter__(self) -> Iterator[Entry]:
        return iter(self._entries)

    def of(self, id: str) -> Entry | None:
        """Return the entry with an id."""
        return self._by_id.get(id)

    def of_key(self, key: str) -> Entry | None:
        """Return the entry with a path."""
        return self._by_key.get(key)

    def add(self, entries: Sequence[Entry]) -> None:
        """Add entries with new ids at the end."""
        self._entries += entries
        self._by_id |= {entry.id: entry for entry in entries}
        self._by_key |= {entry.key: entry for entry in entries}

    def remove(self, entries: Collection[Entry]) -> None:
        """Remove entries."""
        for entry in entries:
            entry.document = None  # a list that is not drawn would keep it alive
            self._by_id.pop(entry.id, None)
            if self._by_key.get(entry.key) is entry:
                del self._by_key[entry.key]
        self._entries = [entry for entry in self._entries if entry.id in self._by_id]

    def attach(self, document: Document) -> Entry:
        """Attach an opened frame to its entry and return it; a new entry if there is none."""
        entry = self.of(document.id) or self.of_key(document.key)
        if entry is None:
            source = document.origin if isinstance(document.origin, FrameRef) else None
            entry = Entry(document.id, document.key, document.name, source, document)
            self.add([entry])
            return entry
        document.change(id=entry.id, note=entry.note, done=entry.summary.done)
        document.had_unsaved = entry.unsaved
        entry.document, entry.name, entry.problem = document, document.name, ""
        return entry

    def detach(self, entry: Entry, stored: bool) -> None:
        """Detach a closed frame from its entry; `stored`: whether its state is stored."""
        entry._unsaved = entry.unsaved_summary()
        entry.set_unsaved(entry.unsaved)
        entry.set_summary(entry.stored_summary)
        entry.document, entry.has_state = None, stored


_MAX_WATCHED = 4
"""Maximum number of frames with key frames at a time."""


class Workspace(Changes):
    """The state of the window: the frames, which one is the current one, and the parameters that they may share.

    Attributes
    ----------
    open : list of Document
    shown : Document or None
        The current one; None if no frame is open.
    entries : Entries
        All frames, open or not.
    undo_group : QUndoGroup
        The undo histories of all documents; that of the current one is the active one.
    parameters : DocumentParameters
    viewed_iteration : ViewedIteration or None
        The earlier iteration that the views show instead of the current depth.

    Signals
    -------
    project_touched()
        Content of the project apart from its frames has changed: the list and its order, shared settings.
    """

    project_touched = Signal()

    shown: Document | None

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.open: list[Document] = []
        self.entries = Entries()
        self.undo_group = QUndoGroup(self)
        self._empty_stack = QUndoStack(self)
        self.parameters = DocumentParameters(self)
        self.viewed_iteration: ViewedIteration | None = None
        self._with_key_frames: WeakKeyDictionary[Document, None] = WeakKeyDictionary()
        """Frames with key frames, the last run at the end."""

    @property
    def current(self) -> Document:
        """The document that is `shown`, where there must be one."""
        if self.shown is None:
            raise RuntimeError("no frame is open")
        return self.shown

    @property
    def current_entry(self) -> Entry | None:
        """The entry of the current document; None if no frame is open."""
        return None if self.shown is None else self.entries.of(self.shown.id)

    @property
    def chosen(self) -> int:
        """The first selected block of the current document; 0 for none."""
        return 0 if self.shown is None else self.shown.chosen

    def select(self, labels: Sequence[int]) -> None:
        """Select blocks of the current document, if there is one."""
        if self.shown is not None:
            self.shown.select(labels)

    @property
    def stroke_in_progress(self) -> bool:
        """Whether a stroke is in progress."""
        return self.shown is not None and self.shown.stroke_in_progress

    def end_stroke(self) -> None:
        """Drop a stroke in progress, before all is stored."""
        if self.stroke_in_progress:
            self.current.prepare_change()

    def touch_project(self, part: Part) -> None:
        """Tell of a change of the project apart from its frames."""
        self.note(part)
        self.project_touched.emit()

    def add(self, document: Document, show: bool = True) -> None:
        """Add an open frame that has its parameters and, with `show`, make it the current one."""
        self.open.append(document)
        document.changes = self
        listed = len(self.entries)
        self.entries.attach(document)
        self.undo_group.addStack(document.undo_stack)
        self.note(Part.LIST)
        if show:
            self.show(document)
        if len(self.entries) > listed:
            self.project_touched.emit()

    def show(self, document: Document | None) -> None:
        """Make a frame the current one."""
        if document is self.shown:
            return
        self.parameters.leave()
        if self.shown is not None:
            self.shown.prepare_change()
        self.shown = document
        self.undo_group.setActiveStack(document.undo_stack if document else self._empty_stack)
        self.note(Part.FRAME)

    def unload(self, document: Document, stored: bool = True) -> None:
        """Close a frame whose state is stored, or that has none; its entry stays, and it can be opened again in the
        same state, without its undo history."""
        entry = self.entries.of(document.id)
        if entry is not None:
            self.entries.detach(entry, stored)
        self._close(document)

    def add_entries(self, entries: Sequence[Entry]) -> None:
        """Add frames to the list without opening them."""
        self.entries.add(entries)
        self.touch_project(Part.LIST)

    def remove_entries(self, entries: Collection[Entry]) -> None:
        """Remove frames from the list permanently, and close those that are open."""
        gone = {entry.document for entry in entries if entry.document is not None}
        if self.shown in gone:  # show the nearest remaining frame
            position = self.open.index(self.shown)
            nearest = [*reversed(self.open[:position]), *self.open[position:]]
            self.show(next((document for document in nearest if document not in gone), None))
        for document in [document for document in self.open if document in gone]:
            self._close(document)
        self.entries.remove(entries)
        self.touch_project(Part.LIST)

    def note_problem(self, entry: Entry, problem: str) -> None:
        """Store why a frame of the list could not be opened."""
        entry.problem = problem
        self.note(Part.LIST)

    def _close(self, document: Document) -> None:
        position = self.open.index(document)
        self.open.remove(document)
        if document is self.shown:
            self.show(self.open[max(position - 1, 0)] if self.open else None)
        document.changes = Changes()
        self.undo_group.removeStack(document.undo_stack)
        document.undo_stack.setParent(None)  # PySide treats it as owned by the group while the group exists
        document.undo_stack.clear()  # commands and document reference each other and would never be freed
        self.note(Part.LIST)

    def set_note(self, entry: Entry, note: str) -> None:
        """Set the user's note on a frame, open or not."""
        self._mark(entry, note, entry.summary.done)

    def set_done(self, entry: Entry, done: bool) -> None:
        """Set whether the user has marked a frame as done, open or not."""
        self._mark(entry, entry.note, done)

    def _mark(self, entry: Entry, note: str, done: bool) -> None:
        if (note, done) == (entry.note, entry.summary.done):
            return
        if entry.document is None:
            entry.set_unsaved(True)
            entry.set_summary(replace(entry.stored_summary, note=note, done=done))
        else:
            entry.document.change(note=note, done=done)
            entry.document.touch()
        self.touch_project(Part.LIST)

    def open_document(
        self,
        document: Document,
        recorded: Run | None = None,
        restored: bool = False,
        show: bool = True,
        first: StoredRun | None = None,
    ) -> None:
        """Open a frame and, with `show`, make it the current one.

        It starts with the parameters of the current frame, or the shared ones, unless it is `restored`. With
        `recorded`, it takes the parameters and the extraction parameters of that run, and the blocks that were run are
        selected if they are not all; with that run as the `first` of its history, also the results.
        """
        self.parameters.start(document, recorded, restored)
        if recorded is not None and recorded.only is not None and set(recorded.only) != set(document.counts()):
            document.change(selected=tuple(sorted(set(recorded.only))))
        if first is not None:
            document.restore_results(list(first.results.values()), first.extrapolation)
            document.change(runs=(first,), next_number=first.number + 1)
            document.note_saved(document.stamp)
        self.add(document, show)

    def watch(self, document: Document, run: Run) -> Watch:
        """Return the observer that stores key frames of a run; key frames of frames run long ago are dropped."""
        others = [one for one in self._with_key_frames if one is not document]
        for one in others[: 1 - _MAX_WATCHED]:
            one.key_frames.clear()
        self._with_key_frames = WeakKeyDictionary(dict.fromkeys([*others[1 - _MAX_WATCHED :], document]))
        return document.key_frames.watch(run)

    def view_iteration(self, viewed_iteration: ViewedIteration | None) -> None:
        """Show the current frame's depth as of an earlier iteration; None for its current depth."""
        if viewed_iteration is not self.viewed_iteration:
            self.viewed_iteration = viewed_iteration
            self.note(Part.ITERATION)

    def take_propagated(self, document: Document, propagated: FrameState, text: str) -> None:
        """Take over the blocks propagated to a frame, with all their attributes, as one undo step."""
        document.prepare_change()
        patch, drawn = patch_between(document.labels, propagated.blocks.labels), propagated.blocks.drawn
        blocks = replace(propagated.blocks, drawn=None if drawn is None else drawn.copy())

        def exchange(to: tuple[FrameState, bool]) -> tuple[FrameState, bool]:
            other, forward = to
            document.prepare_change()
            if patch is not None:
                document.apply(patch, forward)
            former = document.state
            blocks = document.take_blocks(other.blocks)
            document.change(to_check=other.to_check, extrapolate=other.extrapolate)
            self.parameters.take_common(document, other.common, other.own_parameters)
            document.note(Part.INFOS | Part.LIST)
            document.note_labels_changed(patch)
            return replace(former, blocks=blocks), not forward

        document.undo_stack.push(Swap(text, (replace(propagated, blocks=blocks), True), exchange))
        if not document.selected:
            document.select(propagated.selected)

    def accept_run(self, kept: StoredRun) -> list[int]:
        """Replace the current results by those of a stored run, with its parameters, as one undo step.

        Only blocks that have not changed since are replaced. Returns these blocks.
        """
        document, parameters, common = self.current, self.parameters, kept.run.parameters
        results = document.fitting_results(kept)
        former, former_own = document.state.common, document.blocks.own
        own: dict[int, OwnValues] = {
            result.block.label: {}
            if result.parameters.same_effect(common)
            else result.parameters.differences_from(common)
            for result in results
        }

        def exchange(accepted: tuple[FrameResults, FrameResults] | None) -> tuple[FrameResults, FrameResults] | None:
            """Accept the results and return those before and after; given these, undo it: later results stay."""
            if accepted is None:
                parameters.take(document, common.to_dict(), own)
                former_results = document.restore_results(results, kept.extrapolation)
                document.note(Part.RESULTS)
                return former_results, document.results.snapshot()
            parameters.take(document, former.to_dict(), {label: former_own.get(label, {}) for label in own})
            document.put_back_results(*accepted)
            document.note(Part.RESULTS)
            return None

        if results:
            where = "" if common == former else parameters.all_frames_text(document)
            document.undo_stack.push(Swap(f"Accept {kept.name}{where}", None, exchange))
        return list(own)
