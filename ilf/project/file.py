"""Opening and saving project files."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

from .._runtime.schema import check_schema
from ..data.frame import InputFile
from ..errors import ExportError, FormatError, IlfError, InputError
from .archive import Archive, Part, Parts, write_archive
from .decoding import Decoded, load_state
from .encoding import SCHEMA, Encoder, frame_part
from .frame_state import FrameState
from .packing import ARRAYS
from .project import Project, ProjectFrame
from .project_json import PROJECT, ReadProject, decode_project, encode_project
from .recorded import UNREADABLE, arrays_of, bare_state, files_of
from .sources import SOURCES, FilePlace, Places, find_source, source_part
from .thumbnail import thumbnail_part

# What a project file is to hold, gathered from what has changed and where the rest is kept.


class Saving:
    """A project on its way into a file; see `save_project` for what it is made of.

    Attributes
    ----------
    notes : list of str
        What could not be saved as asked for.
    stores : list of Parts
        All that parts are taken from.
    """

    def __init__(
        self,
        path: Path,
        project: Project,
        base: Sequence[Parts],
        frames: Mapping[str, Parts],
        places: Places,
        embed: bool | None,
    ) -> None:
        self.notes: list[str] = []
        self.stores = list(dict.fromkeys((*frames.values(), *base)))
        self._path, self._project, self._base, self._frames = path, project, base, frames
        self._places, self._embed = places, embed
        self._made: dict[str, bytes] = {}
        self._names = {parts: set(parts.names()) for parts in self.stores}
        self._files: dict[str, FilePlace] = {}

    def gather(self, states: Sequence[FrameState]) -> list[str]:
        """Encode what is new; the names of all parts of the file, project.json first."""
        encoder = Encoder()
        for state in states:
            self._encode(encoder, state)
        names: dict[str, None] = {PROJECT: None}
        listed: list[ProjectFrame] = []
        whole = True
        for frame in self._project.frames:
            frame = self._with_state(encoder, frame)
            if frame.has_state:
                whole &= self._refer(frame, names)
            else:
                self._note_places(frame)
            listed.append(frame)
            picture = thumbnail_part(frame.id)
            if self._store_of(picture, frame.id) is not None:
                names[picture] = None
        if not whole:  # what they refer to is not known: nothing may be left out
            everything = (name for there in self._names.values() for name in there)
            names |= dict.fromkeys(name for name in everything if name.startswith((ARRAYS, SOURCES)))
        places = Places(self._path, self._files)
        embedded = self._embed if self._embed is not None else any(name.startswith(SOURCES) for name in names)
        self._made[PROJECT] = encode_project(replace(self._project, frames=tuple(listed)), places, embedded=embedded)
        return list(names)

    def part(self, name: str) -> Part | None:
        """A part to be written, as it is kept, damaged or not; None if it is nowhere."""
        if name in self._made:
            return Part(name, self._made[name])
        damaged: Part | None = None
        for parts in self._stores_of(name, name.split("/")[-1].split(".")[0]):
            try:
                part = parts.as_it_is(name) if isinstance(parts, Archive) else Part(name, parts.read(name))
            except FormatError as error:
                self.notes.append(f"{error} It is not saved.")
                continue
            if part.checksum is None:
                return part
            damaged = damaged or part
        if damaged is None:
            self.notes.append(f"The part {name:.40} is nowhere to be found, and not saved.")
        return damaged

    def _encode(self, encoder: Encoder, state: FrameState) -> None:
        encoded = encoder.encode(state)
        self._made |= {frame_part(state.id): encoded.frame, **encoded.arrays}

    def _store_of(self, name: str, frame_id: str) -> Parts | None:
        return next(self._stores_of(name, frame_id), None)

    def _stores_of(self, name: str, frame_id: str) -> Iterator[Parts]:
        """Who keeps a part: of a frame's own parts, whoever has its state; of all others, anyone."""
        first = [self._frames[frame_id]] if frame_id in self._frames else []
        own = name.startswith(("frames/", "thumbnails/"))
        for parts in dict.fromkeys((*first, *(self._base if own else self.stores))):
            if name in self._names[parts]:
                yield parts

    def _with_state(self, encoder: Encoder, frame: ProjectFrame) -> ProjectFrame:
        """The frame as the list is to have it; one without a state gets one if its files are to be embedded."""
        name = frame_part(frame.id)
        has = name in self._made or (frame.has_state and self._store_of(name, frame.id) is not None)
        if frame.has_state and not has:
            self.notes.append(f"There is no work on {frame.name} to be saved.")
        if not has and self._embed and frame.source is not None:
            try:
                self._encode(encoder, bare_state(frame.id, frame.source.load()))
                has = True
            except IlfError as error:
                self.notes.append(f"{frame.name} is not embedded: {error}")
        return replace(frame, has_state=has)

    def _refer(self, frame: ProjectFrame, names: dict[str, None]) -> bool:
        """Add what a frame's state refers to; False if it cannot be read."""
        name = frame_part(frame.id)
        names[name] = None
        try:
            content = self._content(name, frame.id)
            files, arrays = files_of(content), arrays_of(content)
        except UNREADABLE:
            return False
        names |= dict.fromkeys(sorted(arrays))
        for file in files:
            self._refer_to_file(file, names)
        self._note_places(frame)
        return True

    def _content(self, name: str, frame_id: str) -> bytes:
        if name in self._made:
            return self._made[name]
        parts = self._store_of(name, frame_id)
        if parts is None:
            raise InputError(f"There is no part {name:.40}.")
        return parts.read(name)

    def _refer_to_file(self, file: InputFile, names: dict[str, None]) -> None:
        """Embed a frame's file, leave it embedded, or say where it is."""
        name = source_part(file.sha256, file.path)
        self._place(file)
        if not file.sha256:
            note = f"Not embedded: {file.path} is a recording, which stays where it is."
            if self._embed and note not in self.notes:
                self.notes.append(note)
            return
        embedded = self._store_of(name, "") is not None
        if (self._embed is None and embedded) or (self._embed is False and embedded and not self._is_at_hand(file)):
            names[name] = None
        elif self._embed and name not in names:
            try:
                self._made[name] = find_source(file, _First(self.stores), self._places).data.tobytes()
                names[name] = None
            except InputError as error:
                self.notes.append(f"Not embedded: {error}")

    def _is_at_hand(self, file: InputFile) -> bool:
        try:
            find_source(file, None, self._places)
        except InputError:
            return False
        return True

    def _place(self, file: InputFile) -> None:
        """Note where a file is, seen from the new place of the project."""
        if file.path not in self._files:
            present = self._places.present(file) or Path(file.path)
            self._files[file.path] = FilePlace(_relative(present, self._path.parent), str(present))

    def _note_places(self, frame: ProjectFrame) -> None:
        source = frame.source
        if source is not None:
            for path in (source.rgb, source.depth, source.truth):
                if path is not None and path not in self._files:
                    self._files[path] = FilePlace(_relative(Path(path), self._path.parent), path)


