"""The workspace: the documents of the window, their parameters, and changes that concern both."""

from __future__ import annotations

from dataclasses import replace
from weakref import WeakKeyDictionary

from PySide6.QtCore import QObject

from ilf.completion.block import Watch
from ilf.data.blocks import OwnValues
from ilf.data.results import Completion
from ilf.project.frame_state import FrameState
from ilf.project.run_history import Extrapolation, StoredRun
from ilf.run.run import Run
from ilf.segmentation.editing.patches import patch_between

from .document import Document
from .frames import Frames
from .parameters import DocumentParameters
from .parts import Part, Swap
from .results import FrameResults, ViewedIteration
from .run_history import recorded_history

_MAX_WATCHED = 4
"""Maximum number of frames with key frames at a time."""


class Workspace(Frames):
    """The state of the window: a list of documents, the current one, and the parameters that documents may share.

    Attributes
    ----------
    parameters : DocumentParameters
    viewed_iteration : ViewedIteration or None
        The earlier iteration that the views show instead of the current depth.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.parameters = DocumentParameters(self)
        self.viewed_iteration: ViewedIteration | None = None
        self._with_key_frames: WeakKeyDictionary[Document, None] = WeakKeyDictionary()
        """Frames with key frames, the last run at the end."""

    def show(self, document: Document | None) -> None:
        """Make a frame the current one."""
        if document is not self._shown:
            self.parameters.leave()
            super().show(document)

    def open_document(
        self,
        document: Document,
        recorded: Run | None = None,
        restored: bool = False,
        show: bool = True,
        completion: Completion | None = None,
    ) -> None:
        """Open a frame and, with `show`, make it the current one.

        It starts with the parameters of the current frame, or the shared ones, unless it is `restored`. With
        `recorded`, it takes the parameters and the extraction parameters of that run, and the blocks that were run are
        selected if they are not all; with its `completion`, also the results, as the first run of the history.
        """
        self.parameters.start(document, recorded, restored)
        if recorded is not None and recorded.only is not None and set(recorded.only) != set(document.counts()):
            document.change(selected=tuple(sorted(set(recorded.only))))
        if completion is not None:
            extrapolation = Extrapolation.of(completion) if completion.run.extrapolate else None
            document.restore_results(list(completion.results.values()), extrapolation)
            document.change(runs=(recorded_history(document, completion, extrapolation),), next_number=2)
            document.note_saved(document.stamp)
        self.add(document, show)

    def watch(self, document: Document, run: Run) -> Watch:
        """Return the observer that stores key frames of a run; key frames of frames run long ago are dropped."""
        others = [one for one in self._with_key_frames if one is not document]
        for one in others[: 1 - _MAX_WATCHED]:
            one.key_frames.clear()
        self._with_key_frames = WeakKeyDictionary(dict.fromkeys([*others[1 - _MAX_WATCHED :], document]))
        return document.key_frames.watch(run)

    def view_iteration(self, viewed_iteration: ViewedIteration | None) -> None:
        """Show the current frame's depth as of an earlier iteration; None for its current depth."""
        if viewed_iteration is not self.viewed_iteration:
            self.viewed_iteration = viewed_iteration
            self.note(Part.ITERATION)

    def take_propagated(self, document: Document, propagated: FrameState, text: str) -> None:
        """Take over the blocks propagated to a frame, with all their attributes, as one undo step."""
        document.prepare_change()
        patch, drawn = patch_between(document.labels, propagated.blocks.labels), propagated.blocks.drawn
        blocks = replace(propagated.blocks, drawn=None if drawn is None else drawn.copy())

        def exchange(to: tuple[FrameState, bool]) -> tuple[FrameState, bool]:
            other, forward = to
            document.prepare_change()
            if patch is not None:
                document.apply(patch, forward)
            former = document.state
            blocks = document.take_blocks(other.blocks)
            document.change(to_check=other.to_check, extrapolate=other.extrapolate)
            self.parameters.take_common(document, other.common, other.own_parameters)
            document.note(Part.INFOS | Part.LIST)
            document.note_labels_changed(patch)
            return replace(former, blocks=blocks), not forward

        document.undo_stack.push(Swap(text, (replace(propagated, blocks=blocks), True), exchange))
        if not document.selected:
            document.select(propagated.selected)

    def accept_run(self, kept: StoredRun) -> list[int]:
        """Replace the current results by those of a stored run, with its parameters, as one undo step.

        Only blocks that have not changed since are replaced. Returns these blocks.
        """
        document, parameters, common = self.current, self.parameters, kept.run.parameters
        results = document.fitting_results(kept)
        former, former_own = document.state.common, document.blocks.own
        own: dict[int, OwnValues] = {
            result.block.label: {}
            if result.parameters.same_effect(common)
            else result.parameters.differences_from(common)
            for result in results
        }

        def exchange(accepted: tuple[FrameResults, FrameResults] | None) -> tuple[FrameResults, FrameResults] | None:
            """Accept the results and return those before and after; given these, undo it: later results stay."""
            if accepted is None:
                parameters.take(document, common.to_dict(), own)
                former_results = document.restore_results(results, kept.extrapolation)
                document.note(Part.RESULTS)
                return former_results, document.results.snapshot()
            parameters.take(document, former.to_dict(), {label: former_own.get(label, {}) for label in own})
            newer = document.swap_results(FrameResults({})).without(accepted[1])
            document.swap_results(accepted[0].with_newer(newer))
            document.note(Part.RESULTS)
            return None

        if results:
            where = "" if common == former else parameters.all_frames_text(document)
            document.undo_stack.push(Swap(f"Accept {kept.name}{where}", None, exchange))
        return list(own)
