"""One frame's state in the window: blocks, what is known of them, results, undo history. No widgets."""

from __future__ import annotations

import uuid
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QUndoStack

from ilf.data.blocks import Box, union
from ilf.data.frame import RGBDFrame, TruthFile
from ilf.data.parameters import Parameters
from ilf.data.results import BlockResult, Completion, IterationRecord, compose
from ilf.drawing.blocks import block_colour
from ilf.project.frame_state import BlockInfo, BlockNotes, is_edited
from ilf.project.run_history import Guess, KeptRun
from ilf.run.key_frames import KeyFrames
from ilf.run.replaying import Replay
from ilf.run.run import Run
from ilf.segmentation.editing.patches import LabelPatch
from ilf.segmentation.reextraction import made_by_hand

from .results import BlockCounts, BlockErrors, BlockTally, Held, Kept, Preview, Results, ShownDepth

# The points of a frame that are measured between.

Point = tuple[float, float]


@dataclass
class Chains:
    """Measurements of a frame: chains of points in image coordinates.

    Attributes
    ----------
    chains : list of list of Point
        The oldest first.
    is_open : bool
        Whether the next point belongs to the last one.
    reference : int
        The block whose plane heights are measured over; 0 for the image's upright.
    """

    chains: list[list[Point]] = field(default_factory=list)
    is_open: bool = False
    reference: int = 0


LARGEST_LABEL = 65535
"""Label maps are exported as 16-bit images."""


