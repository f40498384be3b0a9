"""What a project file is to hold, gathered from what has changed and where the rest is kept."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from ..errors import FormatError, IlfError, InputError
from ..frame import InputFile
from .archive import Archive, Part
from .encoding import Encoder, frame_part
from .frame_state import FrameState
from .packing import ARRAYS
from .parts import Parts
from .project import Project, ProjectFrame
from .project_json import PROJECT, encode_project
from .recorded import UNREADABLE, arrays_of, bare_state, files_of
from .sources import SOURCES, FilePlace, Places, find_source, source_part
from .thumbnail import thumbnail_part


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
