"""What a project holds beside its frames' states, as the window has it now."""

from __future__ import annotations

from gui.state.sharing import Shared
from gui.state.workspace import Workspace
from ilf.io.frame_source import FrameSource
from ilf.project import Project, ProjectFrame


def project_of(workspace: Workspace) -> Project:
    """The list of frames, and what is set for all of them."""
    frames = tuple(
        ProjectFrame(
            entry.id,
            entry.name,
            entry.source or FrameSource(entry.key),
            entry.summary,
            entry.has_state or entry.session is not None,
        )
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


def take_settings(workspace: Workspace, project: Project) -> None:
    """Have what a project sets for all frames; before they are opened, since they begin with it."""
    workspace.set_shared(Shared(project.for_all, project.common))
    workspace.set_extraction_parameters(project.extraction)
    workspace.set_keeps_handmade(project.keeps_handmade)
