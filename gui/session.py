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
        The label map, which is the truth about blocks. Changed in place by edits only.
    infos : dict
        Block label -> BlockInfo. Kept for labels that are gone, so that undo brings names back.
    results : dict
        Block label -> its last result. One that no longer fits its block's pixels is kept for undo,
        but does not count (see `valid_results`).
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
        self.results: dict[int, BlockResult] = {}
        self.block_parameters: dict[int, Parameters] = {}
        self.extraction: BlockParameters | None = None
        self.extracted: NDArray[np.int32] | None = None
        self.selected: list[int] = []
        self.undo_stack = QUndoStack()
        self.exported = True

    def take_blocks(self, labels: NDArray[np.int32], extraction: BlockParameters | None, edited: bool = False) -> None:
        """The blocks to begin with; `edited` if they are not what the extraction gives."""
        self.labels[:] = labels
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

    def apply(self, patch: LabelPatch, forward: bool = True) -> None:
        """Make or take back a change of the label map."""
        (patch.apply if forward else patch.revert)(self.labels)

    def counts(self) -> dict[int, BlockCounts]:
        """Block label -> counts, in rising order of labels."""
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
        """Results whose block still has the very pixels that were run, in rising order of labels."""
        return {label: self.results[label] for label in sorted(self.results) if self._fits(self.results[label])}

    def completion(self) -> Completion | None:
        """The completed depth as far as blocks have been run; None if none has."""
        results = self.valid_results()
        return compose(self.frame, results) if results else None

    def _fits(self, result: BlockResult) -> bool:
        block = result.block
        inside = self.labels[block.box] == block.label
        if not np.array_equal(inside, block.mask):
            return False
        return np.count_nonzero(self.labels == block.label) == np.count_nonzero(block.mask)
