"""Recovery: folders of windows that closed unexpectedly with work that is in no project file."""

from __future__ import annotations

import contextlib
import shutil
import socket
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from pathlib import Path

from .._runtime.installation import user_path
from .._runtime.writing import restrict_to_owner
from ..errors import IlfError, InputError
from .archive import Parts
from .codec import UNREADABLE
from .project import Project, ProjectFrame
from .project_json import ReadProject, decode_project, frames_with_state
from .state_codec import frame_part, read_head, thumbnail_part
from .store import FolderInUse, WorkFolder, WorkHeader

SUFFIX = ".work"


def autosave_folder() -> Path:
    """Return the folder of the windows' autosaves: `ILF_AUTOSAVE`, or a folder in the user's data folder."""
    return user_path("data", "autosave", "ILF_AUTOSAVE")


@dataclass(frozen=True, eq=False)
class RecoverableWork:
    """Recoverable work of a closed window. Its folder is locked as long as this object is open.

    Attributes
    ----------
    path : Path
        Of the folder.
    header : WorkHeader or None
        Origin and time of the work; None if it cannot be read.
    read : ReadProject
        The list of frames.
    stored : frozenset of str
        Ids of the frames whose state is in the folder; their state in the project file is older, or the same.
    problem : str
        Why the folder cannot be read; "" if it can.
    """

    path: Path
    header: WorkHeader | None = None
    read: ReadProject = field(default_factory=lambda: ReadProject(Project()))
    stored: frozenset[str] = frozenset()
    problem: str = ""
    _folder: WorkFolder | None = None

    @property
    def parts(self) -> Parts:
        """All parts of the folder; raises InputError if it cannot be read."""
        if self._folder is None:
            raise InputError(self.problem)
        return self._folder

    @property
    def project(self) -> str:
        """Path of the project file; "" if there is none."""
        return "" if self.header is None else self.header.project

    @property
    def changed(self) -> frozenset[str]:
        """Ids of the stored frames with work that was not in the project file."""
        return self.stored.intersection(() if self.header is None else self.header.frames)

    @property
    def frames(self) -> tuple[ProjectFrame, ...]:
        """The frames with work that is only in the folder."""
        return tuple(frame for frame in self.read.project.frames if frame.id in self.changed)

    def release(self) -> None:
        """Close the folder and keep it."""
        if self._folder is not None:
            self._folder.close()

    def discard(self) -> None:
        """Delete the folder; raises OSError if that fails."""
        if self._folder is not None:
            self._folder.discard()
        elif self.path.exists():
            shutil.rmtree(self.path)


def find_recoverable_work(folder: Path) -> list[RecoverableWork]:
    """Find the recoverable work of closed windows in a folder, the newest first.

    Folders in use are skipped; those without unsaved work are deleted. The folder becomes private to the user.
    """
    restrict_to_owner(folder)
    found = [_read_recoverable(path) for path in folder.glob(f"*{SUFFIX}")]
    there = [left for left in found if left is not None]
    return sorted(there, key=lambda left: left.header.changed.timestamp() if left.header else 0.0, reverse=True)


def _read_recoverable(path: Path) -> RecoverableWork | None:
    try:
        folder = WorkFolder(path)
    except FolderInUse:
        return None
    except IlfError as error:
        return RecoverableWork(path, problem=str(error))
    header, names = folder.header, folder.names()
    if not names or (not header.unsaved and header.host == socket.gethostname()):
        with contextlib.suppress(OSError):
            folder.discard()
        return None
    try:
        read = decode_project(folder, Path(header.project) if header.project else None, stated_in="")
    except IlfError as error:
        folder.close()
        return RecoverableWork(path, header, problem=str(error))
    there = {frame.id: frame for frame in frames_with_state(folder, "")}
    listed = [replace(frame, has_state=frame.has_state or frame.id in there) for frame in read.project.frames]
    others = [frame for frame in there.values() if frame.id not in {one.id for one in listed}]
    project = replace(read.project, frames=(*listed, *others))
    return RecoverableWork(path, header, replace(read, project=project), frozenset(there), _folder=folder)


@dataclass(frozen=True)
class Copied:
    """Copies of frames' parts.

    Attributes
    ----------
    put : dict of str to bytes
    names : dict of str to frozenset of str
        Id of a frame -> the parts that its state names.
    problems : dict of str to str
        Id of a frame that cannot be read, which is left out -> why, one sentence.
    """

    put: dict[str, bytes]
    names: dict[str, frozenset[str]]
    problems: dict[str, str]


def copy_frames(stores: Collection[Parts], ids: Collection[str]) -> Copied:
    """Copy frames with all parts that they name, each whole or not at all; arrays are read from the first store that
    has a readable one.

    Parameters
    ----------
    stores : collection of Parts
    ids : collection of str
        Ids of the frames.
    """
    copied = Copied({}, {}, {})
    for frame_id in ids:
        name = frame_part(frame_id)
        try:
            newest = [parts for parts in stores if name in parts.names()][:1]  # an older state does not stand in for it
            content = _first(newest, name)
            names = read_head(content).parts
            arrays = {name: _first(stores, name) for name in names if name not in copied.put}
        except UNREADABLE as error:
            copied.problems[frame_id] = f"The work on this frame cannot be restored: {error}"
            continue
        copied.put.update(arrays | {name: content})
        copied.names[frame_id] = frozenset(names)
        with contextlib.suppress(InputError):
            copied.put[thumbnail_part(frame_id)] = _first(stores, thumbnail_part(frame_id))
    return copied


def _first(stores: Collection[Parts], name: str) -> bytes:
    problem = InputError(f"There is no part {name}.")
    for parts in stores:
        try:
            return parts.read(name)
        except InputError as error:
            problem = error
    raise problem
