"""One frame's state in the window: blocks, what is known of them, results, undo history. No widgets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QUndoStack

from gui.state.results import Results
from ilf.drawing.block_pictures import block_colour
from ilf.ebs.edit import LabelPatch
from ilf.ebs.reextraction import made_by_hand
from ilf.filter.convergence import IterationRecord
from ilf.filter.stepper import edge_parameters
from ilf.frame import RGBDFrame
from ilf.outcomes import BlockResult, Completion, compose
from ilf.parameters import BlockParameters, Parameters
from ilf.run import Replay, Run

LARGEST_LABEL = 65535
"""Label maps are exported as 16-bit images."""


@dataclass(frozen=True)
class BlockInfo:
    """What a user can say about a block, beside its pixels."""

    name: str
    colour: tuple[int, int, int]
    visible: bool = True
    locked: bool = False


@dataclass
class BlockNotes:
    """What is known of a label map beside its pixels; replaced as a whole when the map is.

    Attributes
    ----------
    infos : dict
        Block label -> BlockInfo. Kept for labels that are gone, so that undo brings names back.
    parameters : dict
        Block label -> parameters of its own, where they differ from those of all blocks.
    extraction : BlockParameters or None
        What the blocks were extracted with.
    network : str or None
        SHA-256 of the edge network that had a part in it.
    extracted : ndarray of int32 or None
        The map as that extraction left it; None if it was changed afterwards in ways that are not known.
    kept : frozenset of int
        Blocks that stayed as they were at that extraction, and do not come from it.
    handmade : frozenset of int
        Those of them that had been made by hand.
    """

    infos: dict[int, BlockInfo] = field(default_factory=dict)
    parameters: dict[int, Parameters] = field(default_factory=dict)
    extraction: BlockParameters | None = None
    network: str | None = None
    extracted: NDArray[np.int32] | None = None
    kept: frozenset[int] = frozenset()
    handmade: frozenset[int] = frozenset()


@dataclass(frozen=True)
class BlockCounts:
    """Pixels of a block, and those of them with raw depth."""

    pixels: int
    known: int

    @property
    def defect_rate(self) -> float:
        """Share of pixels without raw depth, 0-1."""
        return 1.0 - self.known / self.pixels if self.pixels else 0.0


class Session:
    """A frame that is open. The workspace alone changes it once it is among its sessions.

    Attributes
    ----------
    frame : RGBDFrame
    origin : object
        What it was opened from; sessions of the same origin are the same.
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
        self.labels: NDArray[np.int32] = np.zeros(frame.shape, np.int32)
        self.notes = BlockNotes()
        self.selected: list[int] = []
        self.undo_stack = QUndoStack()
        self.results = Results()
        self.dense = False
        """Whether what is still missing after a run is to be guessed."""
        self.again: Replay | None = None
        """The record that the session was opened from."""
        self._counts: dict[int, BlockCounts] | None = None
        self._valid: dict[int, BlockResult] | None = None
        self._completion: Completion | None = None
        self._edits = 0
        self.undo_stack.indexChanged.connect(self._note_edit)

    @classmethod
    def of(cls, run: Run, origin: object, key: str, again: Replay | None = None) -> Self:
        """A session whose frame and blocks are those of a run; its parameters are taken up by the workspace.

        With `again`, it is the record that the run comes from.
        """
        session = cls(run.frame, origin, key)
        session.set_labels(run.blocks)
        session.dense, session.again = run.dense, again
        session.notes.extraction, session.notes.network = run.extraction, run.network
        session.notes.extracted = None if run.edited else session.labels.copy()
        return session

    def run(self, common: Parameters, only: Iterable[int] | None = None, dense: bool = False) -> Run:
        """What a run of the frame as it is now is made of.

        Parameters
        ----------
        common : Parameters
            Of all blocks that have none of their own.
        only : iterable of int, optional
            Run just these blocks.
        dense : bool
            Whether the rest is guessed.
        """
        notes = self.notes
        return Run(
            self.frame,
            self.labels,
            common,
            {label: own for label, own in notes.parameters.items() if label in self.counts()},
            None if only is None else frozenset(only),
            dense=dense,
            extraction=notes.extraction,
            edited=self.edited,
            network=notes.network,
        )

    @property
    def name(self) -> str:
        """What the frame is called."""
        return self.frame.name

    @property
    def edited(self) -> bool:
        """Whether the blocks differ from what the extraction gave."""
        notes = self.notes
        return notes.extracted is None or bool(notes.kept) or not np.array_equal(notes.extracted, self.labels)

    def handmade(self) -> frozenset[int]:
        """Blocks made by hand, before the last extraction or since."""
        older = self.notes.handmade & set(self.counts())
        return older | made_by_hand(self.labels, self.notes.extracted)

    @property
    def unsaved(self) -> bool:
        """Whether there are edits or results that have not been exported."""
        return not self.undo_stack.isClean() or self.results.unsaved

    def saving(self) -> tuple[int, int]:
        """Where edits and results stand, to be given to `note_saved` when they have been exported."""
        return self._edits, self.results.changes

    def note_saved(self, state: tuple[int, int]) -> None:
        """What there was at `state` has been exported; what came later has not."""
        edits, results = state
        self.results.note_saved(results)
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
        taken = {*np.unique(self.labels).tolist(), *self.infos}
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
        former, self.notes = self.notes, notes
        if former.extraction != notes.extraction:
            self.results.forget_guess()  # it saw the edges of the former one
        self._forget_results()
        return former

    def set_labels(self, labels: NDArray[np.int32]) -> None:
        """Take over another label map."""
        self.labels[:] = labels
        self._forget()

    def apply(self, patch: LabelPatch, forward: bool = True) -> None:
        """Make or take back a change of the label map."""
        (patch.apply if forward else patch.revert)(self.labels)
        self._forget()

    def add_guess(self, base: Completion, guess: Completion) -> None:
        """Keep the guess of what a completion leaves missing; it holds as long as that is the present one."""
        self.results.note_guess(base, guess)

    def add_results(self, results: Sequence[BlockResult]) -> None:
        """Keep blocks' results; they are not exported yet."""
        self.results.add(results)
        self._forget_results()

    def clear_results(self) -> None:
        """Forget all results."""
        self.results.clear()
        self._forget_results()

    def counts(self) -> dict[int, BlockCounts]:
        """Block label -> counts, in rising order of labels."""
        if self._counts is None:
            self._counts = self._count()
        return self._counts

    def _count(self) -> dict[int, BlockCounts]:
        top = int(self.labels.max()) + 1
        pixels = np.bincount(self.labels.ravel(), minlength=top)
        known = np.bincount(self.labels[self.frame.known], minlength=top)
        return {
            int(label): BlockCounts(int(pixels[label]), int(known[label]))
            for label in np.flatnonzero(pixels)
            if label > 0
        }

    def parameters_of(self, label: int, common: Parameters) -> Parameters:
        """Parameters that a run of this block would take."""
        return self.notes.parameters.get(label, common)

    def valid_results(self) -> dict[int, BlockResult]:
        """Results whose block has the very pixels that were run, and the extraction whose edges the filter saw, in
        rising order of labels."""
        if self._valid is None:
            kept = self.results.kept
            self._valid = {label: kept[label] for label in sorted(kept) if self._fits(kept[label])}
        return self._valid

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
        self._completion = compose(self.frame, results) if results else None
        return self._completion

    def expected_error(self) -> NDArray[np.float32] | None:
        """The expected error [m] of the present completion, if it has been worked out."""
        return self.results.error_of(self.completion())

    def present_depth(self) -> NDArray[np.float32] | None:
        """What is completed, and over it the last that is known of the blocks that run; None if there is neither."""
        completion, previews = self.completion(), self.results.previews
        depth = None if completion is None else completion.depth
        if previews:
            depth = (self.frame.depth if depth is None else depth).copy()
            for block, preview in previews.values():
                depth[block.box][block.mask] = preview
        return depth

    def records_of(self, label: int) -> Sequence[IterationRecord]:
        """Records of the block while it runs, else those of its result."""
        live = self.results.live.get(label)
        if live is not None:
            return live
        result = self.valid_results().get(label)
        return () if result is None else result.history

    def _fits(self, result: BlockResult) -> bool:
        block = result.block
        if result.edges != edge_parameters(result.parameters, self.notes.extraction):
            return False
        if not np.array_equal(self.labels[block.box] == block.label, block.mask):
            return False
        count = self.counts().get(block.label)
        return count is not None and count.pixels == np.count_nonzero(block.mask)

    def _note_edit(self) -> None:
        self._edits += 1

    def _forget(self) -> None:
        """What was worked out from the labels no longer holds."""
        self._counts = None
        self._forget_results()

    def _forget_results(self) -> None:
        self._valid = None


def _same(some: Mapping[int, BlockResult], others: Mapping[int, BlockResult]) -> bool:
    """Whether these are the very same results."""
    return some.keys() == others.keys() and all(result is others[label] for label, result in some.items())
