"""Runs of all frames: each frame has its own run; commands apply to that of the current frame."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QObject
from PySide6.QtGui import QAction

from ..state.document import Document
from ..state.parts import Edit, Part
from ..state.workspace import Workspace
from .frame_runs import FrameRuns, RunNews, RunState


class RunController(RunNews):
    """The runs of all frames in parallel; the state is that of the current frame."""

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._all: dict[Document, FrameRuns] = {}
        """By frame, also those of closed frames until they have ended."""
        workspace.on(Part.LIST, self._cancel_closed)
        self.state_changed.connect(self._forget_closed)

    def of(self, document: Document) -> FrameRuns:
        """Return the runs of a frame."""
        if document not in self._all:
            self._all[document] = FrameRuns(self._workspace, document, self)
        return self._all[document]

    @property
    def current(self) -> FrameRuns:
        """The runs of the current frame."""
        return self.of(self._workspace.current)

    @property
    def running(self) -> list[Document]:
        """Frames with a run or an extrapolation in progress."""
        return [
            document for document, runs in self._all.items() if not runs.state.free and document in self._workspace.open
        ]

    @property
    def state(self) -> RunState:
        """The state of the current frame's run."""
        return self.current.state if self._workspace.has_current else RunState.IDLE

    def _cancel_closed(self) -> None:
        """Cancel the runs of frames that are no longer open."""
        for document, runs in list(self._all.items()):
            if document not in self._workspace.open:
                runs.cancel()
        self._forget_closed()

    def _forget_closed(self) -> None:
        """Delete the runs of closed frames that have ended."""
        for document, runs in list(self._all.items()):
            if runs.state is RunState.IDLE and document not in self._workspace.open:
                del self._all[document]
                runs.deleteLater()


# Live depth: blocks that an edit has changed are re-solved automatically.


class LiveSolver(QObject):
    """Re-solves blocks that were edited since the frame was run, or that get other parameters, the selected one first.

    Blocks changed during a run are re-solved after it. States that undo restores are not re-solved.

    Parameters
    ----------
    live : QAction
        The action that switches it on.
    """

    def __init__(self, workspace: Workspace, runs: RunController, live: QAction) -> None:
        super().__init__(runs)
        self._workspace = workspace
        self._runs = runs
        self._live = live
        workspace.edited.connect(self._take)

    def follow_parameters(self, first: Iterable[int]) -> None:
        """Re-solve the blocks of the current frame that the present parameters change, some of them `first`, also if
        these have no result yet; while a slider moves, what is being solved is not dropped at once."""
        if self._live.isChecked():
            runs = self._runs.current
            changed = {*runs.document.changed_blocks(), *runs.resolving}
            if wanted := [label for label in dict.fromkeys((*first, *runs.completed)) if label in changed]:
                runs.resolve(wanted)

    def _take(self, edit: Edit) -> None:
        document, chosen = edit.document, self._workspace.chosen
        if self._live.isChecked() and (document.results.kept or document in self._runs.running):
            there = edit.blocks & document.counts().keys()
            wanted = [label for label in there if not document.is_up_to_date(label)]
            if wanted:
                self._runs.of(document).resolve(sorted(wanted, key=lambda label: (label != chosen, label)), edited=True)
