"""Stored states of the window's frames: the autosave, with the project file below it."""

from __future__ import annotations

import os
import secrets
import tempfile
import threading
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path

from ilf.errors import IlfError, InputError
from ilf.project.archive import Archive, Parts
from ilf.project.codec import ARRAYS
from ilf.project.frame_state import FrameState
from ilf.project.project import Project
from ilf.project.project_json import PROJECT, encode_project
from ilf.project.recovery import SUFFIX, Copied
from ilf.project.sources import Places
from ilf.project.state_codec import Decoded, Known, encode, frame_part, load_state, thumbnail_part
from ilf.project.store import WorkFolder, WorkHeader

_OF_FRAMES = ("frames/", "thumbnails/")


class WorkStore:
    """The stored states of one window's frames, and all written parts. Safe from several threads; one of them writes.

    States that are not written yet, or cannot be, are kept in memory; readers see no difference.

    Parameters
    ----------
    folder : Path or None
        Folder of the autosaves, which is created when there is something to store; None: a temporary folder.

    Attributes
    ----------
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
        self._names: dict[str, frozenset[str]] = {}
        """Frame whose written state is not out of date -> the parts that this names."""
        self._known = Known()
        self._adopted: set[str] = set()
        """Frames of another window that are not listed yet."""
        self._held = 0
        self.lost = False
        """Whether what was written has been lost with its folder: open frames must be put again."""
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
            return frame_id in self._waiting or self._has(frame_part(frame_id))

    def state(self, frame_id: str) -> Decoded:
        """Read the newest state of a frame.

        Raises
        ------
        MissingSource, UnreadableFrame
            As `load_state` does.
        """
        with self._lock:
            if frame_id in self._waiting:
                return Decoded(self._waiting[frame_id])
        with self.held():
            return load_state(frame_id, self, self.places, self._known)

    def thumbnail(self, frame_id: str) -> bytes | None:
        """Return the stored thumbnail of a frame; None if there is none."""
        with suppress(InputError):
            return self.read(thumbnail_part(frame_id))
        return None

    @contextmanager
    def held(self) -> Iterator[None]:
        """Context in which no array is removed, but newer states of frames may be added."""
        with self._lock:
            self._held += 1
        try:
            yield
        finally:
            with self._lock:
                self._held -= 1

    def _has(self, name: str) -> bool:
        """Whether there is a part of this name."""
        with self._lock:
            return self._owns(name) or (self.project is not None and name in self.project.names())

    def _owns(self, name: str) -> bool:
        """Whether a part is written here, and not out of date."""
        there = self._work is not None and name in self._work.names()
        frame_id = name.rpartition("/")[2].partition(".")[0]
        return there and (not name.startswith(_OF_FRAMES) or frame_id in self._names)

    def read(self, name: str) -> bytes:
        """Return the bytes of a part; raises InputError if there is none or it is damaged."""
        with self._lock:
            work, project = self._work if self._owns(name) else None, self.project
        if work is not None:
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
        return self.read(name)  # the project file was replaced and closed meanwhile

    def own_names(self) -> frozenset[str]:
        """Return the names of the written parts that are not only in the project file."""
        with self._lock:
            return frozenset(filter(self._owns, () if self._work is None else self._work.names()))

    def names(self) -> Collection[str]:
        """Return the names of all parts."""
        with self._lock:
            return self.own_names().union(() if self.project is None else self.project.names())

    def unsaved(self, left_out: Collection[str] = ()) -> tuple[Sequence[FrameState], list[Parts]]:
        """Return all work on frames that the project file does not contain, as of now, without some frames: the states
        that are not written, the parts of the others, and what has their arrays, which must be `held` meanwhile."""
        with self._lock:
            states = [state for id, state in self._waiting.items() if id not in left_out]
            names = (name for name in self.own_names() - _parts_of(left_out) if name.startswith(_OF_FRAMES))
            copies: Parts = _Copies({name: self.read(name) for name in names})
            return states, [copies] if self._work is None else [copies, self._work]

    # for the autosave

    def put(self, state: FrameState) -> None:
        """Take the newest state of a frame: it is read from now on, and written by the next `write`."""
        with self._lock:
            self._waiting[state.id] = state

    def revert(self, frames: Collection[str]) -> None:
        """Discard the newer states of these frames: those of the project file are the latest again."""
        with self._writing, self._lock:
            for frame_id in frames:
                self._waiting.pop(frame_id, None)
                self._names.pop(frame_id, None)

    def adopt(self, copied: Copied) -> None:
        """Write copies of frames of another window; raises as `write`."""
        with self._writing:
            self._open().commit(copied.put)
            with self._lock:
                self._names |= copied.names
                self._adopted |= copied.names.keys()

    @property
    def is_written(self) -> bool:
        """Whether all is written, and nothing else."""
        with self._lock:
            return self._work is not None and not self._waiting and all(map(self._owns, self._work.names()))

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
                waiting, kept = dict(self._waiting), {*frames, *self._adopted}
            names = {id: one for id, one in self._names.items() if id in kept}
            put = {} if project is None else {PROJECT: encode_project(project, self.places)}
            done: list[str] = []
            problem: Exception | None = None
            for frame_id, state in waiting.items():
                try:
                    names[frame_id] = self._encode(state, work, put)
                    done.append(frame_id)
                except Exception as error:  # any error must affect only this frame
                    problem = error
            work.commit(put, self._unused(work, names), header)
            with self._lock:
                self._names = names
                for frame_id in done:
                    if self._waiting.get(frame_id) is waiting[frame_id]:
                        del self._waiting[frame_id]
            return problem

    def _encode(self, state: FrameState, work: WorkFolder, put: dict[str, bytes]) -> frozenset[str]:
        """Encode a state and add its parts to `put`, with those that so far only the project file has; return the names
        of the parts that it names."""
        encoded = encode(state, self._known, lambda name: name in put or self._has(name))
        others = encoded.names - encoded.made.keys() - put.keys()
        try:
            copied = {name: self.read(name) for name in others if name not in work.names()}
        except IlfError:  # the project file has changed
            encoded, copied = encode(state), {}
        put |= {name: content for name, content in encoded.made.items() if name not in work.names()}
        put |= copied | {frame_part(state.id): encoded.content, thumbnail_part(state.id): state.thumbnail()}
        return encoded.names

    def _unused(self, work: WorkFolder, names: dict[str, frozenset[str]]) -> set[str]:
        """Return the written parts that are not needed any more."""
        unused = {*work.names()} - _parts_of(names) - {PROJECT}
        with self._lock:
            if self._held:
                return {name for name in unused if not name.startswith(ARRAYS)}
        return unused.difference(*names.values())

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


class _Copies(dict[str, bytes]):
    """Parts in memory, by name."""

    names = dict.keys
    read = dict.__getitem__
