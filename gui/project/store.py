"""Stored states of the window's frames: the journal, with the project file below it."""

from __future__ import annotations

import os
import secrets
import tempfile
import threading
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path

from ilf.errors import InputError
from ilf.project.archive import Parts
from ilf.project.decoding import Decoded, load_state
from ilf.project.encoding import frame_part
from ilf.project.journal import Journal, JournalHeader
from ilf.project.recovery import SUFFIX
from ilf.project.sources import Places
from ilf.project.thumbnail import thumbnail_part

ARRAYS = "arrays/"


class WorkStore:
    """The stored states of one window's frames. Safe from several threads.

    Parts that cannot be written to the journal yet are kept in memory; readers see no difference.

    Parameters
    ----------
    folder : Path or None
        Folder of the journal, which is created when there is something to store; None: a temporary folder.

    Attributes
    ----------
    parts : Parts
        All stored parts.
    project : Parts or None
        Parts of the project file, below the journal.
    places : Places
        Possible locations of frames' files.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        self._lock = threading.RLock()
        self._arrival = threading.Condition(self._lock)
        self._pending: Counter[str] = Counter()
        """Frames with pending states, and the number of these."""
        self._journal: Journal | None = None
        self._stored: set[str] = set()
        """Names of the parts in the journal."""
        self._waiting: dict[str, bytes] = {}
        """Parts to write to the journal."""
        self._removed: set[str] = set()
        """Names of parts to remove from the journal."""
        self._references: dict[str, frozenset[str]] = {}
        """Frame -> names of the arrays that its stored state refers to."""
        self._lost = False
        """Whether parts were lost with a journal that became unreadable."""
        self._held = 0
        self._read: list[Decoded] = []
        self.parts: Parts = _Layers(self)
        self.project: Parts | None = None
        self.places = Places()

    # for readers

    def has(self, frame_id: str) -> bool:
        """Whether a state of this frame is stored or pending."""
        with self._lock:
            return frame_id in self._pending or self.has_part(frame_part(frame_id))

    def read(self, frame_id: str, to_edit: bool = True) -> Decoded:
        """Read the newest state of a frame; waits for it if it is pending. `to_edit`: it may be stored again, and the
        encoder then reuses its parts.

        Raises
        ------
        MissingSource, ChangedSource, UnreadableFrame
            As `load_state` does.
        """
        with self._arrival:
            self._arrival.wait_for(lambda: frame_id not in self._pending)
        with self.held() as parts:
            decoded = load_state(frame_id, parts, self.places)
        if to_edit:
            with self._lock:
                self._read.append(decoded)
        return decoded

    @contextmanager
    def held(self) -> Iterator[Parts]:
        """Context with all parts: none is removed meanwhile, but newer states of frames may be added."""
        with self._lock:
            self._held += 1
        try:
            yield self.parts
        finally:
            with self._lock:
                self._held -= 1

    def has_part(self, name: str) -> bool:
        """Whether there is a part of this name."""
        with self._lock:
            return not self.lacks(name) or (self.project is not None and name in self.project.names())

    def part(self, name: str) -> bytes:
        """Return the bytes of a part; raises InputError if there is none or it is damaged."""
        with self._lock:
            content, journal, project = self._waiting.get(name), self._journal, self.project
            in_journal = content is None and journal is not None and not self.lacks(name)
        if content is not None:
            return content
        if in_journal and journal is not None:
            try:
                return journal.read(name)
            except InputError:
                if project is None or not name.startswith(ARRAYS):  # arrays of one name are the same everywhere
                    raise
        if project is None:
            raise InputError(f"There is no part {name}.")
        try:
            return project.read(name)
        except InputError:
            if self.project is project:
                raise
        return self.part(name)  # the project file was replaced and closed meanwhile

    def all_names(self) -> set[str]:
        """Return the names of all parts."""
        with self._lock:
            below = set() if self.project is None else set(self.project.names())
            return below | (self._stored - self._removed) | self._waiting.keys()

    # for the autosave

    def expect(self, frame_id: str) -> None:
        """Announce a newer state of this frame: readers wait until it has `arrived`."""
        with self._lock:
            self._pending[frame_id] += 1

    def arrived(self, frames: Iterable[str]) -> None:
        """End the wait for one state of each of these frames, stored or not."""
        with self._arrival:
            self._pending.subtract(frames)
            self._pending += Counter()  # removes frames without pending states
            self._arrival.notify_all()

    def take_read(self) -> list[Decoded]:
        """Return the states that were read since the last call, for the encoder to reuse."""
        with self._lock:
            read, self._read = self._read, []
        return read

    def revert(self, frames: Collection[str]) -> None:
        """Discard the newer states of these frames: those of the project file are the latest again."""
        with self._lock:
            for frame_id in frames:
                self._references.pop(frame_id, None)
                for name in (frame_part(frame_id), thumbnail_part(frame_id)):
                    self._waiting.pop(name, None)
                    self._removed |= {name} & self._stored

    def own_states(self) -> dict[str, bytes]:
        """Return the parts of frames that are stored here, not only in the project file."""
        with self._lock:
            own = ("frames/", "thumbnails/")
            names = [name for name in self.all_names() if name.startswith(own) and not self.lacks(name)]
        return {name: self.part(name) for name in names}

    def take_lost(self) -> bool:
        """Return whether parts were lost since the last call: open frames should be stored again."""
        with self._lock:
            lost, self._lost = self._lost, False
        return lost

    def lacks(self, name: str) -> bool:
        """Whether a part is not stored here, but at most in the project file, which may be replaced or removed."""
        with self._lock:
            return name not in self._waiting and (name not in self._stored or name in self._removed)

    def keep(self, put: Mapping[str, bytes], refers: Mapping[str, frozenset[str]]) -> None:
        """Store parts: readable at once, in the journal after the next `commit`.

        Parameters
        ----------
        put : mapping of str to bytes
        refers : mapping of str to frozenset of str
            Id of a frame -> names of the arrays that its state refers to, all of which are stored here.
        """
        with self._lock:
            self._waiting |= put
            self._removed -= put.keys()
            self._references |= refers

    def tidy(self, frames: Collection[str]) -> set[str]:
        """Remove all other frames, and arrays that none refers to, unless parts are held at the moment.

        Returns
        -------
        set of str
            Names of the removed arrays.
        """
        with self._lock:
            if self._held:
                return set()
            stored = (self._stored - self._removed) | self._waiting.keys()
            left = self._references.keys() - set(frames) - self._pending.keys()
            for frame_id in left:
                del self._references[frame_id]
            unused = {name for name in stored if name.startswith(ARRAYS)}.difference(*self._references.values())
            going = unused | {name for id in left for name in (frame_part(id), thumbnail_part(id))}
            for name in going:
                self._waiting.pop(name, None)
            self._removed |= going & self._stored
            return unused

    @property
    def is_written(self) -> bool:
        """Whether the journal contains all stored parts."""
        with self._lock:
            return self._journal is not None and not (self._waiting or self._removed)

    def commit(self, note: JournalHeader) -> None:
        """Write all pending changes to the journal, in one step.

        Raises
        ------
        ExportError, InputError
            If it cannot be written. It is unchanged then, and the changes stay in memory.
        """
        with self._lock:
            journal = self._open()
            put, drop = dict(self._waiting), set(self._removed)
        journal.commit(put, drop, note)
        with self._lock:
            self._stored = (self._stored - drop) | put.keys()
            self._removed -= drop
            self._waiting = {name: one for name, one in self._waiting.items() if put.get(name) is not one}

    def discard(self) -> None:
        """Delete the journal, after the work was saved or discarded."""
        with self._arrival:
            self._pending.clear()
            self._arrival.notify_all()
            if self._journal is not None:
                self._journal.discard()
                self._journal = None
            if self._temporary is not None:
                self._temporary.cleanup()
                self._temporary = None

    def _open(self) -> Journal:
        """Return the journal; if its file was removed, a new one with its content, as far as it is still readable."""
        former = self._journal
        if former is not None and not former.is_there:
            for name in self._stored - self._removed - self._waiting.keys():
                try:
                    self._waiting[name] = former.read(name)
                except InputError:
                    self._lost = True
            former.close()
            self._journal, self._stored, self._removed = None, set(), set()
        if self._journal is None:
            name = f"{datetime.now():%Y%m%d-%H%M%S}-{os.getpid()}-{secrets.token_hex(4)}{SUFFIX}"
            self._journal = Journal(self._place() / name)
        return self._journal

    def _place(self) -> Path:
        if self._folder is not None:
            return self._folder
        if self._temporary is None:
            self._temporary = tempfile.TemporaryDirectory(prefix="ilf-")
        return Path(self._temporary.name)


class _Layers:
    """All parts of a store, as Parts."""

    def __init__(self, store: WorkStore) -> None:
        self._store = store

    def names(self) -> Collection[str]:
        return self._store.all_names()

    def read(self, name: str) -> bytes:
        return self._store.part(name)
