"""Results of the runs of one frame, the state of the run in progress, and the depth that the views show of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from ilf.data.blocks import Block, Blocks, Box, union, whole
from ilf.data.by_hand import DepthByHand
from ilf.data.frame import RGBDFrame
from ilf.data.guide import Guide
from ilf.data.neighbours import NeighbourDepth
from ilf.data.parameters import Parameters
from ilf.data.results import BlockResult, Completion, IterationRecord
from ilf.segmentation.edges.frame_edges import edge_parameters

Preview = tuple[Block, NDArray[np.float32]]
"""A running block and its depth [m] so far, one value per pixel of the block."""


class StoredBlockResult(NamedTuple):
    """A result with its frame: that has the invalid mask, the guide and the neighbours that it depends on."""

    result: BlockResult
    frame: RGBDFrame

    def is_of_state(self, other: StoredBlockResult) -> bool:
        """Whether both have the same block pixels, drawn borders, depth by hand, edges, invalid mask, guide and depth
        of neighbours."""
        one, another = self.result, other.result
        return (
            one.edges == another.edges
            and one.block.box == another.block.box
            and np.array_equal(one.block.mask, another.block.mask)
            and same_mask(one.drawn, another.drawn)
            and same_depth(one.by_hand, another.by_hand)
            and same_layers(self.frame, other.frame)
        )

    def fits(self, blocks: Blocks, pixels: int, frame: RGBDFrame) -> bool:
        """Whether its block has the same pixels among these blocks, `pixels` in number, and the same drawn borders,
        depth by hand, extraction parameters, invalid mask, guide and depth of neighbours."""
        result = self.result
        block = result.block
        return (
            pixels == result.depth.size
            and result.edges == edge_parameters(result.parameters, blocks.extraction)
            and np.array_equal(blocks.labels[block.box] == block.label, block.mask)
            and same_layers(self.frame, frame)
            and same_mask(result.drawn, blocks.drawn_of(block))
            and same_depth(result.by_hand, blocks.by_hand_of(block, frame))
        )


class ErrorEstimate(NamedTuple):
    """The expected error [m] of a completion, float32 (H, W), and its unsupported pixels."""

    error: NDArray[np.float32]
    unsupported: NDArray[np.bool_]


class FrameResults(NamedTuple):
    """All results of a frame's blocks, and the extrapolation of a completion, as `Results` has them at a time."""

    kept: Mapping[int, Sequence[StoredBlockResult]] = {}
    extrapolation: tuple[Completion, Completion] | None = None


class Results:
    """Results, live records and previews of a frame's blocks. Only the workspace changes them.

    Attributes
    ----------
    kept : dict
        Block label -> results of all its former states, the latest last: undo may bring these states back.
    live : dict
        Label -> records so far of the running blocks, the one that started last at the end.
    previews : dict
        Label -> Preview of running blocks.
    remembered : set of Parameters
        Parameters of blocks at the start or the end of an undo step.
    error_estimate, extrapolation : tuple or None
        A completion, and its error estimate or the extrapolation of what it leaves missing.
    """

    def __init__(self) -> None:
        self.kept: dict[int, list[StoredBlockResult]] = {}
        self.live: dict[int, list[IterationRecord]] = {}
        self.previews: dict[int, Preview] = {}
        self.remembered: set[Parameters] = set()
        self.error_estimate: tuple[Completion, ErrorEstimate] | None = None
        self.extrapolation: tuple[Completion, Completion] | None = None

    @property
    def running(self) -> list[int]:
        """Blocks with records but no result in the current run, the one that started last at the end."""
        return list(self.live)

    def error_estimate_of(self, completion: Completion | None) -> ErrorEstimate | None:
        """Return the error estimate of this completion object; None if it is not computed yet."""
        known, error_estimate = self.error_estimate or (None, None)
        return error_estimate if known is completion else None

    def extrapolation_of(self, completion: Completion | None) -> Completion | None:
        """Return the extrapolated version of this completion object; None if there is none."""
        known, extrapolation = self.extrapolation or (None, None)
        return extrapolation if known is completion else None

    def add_previews(self, previews: Iterable[Preview]) -> None:
        """Store the present depth of running blocks; blocks that have finished are skipped."""
        self.previews |= {block.label: (block, depth) for block, depth in previews if block.label in self.live}

    def add(self, results: Iterable[BlockResult], frame: RGBDFrame) -> None:
        """Store results of finished blocks; `frame` is the frame as it was when they started."""
        for result in results:
            label, new = result.block.label, StoredBlockResult(result, frame)
            # undo and redo may bring these back; intermediate ones of a drag are dropped
            stays, others = self.remembered - {result.parameters}, self.kept.get(label, [])
            kept = [one for one in others if one.result.parameters in stays or not one.is_of_state(new)]
            self.kept[label] = [*kept, new]
            self.live.pop(label, None)
            self.previews.pop(label, None)

    def end_run(self, keep_previews: bool = False) -> None:
        """End the run; with `keep_previews`, another run of the same blocks starts next."""
        self.live.clear()
        if not keep_previews:
            self.previews.clear()

    def snapshot(self) -> FrameResults:
        """Return a copy of the results, which later changes do not affect."""
        return FrameResults({label: list(kept) for label, kept in self.kept.items()}, self.extrapolation)

    def put_back(self, former: FrameResults, known: FrameResults) -> None:
        """Replace the results that are `known` by former ones; those that have come since stay."""
        replaced = {id(one) for kept in known.kept.values() for one in kept}
        newer = {label: [one for one in kept if id(one) not in replaced] for label, kept in self.kept.items()}
        both = {label: [*former.kept.get(label, ()), *newer.get(label, ())] for label in former.kept.keys() | newer}
        self.kept = {label: kept for label, kept in both.items() if kept}
        if self.extrapolation is known.extrapolation:
            self.extrapolation = former.extrapolation


