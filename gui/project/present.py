"""The project of the window: which file holds it, and what of it that file does not hold."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from PySide6.QtCore import QObject

from ilf.data.parameters import BlockParameters, Parameters
from ilf.project.project import FrameSummary, Project, ProjectFrame
from ilf.sources.frame_source import FrameSource

from ..state.entries import Entry
from ..state.session import Session
from ..state.sharing import Shared
from ..state.workspace import Workspace

# What a project holds beside its frames' states, as the window has it now.


def project_of(workspace: Workspace) -> Project:
    """The list of frames, and what is set for all of them."""
    frames = tuple(
        ProjectFrame(entry.id, entry.name, source_of(entry), entry.summary, entry.has_state or is_begun(entry.session))
        for entry in workspace.entries
    )
    return Project(
        frames,
        workspace.session.id if workspace.has_session else "",
        workspace.next_parameters,
        workspace.shared.on,
        workspace.extraction_parameters,
        workspace.keeps_handmade,
    )


def is_begun(session: Session | None) -> bool:
    """Whether there is anything to keep of a frame: one that has no blocks yet is just read from its files again."""
    return session is not None and (bool(session.counts()) or session.unsaved or session.undo_stack.count() > 0)


def source_of(entry: Entry) -> FrameSource | None:
    """Where the frame of an entry is, with absolute paths; None if it comes from no file."""
    source, session = entry.source, entry.session
    if source is None and session is not None and session.frame.inputs is not None:
        source = FrameSource.of(session.frame.inputs)
    return None if source is None else source.absolute()


def take_settings(workspace: Workspace, project: Project) -> None:
    """Have what a project sets for all frames; before they are opened, since they begin with it."""
    workspace.set_shared(Shared(project.for_all, project.common))
    workspace.set_extraction_parameters(project.extraction)
    workspace.set_keeps_handmade(project.keeps_handmade)


class Set(NamedTuple):
    """What is work of a project beside its frames' states."""

    frames: tuple[tuple[str, FrameSource | None], ...]
    shared: Parameters | None
    """Parameters for all frames; None where each has its own."""
    extraction: BlockParameters
    keeps_handmade: bool

    @classmethod
    def of(cls, project: Project) -> Set:
        """Of a project as its file has it."""
        frames = tuple((frame.id, frame.source) for frame in project.frames)
        return cls(frames, project.common if project.for_all else None, project.extraction, project.keeps_handmade)


class FileMark(NamedTuple):
    """Tells a file from what another program has made of it since."""

    size: int
    changed_ns: int
    number: int

    @classmethod
    def of(cls, path: Path) -> FileMark | None:
        """Of a file as it is now; None if it is not there."""
        try:
            status = path.stat()
        except OSError:
            return None
        return cls(status.st_size, status.st_mtime_ns, status.st_ino)


class PresentProject(QObject):
    """Knows the file, and what it lacks.

    Attributes
    ----------
    path : Path or None
        None for a project that has no file yet.
    read_only : str
        Why the file cannot be written over, as a sentence; "" if it can.
    """

    def __init__(self, workspace: Workspace, parent: QObject) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self.path: Path | None = None
        self.read_only = ""
        self._mark: FileMark | None = None
        self._is_new = False
        self._frames: tuple[tuple[str, FrameSource | None], ...] | None = None
        """Which frames there are; None if that has changed."""
        for signal in (workspace.entries.added, workspace.entries.removed):
            signal.connect(lambda *_: self._forget_frames())
        self._saved = self.set_now()
        self._unfound: dict[str, FrameSummary] = {}
        self._found_elsewhere = False
        self._saved_frames: dict[str, ProjectFrame] = {}

    @property
    def name(self) -> str:
        """What it is called; "" as long as it has no file."""
        return "" if self.path is None else self.path.stem

    @property
    def unsaved(self) -> bool:
        """Whether there is anything that the file does not hold."""
        return bool(self.words()) or any(entry.unsaved for entry in self._workspace.entries)

    def words(self) -> str:
        """What is unsaved beside the frames' states; "" for nothing. Which frames there are is no work as long as there
        is no file."""
        now, saved = self.set_now(), self._saved
        texts = ["list of frames"] * (self.path is not None and now.frames != saved.frames)
        texts += ["parameters for all frames"] * (now.shared != saved.shared)
        texts += ["parameters of the extraction"] * (now[2:] != saved[2:])
        texts += ["places of files"] * self._found_elsewhere
        return ", ".join(texts)

    def set_now(self) -> Set:
        """What there is now beside the frames' states."""
        workspace = self._workspace
        if self._frames is None:
            self._frames = tuple((entry.id, entry.source) for entry in workspace.entries)
        shared = workspace.shared.values if workspace.shared.on else None
        return Set(self._frames, shared, workspace.extraction_parameters, workspace.keeps_handmade)

    def _forget_frames(self) -> None:
        self._frames = None

    def snapshot(self, view: Mapping[str, Any], only: Collection[str] | None = None) -> Project:
        """All of it as it is now, to be saved; with `only`, all other frames as they were saved before."""
        project = project_of(self._workspace)
        frames = (
            self._as_now(frame) if only is None or frame.id in only else self._as_before(frame)
            for frame in project.frames
        )
        return replace(project, frames=tuple(frames), view=view)

    def _as_now(self, frame: ProjectFrame) -> ProjectFrame:
        return replace(frame, summary=self._unfound.get(frame.id, frame.summary))

    def _as_before(self, frame: ProjectFrame) -> ProjectFrame:
        before = self._saved_frames.get(frame.id)
        if before is None:
            return replace(frame, summary=FrameSummary(), has_state=False)
        return replace(frame, summary=before.summary, has_state=before.has_state)

    def take(
        self,
        path: Path | None,
        project: Project | None = None,
        read_only: str = "",
        saved: Set | None = None,
        new: bool = False,
    ) -> None:
        """The project has this file now, in which `project` stands; it holds what was `saved`, or else all. If it is
        `new`, there must be none when it is saved."""
        self._is_new = new
        self.path, self.read_only = path, read_only
        self._mark = None if path is None else FileMark.of(path)
        self._saved_frames = {frame.id: frame for frame in project.frames} if project is not None else {}
        self._saved = saved or self.set_now()
        self._found_elsewhere = False

    def take_frames(self) -> None:
        """Which frames there are is no work: they have been found again."""
        self._saved = self._saved._replace(frames=self.set_now().frames)

    def take_extraction(self) -> None:
        """What blocks are extracted with has come with a frame: that is no work."""
        self._saved = self._saved._replace(extraction=self._workspace.extraction_parameters)

    def saved_summary(self, entry: Entry) -> FrameSummary | None:
        """What the file says of a frame; None if it holds no work on it."""
        saved = self._saved_frames.get(entry.id)
        return None if saved is None or not saved.has_state else saved.summary

    def changed_on_disk(self) -> bool:
        """Whether somebody else has written the file since it was opened or saved, or has taken it away."""
        if self.path is not None and self._is_new:
            return self.path.exists()
        return self.path is not None and self._mark is not None and FileMark.of(self.path) != self._mark

    def note_unfound(self, entry: Entry) -> None:
        """The files of a frame are missing: what is said of it in the file stays as it is now."""
        self._unfound.setdefault(entry.id, entry.summary)

    def forget_unfound(self) -> None:
        """Other frames take the place of these."""
        self._unfound.clear()

    def note_found(self, entry: Entry) -> FrameSummary | None:
        """They have been found elsewhere; what was said of the frame before."""
        self._found_elsewhere = True
        self._forget_frames()
        return self._unfound.pop(entry.id, None)
