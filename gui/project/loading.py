"""Opens frames and extracts their blocks in the background: one queue for reading, one for extraction."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PySide6.QtCore import QObject, Signal
from PySide6.QtWidgets import QWidget

from ilf._runtime.formatting import covered
from ilf.data.blocks import Blocks
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.data.presets import preset
from ilf.errors import one_line
from ilf.project.recorded_frames import recorded_run
from ilf.project.sources import Places, moved
from ilf.project.state_codec import Decoded
from ilf.run.replaying import Replay
from ilf.run.run import Run
from ilf.segmentation.edges.frame_edges import edges_for
from ilf.segmentation.extraction import Extraction, extract
from ilf.sources.frame_ref import FrameRef, is_result_folder
from ilf.sources.listing import Listing, list_frames
from ilf.sources.named_places import NotAllowed, note_opened
from ilf.sources.reading import described_beside, read_frame

from ..state.document import Document
from ..state.parts import Part
from ..state.workspace import Entry, Workspace
from ..widgets.notes import Notes
from ..widgets.notices import ACCEPT, ask, error_text
from ..work.latest_request import Job, JobQueue
from ..work.run_recorder import first_run
from ..work.steps import Steps, in_steps
from .store import WorkStore

_RECORDED = "They are those of a recorded run, which is shown with its result."


def state_reader(entry: Entry, store: WorkStore) -> Callable[[], Any] | None:
    """Return a function that reads the state of a frame of the list in any thread: the present state if the frame is
    open, else the stored one; None if there is neither."""
    if entry.document is not None:
        present = Decoded(entry.document.snapshot())
        return lambda: present
    return partial(store.state, entry.id) if entry.has_state and store.has(entry.id) else None


_Opened = tuple[Run, Replay | None]
"""A run, and the record that it was read from; None if its blocks are not extracted yet."""


class FrameLoader(QObject):
    """Opens frames and extracts blocks, and tells the user what has come of it.

    A frame is shown as soon as it is read, also while others are being extracted.

    Attributes
    ----------
    reading : bool
        Whether frames are being read, or wait for it.
    extracting : list of Document
        Frames whose blocks are being extracted, or wait for it.
    present : str
        Description of the work in progress; "" when idle.

    Signals
    -------
    busy_changed()
        What is in progress has changed.
    replayed(object)
        A document that was opened from a record.
    listed(object, object)
        The FrameRef of a folder, and the Listing of its frames, which are now in the list.
    opening_failed(object, object)
        An Entry, and the exception that was raised on opening it.
    """

    busy_changed = Signal()
    replayed = Signal(object)
    listed = Signal(object, object)
    opening_failed = Signal(object, object)

    def __init__(self, workspace: Workspace, store: WorkStore, notes: Notes, window: QWidget) -> None:
        super().__init__(window)
        self._workspace, self._notes, self._window = workspace, notes, window
        self.store = store
        self.replace: Callable[[Sequence[Entry], Callable[[], None]], None] = lambda entries, then: then()
        """Prepares removal of frames that are read again: calls `then` unless the user cancels."""
        self.times: dict[str, float] = {}
        """Key of a frame -> its time [s], where its list has told it."""
        self._reading, self._extracting = self._lines = JobQueue(self), JobQueue(self)
        self.reading, self.present = False, ""
        self.extracting: list[object] = []
        for line in self._lines:
            line.changed.connect(self._follow)
        workspace.on(Part.LIST, self._cancel_closed)

    @property
    def busy(self) -> bool:
        """Whether anything is in progress or waiting."""
        return self.reading or bool(self.extracting)

    def _follow(self) -> None:
        """Take over what is in progress, and tell it."""
        self.reading = self._reading.busy
        self.extracting = [job.about for job in self._extracting.pending]
        jobs = (line.question for line in self._lines)
        self.present = next((job.what for job in jobs if job is not None and job.what), "")
        self.busy_changed.emit()

    @property
    def share_done(self) -> float:
        """Share of the queued frames and extractions that is done, 0-1; 0 for a single one."""
        done, pending = sum(line.done for line in self._lines), sum(len(line.pending) for line in self._lines)
        return done / max(done + pending, 1)

    # opening

    @in_steps
    def open(self, source: FrameRef) -> Steps[None]:
        """Read a frame, show it, and extract its blocks; of a folder with a result, open the recorded run.

        A frame of the list is only shown; if it was read with other options, it is read again and replaced, or, if only
        its camera differs, this is taken over, and the work on it stays.
        """
        workspace, entries = self._workspace, self._workspace.entries
        if self._shows(source):
            return
        if entries.of_key(source.key) is None and is_result_folder(source):
            self.open_new(source, source.name)
            return
        read = partial(_open, source, workspace.parameters.extraction)
        opened: _Opened = yield partial(self.read, f"Opening {Path(source.key).name}", read)
        former = entries.of_key(source.key)
        if former is not None:
            if self._shows(source) or self._take_camera(former, source, opened[0].frame):
                return
            yield partial(self.replace, [former])
            workspace.remove_entries([former])
        self._show_opened(source, opened)

    @in_steps
    def open_folder(self, how: FrameRef, show: bool = True) -> Steps[None]:
        """Add the frames of a folder to the list, with the reading options of `how`; with `show`, open the first, and
        replace frames of the list that were read with other options."""
        workspace, entries = self._workspace, self._workspace.entries

        def find() -> tuple[Listing, list[Entry]]:
            listing = list_frames(how.rgb, how.options)
            return listing, [Entry.of(source, from_folder=True) for source in listing.sources]

        listing, found = yield partial(self.read, f"Looking for frames in {Path(how.rgb).name}", find)
        options = {source.key: source.options for source in listing.sources}
        there = [entry for key in options if show and (entry := entries.of_key(key)) is not None]
        others = [one for one in there if one.source is not None and one.source.options != options[one.key]]
        if others:
            yield partial(self.replace, others)
        workspace.remove_entries(others)
        workspace.add_entries([entry for entry in found if entries.of_key(entry.key) is None])
        self.times |= dict(zip(options, listing.times, strict=False))
        self.listed.emit(how, listing)
        first = entries.of_key(found[0].key)
        if show and first is not None:
            self.open_entry(first)

    def open_entry(self, entry: Entry) -> None:
        """Show a frame of the list, in its stored state or read from its files.

        If another frame is selected before, it is not opened. A frame that cannot be opened is marked in the list.
        """
        if entry.document is not None:
            self._workspace.show(entry.document)
            return
        take: Callable[[Any], object]
        if do := state_reader(entry, self.store):
            take = partial(self.open_state, entry)
        else:
            source, parameters = entry.source or FrameRef(entry.key), self._workspace.parameters.extraction
            do = partial(_open, source, parameters, places=self.store.places if entry.source else None)
            take = partial(self._show_opened, source, entry=entry)

        def wanted() -> bool:
            return entry.document is None and self._workspace.entries.of(entry.id) is entry

        self._reading.add(
            Job(
                do,
                lambda found: take(found) if wanted() else None,
                lambda error: self._note_problem(entry, error) if wanted() else None,
                kind="opening",
                what=f"Opening {entry.name}",
                still_wanted=wanted,
            )
        )

    def open_new(self, source: FrameRef, name: str) -> None:
        """Open a frame as a new one of the list, beside others of the same files."""
        entry = replace(Entry.of(source), name=name)
        self._workspace.add_entries([entry])
        self.open_entry(entry)

    def read(
        self, what: str, do: Callable[[], object], take: Callable[..., None], fail: Callable[[], None] = lambda: None
    ) -> None:
        """Run `do` in the reading queue, in the background; then call `take` with its result in the GUI's thread, or
        report the error and call `fail`."""

        def give_up(error: Exception) -> None:
            self._notes.report(what, error)
            fail()

        def report(error: Exception) -> None:
            if isinstance(error, NotAllowed):
                ask_allowed(self._window, error, lambda: self.read(what, do, take, fail), lambda: give_up(error))
            else:
                give_up(error)

        self._reading.add(Job(do, take, report, what=what))

    def _shows(self, origin: FrameRef) -> bool:
        """Show the frame of the list that is of this origin; return False if there is none."""
        entry = self._workspace.entries.of_key(origin.key)
        if entry is None or entry.origin not in (origin, None):
            return False
        self.open_entry(entry)
        return True

    def _take_camera(self, entry: Entry, origin: FrameRef, frame: RGBDFrame) -> bool:
        """Take over the camera of a frame that was read again; return False if more of it differs."""
        document = entry.document
        if document is None or not document.set_camera(frame, origin):
            return False
        entry.source = origin
        self._workspace.show(document)
        camera = "no intrinsics" if frame.intrinsics is None else "other intrinsics"
        self._notes.show_message(f"{entry.name} has {camera} now; its blocks, edits and their results stay.")
        return True

    def _show_opened(self, origin: FrameRef, opened: _Opened, entry: Entry | None = None) -> None:
        """Show what was opened: a frame, whose blocks are extracted then, or a recorded run. If it was opened from the
        list, other frames of the same files are not affected."""
        run, again = opened
        document = Document.of(run, origin, origin.key, again)
        if entry is not None:
            document.change(id=entry.id)
        if again is None:
            self._workspace.open_document(document)
            self._extract_first(document, transient=entry is not None)
            return
        first = None if again.completion is None else first_run(document, again.completion)
        self._workspace.open_document(document, run, first=first)
        self._report_blocks(document, _RECORDED, *run.blocks.notes)
        self.replayed.emit(document)

    def open_state(self, entry: Entry, decoded: Decoded, show: bool = True) -> Document:
        """Open a frame of the list in a state and, with `show`, make it the current one."""
        document = Document.of_state(decoded.state, entry.source, entry.key)
        self._workspace.open_document(document, restored=entry.has_state, show=show)
        self._notes.warn(f"{document.name}: opened without some of its files", decoded.problems)
        return document

    def _note_problem(self, entry: Entry, error: Exception) -> None:
        self.opening_failed.emit(entry, error)
        problem = error_text(error)
        self._workspace.note_problem(entry, problem)
        self._notes.show_message(f"{entry.name} cannot be opened: {problem}")
        if isinstance(error, NotAllowed):
            ask_allowed(self._window, error, lambda: self.open_entry(entry))

    # extracting

    def extract(self, document: Document) -> None:
        """Extract the blocks of an open frame again, with the workspace's parameters."""
        self._ask_extraction(document, extract, self._take_extraction)

    def _extract_first(self, document: Document, transient: bool = False) -> None:
        """Extract the blocks of a frame that was opened without any. With `transient`, one that is not shown any more
        is closed instead, unless it has been worked on: it is opened again when it is shown."""

        def wanted() -> bool:
            passed = transient and document is not self._workspace.shown
            if passed and not (document.unsaved or document.counts()):
                self._workspace.unload(document, stored=False)
            return document in self._workspace.open and not document.blocks.propagated_from

        self._ask_extraction(document, _extract_first, self._take_first, wanted)

    def _ask_extraction(
        self,
        document: Document,
        extract: Callable[[RGBDFrame, BlockParameters], Extraction],
        take: Callable[[Document, Extraction, BlockParameters], None],
        wanted: Callable[[], bool] = lambda: True,
    ) -> None:
        what, documents = f"Extracting blocks of {document.name}", self._workspace.open
        parameters = self._workspace.parameters.extraction
        self._extracting.add(
            Job(
                partial(extract, document.frame, parameters),
                lambda found: take(document, found, parameters) if document in documents else None,
                partial(self._notes.report, what),
                what=what,
                still_wanted=lambda: document in documents and wanted(),
                about=document,
            )
        )

    def _cancel_closed(self) -> None:
        """Cancel extractions of closed frames."""
        self._extracting.cancel_if(lambda document: document not in self._workspace.open)

    def _take_first(self, document: Document, found: Extraction, parameters: BlockParameters) -> None:
        """Set the blocks of a frame that was opened without any, unless blocks were propagated to it since."""
        if document.blocks.propagated_from:
            return
        if document.undo_stack.count() or document.counts():
            document.set_extracted(found, parameters, self._workspace.parameters.keeps_handmade)
        else:
            document.set_first(found, parameters)
        beside = described_beside(document.origin) if isinstance(document.origin, FrameRef) else ""
        self._report_blocks(document, beside, *document.frame.notes, *found.notes)

    def _take_extraction(self, document: Document, found: Extraction, parameters: BlockParameters) -> None:
        """Set the blocks of an extraction with the workspace's parameters."""
        kept = document.set_extracted(found, parameters, self._workspace.parameters.keeps_handmade)
        self._report_blocks(document, _describe_kept(*kept), *found.notes)

    def _report_blocks(self, document: Document, *notes: str) -> None:
        share = float((document.labels > 0).mean())
        text = f"{document.name}: {covered(len(document.counts()), share)}."
        self._notes.show_message(" ".join(filter(None, (text, *notes))))


