"""The current project of the window: its file and its unsaved changes."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from filelock import FileLock

from ilf.data.parameters import BlockParameters, Parameters
from ilf.project.archive import file_identity
from ilf.project.project import FrameSummary, Project, ProjectFrame
from ilf.project.recovery import autosave_folder
from ilf.project.store import lock_of
from ilf.sources.frame_ref import FrameRef

from ..state.document import Document
from ..state.entries import Entry
from ..state.parameters import SharedParameters
from ..state.workspace import Workspace

# Content of a project apart from its frames' states.


def project_of(workspace: Workspace) -> Project:
    """Return the list of frames and the shared settings."""
    frames = tuple(
        ProjectFrame(
            entry.id, entry.name, source_of(entry), entry.stored_summary, entry.has_state or has_content(entry.document)
        )
        for entry in workspace.entries
    )
    return Project(
        frames,
        workspace.current.id if workspace.has_current else "",
        workspace.parameters.of_next_frame,
        workspace.parameters.shared.on,
        workspace.parameters.extraction,
        workspace.parameters.keeps_handmade,
    )


def has_content(document: Document | None) -> bool:
    """Return whether a frame has anything to store: one without blocks is read from its files again."""
    return document is not None and (bool(document.counts()) or document.unsaved or document.undo_stack.count() > 0)


def source_of(entry: Entry) -> FrameRef | None:
    """Return the source of an entry's frame, with absolute paths; None if it comes from no file."""
    source, document = entry.source, entry.document
    if source is None and document is not None and document.frame.inputs is not None:
        source = FrameRef.of(document.frame.inputs)
    return None if source is None else source.absolute()


def apply_settings(workspace: Workspace, project: Project) -> None:
    """Apply the shared settings of a project, before its frames are opened with them."""
    workspace.parameters.set_shared(SharedParameters(project.for_all, project.common))
    workspace.parameters.set_extraction(project.extraction)
    workspace.parameters.set_keeps_handmade(project.keeps_handmade)


class ProjectSettings(NamedTuple):
    """The settings of a project apart from its frames' states, to detect unsaved changes."""

    frames: tuple[str, ...]
    """Their ids."""
    shared: Parameters | None
    """Parameters of all frames; None if each frame has its own."""
    extraction: BlockParameters
    keeps_handmade: bool


class CurrentProject:
    """The current project: its file and its unsaved changes.

    Attributes
    ----------
    path : Path or None
        None for a project without a file.
    read_only : str
        Why the file cannot be overwritten, as a sentence; "" if it can.
    found_elsewhere : bool
        Whether missing files were found elsewhere since.
    """

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self.path: Path | None = None
        self.read_only = ""
        self._mark: tuple[int, ...] | None = None
        """That of the file when it was opened or saved; None if there was none."""
        self._lock: FileLock | None = None
        self._saved = self._settings()
        self.found_elsewhere = False
        self._saved_frames: dict[str, ProjectFrame] = {}

    @property
    def name(self) -> str:
        """Its name; "" without a file."""
        return "" if self.path is None else self.path.stem

    @property
    def file(self) -> str:
        """Path of its file; "" if it is not written yet."""
        return "" if self.path is None or self._mark is None else str(self.path)

    @property
    def unsaved(self) -> bool:
        """Whether there are changes that are not in the file."""
        return bool(self.words()) or any(entry.unsaved for entry in self._workspace.entries)

    def words(self) -> str:
        """Return a summary of unsaved changes apart from frames' states; "" for none. Without a file, the list of
        frames does not count."""
        now, saved = self._settings(), self._saved
        texts = ["list of frames"] * (self.path is not None and now.frames != saved.frames)
        texts += ["parameters for all frames"] * (now.shared != saved.shared)
        texts += ["extraction parameters"] * (now[2:] != saved[2:])
        texts += ["paths of files"] * self.found_elsewhere
        return ", ".join(texts)

    def _settings(self) -> ProjectSettings:
        parameters, frames = self._workspace.parameters, tuple(entry.id for entry in self._workspace.entries)
        shared = parameters.for_all
        return ProjectSettings(frames, shared, parameters.extraction, parameters.keeps_handmade)

    def snapshot(self, view: Mapping[str, Any], only: Collection[str] | None = None) -> Project:
        """Return the current project for saving; with `only`, all other frames as they were saved before."""
        project = project_of(self._workspace)
        frames = []
        for frame in project.frames:
            if only is None or frame.id in only:
                frames.append(frame)
            else:
                before = self._saved_frames.get(frame.id, ProjectFrame(frame.id, frame.name, frame.source))
                frames.append(replace(frame, summary=before.summary, has_state=before.has_state))
        return replace(project, frames=tuple(frames), view=view)

    def take(self, path: Path | None, project: Project | None = None, read_only: str = "") -> None:
        """Store the project's file, which contains `project`, or else no frame and the current settings."""
        self.release()
        self.path, self.read_only = path, read_only
        if path is not None:
            self._lock = lock_of(path, autosave_folder() / "locks")
            if self._lock is None and not read_only:
                self.read_only = f"{path.name} is open in another window: Save will ask for another file."
        self._mark = None if path is None else file_identity(path)
        self._saved_frames, self._saved, self.found_elsewhere = {}, self._settings(), False
        if project is not None:
            self._saved_frames = {frame.id: frame for frame in project.frames}
            shared = project.common if project.for_all else None
            self._saved = ProjectSettings(tuple(self._saved_frames), shared, project.extraction, project.keeps_handmade)

    def release(self) -> None:
        """Let other windows save the file."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def mark_saved(self, setting: str) -> None:
        """Mark one of the settings as saved: the frames were found again, or the extraction came with a frame."""
        self._saved = self._saved._replace(**{setting: getattr(self._settings(), setting)})

    def saved_summary(self, entry: Entry) -> FrameSummary | None:
        """Return the summary of a frame in the file; None if the file has no state of it."""
        saved = self._saved_frames.get(entry.id)
        return None if saved is None or not saved.has_state else saved.summary

    def changed_on_disk(self) -> bool:
        """Return whether another program has changed, made or removed the file since it was opened or saved."""
        return self.path is not None and file_identity(self.path) != self._mark
