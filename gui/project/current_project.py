"""The current project of the window: its file and its unsaved changes."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from filelock import FileLock

from ilf.project.archive import file_identity
from ilf.project.project import FrameSummary, Project, ProjectFrame
from ilf.project.recovery import autosave_folder
from ilf.project.store import lock_of
from ilf.sources.frame_ref import FrameRef

from ..state.document import Document
from ..state.parameters import SharedParameters
from ..state.workspace import Entry, Workspace

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
        workspace.shown.id if workspace.shown is not None else "",
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
        self._saved = Project()
        """The project in the file, or else as it was when it had none."""
        self.found_elsewhere = False
        self.take(None)

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
        return any(entry.unsaved for entry in self._workspace.entries) or bool(self.words())

    def words(self) -> str:
        """Return a summary of unsaved changes apart from frames' states; "" for none. Without a file, the list of
        frames does not count."""
        saved, parameters = self._saved, self._workspace.parameters
        listed = [entry.id for entry in self._workspace.entries] != [frame.id for frame in saved.frames]
        extraction = parameters.extraction, parameters.keeps_handmade
        texts = ["list of frames"] * (self.path is not None and listed)
        texts += ["parameters for all frames"] * (parameters.for_all != (saved.common if saved.for_all else None))
        texts += ["extraction parameters"] * (extraction != (saved.extraction, saved.keeps_handmade))
        texts += ["paths of files"] * self.found_elsewhere
        return ", ".join(texts)

    def _saved_frames(self) -> dict[str, ProjectFrame]:
        """Return the listed frames as they are in the file, by id; those that it lacks have no state."""
        frames = {entry.id: ProjectFrame(entry.id, entry.name, source_of(entry)) for entry in self._workspace.entries}
        return frames | {frame.id: frame for frame in self._saved.frames if frame.id in frames}

    def snapshot(self, view: Mapping[str, Any], only: Collection[str] | None = None) -> Project:
        """Return the current project for saving; with `only`, all other frames as they were saved before."""
        project, saved = project_of(self._workspace), self._saved_frames()
        frames = [
            frame
            if only is None or frame.id in only
            else replace(frame, summary=saved[frame.id].summary, has_state=saved[frame.id].has_state)
            for frame in project.frames
        ]
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
        self._saved, self.found_elsewhere = project or Project(), False
        if project is None:
            self._saved = replace(project_of(self._workspace), frames=tuple(self._saved_frames().values()))

    def release(self) -> None:
        """Let other windows save the file."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def mark_listed(self) -> None:
        """Note that the list of frames was found again, and is no change."""
        self._saved = replace(self._saved, frames=tuple(self._saved_frames().values()))

    def mark_extraction(self) -> None:
        """Note that the extraction parameters came with a frame, and are no change."""
        self._saved = replace(self._saved, extraction=self._workspace.parameters.extraction)

    def saved_summary(self, entry: Entry) -> FrameSummary | None:
        """Return the summary of a frame in the file; None if the file has no state of it."""
        return next((one.summary for one in self._saved.frames if one.id == entry.id and one.has_state), None)

    def changed_on_disk(self) -> bool:
        """Return whether another program has changed, made or removed the file since it was opened or saved."""
        return self.path is not None and file_identity(self.path) != self._mark
