"""Opening and saving project files."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

from .._runtime.schema import check_schema
from ..data.frame import InputFile
from ..errors import ExportError, FormatError, IlfError, InputError, told_as
from ..sources.reading import read_frame
from .archive import Archive, Parts, StoredPart, write_archive
from .codec import ARRAYS, UNREADABLE
from .frame_state import FrameState
from .project import Project, ProjectFrame
from .project_json import PROJECT, ReadProject, decode_project, encode_project, read_project_head
from .sources import SOURCES, FilePlace, Places, find_source, located, source_part
from .state_codec import SCHEMA, Decoded, empty_state, encode, frame_part, load_state, read_head, thumbnail_part

SUFFIX = ".ilf"


@dataclass(frozen=True)
class OpenedProject(ReadProject, AbstractContextManager["OpenedProject"]):
    """An open project file: the content of project.json, and where the rest is.

    Attributes
    ----------
    parts : Archive
    """

    parts: Archive = field(kw_only=True)

    @property
    def path(self) -> Path:
        """Absolute path of the project file."""
        return self.parts.path

    @property
    def embedded(self) -> bool:
        """Whether it has files of the frames."""
        return any(name.startswith(SOURCES) for name in self.parts.names())

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
        MissingSource
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

    def __exit__(self, *_: object) -> None:
        self.close()

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
    with ExitStack() as stack:
        archive = stack.enter_context(Archive(path))
        read = decode_project(archive, archive.path, stated_in=str(archive.path.parent))
        stack.pop_all()
        return OpenedProject(**vars(replace(read, problems=archive.problems + read.problems)), parts=archive)


def save_project(
    path: str | os.PathLike[str],
    project: Project,
    states: Sequence[FrameState] = (),
    *,
    base: Sequence[Parts] = (),
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
    InputError
        If a part that is to be copied cannot be read, as when its archive has been closed.

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
    saving = _Saving(Path(path).absolute(), project, base, places or Places(), embed)
    names = saving.collect(states)

    def parts() -> Iterator[StoredPart]:
        for done, name in enumerate(names):
            if on_part is not None:
                on_part(done, len(names))
            part = saving.part(name)
            if part is not None:
                yield part

    write_archive(path, parts(), [parts for parts in base if isinstance(parts, Archive)])
    return tuple(dict.fromkeys(saving.notes))


def _check_replaceable(path: str | os.PathLike[str]) -> None:
    """Raise ExportError if an existing file is write-protected, or a project of another schema."""
    if not Path(path).is_file():
        return
    if not os.access(path, os.W_OK):
        raise ExportError(f"{path} is write-protected. Save under another name.")
    head = None
    with suppress(*UNREADABLE), Archive(path) as there:
        head = read_project_head(there.read(PROJECT))
    if head is not None:
        with told_as(ExportError, f"{path} is not replaced. {{error}}", FormatError):
            check_schema(head, SCHEMA, "project")


class _Saving:
    """The parts of a project file that is written: those of changed states, and stored ones that are copied."""

    def __init__(self, path: Path, project: Project, base: Sequence[Parts], places: Places, embed: bool | None) -> None:
        self.notes: list[str] = []
        self._path, self._project, self._places, self._embed = path, project, places, embed
        self._stored: dict[str, list[Parts]] = {}
        """Name of a part -> the stores that have it, in their order."""
        for parts in base:
            for name in parts.names():
                self._stored.setdefault(name, []).append(parts)
        self._made: dict[str, bytes] = {}
        self._names: dict[str, None] = {PROJECT: None}
        self._files: dict[str, FilePlace] = {}

    def collect(self, states: Sequence[FrameState]) -> list[str]:
        """Encode the changed states; return the names of all parts of the file, project.json first."""
        for state in states:
            self._encode(state)
        listed = tuple(map(self._listed, self._project.frames))
        places = Places(self._path, self._files)
        self._made[PROJECT] = encode_project(replace(self._project, frames=listed), places)
        return list(self._names)

    def part(self, name: str) -> StoredPart | None:
        """Return a part to write, as it is stored, damaged or not; None if no store has it."""
        if name in self._made:
            return StoredPart(name, self._made[name])
        damaged: StoredPart | None = None
        for parts in self._stored.get(name, ()):
            try:
                part = parts.read_raw(name) if isinstance(parts, Archive) else StoredPart(name, parts.read(name))
            except FormatError as error:
                self.notes.append(f"{error} It is not saved.")
                continue
            if part.checksum is None:
                return part
            damaged = damaged or part
        if damaged is None:
            self.notes.append(f"The part {name:.40} was not found and is not saved.")
        return damaged

    def _encode(self, state: FrameState) -> None:
        encoded = encode(state)
        self._made |= encoded.made | {frame_part(state.id): encoded.content}

    def _has(self, name: str) -> bool:
        return name in self._made or name in self._stored

    def _listed(self, frame: ProjectFrame) -> ProjectFrame:
        """Add the parts of a frame; return its entry for the list. A frame without a state gets one if its files are to
        be embedded."""
        name = frame_part(frame.id)
        there = (frame.has_state and self._has(name)) or name in self._made
        if frame.has_state and not there:
            self.notes.append(f"The stored work on {frame.name} was not found and is not saved.")
        if not there and self._embed and frame.source is not None:
            try:
                self._encode(empty_state(frame.id, read_frame(frame.source)))
                there = True
            except IlfError as error:
                self.notes.append(f"{frame.name} is not embedded: {error}")
        for path in () if frame.source is None else frame.source.paths:
            self._files.setdefault(path, FilePlace(_relative(Path(path), self._path.parent), path))
        if there:
            self._add_state(name)
        if self._has(thumbnail_part(frame.id)):
            self._names[thumbnail_part(frame.id)] = None
        return replace(frame, has_state=there)

    def _add_state(self, name: str) -> None:
        """Add a state and the parts that it names; all of its store if it cannot be read, so that nothing is lost."""
        self._names[name] = None
        store = next(iter(self._stored.get(name, ())), None)
        try:
            content = self._made[name] if name in self._made or store is None else store.read(name)
            head = read_head(content)
        except UNREADABLE:
            everything = () if store is None else sorted(store.names())
            self._names |= dict.fromkeys(part for part in everything if part.startswith((ARRAYS, SOURCES)))
            return
        self._names |= dict.fromkeys(head.parts)
        for file in head.files:
            self._add_file(file)

    def _add_file(self, file: InputFile) -> None:
        """Embed a frame's file, keep it embedded, or record its path."""
        present = self._places.present(file) or Path(file.path)
        self._files[file.path] = FilePlace(_relative(present, self._path.parent), str(present))
        name = source_part(file.sha256, file.path)
        if not file.sha256:
            if self._embed:
                self.notes.append(f"Not embedded: {file.path} is a recording; recordings are never embedded.")
            return
        if self._has(name):
            if self._embed is not False or located(file, self._places)[0] is None:
                self._names[name] = None
        elif self._embed:
            try:
                self._made[name] = find_source(file, None, self._places).data.tobytes()
                self._names[name] = None
            except InputError as error:
                self.notes.append(f"Not embedded: {error}")


def _relative(path: Path, folder: Path) -> str | None:
    """Return a path relative to a folder, with slashes; None if there is none, as between drives."""
    try:
        return os.path.relpath(path, folder).replace(os.sep, "/")
    except ValueError:
        return None