@in_steps
def ask_allowed(
    window: QWidget, error: NotAllowed, yes: Callable[[], object], no: Callable[[], object] = lambda: None
) -> Steps[None]:
    """Ask whether to open places that a file names; call `yes` after they were noted as opened by the user."""

    places = "\n".join(map(one_line, error.places))
    text = f"A file names this outside its own folder, which was never opened here:\n{places}"
    more = (
        "Open it, and files beside it that are named, only if you trust the file: opening may contact another computer."
    )
    if (yield partial(ask, window, "Open what a file names?", text, more, [("&Open", ACCEPT)])):
        note_opened(*error.places, beside=True)
        yes()
    else:
        no()


def _describe_kept(locked: int, by_hand: int, all_kept: bool) -> str:
    """Return a sentence about the blocks that an extraction kept; "" for none."""
    counts = [f"{locked} locked"] * (locked > 0) + [f"{by_hand} made by hand"] * (by_hand > 0)
    if not counts:
        return ""
    text = f"Kept: {', '.join(counts)}."
    if all_kept and by_hand:
        text += " These are all blocks: switch off 'Keep blocks made by hand' to extract them again."
    return text


def _open(source: FrameRef, parameters: BlockParameters, places: Places | None = None) -> _Opened:
    again = recorded_run(source, places)
    if again is not None:
        again.completion  # noqa: B018 - read here, in the background
        return again.run, again
    frame = read_frame(source if places is None else moved(source, places))
    no_blocks = np.zeros(frame.shape, np.int32)
    return Run(frame, Blocks(no_blocks, extraction=parameters, extracted=no_blocks)), None


def _extract_first(frame: RGBDFrame, parameters: BlockParameters) -> Extraction:
    found = extract(frame, parameters)
    edges_for(frame, preset(), parameters)  # in advance, so that the first slider move is fast
    return found
