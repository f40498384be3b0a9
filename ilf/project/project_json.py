"""project.json: the list of frames, the locations of their files, and the common settings."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeVar

from .._runtime.files import parse_json
from .._runtime.formatting import counted
from .._runtime.installation import __version__
from .._runtime.named_places import NotAllowed, named_in
from .._runtime.schema import Section, check_schema, plain, strict_json
from ..data.declarations import ParameterSet
from ..data.parameters import BlockParameters, Parameters
from ..errors import FormatError, IlfError, InputError
from ..run.record_file import parsed_inputs
from ..sources.frame_source import FrameSource
from .archive import Parts
from .encoding import PROGRAM, SCHEMA
from .project import FrameSummary, Project, ProjectFrame, Stage
from .sources import FilePlace, Places
from .state_json import UNREADABLE, read_frame_part

PROJECT = "project.json"

Set = TypeVar("Set", bound=ParameterSet)


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
    return _Reader(Section("project", data), path, stated_in).project()


class _Reader:
    """Decodes a project from its JSON."""

    def __init__(self, data: Section, path: Path | None, stated_in: str | None) -> None:
        self._data, self._path, self._stated_in = data, path, stated_in
        self._problems: list[str] = []

    def project(self) -> ReadProject:
        problems = self._problems
        places = Places(self._path, self._files(), self._given(), stated_in=self._stated_in)
        moved = self._path is not None and self._value("folder", None, str, type(None)) != str(self._path.parent)
        frames = []
        for row in self._value("frames", [], list):
            try:
                frames.append(_frame(Section("frame", row), places, moved))
            except UNREADABLE as error:
                problems.append(f"A frame of the list is lost: {error}")
        project = Project(
            tuple({frame.id: frame for frame in frames}.values()),
            self._value("present", "", str),
            self._parameters("parameters", Parameters),
            self._value("for_all", False, bool),
            self._parameters("extraction", BlockParameters),
            self._value("keeps_handmade", True, bool),
            self._value("view", {}, dict),
        )
        return ReadProject(project, places, self._value("embedded", False, bool), tuple(problems))

    def _value(self, key: str, default: Any, *kinds: type) -> Any:
        try:
            return self._data.get(key, *kinds)
        except IlfError as error:
            self._problems.append(f"{error} The default is used.")
            return default

    def _parameters(self, key: str, kind: type[Set]) -> Set:
        try:
            return kind.from_dict(self._data.get(key, dict))
        except IlfError as error:
            self._problems.append(f"{error} The defaults are used.")
            return kind()

    def _files(self) -> dict[str, FilePlace]:
        found = {}
        for path, place in self._value("files", {}, dict).items():
            relative, absolute = (
                place.get(key) if isinstance(place, dict) else None for key in ("relative", "absolute")
            )
            if isinstance(relative, str | None) and isinstance(absolute, str | None):
                found[path] = FilePlace(relative, absolute)
        return found

    def _given(self) -> dict[str, Path]:
        found = {}
        for key, path in self._value("given", {}, dict).items():
            with suppress(InputError):
                if isinstance(path, str):
                    found[key] = Path(path if self._stated_in is None else named_in(path, self._stated_in))
        return found


def _frame(row: Section, places: Places, moved: bool) -> ProjectFrame:
    """Decode a frame of the list; `places` locates the files of a project that has been moved."""
    source = None
    if row.get("source", dict, type(None)) is not None:
        source = FrameSource.from_json(row.section("source"), places.stated_in)
        if moved:
            source = source.with_paths(lambda path: _present(path, places))
    identity = row.get("id", str)
    if not re.fullmatch(r"[A-Za-z0-9_-]{1,64}", identity):
        raise FormatError(f"{identity!r:.40} is not a valid id.")
    return ProjectFrame(identity, row.get("name", str), source, _summary(row), row.get("has_state", bool))


def _present(path: str, places: Places) -> str:
    """Return the present path of a moved project's file; the old path if it was not moved along."""
    beside = places.beside(path)
    with suppress(NotAllowed):
        if beside is not None and places.stated_in is not None:
            named_in(str(beside), places.stated_in)
        if beside is not None and beside.exists():
            return str(beside)
    return path


def _summary(row: Section) -> FrameSummary:
    """Decode the frame's summary; an empty one if it cannot be read, since it can be recomputed."""
    try:
        summary: FrameSummary = row.get("summary", FrameSummary)
    except FormatError:
        return FrameSummary()
    return summary


def frames_with_state(parts: Parts, stated_in: str | None) -> list[ProjectFrame]:
    """List the frames whose states are stored, with the summaries in these states; `stated_in` as in `Places`."""
    frames = []
    for name in sorted(parts.names()):
        if name.startswith("frames/"):
            try:
                frames.append(_frame_from_part(name.removeprefix("frames/").removesuffix(".json"), parts, stated_in))
            except UNREADABLE:
                continue
    return frames


def _frame_from_part(identity: str, parts: Parts, stated_in: str | None) -> ProjectFrame:
    """Build a frame's list entry from its stored state."""
    data = read_frame_part(identity, parts)
    frame, source = data.section("frame"), None
    if "inputs" in frame.values:
        source = replace(FrameSource.of(parsed_inputs(frame.get("inputs", dict))), stated_in=stated_in)
    height, width = frame.items("shape", int)
    stage = _stage(data.values)
    note, completed, done = data.get("note", str), len(data.get("results", list)), data.get("done", bool)
    summary = FrameSummary(stage, note, (height, width), completed=completed, done=done)
    return ProjectFrame(identity, frame.get("name", str), source, summary, True)


def _stage(data: Mapping[str, Any]) -> Stage:
    """Derive a frame's stage from the names of its parts: equal content has equal names."""
    if data.get("results"):
        return Stage.RUN
    notes = data.get("notes") or {}
    is_unedited = notes.get("extracted") == data.get("labels")
    if is_unedited and notes.get("propagated_from"):
        return Stage.PROPAGATED
    return Stage.EXTRACTED if is_unedited and not notes.get("kept") else Stage.EDITED
