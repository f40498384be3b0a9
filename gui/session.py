"""One frame's state in the window: blocks, what is known of them, results, undo history. No widgets."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QUndoStack

from ilf.completion import BlockResult, Completion, compose
from ilf.ebs.edit import LabelPatch
from ilf.frame import RGBDFrame
from ilf.parameters import BlockParameters, Parameters
from ilf.pictures import block_colour


@dataclass(frozen=True)
class BlockInfo:
    """What a user can say about a block, beside its pixels."""

    name: str
    colour: tuple[int, int, int]
    visible: bool = True
    locked: bool = False


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
    """A frame that is open.

    Attributes
    ----------
    frame : RGBDFrame
    labels : ndarray of int32, shape (H, W)
        The label map, which is the truth about blocks. Changed in place by `apply` and `set_labels` only.
    infos : dict
        Block label -> BlockInfo. Kept for labels that are gone, so that undo brings names back.
    block_parameters : dict
        Block label -> parameters of its own, where they differ from those of all blocks.
    extraction : BlockParameters or None
        What the blocks were extracted with; None before the first extraction.
    undo_stack : QUndoStack
    """

    def __init__(self, frame: RGBDFrame, source: str) -> None:
        self.frame = frame
        self.source = source
        self.labels: NDArray[np.int32] = np.zeros(frame.shape, np.int32)
        self.infos: dict[int, BlockInfo] = {}
        self._results: dict[int, BlockResult] = {}
        self._counts: dict[int, BlockCounts] | None = None
        self._valid: dict[int, BlockResult] | None = None
        self.block_parameters: dict[int, Parameters] = {}
        self.extraction: BlockParameters | None = None
        self.extracted: NDArray[np.int32] | None = None
        self.selected: list[int] = []
        self.undo_stack = QUndoStack()
        self.exported = True

    def take_blocks(self, labels: NDArray[np.int32], extraction: BlockParameters | None, edited: bool = False) -> None:
        """The blocks to begin with; `edited` if they are not what the extraction gives."""
        self.set_labels(labels)
        self.extraction = extraction
        self.extracted = None if edited or extraction is None else self.labels.copy()

    @property
    def name(self) -> str:
        """What the frame is called."""
        return self.frame.name

    @property
    def edited(self) -> bool:
        """Whether the blocks differ from what the extraction gave."""
        return self.extracted is None or not np.array_equal(self.extracted, self.labels)

    @property
    def unsaved(self) -> bool:
        """Whether there are edits or results that have not been exported."""
        return not (self.exported and self.undo_stack.isClean())

    def note_saved(self) -> None:
        """Everything has been exported."""
        self.exported = True
        self.undo_stack.setClean()

    @property
    def locked(self) -> frozenset[int]:
        """Labels that edits must not touch."""
        return frozenset(label for label, info in self.infos.items() if info.locked)

    @property
    def export_folder(self) -> Path:
        """Where an export goes unless the user says otherwise."""
        return Path(self.source).parent / f"{self.name}-ilf"

    def next_label(self) -> int:
        """A number that no block has, nor had: names, locks and results of the past stay with their blocks."""
        return max([int(self.labels.max()), *self.infos]) + 1

    def info(self, label: int) -> BlockInfo:
        """The block's info; a new block gets its name and colour by number."""
        return self.infos.setdefault(label, BlockInfo(f"Block {label}", block_colour(label)))

    def change_info(self, label: int, **changes: object) -> None:
        """Set name, colour, visible or locked of a block."""
        self.infos[label] = replace(self.info(label), **changes)

    def set_labels(self, labels: NDArray[np.int32]) -> None:
        """Take over another label map."""
        self.labels[:] = labels
        self._forget()

    def apply(self, patch: LabelPatch, forward: bool = True) -> None:
        """Make or take back a change of the label map."""
        (patch.apply if forward else patch.revert)(self.labels)
        self._forget()

    def add_results(self, results: list[BlockResult]) -> None:
        """Keep blocks' results; they are not exported yet."""
        self._results.update({result.block.label: result for result in results})
        self.exported = False
        self._forget()

    def clear_results(self) -> None:
        """Forget all results."""
        self._results.clear()
        self.exported = True
        self._forget()

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
        return self.block_parameters.get(label, common)

    def valid_results(self) -> dict[int, BlockResult]:
        """Results whose block still has the very pixels that were run, in rising order of labels.

        The others are kept, because undo may bring their blocks back.
        """
        if self._valid is None:
            self._valid = {label: self._results[label] for label in sorted(self._results) if self._fits(label)}
        return self._valid

    def completion(self) -> Completion | None:
        """The completed depth as far as blocks have been run; None if none has."""
        results = self.valid_results()
        return compose(self.frame, results) if results else None

    def _fits(self, label: int) -> bool:
        block = self._results[label].block
        if not np.array_equal(self.labels[block.box] == label, block.mask):
            return False
        count = self.counts().get(label)
        return count is not None and count.pixels == np.count_nonzero(block.mask)

    def _forget(self) -> None:
        """What was worked out from labels and results no longer holds."""
        self._counts = None
        self._valid = None
