"""Opening and saving project files."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from .._runtime.closing import Closeable
from .._runtime.files import parse_json
from .._runtime.schema import check_schema
from ..data.frame import InputFile
from ..errors import ExportError, FormatError, IlfError, InputError
from ..sources.reading import read_frame
from .archive import Archive, Part, Parts, write_archive
from .decoding import Decoded, load_state
from .encoding import SCHEMA, Encoder, frame_part
from .frame_state import FrameState
from .packing import ARRAYS
from .project import Project, ProjectFrame
from .project_json import PROJECT, ReadProject, decode_project, encode_project
from .sources import SOURCES, FilePlace, Places, find_source, source_part
from .state_json import UNREADABLE, empty_state, files_of, parsed_frame_part
from .thumbnail import thumbnail_part

# Collecting the parts of a project file: changed parts, and stored parts that are copied.


class PartCollector:
    """Collects the parts of a project file; see `save_project` for the parameters.

    Attributes
    ----------
    notes : list of str
        What could not be saved as requested.
    stores : list of Parts
        All stores that parts are copied from.
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

    def collect(self, states: Sequence[FrameState]) -> list[str]:
        """Encode the changed states; return the names of all parts of the file, project.json first."""
        encoder = Encoder()
        for state in states:
            self._encode(encoder, state)
        names: dict[str, None] = {PROJECT: None}
        listed: list[ProjectFrame] = []
        whole = True
        for frame in self._project.frames:
            frame = self._with_state(encoder, frame)
            if frame.has_state:
                whole &= self._add_references(frame, names)
            else:
                self._record_paths(frame)
            listed.append(frame)
            picture = thumbnail_part(frame.id)
            if self._store_of(picture, frame.id) is not None:
                names[picture] = None
        if not whole:  # the parts that an unreadable state refers to are unknown: keep all of them
            everything = (name for there in self._names.values() for name in there)
            names |= dict.fromkeys(name for name in everything if name.startswith((ARRAYS, SOURCES)))
        places = Places(self._path, self._files)
        embedded = self._embed if self._embed is not None else any(name.startswith(SOURCES) for name in names)
        self._made[PROJECT] = encode_project(replace(self._project, frames=tuple(listed)), places, embedded=embedded)
        return list(names)

    def part(self, name: str) -> Part | None:
        """Return a part to write, as it is stored, damaged or not; None if no store has it."""
        if name in self._made:
            return Part(name, self._made[name])
        damaged: Part | None = None
        for parts in self._stores_of(name, name.split("/")[-1].split(".")[0]):
            try:
                part = parts.read_raw(name) if isinstance(parts, Archive) else Part(name, parts.read(name))
            except FormatError as error:
                self.notes.append(f"{error} It is not saved.")
                continue
            if part.checksum is None:
                return part
            damaged = damaged or part
        if damaged is None:
            self.notes.append(f"The part {name:.40} was not found and is not saved.")
        return damaged

    def _encode(self, encoder: Encoder, state: FrameState) -> None:
        encoded = encoder.encode(state)
        self._made |= {frame_part(state.id): encoded.frame, **encoded.arrays}

    def _store_of(self, name: str, frame_id: str) -> Parts | None:
        return next(self._stores_of(name, frame_id), None)

    def _stores_of(self, name: str, frame_id: str) -> Iterator[Parts]:
        """Yield the stores that have a part: for a frame's own parts, those with its state; otherwise all."""
        first = [self._frames[frame_id]] if frame_id in self._frames else []
        own = name.startswith(("frames/", "thumbnails/"))
        for parts in dict.fromkeys((*first, *(self._base if own else self.stores))):
            if name in self._names[parts]:
                yield parts

    def _with_state(self, encoder: Encoder, frame: ProjectFrame) -> ProjectFrame:
        """Return the frame's entry for the list; a frame without a state gets one if its files are to be embedded."""
        name = frame_part(frame.id)
        has = name in self._made or (frame.has_state and self._store_of(name, frame.id) is not None)
        if frame.has_state and not has:
            self.notes.append(f"The stored work on {frame.name} was not found and is not saved.")
        if not has and self._embed and frame.source is not None:
            try:
                self._encode(encoder, empty_state(frame.id, read_frame(frame.source)))
                has = True
            except IlfError as error:
                self.notes.append(f"{frame.name} is not embedded: {error}")
        return replace(frame, has_state=has)

    def _add_references(self, frame: ProjectFrame, names: dict[str, None]) -> bool:
        """Add the parts that a frame's state refers to; return False if the state cannot be read."""
        name = frame_part(frame.id)
        names[name] = None
        try:
            stored = parsed_frame_part(self._content(name, frame.id))
            files = files_of(stored)
        except UNREADABLE:
            return False
        names |= dict.fromkeys(sorted(stored.arrays))
        for file in files:
            self._add_file(file, names)
        self._record_paths(frame)
        return True

    def _content(self, name: str, frame_id: str) -> bytes:
        if name in self._made:
            return self._made[name]
        parts = self._store_of(name, frame_id)
        if parts is None:
            raise InputError(f"There is no part {name:.40}.")
        return parts.read(name)

    def _add_file(self, file: InputFile, names: dict[str, None]) -> None:
        """Embed a frame's file, keep it embedded, or record its path."""
        name = source_part(file.sha256, file.path)
        self._record_path(file)
        if not file.sha256:
            note = f"Not embedded: {file.path} is a recording; recordings are never embedded."
            if self._embed and note not in self.notes:
                self.notes.append(note)
            return
        embedded = self._store_of(name, "") is not None
        if (self._embed is None and embedded) or (self._embed is False and embedded and not self._is_on_disk(file)):
            names[name] = None
        elif self._embed and name not in names:
            try:
                self._made[name] = find_source(file, _FirstStore(self.stores), self._places).data.tobytes()
                names[name] = None
            except InputError as error:
                self.notes.append(f"Not embedded: {error}")

    def _is_on_disk(self, file: InputFile) -> bool:
        try:
            find_source(file, None, self._places)
        except InputError:
            return False
        return True

    def _record_path(self, file: InputFile) -> None:
        """Record the path of a file relative to the project's new folder."""
        if file.path not in self._files:
            present = self._places.present(file) or Path(file.path)
            self._files[file.path] = FilePlace(_relative(present, self._path.parent), str(present))

    def _record_paths(self, frame: ProjectFrame) -> None:
        source = frame.source
        if source is not None:
            for path in source.paths:
                if path not in self._files:
                    self._files[path] = FilePlace(_relative(Path(path), self._path.parent), path)


