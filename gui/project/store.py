"""Stored states of the window's frames: the autosave, with the project file below it."""

from __future__ import annotations

import os
import secrets
import tempfile
import threading
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from ilf.errors import IlfError, InputError
from ilf.project.archive import Archive, Parts
from ilf.project.frame_state import FrameState
from ilf.project.project import Project
from ilf.project.project_json import PROJECT, encode_project
from ilf.project.recovery import SUFFIX, Copied
from ilf.project.sources import Places
from ilf.project.state_codec import Decoded, Encoded, Known, encode, frame_part, load_state
from ilf.project.store import WorkFolder, WorkHeader
from ilf.project.thumbnail import thumbnail, thumbnail_part

_OF_FRAMES = ("frames/", "thumbnails/")


class WorkStore:
    """The stored states of one window's frames. Safe from several threads; one of them writes.

    States that are not written yet, or cannot be, are kept in memory; readers see no difference.

    Parameters
    ----------
    folder : Path or None
        Folder of the autosaves, which is created when there is something to store; None: a temporary folder.

    Attributes
    ----------
    parts : Parts
        All written parts.
    project : Parts or None
        Parts of the project file.
    places : Places
        Possible locations of frames' files.
    """

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        self._lock = threading.RLock()
        self._writing = threading.RLock()
        self._work: WorkFolder | None = None
        self._waiting: dict[str, FrameState] = {}
        """Newest states, by frame, that are not written yet."""
        self._reverted: set[str] = set()
        """Frames whose written states are out of date."""
        self._names: dict[str, frozenset[str]] = {}
        """Frame -> the parts that its written state names."""
        self._known: dict[str, Known] = {}
        """Frame -> its objects that are stored."""
        self._adopted: set[str] = set()
        """Frames of another window that are not listed yet."""
        self._held = 0
        self.lost = False
        """Whether what was written has been lost with its folder: open frames must be put again."""
        self.parts: Parts = _View(self.all_names, self.part)
        self.project: Parts | None = None
        self.places = Places()

    def set_project(self, parts: Parts | None, places: Places) -> None:
        """Take the parts of another project file, and the places of its frames' files; close the former one."""
        former, self.project, self.places = self.project, parts, places
        if isinstance(former, Archive):
            former.close()

    # for readers

    def has(self, frame_id: str) -> bool:
        """Whether there is a state of this frame."""
        with self._lock:
            return frame_id in self._waiting or self.has_part(frame_part(frame_id))

    def read(self, frame_id: str, to_edit: bool = True) -> Decoded:
        """Read the newest state of a frame. `to_edit`: it may be stored again, and its parts are then reused.

        Raises
        ------
        MissingSource, ChangedSource, UnreadableFrame
            As `load_state` does.
        """
        with self._lock:
            if frame_id in self._waiting:
                return Decoded(self._waiting[frame_id])
        with self.held() as parts:
            decoded = load_state(frame_id, parts, self.places)
        if to_edit:
            with self._lock:
                self._known[frame_id] = decoded.known
        return decoded

    @contextmanager
    def held(self) -> Iterator[Parts]:
        """Context with all written parts: none is removed meanwhile, but newer states of frames may be added."""
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
            return self._owns(name) or (self.project is not None and name in self.project.names())

    def _owns(self, name: str) -> bool:
        """Whether a part is written here."""
        return self._work is not None and name in self._work.names() and name not in _parts_of(self._reverted)

    def part(self, name: str) -> bytes:
        """Return the bytes of a part; raises InputError if there is none or it is damaged."""
        with self._lock:
            work, project = self._work, self.project
            own = self._owns(name)
        if own and work is not None:
            try:
                return work.read(name)
            except InputError:
                if project is None or name.startswith(_OF_FRAMES):  # arrays of one name are the same everywhere
                    raise
        if project is None:
            raise InputError(f"There is no part {name}.")
        try:
            return project.read(name)
        except InputError:
            if self.project is project:
                raise
        return self.part(name)  # the project file was replaced and closed meanwhile

    def own_names(self) -> frozenset[str]:
        """Return the names of the written parts that are not only in the project file."""
        with self._lock:
            names = frozenset() if self._work is None else frozenset(self._work.names())
            return names - _parts_of(self._reverted)

    def all_names(self) -> frozenset[str]:
        """Return the names of all parts."""
        with self._lock:
            return self.own_names().union(() if self.project is None else self.project.names())

    def unsaved_parts(self, left_out: Collection[str] = ()) -> tuple[Sequence[FrameState], Parts]:
        """Return all that the project file does not contain, as of now, without some frames: the states that are not
        written, and the written parts. They must be `held` meanwhile."""
        with self._lock:
            states = [state for id, state in self._waiting.items() if id not in left_out]
            names = self.own_names() - _parts_of(left_out)
            frames = {name: self.part(name) for name in names if name.startswith(_OF_FRAMES)}
        return states, _View(lambda: names, lambda name: frames[name] if name in frames else self.part(name))

    # for the autosave

    def put(self, state: FrameState) -> None:
        """Take the newest state of a frame: it is read from now on, and written by the next `write`."""
        with self._lock:
            self._waiting[state.id] = state

    def revert(self, frames: Collection[str]) -> None:
        """Discard the newer states of these frames: those of the project file are the latest again."""
        with self._lock:
            for frame_id in frames:
                self._waiting.pop(frame_id, None)
                self._known.pop(frame_id, None)
            self._reverted |= set(frames)

    def adopt(self, copied: Copied) -> None:
        """Write copies of frames of another window; raises as `write`."""
        with self._writing:
            self._open().commit(copied.put)
            with self._lock:
                self._names |= copied.names
                self._reverted -= copied.names.keys()
                self._adopted |= copied.names.keys()

    @property
    def is_written(self) -> bool:
        """Whether all is written."""
        with self._lock:
            return self._work is not None and not self._waiting and not self._reverted

    def write(self, project: Project | None, frames: Collection[str], header: WorkHeader) -> Exception | None:
        """Write all states that wait, in one step, and remove frames that are no longer listed.

        Parameters
        ----------
        project : Project or None
            If it has changed.
        frames : collection of str
            Ids of all listed frames.
        header : WorkHeader

        Returns
        -------
        Exception or None
            Why a frame could not be encoded; it waits.

        Raises
        ------
        ExportError, InputError
            If nothing can be written. All that is written is unchanged, and the states wait.
        """
        with self._writing:
            work = self._open()
            with self._lock:
                self._adopted -= set(frames)
                self._waiting = {id: state for id, state in self._waiting.items() if id in frames}
                waiting, reverted = dict(self._waiting), set(self._reverted)
                gone = self._names.keys() - set(frames) - self._adopted
            put = {} if project is None else {PROJECT: encode_project(project, self.places)}
            done: dict[str, Encoded] = {}
            problem: Exception | None = None
            for frame_id, state in waiting.items():
                try:
                    done[frame_id] = self._encoded(state, work, put)
                except Exception as error:  # any error must affect only this frame
                    problem = error
            names = {id: one for id, one in self._names.items() if id not in gone | reverted}
            names |= {frame_id: encoded.names for frame_id, encoded in done.items()}
            work.commit(put, self._unused(work, names, gone | (reverted - done.keys())), header)
            with self._lock:
                self._names = names
                self._reverted -= reverted
                for frame_id in gone:
                    self._known.pop(frame_id, None)
                for frame_id, encoded in done.items():
                    self._known[frame_id] = encoded.known
                    if self._waiting.get(frame_id) is waiting[frame_id]:
                        del self._waiting[frame_id]
            return problem

    def _encoded(self, state: FrameState, work: WorkFolder, put: dict[str, bytes]) -> Encoded:
        """Encode a state and add its parts to `put`, with those that so far only the project file has."""
        there = {*work.names(), *put}
        encoded = encode(state, self._known.get(state.id))
        try:
            copied = {name: self.part(name) for name in encoded.names - encoded.made.keys() - there}
        except IlfError:  # the project file has changed
            encoded, copied = encode(state), {}
        put |= {name: content for name, content in encoded.made.items() if name not in there}
        put |= copied | {frame_part(state.id): encoded.content, thumbnail_part(state.id): thumbnail(state)}
        return encoded

    def _unused(self, work: WorkFolder, names: Mapping[str, frozenset[str]], gone: Collection[str]) -> set[str]:
        """Return the written parts that are not needed any more."""
        unused = _parts_of(gone)
        with self._lock:
            if not self._held:
                arrays = (name for name in work.names() if name.startswith("arrays/"))
                unused |= set(arrays).difference(*names.values())
        return unused

    def discard(self) -> None:
        """Delete all that is written, after the work was saved or discarded."""
        with self._writing, self._lock:
            self._waiting.clear()
            if self._work is not None:
                self._work.discard()
                self._work = None
            if self._temporary is not None:
                self._temporary.cleanup()
                self._temporary = None

    def _open(self) -> WorkFolder:
        """Return the folder of this window; a new one if it was removed. What it contained is lost: the open frames
        must be put again."""
        with self._lock:
            if self._work is not None and not self._work.is_there:
                self._work.close()
                self._work = None
                self._known.clear()
                self._names.clear()
                self.lost = True
            if self._work is None:
                name = f"{datetime.now():%Y%m%d-%H%M%S}-{os.getpid()}-{secrets.token_hex(4)}{SUFFIX}"
                self._work = WorkFolder(self._place() / name)
            return self._work

    def _place(self) -> Path:
        if self._folder is not None:
            return self._folder
        if self._temporary is None:
            self._temporary = tempfile.TemporaryDirectory(prefix="ilf-")
        return Path(self._temporary.name)


def _parts_of(frames: Iterable[str]) -> set[str]:
    return {part(frame_id) for frame_id in frames for part in (frame_part, thumbnail_part)}


@dataclass(frozen=True, eq=False)
class _View:
    """Parts of a store."""

    names: Callable[[], Collection[str]]
    read: Callable[[str], bytes]
