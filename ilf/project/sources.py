"""Locating the files of a project's frames: in the project, beside it, at their old paths, or at paths of the user."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np

from .._runtime.files import FileContent, file_sha256, is_address, read_file
from ..data.camera import Camera
from ..data.frame import FrameInputs, GroundTruthFile, InputFile, RGBDFrame
from ..errors import InputError
from ..io.frame_additions import ground_truth_of
from ..sources.frame_folder import FrameFiles
from ..sources.frame_ref import FrameRef
from ..sources.named_places import first_allowed, may_look_at, named_in, note_opened
from ..sources.read_images import read_files, read_recorded
from .archive import Parts

SOURCES = "sources/"


class MissingSource(InputError):
    """A file of a frame was not found, or only with other content.

    Attributes
    ----------
    wanted : InputFile
        Its old path and the SHA-256 of its content.
    found : Path or None
        The changed file.
    """

    def __init__(self, message: str, wanted: InputFile, found: Path | None = None) -> None:
        super().__init__(message)
        self.wanted, self.found = wanted, found


@dataclass(frozen=True)
class FilePlace:
    """Path of a file when the project was saved: relative to the project's folder (with slashes), and absolute."""

    relative: str | None = None
    absolute: str | None = None


@dataclass(frozen=True)
class Places:
    """Possible locations of the files that frames were read from.

    Attributes
    ----------
    project : Path or None
        The project file; its folder is searched, too.
    files : mapping of str to FilePlace
        Path of a file as stored in the frames -> its path when the project was saved.
    given : mapping of str to Path
        Path of a file as stored in the frames, or the SHA-256 of its content -> its present path.
    folders : tuple of Path
        Folders in which the files are now, by their names or the last parts of their paths.
    stated_in : str or None
        The opened folder of the file that states these places and the frames' files, "" if it is not known; None if the
        user states them. See `FrameRef`.
    """

    project: Path | None = None
    files: Mapping[str, FilePlace] = field(default_factory=dict)
    given: Mapping[str, Path] = field(default_factory=dict)
    folders: tuple[Path, ...] = ()
    stated_in: str | None = None

    def beside(self, path: str) -> Path | None:
        """Return the path that a file has if it was moved together with the project."""
        relative = self.files.get(path, FilePlace()).relative
        if self.project is None or relative is None:
            return None
        return Path(os.path.normpath(self.project.parent / relative))

    def candidates(self, wanted: InputFile) -> Iterator[Path]:
        """Yield the paths where a file may be opened and one is, of any content, or, without a known SHA-256, a folder;
        the likeliest first."""
        return (path for path in self._possible(wanted) if _is_there(path, wanted))

    def _possible(self, wanted: InputFile) -> Iterator[Path]:
        yield from (self.given[key] for key in (wanted.path, wanted.sha256) if key in self.given)
        for path in self._stated(wanted):
            with suppress(InputError):
                yield Path(path if self.stated_in is None else named_in(path, self.stated_in, wanted.sha256))
        yield from _in(self.folders, wanted)

    def check(self, wanted: InputFile) -> None:
        """Raise as `named_in` if a file may be at a path that must not be opened unasked."""
        if self.stated_in is not None:
            first_allowed(self._stated(wanted), self.stated_in, lambda _: False, wanted.sha256)

    def _stated(self, wanted: InputFile) -> Iterator[str]:
        came_along = self.beside(wanted.path)
        if came_along is not None:
            yield str(came_along)
        if absolute := self.files.get(wanted.path, FilePlace()).absolute:
            yield absolute
        yield wanted.path
        yield from map(str, _in(() if self.project is None else (self.project.parent,), wanted))

    def present(self, wanted: InputFile) -> Path | None:
        """Return the first candidate; None if there is none."""
        return next(self.candidates(wanted), None)


def _is_there(path: Path, wanted: InputFile) -> bool:
    try:
        return path.is_file() or (not wanted.sha256 and path.is_dir())
    except (OSError, ValueError):
        return False


def _in(folders: Iterable[Path], wanted: InputFile) -> Iterator[Path]:
    """Yield the paths of a file in folders, by its name and the last parts of its path."""
    steps = [step for step in re.split(r"[\\/]", wanted.path) if step not in {"", ".", ".."}]
    for folder in folders:
        yield from (folder.joinpath(*steps[-count:]) for count in (1, 2, 3) if count <= len(steps))


def source_part(sha256: str, path: str) -> str:
    """Return the name of the part with an embedded file."""
    suffix = re.search(r"\.\w{1,8}$", path)
    return f"{SOURCES}{sha256}{suffix[0].lower() if suffix else ''}"


def embedded(wanted: InputFile, parts: Parts) -> FileContent | None:
    """Return the original content of a file that is embedded in a project; None if it is not, or is damaged."""
    name = source_part(wanted.sha256, wanted.path)
    with suppress(InputError):
        content = parts.read(name) if name in parts.names() else b""
        if hashlib.sha256(content).hexdigest() == wanted.sha256:
            return FileContent(Path(wanted.path), np.frombuffer(content, np.uint8))
    return None


