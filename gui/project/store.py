"""What is stored of the frames that the window works on: the journal over the project file."""

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
from ilf.project.journal import Journal, JournalNote
from ilf.project.journals import SUFFIX
from ilf.project.sources import Places
from ilf.project.thumbnail import thumbnail_part
from ilf.sources.frame_source import FrameSource

ARRAYS = "arrays/"


class WorkStore:
    """The stored states of one window's frames. Safe from several threads.

    What the journal cannot take is kept in memory until it can: who reads need not care.

    Parameters
    ----------
    folder : Path or None
        Where the journal is made as soon as there is something to keep; None: where nobody looks for it again.

    Attributes
    ----------
    parts : Parts
        All that is stored.
    project : Parts or None
        Of the project file, below the journal.
    places : Places
        Where frames' files may be.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._passing: tempfile.TemporaryDirectory[str] | None = None
        self._lock = threading.RLock()
        self._arrival = threading.Condition(self._lock)
        self._coming: Counter[str] = Counter()
        """Frames whose newest state is on its way, and how many states of them are."""
        self._journal: Journal | None = None
        self._there: set[str] = set()
        """Names of what the journal holds."""
        self._waiting: dict[str, bytes] = {}
        """What it is to hold, too."""
        self._gone: set[str] = set()
        """What it holds and is not to hold any more."""
        self._refers: dict[str, frozenset[str]] = {}
        """Frame -> the arrays that its stored state refers to."""
        self._lost = False
        """Whether parts went with a journal that could not be read any more."""
        self._held = 0
        self._read: list[Decoded] = []
        self.parts: Parts = _Layers(self)
        self.project: Parts | None = None
        self.places = Places()

    # for those who read

    def has(self, frame_id: str) -> bool:
        """Whether a state of this frame is stored, or about to be."""
        with self._lock:
            return frame_id in self._coming or self.has_part(frame_part(frame_id))

    def read(self, frame_id: str, source: FrameSource | None = None) -> Decoded:
        """The newest state of a frame; waits for it if it is on its way.

        Raises
        ------
        MissingSource, ChangedSource, InputError
            As `load_state` does.
        """
        with self._arrival:
            self._arrival.wait_for(lambda: frame_id not in self._coming)
        with self.held() as parts:
            decoded = load_state(frame_id, parts, source, self.places)
        with self._lock:
            self._read.append(decoded)
        return decoded

    @contextmanager
    def held(self) -> Iterator[Parts]:
        """All parts; none of them goes meanwhile, though newer states of frames may come."""
        with self._lock:
            self._held += 1
        try:
            yield self.parts
        finally:
            with self._lock:
                self._held -= 1

    def has_part(self, name: str) -> bool:
        """Whether there is such a part."""
        with self._lock:
            return not self.lacks(name) or (self.project is not None and name in self.project.names())

    def part(self, name: str) -> bytes:
        """The bytes of a part; raises InputError if there is none, or it is damaged."""
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
        return self.part(name)  # another file has taken its place meanwhile, and it has been closed

    def all_names(self) -> set[str]:
        """Of all parts."""
        with self._lock:
            below = set() if self.project is None else set(self.project.names())
            return below | (self._there - self._gone) | self._waiting.keys()

    # for the autosave

    def expect(self, frame_id: str) -> None:
        """A newer state of this frame is on its way: who reads it waits until it has `arrived`."""
        with self._lock:
            self._coming[frame_id] += 1

    def arrived(self, frames: Iterable[str]) -> None:
        """A state of each of these frames is here, or will not come."""
        with self._arrival:
            self._coming.subtract(frames)
            self._coming += Counter()  # those of which none is to come any more are left out
            self._arrival.notify_all()

    def take_read(self) -> list[Decoded]:
        """What was read since the last call, for an encoder to learn from."""
        with self._lock:
            read, self._read = self._read, []
        return read

    def revert(self, frames: Collection[str]) -> None:
        """The newer states of these frames are not wanted: those of the project file are the latest again."""
        with self._lock:
            for frame_id in frames:
                self._refers.pop(frame_id, None)
                for name in (frame_part(frame_id), thumbnail_part(frame_id)):
                    self._waiting.pop(name, None)
                    self._gone |= {name} & self._there

    def own_states(self) -> dict[str, bytes]:
        """Parts of frames that are stored here, and not in the project file alone."""
        with self._lock:
            own = ("frames/", "thumbnails/")
            names = [name for name in self.all_names() if name.startswith(own) and not self.lacks(name)]
        return {name: self.part(name) for name in names}

    def take_lost(self) -> bool:
        """Whether parts have been lost since the last call: frames that are open should be stored anew."""
        with self._lock:
            lost, self._lost = self._lost, False
        return lost

    def lacks(self, name: str) -> bool:
        """Whether a part is not stored here, but at most in the project file, which may be replaced or taken away."""
        with self._lock:
            return name not in self._waiting and (name not in self._there or name in self._gone)

    def keep(self, put: Mapping[str, bytes], refers: Mapping[str, frozenset[str]]) -> None:
        """Store parts, at once for whoever reads; in the journal by the next `commit`.

        Parameters
        ----------
        put : mapping of str to bytes
        refers : mapping of str to frozenset of str
            Id of a frame -> the arrays that its state refers to, which all are stored here by now.
        """
        with self._lock:
            self._waiting |= put
            self._gone -= put.keys()
            self._refers |= refers

    def tidy(self, frames: Collection[str]) -> set[str]:
        """Let go of all frames but these, and of arrays that none refers to, unless parts are held just now.

        Returns
        -------
        set of str
            Names of arrays that are not stored here any more.
        """
        with self._lock:
            if self._held:
                return set()
            stored = (self._there - self._gone) | self._waiting.keys()
            left = self._refers.keys() - set(frames) - self._coming.keys()
            for frame_id in left:
                del self._refers[frame_id]
            unused = {name for name in stored if name.startswith(ARRAYS)}.difference(*self._refers.values())
            going = unused | {name for id in left for name in (frame_part(id), thumbnail_part(id))}
            for name in going:
                self._waiting.pop(name, None)
            self._gone |= going & self._there
            return unused

    @property
    def is_written(self) -> bool:
        """Whether the journal holds all that is stored."""
        with self._lock:
            return self._journal is not None and not (self._waiting or self._gone)

    def commit(self, note: JournalNote) -> None:
        """Bring the journal to what is stored, in one step.

        Raises
        ------
        ExportError, InputError
            If it cannot be written. It is as it was, and what it should hold stays in memory.
        """
        with self._lock:
            journal = self._open()
            put, drop = dict(self._waiting), set(self._gone)
        journal.commit(put, drop, note)
        with self._lock:
            self._there = (self._there - drop) | put.keys()
            self._gone -= drop
            self._waiting = {name: one for name, one in self._waiting.items() if put.get(name) is not one}

    def discard(self) -> None:
        """The work is saved, or not to be kept: take the journal away."""
        with self._arrival:
            self._coming.clear()
            self._arrival.notify_all()
            if self._journal is not None:
                self._journal.discard()
                self._journal = None
            if self._passing is not None:
                self._passing.cleanup()
                self._passing = None

    def _open(self) -> Journal:
        """The journal; where its file has gone, another one for all that it held, which can often still be read."""
        former = self._journal
        if former is not None and not former.is_there:
            for name in self._there - self._gone - self._waiting.keys():
                try:
                    self._waiting[name] = former.read(name)
                except InputError:
                    self._lost = True
            former.close()
            self._journal, self._there, self._gone = None, set(), set()
        if self._journal is None:
            name = f"{datetime.now():%Y%m%d-%H%M%S}-{os.getpid()}-{secrets.token_hex(4)}{SUFFIX}"
            self._journal = Journal(self._place() / name)
        return self._journal

    def _place(self) -> Path:
        if self._folder is not None:
            return self._folder
        if self._passing is None:
            self._passing = tempfile.TemporaryDirectory(prefix="ilf-")
        return Path(self._passing.name)


class _Layers:
    """The parts of a store."""

    def __init__(self, store: WorkStore) -> None:
        self._store = store

    def names(self) -> Collection[str]:
        return self._store.all_names()

    def read(self, name: str) -> bytes:
        return self._store.part(name)
