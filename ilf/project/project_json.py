"""project.json: the list of frames, the locations of their files, and the common settings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from .._runtime.files import parse_json
from .._runtime.formatting import counted
from .._runtime.installation import __version__
from .._runtime.schema import PROGRAM, Section, check_schema, converted, strict_json
from ..data.frame import FrameInputs
from ..errors import FormatError, InputError
from ..sources.frame_ref import FrameRef
from ..sources.named_places import NotAllowed, named_in
from .archive import Parts
from .codec import UNREADABLE, Read, Write, from_plain, to_plain
from .project import FrameSummary, Project, ProjectFrame, Stage
from .sources import FilePlace, Places
from .state_codec import SCHEMA, frame_part, read_head

PROJECT = "project.json"
_ID = r"[A-Za-z0-9_-]{1,64}"


@dataclass(frozen=True)
class ReadProject:
    """The readable content of project.json.

    Attributes
    ----------
    project : Project
    places : Places
        Locations of the frames' files.
    problems : tuple of str
        What could not be read, with the consequence; one sentence each.
    """

    project: Project
    places: Places = field(default_factory=Places)
    problems: tuple[str, ...] = ()


def encode_project(project: Project, places: Places | None = None) -> bytes:
    """Encode the part project.json.

    Parameters
    ----------
    project : Project
    places : Places, optional
        Locations of the frames' files, relative to the project file.
    """
    known = places or Places()
    hooks: dict[type, Write] = {FrameRef: FrameRef.to_json}
    data = {
        "program": PROGRAM,
        "schema": SCHEMA,
        "version": __version__,
        "folder": None if known.project is None else str(known.project.parent),
        "files": to_plain(known.files, {}),
        "given": {key: str(path) for key, path in known.given.items()},
        "settings": to_plain(replace(project, frames=()), hooks),
    }
    # encoded frame by frame: encoding thousands of frames at once would block all other threads
    frames = b",".join(strict_json(to_plain(frame, hooks)) for frame in project.frames)
    return strict_json(data)[:-1] + b',"frames":[' + frames + b"]}"


def decode_project(parts: Parts, path: Path | None = None, *, stated_in: str | None = None) -> ReadProject:
    """Read the project stored in parts; if project.json cannot be read, build it from the stored frames.

    Parameters
    ----------
    parts : Parts
    path : Path, optional
        Of the project file, which relative paths refer to.
    stated_in : str, optional
        Its folder if the user has opened it, "" for an autosave; see `Places`.

    Raises
    ------
    FormatError
        If there is neither a project nor a frame, or the project has another schema.
    """
    try:
        head = read_project_head(parts.read(PROJECT))
    except UNREADABLE as error:
        return _from_states(parts, path, stated_in, error)
    check_schema(head, SCHEMA, "project" if path is None else f"project {path}")
    try:
        return _decoded(head, path, stated_in)
    except UNREADABLE as error:
        return _from_states(parts, path, stated_in, error)


def read_project_head(content: bytes) -> dict[str, Any]:
    """Parse a project.json; raises FormatError if it is damaged, or of another program."""
    data = parse_json(content, "Its list of frames")
    if not isinstance(data, dict) or data.get("program") != PROGRAM:
        raise FormatError("It was written by another program.")
    return data


def _decoded(data: Mapping[str, Any], path: Path | None, stated_in: str | None) -> ReadProject:
    stored = Section("project", dict(data))
    given = _given(stored.get("given", dict[str, str]), stated_in)
    places = Places(path, stored.get("files", dict[str, FilePlace]), given, stated_in=stated_in)
    moved = path is not None and stored.get("folder", str | None) != str(path.parent)

    def source(data: Any, kind: Any) -> FrameRef:
        read = FrameRef.from_json(Section("source", converted(data, dict, "source")), stated_in)
        return read.with_paths(lambda path: _present(path, places)) if moved else read

    hooks: dict[type, Read] = {FrameRef: source}
    frames = tuple(from_plain(row, ProjectFrame, hooks) for row in stored.get("frames", list[Any]))
    for frame in frames:
        if not re.fullmatch(_ID, frame.id):
            raise FormatError(f"{frame.id!r:.40} is not a valid id.")
    project = replace(from_plain(stored.get("settings", dict[str, Any]), Project, hooks), frames=frames)
    return ReadProject(project, places)


def _from_states(parts: Parts, path: Path | None, stated_in: str | None, error: Exception) -> ReadProject:
    frames = tuple(frames_with_state(parts, stated_in))
    if not frames:
        raise FormatError(f"There is no project in it: {error}") from error
    lost = f"The list of frames and the common settings are lost: {error} {counted(len(frames), 'frame')} recovered."
    return ReadProject(Project(frames), Places(path, stated_in=stated_in), problems=(lost,))


def _given(given: dict[str, str], stated_in: str | None) -> dict[str, Path]:
    """Return the places that the user has given, without those that must not be opened unasked."""
    found = {}
    for key, path in given.items():
        with suppress(InputError):
            found[key] = Path(path if stated_in is None else named_in(path, stated_in))
    return found


def _present(path: str, places: Places) -> str:
    """Return the present path of a moved project's file; the old path if it was not moved along."""
    beside = places.beside(path)
    with suppress(NotAllowed):
        if beside is not None and places.stated_in is not None:
            named_in(str(beside), places.stated_in)
        if beside is not None and beside.exists():
            return str(beside)
    return path


def frames_with_state(parts: Parts, stated_in: str | None) -> list[ProjectFrame]:
    """List the frames whose states are stored, with what these say of them, or why they cannot be read; `stated_in` as
    in `Places`."""
    names = (name for name in sorted(parts.names()) if name.startswith("frames/"))
    ids = (name.removeprefix("frames/").removesuffix(".json") for name in names)
    return [_frame_from_part(identity, parts, stated_in) for identity in ids if re.fullmatch(_ID, identity)]


def _frame_from_part(identity: str, parts: Parts, stated_in: str | None) -> ProjectFrame:
    """Build a frame's list entry from its stored state."""
    try:
        head = read_head(parts.read(frame_part(identity)))
        stored = head.state["frame"]
        inputs = from_plain(stored["inputs"], FrameInputs | None, {})
        source = None if inputs is None else replace(FrameRef.of(inputs), stated_in=stated_in)
        completed = len(head.state["results"])
        stage = Stage.RUN if completed else Stage.EDITED
        summary = FrameSummary(stage, head.state["note"], completed=completed, done=head.state["done"])
        return ProjectFrame(identity, converted(stored["name"], str, "frame"), source, summary, True)
    except UNREADABLE as error:
        problem = f"The work on this frame cannot be read: {error}"
        return ProjectFrame(identity, identity, None, FrameSummary(Stage.FAILED, problem=problem), True)
