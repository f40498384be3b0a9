"""Opens frames and extracts their blocks in the background: one queue for reading, one for extraction."""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any
from weakref import WeakSet

import numpy as np
from PySide6.QtCore import QObject, Signal

from ilf._runtime.named_places import NotAllowed
from ilf.completion.filter import edges_for
from ilf.data.blocks import Blocks
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.data.presets import preset
from ilf.errors import IlfError
from ilf.io.depth_reading import PlausibilityWarning
from ilf.project.recorded_frames import measured_frame, recorded_run
from ilf.project.sources import Places
from ilf.project.state_codec import Decoded
from ilf.run.replaying import Replay, replay
from ilf.run.run import Run
from ilf.sources.frame_folder import is_frame_folder
from ilf.sources.frame_ref import FrameRef
from ilf.sources.listing import Listing, list_frames
from ilf.sources.opening import is_recording
from ilf.sources.own_results import is_result_folder
from ilf.sources.reading import described_beside, read_depth, read_frame

from ..state.document import Document
from ..state.entries import Entry
from ..state.parts import Part
from ..state.workspace import Workspace
from ..work.found_blocks import FoundBlocks, describe_blocks, find
from ..work.latest_request import Job, JobQueue
from .store import WorkStore

_RECORDED = "They are those of a recorded run, which is shown with its result."

# Folders of frames and recordings: their frames, and a preview of the first. Without Qt.


@dataclass(frozen=True, eq=False)
class FolderPreview:
    """A preview of a folder of frames or a recording before it is opened.

    Attributes
    ----------
    listing : Listing
        Its frames.
    frame : RGBDFrame or None
        The first frame; None if it cannot be read.
    problem : str
        Why it cannot be read; "" if it can.
    plausibility_warnings : tuple of PlausibilityWarning
        Plausibility warnings about the way its depth is read.
    """

    listing: Listing
    frame: RGBDFrame | None
    problem: str = ""
    plausibility_warnings: tuple[PlausibilityWarning, ...] = ()


def contains_frames(path: str) -> bool:
    """Return whether a path is a folder of frames or a recording, by names only; a single frame's folder is not."""
    return is_recording(path) or (Path(path).is_dir() and not is_frame_folder(path))


def preview_folder(how: FrameRef) -> FolderPreview:
    """List the frames of the folder or recording `how.rgb` and read the first; raises what `list_frames` does."""
    listing = list_frames(how.rgb, how.options)
    first = listing.sources[0]
    try:
        if is_result_folder(first):
            return FolderPreview(listing, measured_frame(first))
        frame = read_frame(first)
        return FolderPreview(
            listing, frame, plausibility_warnings=read_depth(first).plausibility_warnings if frame.notes else ()
        )
    except IlfError as error:
        return FolderPreview(listing, None, str(error))


def state_reader(entry: Entry, store: WorkStore) -> Callable[[], Any] | None:
    """Return a function that reads the state of a frame of the list in any thread: the present state if the frame is
    open, else the stored one; None if there is neither."""
    if entry.document is not None:
        present = Decoded(entry.document.snapshot())
        return lambda: present
    return partial(store.read, entry.id) if entry.has_state and store.has(entry.id) else None


_Opened = tuple[Run, Replay | None]
"""A run, and the record that it was read from; None if its blocks are not extracted yet."""