Stated = TypeVar("Stated", Guide, NeighbourDepth, DepthByHand)


def same_depth(one: Stated | None, other: Stated | None) -> bool:
    """Return whether two guides, two depths of neighbours or two depths by hand are equal; None is none."""
    return one is other or (one is not None and one.is_same_as(other))


def same_mask(one: NDArray[np.bool_] | None, other: NDArray[np.bool_] | None) -> bool:
    """Return whether two masks are equal; None equals an empty mask."""
    if one is None or other is None:
        return one is other or not np.any(other if one is None else one)
    return one is other or np.array_equal(one, other)


def same_layers(one: RGBDFrame, other: RGBDFrame) -> bool:
    """Return whether invalid mask, guide and depth of neighbours are equal."""
    return (
        same_mask(one.invalid_mask, other.invalid_mask)
        and same_depth(one.guide, other.guide)
        and same_depth(one.neighbours, other.neighbours)
    )


# The depth that the views show, updated only where it changed; and an earlier iteration of it.

Depth = NDArray[np.float32]


class CurrentDepth:
    """The completed depth, the last depth of blocks that have changed since, and previews of running blocks.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        [m], NaN where missing. Changed in place.
    stale : ndarray of bool, shape (H, W)
        Pixels whose depth is from before their block or its parameters changed. Changed in place.
    """

    def __init__(self, depth: Depth) -> None:
        self.depth = depth.copy()
        self.stale: NDArray[np.bool_] = np.zeros(depth.shape, bool)
        self._last: Depth = np.full(depth.shape, np.nan, np.float32)
        self._changed: Box | None = None
        self._valid: Mapping[int, BlockResult] = {}
        self._outdated: frozenset[int] = frozenset()

    def keep(self, results: Iterable[BlockResult]) -> None:
        """Store the depth of results; it is shown until there is newer depth, also when the blocks change."""
        for result in results:
            self._last[result.block.box][result.block.mask] = result.depth
            self.note(result.block.box)

    def forget(self) -> None:
        """Drop the depth of all results."""
        self._last.fill(np.nan)
        self.note_all()

    def note(self, box: Box) -> None:
        """Mark a box (rows, columns) as changed."""
        self._changed = box if self._changed is None else union(self._changed, box)

    def note_all(self) -> None:
        """Mark the whole frame as changed."""
        self._changed = whole(self.depth.shape)

    def note_results(self, valid: Mapping[int, BlockResult], outdated: frozenset[int]) -> None:
        """Take the valid results, and the blocks whose results have other parameters than the current ones; mark where
        either has changed."""
        for label in self._valid.keys() | valid.keys():
            one, other = self._valid.get(label), valid.get(label)
            if one is not other or (label in self._outdated) != (label in outdated):
                for result in filter(None, (one, other)):
                    self.note(result.block.box)
        self._valid, self._outdated = valid, outdated

    def update(self, labels: NDArray[np.int32], depth: Depth, previews: Iterable[Preview]) -> Box | None:
        """Bring `depth` and `stale` up to date.

        Parameters
        ----------
        labels : ndarray of int32, shape (H, W)
            The current label map.
        depth : ndarray of float32, shape (H, W)
            The completion from the valid results, extrapolated depth included; or what is known without any.
        previews : iterable of (Block, ndarray)

        Returns
        -------
        (slice, slice) or None
            The changed box; None if nothing changed.
        """
        box, self._changed = self._changed, None
        if box is None:
            return None
        part, here = depth[box].copy(), labels[box]
        fresh = np.zeros(max(int(here.max()), 0) + 1, bool)
        fresh[[0, *(label for label in self._valid if label < fresh.size)]] = True
        stale = ~fresh[here]
        if stale.any():
            last = self._last[box]
            stale &= np.isfinite(last)
            part = np.where(stale, last, part)
        if self._outdated:
            stale |= np.isin(here, list(self._outdated)) & np.isfinite(part)
        self.depth[box], self.stale[box] = part, stale
        for block, preview in previews:
            still = labels[block.box][block.mask] == block.label  # it may have lost pixels since it started
            mask = block.mask.copy()
            mask[block.mask] = still
            self.depth[block.box][mask] = preview[still]
            self.stale[block.box][mask] = False
        return box


@dataclass(frozen=True, eq=False)
class ViewedIteration:
    """The depth of the current frame after an earlier iteration of its last run.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        [m], NaN where it was missing.
    iteration : int
        The iteration of every block after which it was so.
    """

    depth: NDArray[np.float32]
    iteration: int

    @property
    def text(self) -> str:
        """Its label in the window."""
        return f"as of iteration {self.iteration}"
