"""The list of all frames that are worked on, open or not."""

from __future__ import annotations

import uuid
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Self

from PySide6.QtCore import QObject, Signal

from ilf.data.results import Status
from ilf.project.frame_state import is_carried
from ilf.project.project import FrameSummary, Stage
from ilf.sources.frame_source import FrameSource

from .session import Session


@dataclass(eq=False)
class Entry:
    """A frame of the list.

    Attributes
    ----------
    id : str
        Stays with the frame.
    key : str
        The path of what holds its depth, or of the record that it was opened from.
    name : str
    source : FrameSource or None
        How to read it; None if it can be had from its stored state alone.
    session : Session or None
        None while it is not open.
    has_state : bool
        Whether a state of it is stored, to be opened in place of the source.
    of_folder : bool
        Whether it was found in a folder, which is what the user has opened.
    changes : int
        How often it has been changed while it was not open.
    """

    id: str
    key: str
    name: str
    source: FrameSource | None = None
    session: Session | None = None
    has_state: bool = False
    of_folder: bool = False
    changes: int = 0
    _summary: FrameSummary = field(default_factory=FrameSummary)
    _stamp: tuple[int, ...] = ()
    _unsaved: bool = False
    _unsaved_words: str = ""

    @classmethod
    def of(cls, source: FrameSource, of_folder: bool = False) -> Self:
        """A new entry of a frame that has not been read, with the name that it will have as far as files tell."""
        return cls(uuid.uuid4().hex, source.key, source.name, source, of_folder=of_folder)

    @property
    def summary(self) -> FrameSummary:
        """What there is to say of it; of an open frame, as it is now."""
        session = self.session
        if session is not None:
            stamp = (*session.stamp, id(session.valid_results()), id(session.notes))
            if stamp != self._stamp:
                self._summary, self._stamp = summary_of(session), stamp
        return self._summary

    def set_summary(self, summary: FrameSummary) -> None:
        """What there is to say of it while it is not open."""
        self._summary, self._stamp = summary, ()

    @property
    def unsaved(self) -> bool:
        """Whether there is work on it that the project's file does not hold."""
        return self._unsaved if self.session is None else self.session.unsaved

    def unsaved_words(self) -> str:
        """What that work is, as "3 edits, 1 run"; "" for none."""
        if self.session is not None:
            return self.session.unsaved_words()
        return (self._unsaved_words or "changes") if self._unsaved else ""

    def set_unsaved(self, unsaved: bool) -> None:
        """Whether there is such work, while it is not open."""
        self._unsaved = unsaved
        self.changes += unsaved

    @property
    def origin(self) -> object:
        """What it was opened from, or would be."""
        return self.source if self.session is None else self.session.origin

    @property
    def note(self) -> str:
        """What the user says of it."""
        return self.summary.note


class Entries(QObject):
    """The frames in the order of the list. The workspace alone changes it.

    Signals
    -------
    added(int, int), removed(int, int)
        First and last row, afterwards and before.
    changed(object)
        An entry: it has been opened or left, or there is something else to say of it.
    """

    added = Signal(int, int)
    removed = Signal(int, int)
    changed = Signal(object)

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._entries: list[Entry] = []
        self._by_id: dict[str, Entry] = {}
        self._by_key: dict[str, Entry] = {}

    def __len__(self) -> int:
        return len(self._entries)

    def __getitem__(self, row: int) -> Entry:
        return self._entries[row]

    def __iter__(self) -> Iterator[Entry]:
        return iter(self._entries)

    def of(self, id: str) -> Entry | None:
        """The entry of an id."""
        return self._by_id.get(id)

    def of_key(self, key: str) -> Entry | None:
        """The entry of a path."""
        return self._by_key.get(key)

    def row_of(self, entry: Entry) -> int:
        """Where it stands."""
        return self._entries.index(entry)

    def add(self, entries: Sequence[Entry]) -> None:
        """Add entries with new ids at the end."""
        if not entries:
            return
        first = len(self._entries)
        self._entries += entries
        self._by_id |= {entry.id: entry for entry in entries}
        self._by_key |= {entry.key: entry for entry in entries}
        self.added.emit(first, len(self._entries) - 1)

    def remove(self, entries: Collection[Entry]) -> None:
        """Take entries out."""
        gone = {entry.id for entry in entries}
        rows = [row for row, entry in enumerate(self._entries) if entry.id in gone]
        while rows:
            first = last = rows.pop()
            while rows and rows[-1] == first - 1:
                first = rows.pop()
            for entry in self._entries[first : last + 1]:
                del self._by_id[entry.id]
                if self._by_key.get(entry.key) is entry:
                    del self._by_key[entry.key]
            del self._entries[first : last + 1]
            self.removed.emit(first, last)

    def attach(self, session: Session) -> Entry:
        """A frame has been opened: its entry, a new one if it has none yet."""
        entry = self.of(session.id) or self.of_key(session.key)
        if entry is None:
            source = session.origin if isinstance(session.origin, FrameSource) else None
            entry = Entry(session.id, session.key, session.name, source, session)
            self.add([entry])
            return entry
        session.id, session.note = entry.id, entry.note
        if entry.unsaved:
            session.note_other_change()
        entry.session, entry.name = session, session.name
        self.changed.emit(entry)
        return entry

    def detach(self, entry: Entry, stored: bool) -> None:
        """Its frame is no longer open; its state is stored, or there was none to store."""
        entry._unsaved_words = entry.unsaved_words()
        entry.set_unsaved(entry.unsaved)
        entry.set_summary(entry.summary)
        entry.session, entry.has_state = None, stored
        self.changed.emit(entry)

    def set_note(self, entry: Entry, note: str) -> None:
        """What the user says of a frame that is not open."""
        entry.set_summary(replace(entry.summary, note=note))
        entry.set_unsaved(True)
        self.changed.emit(entry)

    def set_summary(self, entry: Entry, summary: FrameSummary) -> None:
        """What there is to say of a frame that is not open."""
        entry.set_summary(summary)
        self.changed.emit(entry)

    def note_problem(self, entry: Entry, problem: str) -> None:
        """A frame could not be opened, for this reason."""
        entry.set_summary(replace(entry.summary, stage=Stage.FAILED, problem=problem))
        self.changed.emit(entry)


def summary_of(session: Session) -> FrameSummary:
    """What there is to say of an open frame."""
    results, blocks = session.valid_results(), session.counts()
    hopeless = [result.outcome for result in results.values() if result.outcome.status is Status.NOT_RECOVERABLE]
    failed = bool(results) and len(hopeless) == len(results)
    if failed:
        stage = Stage.FAILED
    elif results:
        stage = Stage.RUN
    elif blocks and is_carried(session.notes, session.labels):
        stage = Stage.CARRIED
    elif session.edited and blocks:
        stage = Stage.EDITED
    else:
        stage = Stage.EXTRACTED if blocks else Stage.UNTOUCHED
    return FrameSummary(
        stage,
        session.note,
        session.frame.shape,
        session.frame.missing_share,
        len(blocks),
        len(results),
        len(session.to_check & blocks.keys()),
        hopeless[0].message if failed else "",
        session.own_parameters,
    )
