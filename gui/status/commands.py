"""Says which commands can be given now."""

from __future__ import annotations

from PySide6.QtCore import QObject

from gui.actions import Actions
from gui.frames.loader import FrameLoader
from gui.state.workspace import Workspace
from gui.tools.kinds import TOOL_NAMES
from gui.work.runs import RunController, RunState
from ilf.drawing.stages import STAGES

_FRAME_ACTIONS = (
    "export",
    "close_frame",
    "new_block",
    "select_all",
    *(f"tool_{name}" for name in TOOL_NAMES),
    "brush_smaller",
    "brush_larger",
    "similar_only",
    "to_no_block",
    "next_suspect",
    "previous_suspect",
    "suggest_distrust",
    "fit",
    "one_to_one",
    *(f"stage_{name}" for name in STAGES),
)


class CommandsPresenter(QObject):
    """Enables the actions that make sense as things are."""

    def __init__(self, workspace: Workspace, runs: RunController, loader: FrameLoader, actions: Actions) -> None:
        super().__init__(workspace)
        self._workspace = workspace
        self._runs = runs
        self._loader = loader
        self._actions = actions

    def show(self) -> None:
        """Enable and disable."""
        runs, actions = self._runs, self._actions
        session = self._workspace.session if self._workspace.has_session else None
        shown = session is not None
        free = runs.free and not self._loader.busy
        counts = session.counts() if session else {}
        chosen = set(session.selected) & set(counts) if session else set()
        unlocked = chosen - session.locked if session else set()
        paused = runs.state is RunState.PAUSED
        actions.enable(shown, *_FRAME_ACTIONS)
        actions.enable(shown and free, "extract", "load_blocks")
        actions.enable(bool(counts), "save_blocks")
        actions.enable(bool(chosen), "zoom_block")
        actions.enable(bool(unlocked), "delete_blocks", "grow_blocks", "shrink_blocks", "smooth_blocks")
        actions.enable(bool(counts), "clean_up")
        actions.enable(len(unlocked) > 1, "merge_blocks")
        actions.enable(bool(session and session.selected), "lock_blocks", "hide_blocks")
        actions.enable(free and bool(counts), "run", "run_all")
        actions.enable(free and bool(chosen), "run_selected")
        actions.enable((free and bool(counts)) or paused, "step")
        actions.enable(runs.state in (RunState.RUNNING, RunState.PAUSED, RunState.GUESSING), "pause", "cancel")
        actions.enable(bool(free and session and session.valid_results() and not session.guessed), "guess")
        actions.enable(bool(session and session.results.kept), "clear_results")
        own = session.notes.own if session else {}
        actions.enable(not chosen.isdisjoint(own), "reset_own")
        actions.enable(bool(session and len(session.selected) > 1 and session.selected[0] in own), "copy_own")
        actions["pause"].setChecked(paused)
        actions["pause"].setText("Resume" if paused else "&Pause")
