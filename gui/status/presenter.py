"""Says in the status bar what a click would do, and how far the work under way is."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject

from gui.dialogs.documents import Documents
from gui.frames.loader import FrameLoader
from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.status.bar import StatusBar
from gui.tools.editor import Editor
from gui.widgets.plain_text import as_it_is
from gui.work.pace import Pace
from gui.work.runs import RunController, RunState

_NO_FRAME = "Open a frame by the menu File, or drop its files here"


class StatusPresenter(QObject):
    """Hint and progress.

    Parameters
    ----------
    elsewhere : callable
        Gives what the mouse does where it is at no view of the tools; "" where it is at one.
    """

    def __init__(
        self,
        workspace: Workspace,
        runs: RunController,
        loader: FrameLoader,
        documents: Documents,
        editor: Editor,
        bar: StatusBar,
        elsewhere: Callable[[], str],
    ) -> None:
        super().__init__(bar)
        self._workspace = workspace
        self._runs = runs
        self._loader = loader
        self._documents = documents
        self._editor = editor
        self._pace = Pace()
        self._paced: list[Session] = []
        """Frames whose runs the pace is of."""
        self._bar = bar
        self._elsewhere = elsewhere

    def show_hint(self) -> None:
        """What is being opened or extracted, or else what a click would do now."""
        hint = self._elsewhere() or self._editor.tool.hint
        idle = hint if self._workspace.has_session else _NO_FRAME
        self._bar.hint.setText(self._loader.present or idle)
        self._bar.hint.setToolTip(as_it_is(idle))  # where the window is too narrow for it

    def show_progress(self) -> None:
        """How far runs, openings and extractions are, and how long they will still take; or that files are written."""
        bar, share = self._bar, None
        if self._runs.running:
            text, share = self._runs_text()
        elif self._loader.busy:
            text, share = self._loader.present, self._loader.share_done or None
            self._pace.note(share or 0.0)
        elif (saved := self._documents.saved_share()) is not None:
            text, share = "Saving", saved
        else:
            text = "Exporting" if self._documents.exporting else ""
        if not text:
            self._pace.forget()
            self._paced = []
        bar.show_progress(text, share, self._pace.text() if share is not None else "")

    def _runs_text(self) -> tuple[str, float | None]:
        """What goes on for the present frame, or else for others, and the share of it that is done."""
        runs, present = self._runs, not self._runs.free
        if runs.state is RunState.GUESSING:
            return runs.state.value, None
        going = [self._workspace.session] if present else runs.running
        shares = [runs.of(session).share_done for session in going]
        share = sum(shares) / len(shares)
        if going != self._paced:
            self._paced = going
            self._pace.forget()
        self._pace.note(share, going=runs.state is not RunState.PAUSED)
        if present:
            return runs.state.value, share
        return (going[0].name if len(going) == 1 else f"{len(going)} other frames running"), share