class _First:
    """Parts of several stores, each from the first that has it."""

    def __init__(self, stores: Sequence[Parts]) -> None:
        self._stores = stores

    def names(self) -> Collection[str]:
        return {name for parts in self._stores for name in parts.names()}

    def read(self, name: str) -> bytes:
        for parts in self._stores:
            if name in parts.names():
                return parts.read(name)
        raise InputError(f"There is no part {name:.40}.")


def _relative(path: Path, folder: Path) -> str | None:
    """A path from a folder, with slashes; None if there is no way, as between drives."""
    try:
        return os.path.relpath(path, folder).replace(os.sep, "/")
    except ValueError:
        return None


SUFFIX = ".ilf"


@dataclass(frozen=True)
class OpenedProject:
    """A project file that is open.

    Attributes
    ----------
    parts : Archive
    read : ReadProject
        What project.json says.
    """

    parts: Archive
    read: ReadProject

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def path(self) -> Path:
        """Of the project file, absolute."""
        return self.parts.path

    @property
    def project(self) -> Project:
        """The frames, and what is set for all of them."""
        return self.read.project

    @property
    def problems(self) -> tuple[str, ...]:
        """What could not be read of file and list, and what that means; a sentence each."""
        return self.parts.problems + self.read.problems

    @property
    def places(self) -> Places:
        """Where the files of its frames are."""
        return self.read.places

    def frame(self, frame_id: str) -> ProjectFrame:
        """A frame of the list; raises InputError if there is none."""
        for frame in self.project.frames:
            if frame.id == frame_id:
                return frame
        raise InputError(f"The project has no frame {frame_id:.40}.")

    def state(self, frame_id: str, places: Places | None = None) -> Decoded:
        """A frame with all work on it; of one without any, as its files have it.

        Parameters
        ----------
        frame_id : str
        places : Places, optional
            Where its files may be, in place of `self.places`.

        Raises
        ------
        MissingSource, ChangedSource
            If one of the frame's files is nowhere to be found, or has changed.
        InputError
            If there is no such frame, or it cannot be read.
        """
        frame = self.frame(frame_id)
        if not frame.has_state and frame.source is not None:
            return Decoded(bare_state(frame_id, frame.source.load()))
        return load_state(frame_id, self.parts, frame.source, places or self.places)

    def close(self) -> None:
        """Let go of the file."""
        self.parts.close()


