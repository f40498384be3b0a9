"""The list of all frames of the workspace, open or not."""

from __future__ import annotations

import os
import uuid
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

from ilf.project.project import FrameSummary, Stage
from ilf.sources.frame_ref import FrameRef

from .document import Document


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
        return bool(self.unsaved_summary())

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
