"""Says in the status bar what a click would do, and how far the work under way is."""

from __future__ import annotations

from PySide6.QtCore import QObject

from gui.frames.loader import FrameLoader
from gui.state.workspace import Workspace
from gui.status.bar import StatusBar
from gui.tools.editor import Editor
from gui.work.runs import RunController, RunState


class StatusPresenter(QObject):
    """Hint and progress."""

    def __init__(
        self, workspace: Workspace, runs: RunController, loader: FrameLoader, editor: Editor, bar: StatusBar
    ) -> None:
        super().__init__(bar)
        self._workspace = workspace
        self._runs = runs
        self._loader = loader
        self._editor = editor
        self._bar = bar

    def show_hint(self) -> None:
        """What is being opened or extracted, or else what a click would do now."""
        idle = self._editor.tool.hint if self._workspace.has_session else "Open a frame: Ctrl+O"
        self._bar.hint.setText(self._loader.present or idle)
        self._bar.hint.setToolTip(idle)  # where the window is too narrow for it

    def show_progress(self) -> None:
        """How far the run is; or that something is being opened or extracted."""
        runs, progress = self._runs, self._bar.progress
        progress.setVisible(not runs.free or self._loader.busy)
        if runs.state is RunState.GUESSING:
            progress.setRange(0, 0)
            progress.setFormat(runs.state.value)
        elif not runs.free:
            progress.setRange(0, 100)
            progress.setValue(round(100 * runs.share_done))
            progress.setFormat(f"{runs.state.value} %p%")
        elif self._loader.busy:
            progress.setRange(0, 0)
            progress.setFormat(self._loader.present)