def located(wanted: InputFile, places: Places) -> tuple[Path | None, Path | None]:
    """Return the file at its possible places, and the first one with another content; None for none. Files without a
    known SHA-256 may be folders."""
    other: Path | None = None
    for path in places.candidates(wanted):
        with suppress(InputError, OSError):
            if not wanted.sha256 or file_sha256(path) == wanted.sha256:
                return path, None
        other = other or path
    return None, other


def moved(source: FrameRef, places: Places) -> FrameRef:
    """Return a frame's source with files and folders that are no longer there at their present places.

    Raises
    ------
    MissingSource
        If one of them is at none of its possible places.
    NotAllowed
        If it may be where nothing is opened unasked.
    """

    def present(path: str) -> str:
        wanted = InputFile(path, "")
        if is_address(path) or (may_look_at(path) and os.path.exists(path)):
            return path
        found = places.present(wanted)
        if found is None:
            places.check(wanted)
            raise MissingSource(f"{path} no longer exists. Give its new path.", wanted)
        note_opened(found)
        return str(found)

    return source.with_paths(present)


def find_source(wanted: InputFile, parts: Parts | None = None, places: Places | None = None) -> FileContent:
    """Read the original content of a file that a frame was read from, embedded or on disk.

    Parameters
    ----------
    wanted : InputFile
    parts : Parts, optional
        Parts of the project, which may embed the file.
    places : Places, optional

    Raises
    ------
    MissingSource
        If it was not found, or only with changed content.
    NotAllowed
        If it may be where nothing is opened unasked.
    """
    if parts is not None and (inside := embedded(wanted, parts)) is not None:
        return inside

    def original(path: Path) -> FileContent | None:
        found = read_file(path)
        return found if found.sha256 == wanted.sha256 else None

    return first_original(wanted, places or Places(), original)


Found = TypeVar("Found")


def first_original(wanted: InputFile, places: Places, read: Callable[[Path], Found | None]) -> Found:
    """Return what `read` makes of the first possible place of a file with its original content.

    Parameters
    ----------
    wanted : InputFile
    places : Places
    read : callable
        Returns None if a path has another content, or raises InputError, OSError or ValueError.

    Raises
    ------
    MissingSource, NotAllowed
        As `find_source`.
    """
    changed: tuple[Path, str] | None = None
    for path in places.candidates(wanted):
        try:
            found, problem = read(path), ""
        except (InputError, OSError, ValueError) as error:
            found, problem = None, f" ({error})"
        if found is not None:
            note_opened(path)
            return found
        changed = changed or (path, problem)
    places.check(wanted)
    if changed is None:
        raise MissingSource(f"{wanted.path} no longer exists, and is not embedded. Give its new path.", wanted)
    path, problem = changed
    text = f"{path} has changed since the frame was loaded from it{problem}. Restore it, or give its new path."
    raise MissingSource(text, wanted, path)


def load_inputs(
    inputs: FrameInputs,
    name: str,
    intrinsics: Camera | None,
    parts: Parts | None = None,
    places: Places | None = None,
) -> RGBDFrame:
    """Load a frame from its files at their present paths, without its ground truth (see `with_ground_truth`).

    Returns
    -------
    RGBDFrame
        Its `inputs` contain the present paths.

    Raises
    ------
    MissingSource
        As `find_source`.
    InputError
        If the files are not a valid frame.
    """
    if inputs.frame is not None:
        return _of_recording(inputs, name, intrinsics, places or Places())
    colour, depth = (find_source(wanted, parts, places) for wanted in (inputs.rgb, inputs.depth))
    found = dataclasses.replace(
        inputs,
        rgb=InputFile(str(colour.path), inputs.rgb.sha256),
        depth=InputFile(str(depth.path), inputs.depth.sha256),
        ground_truth=None,
    )
    files, options = FrameFiles(colour.path, depth.path, name), FrameRef.of(found).options
    frame = read_files(files, options, contents=(colour, depth)).frame()
    # what was doubtful was told when it was read first
    return dataclasses.replace(frame, intrinsics=intrinsics, inputs=found, notes=(), plausibility_warnings=())


def _of_recording(inputs: FrameInputs, name: str, intrinsics: Camera | None, places: Places) -> RGBDFrame:
    """Load a frame of a recording at its present path; the recording is identified by the bytes of the frame."""

    def original(path: Path) -> RGBDFrame | None:
        found = read_recorded(dataclasses.replace(FrameRef.of(inputs), rgb=str(path)), name)
        same = (found.inputs.rgb.sha256, found.inputs.depth.sha256) == (inputs.rgb.sha256, inputs.depth.sha256)
        return dataclasses.replace(found, camera=intrinsics).frame() if same else None

    return first_original(InputFile(inputs.rgb.path, ""), places, original)


def with_ground_truth(
    frame: RGBDFrame, wanted: GroundTruthFile, parts: Parts | None = None, places: Places | None = None
) -> RGBDFrame:
    """Return the frame with the ground truth of a file at its present path; raises as `find_source`, and InputError."""
    content = find_source(wanted, parts, places)
    ground_truth, file, _ = ground_truth_of(frame, content, wanted.units, wanted.dataset)
    return frame.with_ground_truth(ground_truth, file)
