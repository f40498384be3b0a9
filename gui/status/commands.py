"""Says which commands can be given now."""

from __future__ import annotations

from PySide6.QtCore import QObject

from gui.actions import Actions
from gui.frames.loader import FrameLoader
from gui.state.session import Session
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
_ANY_CHOSEN = "lock_blocks", "hide_blocks"


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
        counts = session.counts() if session else {}
        chosen = set(session.selected) & set(counts) if session else set()
        unlocked = chosen - session.locked if session else set()
        own = session.notes.own if session else {}
        paused = runs.state is RunState.PAUSED
        free = runs.free and not self._loader.busy
        no_frame = "" if session else "Open a frame first."
        busy = no_frame or ("" if free else "Wait until what is under way has ended, or cancel it.")
        no_blocks = no_frame or ("" if counts else "There are no blocks: extract or draw some first.")
        none_chosen = no_blocks or ("" if chosen else "Choose a block first.")
        locked = none_chosen or ("" if unlocked else "The chosen blocks are locked: unlock them first.")
        idle = "" if runs.state in (RunState.RUNNING, RunState.PAUSED, RunState.GUESSING) else "Nothing is running."
        no_results = no_frame or ("" if session and session.results.kept else "There are no results yet.")
        allow = actions.allow
        allow(no_frame, *_FRAME_ACTIONS)
        allow(busy, "extract", "load_blocks")
        allow(no_blocks, "save_blocks", "clean_up")
        allow(none_chosen, "zoom_block")
        allow(locked, "delete_blocks", "grow_blocks", "shrink_blocks", "smooth_blocks")
        allow("" if len(unlocked) > 1 else no_blocks or "Choose two or more unlocked blocks first.", "merge_blocks")
        allow("" if session and session.selected else none_chosen or "Choose a block first.", *_ANY_CHOSEN)
        allow(no_blocks or busy, "run", "run_all")
        allow(none_chosen or busy, "run_selected")
        allow("" if paused else no_blocks or busy, "step")
        allow(idle, "pause", "cancel")
        allow(no_results or busy or self._why_no_guess(session), "guess")
        allow(no_results, "clear_results")
        unseen = session is not None and not session.to_check.isdisjoint(chosen)
        allow("" if unseen else none_chosen or "The chosen blocks need no look.", "looked_at")
        none_own = "The chosen blocks have no values of their own." if chosen.isdisjoint(own) else ""
        allow(none_chosen or none_own, "reset_own")
        can_copy = session is not None and len(session.selected) > 1 and session.selected[0] in own
        allow("" if can_copy else "Choose a block with values of its own, and others after it.", "copy_own")
        actions["pause"].setChecked(paused)
        actions["pause"].setText("Resume" if paused else "&Pause")

    @staticmethod
    def _why_no_guess(session: Session | None) -> str:
        if session is None or not session.valid_results():
            return "Run the blocks first."
        return "The rest is guessed already." if session.guessed else ""