class Session:
    """A frame that is open. The workspace alone changes it once it is among its sessions.

    Attributes
    ----------
    frame : RGBDFrame
    origin : object
        What it was opened from; sessions of the same origin are the same.
    id : str
        Tells it from all other frames of its project, open or not.
    labels : ndarray of int32, shape (H, W)
        The label map, which is the truth about blocks. Changed in place by `apply` and `set_labels` only.
    notes : BlockNotes
    results : Results
    selected : list of int
        The chosen blocks; the first is the one that edits and curves are about.
    undo_stack : QUndoStack
    """

    def __init__(self, frame: RGBDFrame, origin: object, key: str) -> None:
        self.frame = frame
        self.origin = origin
        self.key = key
        self.id = uuid.uuid4().hex
        self.note = ""
        """What the user says of the frame."""
        self.labels: NDArray[np.int32] = np.zeros(frame.shape, np.int32)
        self.notes = BlockNotes()
        self.selected: list[int] = []
        self.undo_stack = QUndoStack()
        self.results = Results()
        self.key_frames = KeyFrames()
        self.block_errors = BlockErrors()
        self.kept_runs: list[KeptRun] = []
        self.compared: list[KeptRun] = []
        """Those of the kept runs that are shown beside the present result."""
        self.next_run = 1
        """Number of the next run that is kept."""
        self.region: Box | None = None
        """The chosen rectangle (rows, columns)."""
        self.line: tuple[Point, Point] | None = None
        """The profile line, in image coordinates."""
        self.chains = Chains()
        """What is measured."""
        self.to_check: set[int] = set()
        """Blocks that came from another frame and should be looked at."""
        self.view: dict[str, Any] = {}
        """How it was looked at last, in values that JSON has."""
        self.dense = False
        """Whether what is still missing after a run is to be guessed."""
        self.again: Replay | None = None
        """The record that the session was opened from."""
        self.common = Parameters()
        """Parameters of all blocks that have no values of their own."""
        self.own_parameters = False
        """Whether they are this frame's own where parameters are for all frames."""
        self._shown = ShownDepth(frame)
        self._tally: BlockTally | None = None
        self._fitting: dict[int, list[BlockResult]] = {}
        self._valid: dict[int, BlockResult] | None = None
        self._last_valid: Mapping[int, BlockResult] = {}
        self._completion: Completion | None = None
        self._edits = 0
        self._others = 0
        """How much has changed that is no step of the history."""
        self._others_saved = 0
        self._runs_saved = 1
        self._dirty: Box | None = None
        self.undo_stack.indexChanged.connect(self.note_edit)

    @classmethod
    def of(cls, run: Run, origin: object, key: str, again: Replay | None = None) -> Self:
        """A session whose frame and blocks are those of a run; its parameters are taken up by the workspace.

        With `again`, it is the record that the run comes from.
        """
        session = cls(run.frame, origin, key)
        session.set_labels(run.blocks)
        session.dense, session.again = run.dense, again
        session.notes.extraction, session.notes.network = run.extraction, run.network
        session.notes.drawn = None if run.drawn is None else run.drawn.copy()
        session.notes.extracted = None if run.edited else session.labels.copy()
        return session

    def run(self, common: Parameters, only: Collection[int] | None = None, dense: bool = False) -> Run:
        """What a run of the frame as it is now is made of.

        Parameters
        ----------
        common : Parameters
            Of all blocks that have none of their own.
        only : collection of int, optional
            Run just these blocks, in this order if it has one.
        dense : bool
            Whether the rest is guessed.
        """
        notes = self.notes
        return Run(
            self.frame,
            self.labels,
            common,
            {label: self.parameters_of(label, common) for label in notes.own if label in self.counts()},
            only,
            dense=dense,
            extraction=notes.extraction,
            edited=self.edited,
            network=notes.network,
            drawn=notes.drawn,
        )

    @property
    def name(self) -> str:
        """What the frame is called."""
        return self.frame.name

    @property
    def edited(self) -> bool:
        """Whether the blocks differ from what the extraction gave."""
        return is_edited(self.notes, self.labels)

    def handmade(self) -> frozenset[int]:
        """Blocks made by hand, before the last extraction or since."""
        older = self.notes.handmade & set(self.counts())
        return older | made_by_hand(self.labels, self.notes.extracted)

    @property
    def unsaved(self) -> bool:
        """Whether there is work that the project's file does not hold."""
        return not self.undo_stack.isClean() or self._others != self._others_saved

    def unsaved_words(self) -> str:
        """What the work is that the project's file does not hold, as "3 edits, 1 run"; "" for none."""
        if not self.unsaved:
            return ""
        clean = self.undo_stack.cleanIndex()
        edits = abs(self.undo_stack.index() - clean) if clean >= 0 else self.undo_stack.index()
        runs = sum(kept.number >= self._runs_saved for kept in self.kept_runs)
        counts = [f"{count} {what}{'s' * (count != 1)}" for count, what in ((edits, "edit"), (runs, "run")) if count]
        return ", ".join(counts) or "changes"

    @property
    def stamp(self) -> tuple[int, int, int]:
        """Where the work stands: other than before as soon as something has changed; to be given to `note_saved`."""
        return self._edits, self._others, self.next_run

    def note_saved(self, stamp: tuple[int, int, int]) -> None:
        """What there was at a stamp has been saved; what came later has not."""
        edits, self._others_saved, self._runs_saved = stamp
        if edits == self._edits:
            self.undo_stack.setClean()
        else:
            self.undo_stack.resetClean()

    @property
    def infos(self) -> dict[int, BlockInfo]:
        """Block label -> BlockInfo."""
        return self.notes.infos

    @property
    def locked(self) -> frozenset[int]:
        """Labels that edits must not touch."""
        return frozenset(label for label, info in self.infos.items() if info.locked)

    def next_label(self) -> int:
        """A number that no block has, nor had: names, locks and results of the past stay with their blocks."""
        taken = {*self.counts(), *self.infos}
        following = max(taken, default=0) + 1
        if following <= LARGEST_LABEL:
            return following
        return next(label for label in range(1, LARGEST_LABEL + 1) if label not in taken)

    def info(self, label: int) -> BlockInfo:
        """The block's info; a new block gets its name and colour by number."""
        return self.infos.setdefault(label, BlockInfo(f"Block {label}", block_colour(label)))

    def change_info(self, label: int, **changes: Any) -> None:
        """Set name, colour, visible or locked of a block."""
        self.infos[label] = replace(self.info(label), **changes)

    def label_at(self, x: float, y: float) -> int:
        """Block under image coordinates; 0 for none or off the frame."""
        row, column = int(y // 1), int(x // 1)
        height, width = self.labels.shape
        return int(self.labels[row, column]) if 0 <= row < height and 0 <= column < width else 0

    def take_notes(self, notes: BlockNotes) -> BlockNotes:
        """Take over what is known of the label map beside its pixels; the former notes are returned."""
        self.settle_parameters()
        former, self.notes = self.notes, notes
        self._note_dirty()
        if former.extraction != notes.extraction:
            self.results.forget_guess()  # it saw the edges of the former one
        self._forget_results()
        return former

    def take_frame(self, frame: RGBDFrame) -> None:
        """Take over the same frame with other distrusted depth or another guide; its truth stays what it is now."""
        if frame.truth is not self.frame.truth:
            frame = frame.with_truth(self.frame.truth, None if self.frame.inputs is None else self.frame.inputs.truth)
        self.frame = frame
        self._tally = self._completion = None
        self._shown.take_frame(frame)
        self._forget_results()

    def take_truth(self, truth: NDArray[np.float32] | None, file: TruthFile | None = None) -> None:
        """Take over another truth [m], float32 (H, W), or none; results are none the worse for it."""
        self.frame = self.frame.with_truth(truth, file)
        for kept in self.kept_runs:
            kept.truth_error = None

    def settle_parameters(self) -> None:
        """The parameters that blocks have now are about to be left, and may be come back to."""
        self.results.settled.update(self.parameters_of(label, self.common) for label in self.counts())

    def take_common(self, parameters: Parameters) -> None:
        """Take over other parameters of all blocks."""
        self.common = parameters
        self._valid = None

    def take_dirty(self) -> Box | None:
        """Where label map or drawn borders have changed since the last call (rows, columns); None if nowhere."""
        dirty, self._dirty = self._dirty, None
        return dirty

    def _note_dirty(self, box: Box | None = None) -> None:
        """They have changed in a box, or anywhere."""
        changed = box or (slice(0, self.labels.shape[0]), slice(0, self.labels.shape[1]))
        self._dirty = changed if self._dirty is None else union(self._dirty, changed)

    def set_labels(self, labels: NDArray[np.int32]) -> None:
        """Take over another label map."""
        self.labels[:] = labels
        self._note_dirty()
        self._tally = None
        self._forget_results()

    def apply(self, patch: LabelPatch, forward: bool = True) -> None:
        """Make or take back a change of the label map."""
        if self._tally is not None:
            self._tally.take_out(patch.box)
        (patch.apply if forward else patch.revert)(self.labels)
        self._note_dirty(patch.box)
        if self._tally is not None:
            self._tally.add(patch.box)
        self._shown.note(patch.box)
        for label in touched_by(patch):
            self._forget_result(label)

    def draw(self, box: Box, drawn: NDArray[np.bool_], blocks: Iterable[int]) -> None:
        """Take over which pixels have drawn borders inside a box; it belongs to a change of these blocks there."""
        if self.notes.drawn is None:
            self.notes.drawn = np.zeros(self.labels.shape, bool)
        self.notes.drawn[box] = drawn
        self._note_dirty(box)
        for label in blocks:  # during a stroke, results were looked for before its borders were known
            self._forget_result(label)

    def add_guess(self, base: Completion, guess: Completion) -> None:
        """Keep the guess of what a completion leaves missing; it holds as long as that is the present one."""
        self.results.note_guess(base, guess)
        self._shown.note_all()

    def add_previews(self, previews: Sequence[Preview]) -> None:
        """Blocks that run have other depth."""
        self.results.add_previews(previews)
        for block, _ in previews:
            self._shown.note(block.box)

    def end_run(self, previews_stay: bool = False) -> None:
        """Nothing runs any more; with `previews_stay`, another run of the same is about to begin."""
        for block, _ in self.results.previews.values():
            self._shown.note(block.box)
        self.results.end_run(previews_stay)

    def add_results(self, results: Sequence[BlockResult], frame: RGBDFrame | None = None) -> None:
        """Keep blocks' results, of the frame as it was when they were begun if it has changed since; they are not
        exported yet."""
        self.results.add(results, frame or self.frame)
        self._shown.keep(results)
        for result in results:
            self._forget_result(result.block.label)

    def swap_results(self, other: Held) -> Held:
        """Take other results, none or those of before; the former ones are returned."""
        former = self.results.swap(other)
        self._shown.forget()
        for results in other.kept.values():
            self._shown.keep(kept.result for kept in results)
        self._forget_results()
        return former

    def bring_back(self, results: Sequence[BlockResult], guess: Guess | None) -> Held:
        """Let results of the past, and the guess that they had, be the latest again; what there was is returned."""
        former = self.results.held()
        self.add_results(results)
        completion = self._blocks_completion()
        if guess is not None and completion is not None and not completion.filled.ravel()[guess.pixels].any():
            self.add_guess(completion, guess.added_to(completion))
        return former

    def counts(self) -> dict[int, BlockCounts]:
        """Block label -> counts, in rising order of labels."""
        if self._tally is None:
            self._tally = BlockTally(self.labels, ~self.frame.missing)
        return self._tally.counts()

    def parameters_of(self, label: int, common: Parameters) -> Parameters:
        """Parameters that a run of this block would take: its own values over the common ones."""
        own = self.notes.own.get(label)
        return common.replace(**own) if own else common

    def valid_results(self) -> dict[int, BlockResult]:
        """Results whose block has the very pixels and drawn borders that were run, whose depth was distrusted and
        guided as it is now, and whose filter saw the edges of the present extraction, in rising order of labels.

        Of several, that of the present parameters; if there is none, the latest.
        """
        if self._valid is None:
            found = {label: self._best(label) for label in sorted(self.results.kept)}
            self._valid = {label: result for label, result in found.items() if result is not None}
            self._note_others(self._valid)
        return self._valid

    def _note_others(self, valid: Mapping[int, BlockResult]) -> None:
        """Have the present depth brought up to date where these results are not those of the last time."""
        former, self._last_valid = self._last_valid, valid
        for label in former.keys() | valid.keys():
            one, other = former.get(label), valid.get(label)
            for result in (one, other) if one is not other else ():
                if result is not None:
                    self._shown.note(result.block.box)

    def results_of(self, run: Run) -> dict[int, BlockResult]:
        """Results of the blocks that a run was made of, as they were then; of several, that of its parameters, else the
        latest. In rising order of labels."""
        sizes = np.bincount(run.blocks.ravel())
        found = {}
        for label in sorted(label for label in self.results.kept if label < sizes.size and sizes[label]):
            wanted, size = run.parameters_of(label), int(sizes[label])
            fitting = [
                kept.result
                for kept in reversed(self.results.kept[label])
                if kept.fits(run.blocks, size, run.frame, run.drawn, run.extraction)
            ]
            if fitting:
                same = (result for result in fitting if result.parameters.same_effect(wanted))
                found[label] = next(same, fitting[0])
        return found

    def still_fitting(self, kept: KeptRun) -> list[BlockResult]:
        """Results of a kept run whose blocks are as they were then."""
        return [result for result in kept.results.values() if self._fits(Kept.of(result, kept.run.frame))]

    def changed_blocks(self) -> list[int]:
        """Blocks that have no result, or one of another state or of other parameters, in rising order."""
        return [label for label in self.counts() if not self.is_up_to_date(label)]

    def is_up_to_date(self, label: int) -> bool:
        """Whether there is a result of the block as it is now."""
        result = self.valid_results().get(label)
        return result is not None and result.parameters.same_effect(self.parameters_of(label, self.common))

    def _best(self, label: int) -> BlockResult | None:
        if label not in self._fitting:
            self._fitting[label] = [kept.result for kept in reversed(self.results.kept[label]) if self._fits(kept)]
        fitting, wanted = self._fitting[label], self.parameters_of(label, self.common)
        return next((result for result in fitting if result.parameters.same_effect(wanted)), next(iter(fitting), None))

    def completion(self) -> Completion | None:
        """The completed depth as far as blocks have been run, and the guess of the rest if there is one.

        None if no block has been run; the same object until it changes.
        """
        completion = self._blocks_completion()
        return self.results.guess_of(completion) or completion

    @property
    def guessed(self) -> bool:
        """Whether the rest of the present completion has been guessed."""
        return self.results.guess_of(self._blocks_completion()) is not None

    def _blocks_completion(self) -> Completion | None:
        results = self.valid_results()
        for known in (self._completion, self.results.guess_base):
            if known is not None and _same(known.results, results):
                self._completion = known
                return known
        self._completion = compose(self.frame, results, self._completion) if results else None
        return self._completion

    def expected_error(self) -> NDArray[np.float32] | None:
        """The expected error [m] of the present completion, if it has been worked out."""
        doubt = self.results.doubt_of(self.completion())
        return None if doubt is None else doubt.error

    def unvouched(self) -> NDArray[np.bool_] | None:
        """Which filled pixels nothing vouches for, if that has been worked out for the present completion."""
        doubt = self.results.doubt_of(self.completion())
        return None if doubt is None else doubt.unvouched

    def present_depth(self) -> NDArray[np.float32] | None:
        """What is completed, and over it the last that is known of the blocks that run or have changed since; None if
        there is neither. Changed in place when it changes."""
        self.update_depth()
        return self._shown.depth if self.results.kept or self.results.previews else None

    @property
    def stale(self) -> NDArray[np.bool_]:
        """Pixels of the present depth that are of a former state of their block."""
        return self._shown.stale

    def update_depth(self) -> Box | None:
        """Bring the present depth up to date; where it has changed (rows, columns), None if nowhere."""
        completion = self.completion()
        return self._shown.update(self.labels, self.valid_results(), completion, self.results.previews.values())

    def records_of(self, label: int) -> Sequence[IterationRecord]:
        """Records of the block while it runs, else those of its result."""
        live = self.results.live.get(label)
        if live is not None:
            return live
        result = self.valid_results().get(label)
        return () if result is None else result.history

    def _fits(self, kept: Kept) -> bool:
        count = self.counts().get(kept.result.block.label)
        notes = self.notes
        return count is not None and kept.fits(self.labels, count.pixels, self.frame, notes.drawn, notes.extraction)

    def note_edit(self) -> None:
        """What was edited up to now is no longer all; steps of the history tell by themselves."""
        self._edits += 1

    def note_other_change(self) -> None:
        """Something has changed that no step of the history tells of."""
        self._others += 1

    def _forget_result(self, label: int) -> None:
        """What was worked out from a block and its results no longer holds."""
        self._valid = None
        for result in self._fitting.pop(label, ()):
            self._shown.note(result.block.box)

    def _forget_results(self) -> None:
        self._valid = None
        self._fitting.clear()
        self._shown.note_all()


def touched_by(patch: LabelPatch) -> frozenset[int]:
    """Blocks that gain or lose pixels by a change of the label map."""
    changed = patch.before != patch.after
    counts = (np.bincount(labels[changed]) for labels in (patch.before, patch.after))
    return frozenset(int(label) for count in counts for label in np.flatnonzero(count)) - {0}


def _same(some: Mapping[int, BlockResult], others: Mapping[int, BlockResult]) -> bool:
    """Whether these are the very same results."""
    return some.keys() == others.keys() and all(result is others[label] for label, result in some.items())
