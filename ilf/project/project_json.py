"""project.json: the list of frames, the locations of their files, and the common settings."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec

from .._runtime.files import parse_json
from .._runtime.formatting import counted
from .._runtime.installation import __version__
from .._runtime.named_places import NotAllowed, named_in
from .._runtime.schema import Section, check_schema, converted, plain, strict_json
from ..data.parameters import BlockParameters, Parameters
from ..errors import FormatError, InputError
from ..run.record_file import parsed_inputs
from ..sources.frame_ref import FrameRef
from .archive import Parts
from .encoding import PROGRAM, SCHEMA
from .project import FrameSummary, Project, ProjectFrame, Stage
from .sources import FilePlace, Places
from .state_json import UNREADABLE, StateJson, read_frame_part

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
    embedded : bool
        Whether the frames' files are to be embedded when the project is saved.
    problems : tuple of str
        What could not be read, with the consequence; one sentence each.
    """

    project: Project
    places: Places = field(default_factory=Places)
    embedded: bool = False
    problems: tuple[str, ...] = ()


def encode_project(project: Project, places: Places | None = None, *, embedded: bool = False) -> bytes:
    """Encode the part project.json.

    Parameters
    ----------
    project : Project
    places : Places, optional
        Locations of the frames' files, relative to the project file.
    embedded : bool
        Whether the files are embedded whenever the project is saved.
    """
    known = places or Places()
    data = {
        "program": PROGRAM,
        "schema": SCHEMA,
        "version": __version__,
        "folder": None if known.project is None else str(known.project.parent),
        "present": project.present,
        "parameters": project.common.to_dict(),
        "for_all": project.for_all,
        "extraction": project.extraction.to_dict(),
        "keeps_handmade": project.keeps_handmade,
        "view": plain(project.view),
        "embedded": embedded,
        "files": {path: vars(place) for path, place in known.files.items()},
        "given": {key: str(path) for key, path in known.given.items()},
    }
    # encoded frame by frame: encoding thousands of frames at once would block all other threads
    frames = b",".join(map(_encoded_frame, project.frames))
    return strict_json(data)[:-1] + b',"frames":[' + frames + b"]}"


def _encoded_frame(frame: ProjectFrame) -> bytes:
    data = {
        "id": frame.id,
        "name": frame.name,
        "source": None if frame.source is None else frame.source.to_json(),
        "summary": vars(frame.summary),
        "has_state": frame.has_state,
    }
    return strict_json(data)


def decode_project(parts: Parts, path: Path | None = None, *, stated_in: str | None = None) -> ReadProject:
    """Read the project stored in parts; if project.json cannot be read, build it from the stored frames.

    Parameters
    ----------
    parts : Parts
    path : Path, optional
        Of the project file, which relative paths refer to.
    stated_in : str, optional
        Its folder if the user has opened it, "" for a journal; see `Places`.

    Raises
    ------
    FormatError
        If there is neither a project nor a frame, or the project has another schema.
    """
    try:
        data = parse_json(parts.read(PROJECT), "Its list of frames")
        if not isinstance(data, dict) or data.get("program") != PROGRAM:
            raise FormatError("It was written by another program.")
    except UNREADABLE as error:
        frames = tuple(frames_with_state(parts, stated_in))
        if not frames:
            raise FormatError(f"There is no project in it: {error}") from error
        lost = (
            f"The list of frames and the common settings are lost: {error} {counted(len(frames), 'frame')} recovered."
        )
        return ReadProject(Project(frames), Places(path, stated_in=stated_in), problems=(lost,))
    check_schema(data, SCHEMA, "project" if path is None else f"project {path}")
    problems: list[str] = []
    try:
        settings = converted(data, _Settings, "project")
    except FormatError as error:
        problems.append(f"The common settings are lost: {error} The defaults are used.")
        settings = converted(parse_json(encode_project(Project()), "The defaults"), _Settings, "project")
    places = Places(path, settings.files, _given(settings.given, stated_in), stated_in=stated_in)
    moved = path is not None and settings.folder != str(path.parent)
    frames = _listed_frames(data, parts, places, moved, problems)
    project = Project(
        frames,
        settings.present,
        settings.parameters,
        settings.for_all,
        settings.extraction,
        settings.keeps_handmade,
        settings.view,
    )
    return ReadProject(project, places, settings.embedded, tuple(problems))


