"""Missing and changed files of a project's frames, and where they are now."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Collection, Generator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from .._runtime.files import file_sha256
from .._runtime.installation import user_path
from ..data.frame import InputFile
from ..errors import InputError
from ..sources.frame_ref import FrameRef
from .archive import Parts
from .codec import UNREADABLE
from .file import SUFFIX, OpenedProject
from .project import ProjectFrame
from .sources import Places, embedded, source_part
from .state_codec import frame_part, read_head


@dataclass(frozen=True)
class MissingFile:
    """A missing or changed file of a frame.

    Attributes
    ----------
    frame : str
        Id of the frame.
    wanted : InputFile
        Its old path and the SHA-256 of its content; "" if there is no work on the frame, so that the hash is unknown.
    changed : Path or None
        The changed file at one of its possible paths; None if there is none.
    """

    frame: str
    wanted: InputFile
    changed: Path | None = None


def missing_files(opened: OpenedProject, since: float | None = None) -> Generator[None, None, list[MissingFile]]:
    """Check the files of a project's frames, one frame per step.

    Parameters
    ----------
    opened : OpenedProject
    since : float, optional
        Files last modified before this time [s since 1970] are assumed unchanged without reading them.

    Yields
    ------
    None
        After each frame.

    Returns
    -------
    list of MissingFile
    """
    lost: list[MissingFile] = []
    for frame in opened.project.frames:
        for wanted in wanted_files(frame, opened.parts):
            if source_part(wanted.sha256, wanted.path) in opened.parts.names():
                continue  # embedded: it is read, and checked, with its frame
            how, changed = how_found(wanted, opened, since)
            if how in ("changed", "missing"):  # the user is asked about others when their frame is opened
                lost.append(MissingFile(frame.id, wanted, changed))
        yield
    return lost


def located(wanted: InputFile, places: Places, since: float | None = None) -> tuple[Path | None, Path | None]:
    """Return the file at its possible places, and the first one with another content; None for none. Files without a
    known SHA-256 may be folders; those not modified since a time [s since 1970] are not read."""
    other: Path | None = None
    for path in places.candidates(wanted):
        if not wanted.sha256 or _is_same(path, wanted.sha256, since):
            return path, None
        other = other or path
    return None, other


def how_found(wanted: InputFile, opened: OpenedProject, since: float | None = None) -> tuple[str, Path | None]:
    """Return how a file of a project's frames is there: "embedded", "present", "changed", "missing", or "not allowed"
    if it may lie where nothing is opened unasked; with the changed file. `since` as of `missing_files`."""
    if embedded(wanted, opened.parts) is not None:
        return "embedded", None
    same, other = located(wanted, opened.places, since)
    if same is not None or other is not None:
        return ("changed" if same is None else "present"), other
    try:
        opened.places.check(wanted)
    except InputError:
        return "not allowed", None
    return "missing", None


def wanted_files(frame: ProjectFrame, parts: Parts) -> list[InputFile]:
    """List the files of a frame from its state, or else from its source, without their SHA-256."""
    if frame.has_state:
        with suppress(*UNREADABLE):  # else from the source
            return list(read_head(parts.read(frame_part(frame.id))).files)
    return [] if frame.source is None else [InputFile(path, "") for path in frame.source.paths]


def locate(wanted: Collection[InputFile], places: Places) -> Generator[float, None, dict[InputFile, Path]]:
    """Look for files at their possible places.

    Parameters
    ----------
    wanted : collection of InputFile
    places : Places
        With the folders in which the files are now.

    Yields
    ------
    float
        Share of the files that have been looked for, 0-1.

    Returns
    -------
    dict of InputFile to Path
        The found files. Their content is the recorded one; without a SHA-256 it is not checked.
    """
    found: dict[InputFile, Path] = {}
    for number, file in enumerate(wanted):
        yield number / len(wanted)
        path, _ = located(file, places)
        if path is not None:
            found[file] = path
    return found


def relocated(source: FrameRef, found: Mapping[str, Path]) -> FrameRef:
    """Return a frame's source with files replaced by their new paths; `found` maps old to new paths.

    Examples
    --------
    >>> relocated(FrameRef("/old/a"), {"/old/a/rgb.png": Path("/new/a/rgb.png")}).rgb
    '/new/a'
    """
    return source.with_paths(lambda path: _relocated(path, found))


def _relocated(path: str, found: Mapping[str, Path]) -> str:
    if path in found:
        return str(found[path])
    for former, now in found.items():  # path may be a folder, and a file in it was found
        before, *inside = re.split(r"[\\/]", former.removeprefix(path))
        if former.startswith(path) and not before and list(now.parts[-len(inside) :]) == inside:
            return str(now.parents[len(inside) - 1])
    return path


def _is_same(path: Path, sha256: str, since: float | None) -> bool:
    try:
        if since is not None and path.stat().st_mtime < since:
            return True
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