class _FirstStore:
    """The parts of several stores; each is read from the first store that has it."""

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
    """Return a path relative to a folder, with slashes; None if there is none, as between drives."""
    try:
        return os.path.relpath(path, folder).replace(os.sep, "/")
    except ValueError:
        return None


SUFFIX = ".ilf"


@dataclass(frozen=True)
class OpenedProject(Closeable):
    """An open project file.

    Attributes
    ----------
    parts : Archive
    read : ReadProject
        Content of project.json.
    """

    parts: Archive
    read: ReadProject

    @property
    def path(self) -> Path:
        """Absolute path of the project file."""
        return self.parts.path

    @property
    def project(self) -> Project:
        """The frames and the common settings."""
        return self.read.project

    @property
    def problems(self) -> tuple[str, ...]:
        """What could not be read of the file and the list of frames, with the consequence; one sentence each."""
        return self.parts.problems + self.read.problems

    @property
    def places(self) -> Places:
        """Locations of the frames' files."""
        return self.read.places

    def frame(self, frame_id: str) -> ProjectFrame:
        """Return a frame of the list; raises InputError if there is none."""
        for frame in self.project.frames:
            if frame.id == frame_id:
                return frame
        raise InputError(f"The project has no frame {frame_id:.40}.")

    def state(self, frame_id: str, places: Places | None = None) -> Decoded:
        """Load a frame with all work on it; a frame without work is loaded from its files.

        Parameters
        ----------
        frame_id : str
        places : Places, optional
            Possible locations of its files, instead of `self.places`.

        Raises
        ------
        MissingSource, ChangedSource
            If one of the frame's files was not found, or has changed.
        UnreadableFrame
            If any part of its state is missing, damaged or of another version.
        InputError
            If there is no such frame, or its files cannot be read.
        """
        frame = self.frame(frame_id)
        if not frame.has_state and frame.source is not None:
            return Decoded(empty_state(frame_id, read_frame(frame.source)))
        return load_state(frame_id, self.parts, places or self.places)

    def close(self) -> None:
        """Close the file."""
        self.parts.close()


def open_project(path: str | os.PathLike[str]) -> OpenedProject:
    """Open a project file and read its list of frames.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is not a project file, or has another schema.

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
        return OpenedProject(archive, decode_project(archive, archive.path, stated_in=str(archive.path.parent)))
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
    """Write a project file. If that fails, an existing file stays unchanged.

    Unchanged parts are copied as they are stored; parts that no frame refers to are left out.

    Parameters
    ----------
    path : path-like
    project : Project
    states : sequence of FrameState
        States of frames that have changed since they were stored.
    base : sequence of Parts
        Stores of the other states, arrays, pictures and embedded files; a part is read from the first store that has
        it. An `Archive` of the saved file is closed and reopened when the file is replaced; list it here even if it
        is only read elsewhere.
    frames : mapping of str to Parts, optional
        Id of a frame -> store of its state, searched before `base`.
    places : Places, optional
        Present locations of the frames' files.
    embed : bool, optional
        Whether to embed the frames' files in the project, so that it can be opened anywhere. None keeps embedded files
        embedded; False removes those that are also on this machine.
    on_part : callable, optional
        Called with the number of written parts and the total; an exception that it raises cancels saving.

    Returns
    -------
    tuple of str
        What could not be saved as requested, one sentence each.

    Raises
    ------
    ExportError
        If the file cannot be written, or an existing file is write-protected or has another schema.

    Examples
    --------
    >>> import ilf, numpy as np
    >>> frame = ilf.RGBDFrame(np.zeros((4, 6, 3), np.uint8), np.full((4, 6), 2.0), name="wall")
    >>> from ilf.data.blocks import Blocks
    >>> state = FrameState("a1", frame, Blocks(np.ones((4, 6), np.int32)), note="Flat.")
    >>> save_project("wall.ilf", Project((ProjectFrame("a1", "wall", None),)), [state])
    ()
    >>> with open_project("wall.ilf") as opened:
    ...     again = opened.state("a1").state
    >>> again.note, again.frame.name, int(again.blocks.labels.sum())
    ('Flat.', 'wall', 24)
    """
    _check_replaceable(path)
    saving = PartCollector(Path(path).absolute(), project, base, frames or {}, places or Places(), embed)
    names = saving.collect(states)
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
    """Raise ExportError if an existing file is write-protected, or a project of another schema."""
    if not Path(path).is_file():
        return
    if not os.access(path, os.W_OK):
        raise ExportError(f"{path} is write-protected. Save under another name.")
    try:
        with Archive(path) as there:
            data = dict(parse_json(there.read(PROJECT), path))
    except UNREADABLE:
        return
    try:
        check_schema(data, SCHEMA, "project")
    except FormatError as error:
        raise ExportError(f"{path} is not replaced. {error}") from error