class _Settings(msgspec.Struct):
    """Everything in project.json but the frames."""

    folder: str | None
    present: str
    parameters: Parameters
    for_all: bool
    extraction: BlockParameters
    keeps_handmade: bool
    view: dict[str, Any]
    embedded: bool
    files: dict[str, FilePlace]
    given: dict[str, str]


def _listed_frames(
    data: dict[str, Any], parts: Parts, places: Places, moved: bool, problems: list[str]
) -> tuple[ProjectFrame, ...]:
    """Decode the list of frames; an entry that cannot be read is added to `problems`, and its frame listed by its
    state."""
    listed: dict[str, ProjectFrame] = {}
    rows = data.get("frames")
    if not isinstance(rows, list):
        rows = []
        problems.append("The list of frames is lost.")
    for row in rows:
        try:
            frame = _frame(Section("frame", row), places, moved)
        except UNREADABLE as error:
            problems.append(f"A frame of the list is lost: {error}")
        else:
            listed[frame.id] = frame
    if problems:
        for frame in frames_with_state(parts, places.stated_in):
            listed.setdefault(frame.id, frame)
    return tuple(listed.values())


def _given(given: dict[str, str], stated_in: str | None) -> dict[str, Path]:
    """Return the places that the user has given, without those that must not be opened unasked."""
    found = {}
    for key, path in given.items():
        with suppress(InputError):
            found[key] = Path(path if stated_in is None else named_in(path, stated_in))
    return found


def _frame(row: Section, places: Places, moved: bool) -> ProjectFrame:
    """Decode a frame of the list; `places` locates the files of a project that has been moved."""
    source = None
    if row.get("source", dict, type(None)) is not None:
        source = FrameRef.from_json(row.section("source"), places.stated_in)
        if moved:
            source = source.with_paths(lambda path: _present(path, places))
    identity = row.get("id", str)
    if not re.fullmatch(_ID, identity):
        raise FormatError(f"{identity!r:.40} is not a valid id.")
    return ProjectFrame(
        identity, row.get("name", str), source, row.get("summary", FrameSummary), row.get("has_state", bool)
    )


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
    """List the frames whose states are stored, with the summaries in these states, or why they cannot be read;
    `stated_in` as in `Places`."""
    names = (name for name in sorted(parts.names()) if name.startswith("frames/"))
    ids = (name.removeprefix("frames/").removesuffix(".json") for name in names)
    return [_frame_from_part(identity, parts, stated_in) for identity in ids if re.fullmatch(_ID, identity)]


def _frame_from_part(identity: str, parts: Parts, stated_in: str | None) -> ProjectFrame:
    """Build a frame's list entry from its stored state."""
    try:
        stored = read_frame_part(identity, parts)
        inputs = None if stored.frame.inputs is None else parsed_inputs(stored.frame.inputs)
    except UNREADABLE as error:
        problem = f"The work on this frame cannot be read: {error}"
        return ProjectFrame(identity, identity, None, FrameSummary(Stage.FAILED, problem=problem), True)
    source = None if inputs is None else replace(FrameRef.of(inputs), stated_in=stated_in)
    summary = FrameSummary(
        _stage(stored), stored.note, stored.frame.shape, completed=len(stored.results), done=stored.done
    )
    return ProjectFrame(identity, stored.frame.name, source, summary, True)


def _stage(stored: StateJson) -> Stage:
    """Derive a frame's stage from the names of its parts: equal content has equal names."""
    if stored.results:
        return Stage.RUN
    is_unedited = stored.notes.extracted == stored.labels
    if is_unedited and stored.notes.propagated_from:
        return Stage.PROPAGATED
    return Stage.EXTRACTED if is_unedited and not stored.notes.kept else Stage.EDITED