class FrameLoader(QObject):
    """Opens frames and extracts blocks.

    A frame is shown as soon as it is read, also while others are being extracted.

    Signals
    -------
    busy_changed()
        `busy` or `present` has changed.
    message(str)
        The result of opening a frame or of an extraction.
    extracted(object)
        The Found of the frame that is or becomes the current one.
    replayed(object)
        A document that was opened from a record.
    listed(object, object)
        The FrameRef of a folder, and the Listing of its frames, which are now in the list.
    opening_failed(object, object)
        An Entry, and the exception that was raised on opening it.
    incomplete(object, object)
        A document that was opened from its stored state, and sentences about files that are not available.
    failed(str, object)
        A description of the work, and the exception.
    not_allowed(object, object, object)
        A NotAllowed, a function that tries again after the user has allowed its place, and one that gives up.
    idle()
        All work has ended.
    """

    busy_changed = Signal()
    message = Signal(str)
    extracted = Signal(object)
    replayed = Signal(object)
    listed = Signal(object, object)
    opening_failed = Signal(object, object)
    incomplete = Signal(object, object)
    failed = Signal(str, object)
    not_allowed = Signal(object, object, object)
    idle = Signal()

    def __init__(self, workspace: Workspace, store: WorkStore, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self.store = store
        self.replace: Callable[[Sequence[Entry], Callable[[], None]], None] = lambda entries, then: then()
        """Prepares removal of frames that are read again: calls `then` unless the user cancels."""
        self._reading, self._extracting = self._lines = JobQueue(self), JobQueue(self)
        self._was_busy = False
        self._postponed = WeakSet[Document]()
        """Frames whose extraction was postponed because another frame was shown."""
        for line in self._lines:
            line.changed.connect(self._emit_busy)
        workspace.on(Part.FRAME, self._resume_postponed)
        workspace.on(Part.LIST, self._cancel_closed)

    @property
    def busy(self) -> bool:
        """Whether anything is in progress or waiting."""
        return any(line.busy for line in self._lines)

    @property
    def present(self) -> str:
        """Description of the work in progress; "" when idle."""
        return self._reading.present or self._extracting.present

    @property
    def share_done(self) -> float:
        """Share of the queued frames and extractions that is done, 0-1; 0 for a single one."""
        done, pending = (sum(getattr(line, name) for line in self._lines) for name in ("done", "pending_count"))
        return done / max(done + pending, 1)

    # opening

    def open(self, source: FrameRef, frame: RGBDFrame | None = None) -> None:
        """Read a frame, unless `frame` is what was read, show it, and extract its blocks.

        A frame that is already open is only shown; if it is open with other units or intrinsics, it is read again and
        replaced. Of a folder with a result, the recorded run is opened, with the frame that was completed.
        """
        entry, parameters = self._workspace.entries.of_key(source.key), self._workspace.parameters.extraction
        if entry is not None and entry.document is None and entry.source == source:
            self.open_entry(entry)
        elif entry is None and is_result_folder(source):
            self.open_new(source, source.name)
        elif not self._shown_already(source):
            do, take = partial(_open, source, parameters, frame), partial(self._take_opened, source)
            self.read(f"Opening {Path(source.key).name}", do, take)

    def read_again(self, entry: Entry, source: FrameRef, replace: Callable[[RGBDFrame | None], None]) -> None:
        """Read an open frame with other options. If only its camera differs, it is taken over, and the work on the
        frame stays; otherwise call `replace` with what was read, or, for a frame that is not open, with None."""
        document = entry.document
        if document is None:
            replace(None)
            return

        def take(frame: RGBDFrame) -> None:
            if entry.document is not document or not document.set_camera(frame, source):
                replace(frame)
                return
            entry.source = source
            self._workspace.show(document)
            camera = "no intrinsics" if frame.intrinsics is None else "other intrinsics"
            self.message.emit(f"{entry.name} has {camera} now; its blocks, edits and their results stay.")

        self.read(f"Opening {entry.name}", lambda: measured_frame(source), take)

    def open_run(self, record: Path) -> None:
        """Open a run.json: its frame, blocks, parameters and result."""
        record = Path(os.path.abspath(record))  # one key for all spellings of the path
        entry = self._workspace.entries.of_key(str(record))
        if entry is not None and entry.document is None:
            self.open_entry(entry)
        elif not self._shown_already(record):
            do = lambda: _replayed(replay(record, extract=False))  # noqa: E731
            self.read(f"Opening {record.name}", do, partial(self._take_opened, record))

    def open_folder(self, how: FrameRef, show: bool = True) -> None:
        """Add the frames of a folder to the list, with the reading options of `how`; with `show`, open the first, and
        replace frames of the list that were read with other options."""
        what = f"Looking for frames in {Path(how.rgb).name}"
        self.read(what, lambda: _list(how), lambda found: self._take_listing(how, found[0], found[1], show))

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
            do = partial(_open, source, parameters, places=self.store.places)
            take = partial(self._take_entry, entry, source)

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
        entry = Entry(uuid.uuid4().hex, source.key, name, source)
        self._workspace.add_entries([entry])
        self.open_entry(entry)

    def read(
        self, what: str, do: Callable[[], object], take: Callable[..., None], fail: Callable[[], None] = lambda: None
    ) -> None:
        """Run `do` in the reading queue, in the background; then call `take` with its result in the GUI's thread, or
        emit `failed` and call `fail`."""

        def give_up(error: Exception) -> None:
            self.failed.emit(what, error)
            fail()

        def report(error: Exception) -> None:
            if isinstance(error, NotAllowed):
                again = lambda: self.read(what, do, take, fail)  # noqa: E731
                self.not_allowed.emit(error, again, lambda: give_up(error))
            else:
                give_up(error)

        self._reading.add(Job(do, take, report, what=what))

    def _shown_already(self, origin: FrameRef | Path) -> bool:
        document = self._workspace.document_of(_key(origin))
        if document is None or document.origin != origin:
            return False
        self._workspace.show(document)
        return True

    def _take_entry(self, entry: Entry, source: FrameRef, opened: _Opened) -> None:
        """Show a frame of the list that was read; other frames of the same files are not affected."""
        document = _document(source, opened)
        document.change(id=entry.id)
        self._show_opened(document, transient=True)

    def _take_opened(self, origin: FrameRef | Path, opened: _Opened) -> None:
        if self._shown_already(origin):
            return
        document = _document(origin, opened)
        replaced = self._workspace.entries.of_key(document.key)
        if replaced is not None:
            self._workspace.remove_entries([replaced])
        self._show_opened(document)

    def _show_opened(self, document: Document, transient: bool = False) -> None:
        """Show what was opened: a frame, whose blocks are extracted then (`transient` as there), or a recorded run."""
        again = document.record_replay
        if again is None:
            self._workspace.open_document(document)
            self._extract_first(document, transient)
            return
        self._workspace.open_document(document, again.run, completion=again.completion)
        self._report_blocks(document, _RECORDED, *again.run.blocks.notes)
        self.replayed.emit(document)

    def open_state(self, entry: Entry, decoded: Decoded, show: bool = True) -> Document:
        """Open a frame of the list in a state and, with `show`, make it the current one."""
        origin = entry.source or (Path(entry.key) if entry.has_state else FrameRef(entry.key))
        document = Document.of_state(decoded.state, origin, entry.key)
        self._workspace.open_document(document, restored=entry.has_state, show=show)
        if decoded.problems:
            self.incomplete.emit(document, decoded.problems)
        return document

    def _take_listing(self, how: FrameRef, listing: Listing, found: Sequence[Entry], show: bool) -> None:
        workspace, entries = self._workspace, self._workspace.entries
        there = [(entry, entries.of_key(entry.key)) for entry in found]
        others = [old for new, old in there if show and old is not None and _is_read_otherwise(old, new)]

        def add() -> None:
            workspace.remove_entries(others)
            workspace.add_entries([entry for entry in found if entries.of_key(entry.key) is None])
            self.listed.emit(how, listing)
            first = entries.of_key(found[0].key)
            if show and first is not None:
                self.open_entry(first)

        if others:
            self.replace(others, add)
        else:
            add()

    def _note_problem(self, entry: Entry, error: Exception) -> None:
        self.opening_failed.emit(entry, error)
        self._workspace.note_problem(entry, str(error))
        self.message.emit(f"{entry.name} cannot be opened: {error}")
        if isinstance(error, NotAllowed):
            self.not_allowed.emit(error, lambda: self.open_entry(entry), lambda: None)

    # extracting

    def extract(self, document: Document) -> None:
        """Extract the blocks of an open frame again, with the workspace's parameters."""
        frame, parameters = document.frame, self._workspace.parameters.extraction
        self._add_extraction(
            document, lambda: find(frame, parameters), lambda found: self.take_extraction(document, found)
        )

    def is_extracting(self, document: Document) -> bool:
        """Whether a frame's extraction is in progress or waiting."""
        return self._extracting.has(document)

    def is_preparing(self, document: Document | None) -> bool:
        """Whether frames are being read, or the blocks of this one extracted."""
        return self._reading.busy or self._extracting.has(document)

    def is_postponed(self, document: Document) -> bool:
        """Whether a frame's extraction was postponed because another frame was shown."""
        return document in self._postponed

    def _extract_first(self, document: Document, transient: bool = False) -> None:
        """Extract the blocks of a frame that was opened without any; `transient`: only if it is still the current
        one."""
        frame, parameters = document.frame, self._workspace.parameters.extraction

        def wanted() -> bool:
            if document.blocks.propagated_from:
                return False
            if not transient or self._workspace.is_shown(document):
                return True
            self._postponed.add(document)
            return False

        self._add_extraction(
            document, lambda: _extract_first(frame, parameters), lambda found: self._take_first(document, found), wanted
        )

    def _add_extraction(
        self,
        document: Document,
        do: Callable[[], FoundBlocks],
        take: Callable[[FoundBlocks], None],
        wanted: Callable[[], bool] = lambda: True,
    ) -> None:
        what, documents = f"Extracting blocks of {document.name}", self._workspace.open
        self._extracting.add(
            Job(
                do,
                lambda found: take(found) if document in documents else None,
                lambda error: self.failed.emit(what, error),
                what=what,
                still_wanted=lambda: document in documents and wanted(),
                about=document,
            )
        )

    def _resume_postponed(self) -> None:
        """Start the postponed extraction of the current frame."""
        document = self._workspace.current if self._workspace.has_current else None
        if document is not None and document in self._postponed:
            self._postponed.discard(document)
            self._extract_first(document, transient=True)

    def _cancel_closed(self) -> None:
        """Cancel extractions of closed frames."""
        self._extracting.cancel_if(lambda document: document not in self._workspace.open)

    def _take_first(self, document: Document, found: FoundBlocks) -> None:
        """Set the blocks of a frame that was opened without any, unless blocks were propagated to it since."""
        if document.blocks.propagated_from:
            return
        if self._workspace.is_shown(document):
            self.extracted.emit(found)
        if document.undo_stack.count() or document.counts():
            document.set_extracted(found.extraction, found.parameters, self._workspace.parameters.keeps_handmade)
        else:
            document.set_first(found.extraction, found.parameters)
        beside = described_beside(document.origin) if isinstance(document.origin, FrameRef) else ""
        self._report_blocks(document, beside, *document.frame.notes, *found.extraction.notes)

    def take_extraction(self, document: Document, found: FoundBlocks) -> None:
        """Set the blocks of an extraction with the workspace's parameters."""
        keeps_handmade = self._workspace.parameters.keeps_handmade
        kept = document.set_extracted(found.extraction, found.parameters, keeps_handmade)
        if self._workspace.is_shown(document):
            self.extracted.emit(found)
        self._report_blocks(document, _describe_kept(*kept), *found.extraction.notes)

    def _report_blocks(self, document: Document, *notes: str) -> None:
        text = f"{document.name}: {describe_blocks(len(document.counts()), document.labels)}."
        self.message.emit(" ".join(filter(None, (text, *notes))))

    # both

    def _emit_busy(self) -> None:
        was_busy, self._was_busy = self._was_busy, self.busy
        self.busy_changed.emit()
        if was_busy and not self.busy:
            self.idle.emit()


def _describe_kept(locked: int, by_hand: int, all_kept: bool) -> str:
    """Return a sentence about the blocks that an extraction kept; "" for none."""
    counts = [f"{locked} locked"] * (locked > 0) + [f"{by_hand} made by hand"] * (by_hand > 0)
    if not counts:
        return ""
    text = f"Kept: {', '.join(counts)}."
    if all_kept and by_hand:
        text += " These are all blocks: switch off 'Keep blocks made by hand' to extract them again."
    return text


def _list(how: FrameRef) -> tuple[Listing, list[Entry]]:
    listing = list_frames(how.rgb, how.options)
    return listing, [Entry.of(source, from_folder=True) for source in listing.sources]


def _is_read_otherwise(present: Entry, found: Entry) -> bool:
    """Whether a frame of the list was read with other options than those of the same frame in a listing."""
    return present.source is not None and found.source is not None and present.source.options != found.source.options


def _key(origin: FrameRef | Path) -> str:
    return origin.key if isinstance(origin, FrameRef) else str(origin)


def _document(origin: FrameRef | Path, opened: _Opened) -> Document:
    """Make the document of what was opened, in the GUI's thread because of its undo stack."""
    run, again = opened
    return Document.of(run, origin, _key(origin), again)


def _open(
    source: FrameRef, parameters: BlockParameters, frame: RGBDFrame | None = None, places: Places | None = None
) -> _Opened:
    again = recorded_run(source, places) if frame is None else None
    if again is not None:
        return _replayed(again)
    frame = read_frame(source) if frame is None else frame
    no_blocks = np.zeros(frame.shape, np.int32)
    return Run(frame, Blocks(no_blocks, extraction=parameters, extracted=no_blocks)), None


def _replayed(again: Replay) -> _Opened:
    again.completion  # noqa: B018 - read here, in the background
    return again.run, again


def _extract_first(frame: RGBDFrame, parameters: BlockParameters) -> FoundBlocks:
    found = find(frame, parameters)
    edges_for(frame, preset(), parameters)  # in advance, so that the first slider move is fast
    return found