def open_project(path: str | os.PathLike[str]) -> OpenedProject:
    """Open a project file; only its list of frames is read.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is no project file, or of another schema.

    Examples
    --------
    >>> save_project("empty.ilf", Project(()), [])
    ()
    >>> with open_project("empty.ilf") as opened:
    ...     opened.project.frames, opened.problems
    ((), ())
    """
    archive = Archive(path)
    try:
        return OpenedProject(archive, decode_project(archive, archive.path))
    except BaseException:
        archive.close()
        raise


def save_project(
    path: str | os.PathLike[str],
    project: Project,
    states: Sequence[FrameState] = (),
    *,
    base: Sequence[Parts] = (),
    frames: Mapping[str, Parts] | None = None,
    places: Places | None = None,
    embed: bool | None = None,
    on_part: Callable[[int, int], None] | None = None,
) -> tuple[str, ...]:
    """Write a project file: as a whole, or what is there stays as it is.

    What has not changed is copied as it is kept; what no frame refers to any more is left out.

    Parameters
    ----------
    path : path-like
    project : Project
    states : sequence of FrameState
        Of frames that have changed and are in no parts yet.
    base : sequence of Parts
        Where the other states, arrays, pictures and embedded files are: the first that has a part gives it. An
        `Archive` of the file that is saved is closed and read anew when it is replaced; it belongs here, too, if others
        read it for their own parts.
    frames : mapping of str to Parts, optional
        Id of a frame -> where its state is, before `base`.
    places : Places, optional
        Where the files of frames are now.
    embed : bool, optional
        Whether the very bytes of frames' files go into the project, so that it can be opened anywhere. None leaves
        those in that are in; False takes those out that are on this machine, too.
    on_part : callable, optional
        Called with the number of parts that have been written, and of all; what it raises ends it.

    Returns
    -------
    tuple of str
        What could not be saved as asked for, a sentence each.

    Raises
    ------
    ExportError
        If the file cannot be written, or the one that is there is write-protected or of another schema.

    Examples
    --------
    >>> import ilf, numpy as np
    >>> frame = ilf.RGBDFrame(np.zeros((4, 6, 3), np.uint8), np.full((4, 6), 2.0), name="wall")
    >>> state = FrameState("a1", frame, np.ones((4, 6), np.int32), note="Flat.")
    >>> save_project("wall.ilf", Project((ProjectFrame("a1", "wall", None),)), [state])
    ()
    >>> with open_project("wall.ilf") as opened:
    ...     again = opened.state("a1").state
    >>> again.note, again.frame.name, int(again.labels.sum())
    ('Flat.', 'wall', 24)
    """
    _check_replaceable(path)
    saving = Saving(Path(path).absolute(), project, base, frames or {}, places or Places(), embed)
    names = saving.gather(states)
    total = len(names)

    def parts() -> Iterator[Part]:
        for done, name in enumerate(names):
            if on_part is not None:
                on_part(done, total)
            part = saving.part(name)
            if part is not None:
                yield part

    write_archive(path, parts(), [parts for parts in saving.stores if isinstance(parts, Archive)])
    return tuple(dict.fromkeys(saving.notes))


def _check_replaceable(path: str | os.PathLike[str]) -> None:
    """Raise ExportError if what is there is write-protected, or a project of another schema."""
    if not Path(path).is_file():
        return
    if not os.access(path, os.W_OK):
        raise ExportError(f"{path} is write-protected. Save under another name.")
    try:
        with Archive(path) as there:
            data = dict(json.loads(there.read(PROJECT)))
    except UNREADABLE:
        return
    try:
        check_schema(data, SCHEMA, "project")
    except FormatError as error:
        raise ExportError(f"{path} is not replaced. {error}") from error
