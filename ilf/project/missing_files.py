"""Missing and changed files of a project's frames, and where they are now."""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from pathlib import Path

from .._runtime.files import file_sha256, is_address
from .._runtime.installation import user_path
from .._runtime.named_places import may_look_at, note_opened
from ..data.frame import InputFile
from ..errors import InputError
from ..sources.frame_ref import FrameRef
from .archive import Parts
from .codec import UNREADABLE
from .file import SUFFIX, OpenedProject
from .project import ProjectFrame
from .sources import MissingSource, Places, embedded
from .state_codec import frame_part, read_head


def located(wanted: InputFile, places: Places) -> tuple[Path | None, Path | None]:
    """Return the file at its possible places, and the first one with another content; None for none. Files without a
    known SHA-256 may be folders."""
    other: Path | None = None
    for path in places.candidates(wanted):
        if not wanted.sha256 or _is_same(path, wanted.sha256):
            return path, None
        other = other or path
    return None, other


def how_found(wanted: InputFile, opened: OpenedProject) -> str:
    """Return how a file of a project's frames is there: "embedded", "present", "changed", "missing", or "not allowed"
    if it may lie where nothing is opened unasked."""
    if embedded(wanted, opened.parts) is not None:
        return "embedded"
    same, other = located(wanted, opened.places)
    if same is not None or other is not None:
        return "changed" if same is None else "present"
    try:
        opened.places.check(wanted)
    except InputError:
        return "not allowed"
    return "missing"


def wanted_files(frame: ProjectFrame, parts: Parts) -> list[InputFile]:
    """List the files of a frame from its state, or else from its source, without their SHA-256."""
    if frame.has_state:
        with suppress(*UNREADABLE):  # else from the source
            return list(read_head(parts.read(frame_part(frame.id))).files)
    return [] if frame.source is None else [InputFile(path, "") for path in frame.source.paths]


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


def _is_same(path: Path, sha256: str) -> bool:
    try:
        return file_sha256(path) == sha256
    except (InputError, OSError):
        return False


# Project files of frame folders, used until the user saves the work in a project file.


def folder_projects_dir() -> Path:
    """Return the folder of these project files: `ILF_FOLDERS`, or a folder in the user's data folder."""
    return user_path("data", "folders", "ILF_FOLDERS")


def folder_project_path(folder: str | os.PathLike[str]) -> Path:
    """Return the path of the project file of a frame folder that is not beside it: the same for the same folder,
    existing or not.

    Examples
    --------
    >>> path = folder_project_path("/data/desk")
    >>> path.name, path == folder_project_path("/data/more/../desk")
    ('desk.ilf', True)
    """
    place = os.path.realpath(folder)
    name = os.path.basename(place) or "frames"
    return folder_projects_dir() / hashlib.sha256(os.fsencode(place)).hexdigest()[:16] / f"{name}{SUFFIX}"
