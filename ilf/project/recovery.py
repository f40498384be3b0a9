"""Recovery: journals of windows that closed unexpectedly with work that is in no project file."""

from __future__ import annotations

import contextlib
import json
import os
import socket
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import platformdirs

from .._runtime.files import parse_json
from .._runtime.writing import restrict_to_owner
from ..errors import IlfError, InputError
from .archive import Parts
from .encoding import frame_part
from .journal import Journal, JournalHeader, JournalInUse
from .project import Project, ProjectFrame
from .project_json import ReadProject, decode_project, frames_with_state
from .state_json import UNREADABLE, parsed_frame_part
from .thumbnail import thumbnail_part

SUFFIX = ".journal"


def journal_folder() -> Path:
    """Return the folder of the windows' journals: `ILF_AUTOSAVE`, or a folder in the user's data folder."""
    chosen = os.environ.get("ILF_AUTOSAVE")
    return Path(chosen) if chosen else platformdirs.user_data_path("ilf-studio", appauthor=False) / "autosave"


@dataclass(frozen=True, eq=False)
class RecoverableWork:
    """Recoverable work in the journal of a closed window. It is locked as long as this object is open.

    Attributes
    ----------
    path : Path
        Of the journal.
    note : JournalHeader or None
        Origin and times of the work; None if the journal cannot be read.
    read : ReadProject
        The list of frames with their present summaries.
    stored : frozenset of str
        Ids of the frames whose state is in the journal; their state in the project file is older, or the same.
    changed : frozenset of str
        Those of `stored` with work that was not in the project file when the journal was last written.
    problem : str
        Why the journal cannot be read; "" if it can.
    """

    path: Path
    note: JournalHeader | None = None
    read: ReadProject = field(default_factory=lambda: ReadProject(Project()))
    stored: frozenset[str] = frozenset()
    changed: frozenset[str] = frozenset()
    problem: str = ""
    _journal: Journal | None = None

    @property
    def parts(self) -> Parts:
        """All parts of the journal; raises InputError if it cannot be read."""
        if self._journal is None:
            raise InputError(self.problem)
        return self._journal

    @property
    def frames(self) -> tuple[ProjectFrame, ...]:
        """The frames with work that is only in the journal."""
        return tuple(frame for frame in self.read.project.frames if frame.id in self.changed)

    def picture(self) -> bytes | None:
        """Return a JPEG image of the frame viewed last, or of another one with work; None if there is none."""
        for frame_id in (self.read.project.present, *sorted(self.changed)):
            with contextlib.suppress(IlfError):
                return self.parts.read(thumbnail_part(frame_id))
        return None

    def release(self) -> None:
        """Close the journal and keep it."""
        if self._journal is not None:
            self._journal.close()

    def discard(self) -> None:
        """Delete the journal; raises OSError if that fails."""
        if self._journal is not None:
            self._journal.discard()
        for suffix in ("-wal", ""):
            self.path.with_name(self.path.name + suffix).unlink(missing_ok=True)


def find_recoverable_work(folder: Path) -> list[RecoverableWork]:
    """Find the recoverable work of closed windows in a folder, the newest first.

    Journals in use are skipped; journals without unsaved work are deleted. The folder becomes private to the user.
    """
    restrict_to_owner(folder)
    found = [_read_recoverable(path) for path in folder.glob(f"*{SUFFIX}")]
    there = [left for left in found if left is not None]
    return sorted(there, key=lambda left: left.note.changed.timestamp() if left.note else 0.0, reverse=True)


def _read_recoverable(path: Path) -> RecoverableWork | None:
    try:
        journal = Journal(path)
    except JournalInUse:
        return None
    except IlfError as error:
        return RecoverableWork(path, problem=str(error))
    note, names = journal.note, journal.names()
    stored = frozenset(name.split("/")[1].removesuffix(".json") for name in names if name.startswith("frames/"))
    if not names or (not note.unsaved and note.host == socket.gethostname()):
        with contextlib.suppress(OSError):
            journal.discard()
        return None
    try:
        read = decode_project(journal, Path(note.project) if note.project else None, stated_in="")
    except IlfError as error:
        journal.close()
        return RecoverableWork(path, note, problem=str(error))
    now = {frame.id: frame for frame in frames_with_state(journal, "")}
    listed = [_with_newer_summary(frame, now.pop(frame.id, None)) for frame in read.project.frames]
    project = replace(read.project, frames=(*listed, *now.values()))
    changed = stored if note.frames is None else stored.intersection(note.frames)
    return RecoverableWork(path, note, replace(read, project=project), stored, changed, _journal=journal)


def _with_newer_summary(listed: ProjectFrame, own: ProjectFrame | None) -> ProjectFrame:
    """Return a frame of the list with the newer summary of its own part. The note stays that of the list, since notes
    of frames that are not open are stored only there."""
    if own is None:
        return listed
    fresh = own.summary
    summary = replace(
        listed.summary, stage=fresh.stage, shape=fresh.shape, completed=fresh.completed, problem=fresh.problem
    )
    return replace(listed, has_state=True, summary=summary)


@dataclass(frozen=True)
class Copied:
    """Copies of frames' parts under new ids.

    Attributes
    ----------
    put : dict of str to bytes
    refers : dict of str to frozenset of str
        Id of a frame -> the arrays that its state refers to.
    problems : dict of str to str
        New id of a frame that cannot be read, which is left out -> why, one sentence.
    """

    put: dict[str, bytes]
    refers: dict[str, frozenset[str]]
    problems: dict[str, str]


def copy_frames(stores: Collection[Parts], ids: Mapping[str, str]) -> Copied:
    """Copy frames with all parts that they refer to, each whole or not at all; arrays are read from the first store
    that has a readable one.

    Parameters
    ----------
    stores : collection of Parts
    ids : mapping of str to str
        Id of a frame in the stores -> its new id.
    """
    put: dict[str, bytes] = {}
    refers: dict[str, frozenset[str]] = {}
    problems: dict[str, str] = {}
    for former, frame_id in ids.items():
        try:
            name = frame_part(former)
            newest = [parts for parts in stores if name in parts.names()][:1]  # an older state does not stand in for it
            content = _first(newest, name)
            names = parsed_frame_part(content).arrays
            arrays = {name: _first(stores, name) for name in names - put.keys()}
        except UNREADABLE as error:
            problems[frame_id] = f"The work on this frame cannot be restored: {error}"
            continue
        if former != frame_id:
            content = json.dumps(parse_json(content, "The frame's part") | {"id": frame_id}).encode()
        put |= arrays | {frame_part(frame_id): content}
        refers[frame_id] = names
        with contextlib.suppress(InputError):
            put[thumbnail_part(frame_id)] = _first(stores, thumbnail_part(former))
    return Copied(put, refers, problems)


def _first(stores: Collection[Parts], name: str) -> bytes:
    problem = InputError(f"There is no part {name}.")
    for parts in stores:
        try:
            return parts.read(name)
        except InputError as error:
            problem = error
    raise problem
