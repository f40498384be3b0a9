"""Runs of all frames: each frame has its own run; commands apply to that of the current frame."""

from __future__ import annotations

from collections.abc import Iterable
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject
from PySide6.QtGui import QAction

from ..state.document import Document
from ..state.parts import Edit, Part
from ..state.workspace import Workspace
from .frame_runs import FrameRuns, RunNews, RunOutcome, RunState

__all__ = ["RunController", "RunOutcome", "RunState"]


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
        self._touched: WeakKeyDictionary[Document, set[int]] = WeakKeyDictionary()
        """Blocks to re-solve, also of frames that are not shown."""
        self._following: WeakKeyDictionary[Document, set[int]] = WeakKeyDictionary()
        """Blocks to re-solve only because of their parameters: not after a run that is cancelled."""
        self._requested: set[int] = set()
        """Blocks of the current frame that were requested since they were last edited."""
        workspace.edited.connect(self._take)
        workspace.on(Part.FRAME, self._turn)
        runs.state_changed.connect(self._go_on)

    def follow_parameters(self, first: Iterable[int]) -> None:
        """Re-solve the blocks of the current frame that the present parameters change, some of them `first`, also if
        these have no result yet; while a slider moves, what is being solved is not dropped at once."""
        if not self._live.isChecked():
            return
        document, runs = self._workspace.current, self._runs.current
        changed = {*document.changed_blocks(), *runs.resolving}
        wanted = [label for label in dict.fromkeys((*first, *runs.completed)) if label in changed]
        touched = self._touched.setdefault(document, set())
        self._following.setdefault(document, set()).update(set(wanted) - touched)
        touched.update(wanted)
        self._requested.update(wanted)
        if wanted and not runs.resolve(wanted):
            self._requested.difference_update(wanted)

    def _take(self, edit: Edit) -> None:
        if self._live.isChecked() and (edit.document.results.kept or edit.document in self._runs.running):
            self._touched.setdefault(edit.document, set()).update(edit.blocks)
            self._following.get(edit.document, set()).difference_update(edit.blocks)
            self._requested.difference_update(edit.blocks)
            self._go_on()

    def _turn(self) -> None:
        """Clear the requests when another frame is shown; they are made again when the frame is shown again."""
        self._requested.clear()
        self._go_on()

    def _go_on(self) -> None:
        runs, workspace = self._runs, self._workspace
        if not workspace.has_current or not runs.state.free:
            if runs.state is RunState.STOPPING:  # what is cancelled is not asked for again
                following = self._following.pop(workspace.current, set())
                self._touched.get(workspace.current, set()).difference_update(following)
            return
        document, chosen = workspace.current, workspace.chosen
        touched = self._touched.get(document, set())
        if runs.state is RunState.IDLE:  # requested blocks are solved or cancelled
            touched -= self._requested
            self._requested.clear()
        there = touched.intersection(document.counts()) - self._requested
        wanted = [label for label in there if not document.is_up_to_date(label)]
        touched -= there.difference(wanted)  # parameters set later are no edit
        wanted.sort(key=lambda label: (label != chosen, label))
        if wanted:
            self._requested.update(wanted)  # before the call: it emits state_changed at once
            if not runs.current.resolve(wanted, edited=True):
                self._requested.difference_update(wanted)
