"""What a project holds beside its frames' states, as the window has it now."""

from __future__ import annotations

from gui.state.entries import Entry
from gui.state.session import Session
from gui.state.sharing import Shared
from gui.state.workspace import Workspace
from ilf.io.frame_source import FrameSource
from ilf.project import Project, ProjectFrame


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
