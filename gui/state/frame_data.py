"""A frame in the window and what follows from its state: valid results, completion, depth. No undo, no widgets."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ilf.data.blocks import BlockInfo, Blocks, Box, block_colour
from ilf.data.by_hand import DepthByHand, as_by_hand
from ilf.data.frame import RGBDFrame, read_only
from ilf.data.parameters import Parameters
from ilf.data.results import BlockResult, Completion, IterationRecord, compose
from ilf.project.frame_state import FrameState
from ilf.project.project import FrameSummary
from ilf.project.run_history import Extrapolation, StoredRun
from ilf.run.key_frames import KeyFrames
from ilf.run.replaying import Replay
from ilf.run.run import Run
from ilf.segmentation.editing.patches import LabelPatch, values_at
from ilf.segmentation.reextraction import made_by_hand

from .results import CurrentDepth, FrameResults, Results, StoredBlockResult, same_depth, same_layers, same_mask

LARGEST_LABEL = 65535
"""Label maps are exported as 16-bit images."""


@dataclass(frozen=True)
class BlockCounts:
    """Pixels of a block; `known` counts those with known depth or outside the depth camera's view."""

    pixels: int
    known: int

    @property
    def defect_rate(self) -> float:
        """Share of pixels without raw depth in the depth camera's view, 0-1."""
        return 1.0 - self.known / self.pixels if self.pixels else 0.0


class BlockTally:
    """Counts of all blocks of a label map, int32 (H, W), given a mask of pixels that lack no depth, bool (H, W)."""

    def __init__(self, labels: NDArray[np.int32], known: NDArray[np.bool_]) -> None:
        self._labels = labels
        self._known = known
        self._counts = np.zeros((2, 1), np.int64)
        self.add((slice(None), slice(None)))

    def counts(self) -> dict[int, BlockCounts]:
        """Block label -> counts, in rising order of labels; 0 is no block."""
        pixels, known = self._counts
        present = np.flatnonzero(pixels)
        return {int(label): BlockCounts(int(pixels[label]), int(known[label])) for label in present if label > 0}

    def add(self, box: Box, sign: int = 1) -> None:
        """Add the pixels of a box to the counts; with sign -1, subtract them."""
        here = self._labels[box]
        beyond = int(here.max()) + 1 - self._counts.shape[1]
        if beyond > 0:
            self._counts = np.pad(self._counts, ((0, 0), (0, beyond)))
        size = self._counts.shape[1]
        self._counts[0] += sign * np.bincount(here.ravel(), minlength=size)
        self._counts[1] += sign * np.bincount(here[self._known[box]], minlength=size)


class FrameData:
    """An open frame: its state, the results of its runs, and what follows from both. `Document` adds undo and tells the
    window.

    Attributes
    ----------
    state : FrameState
        The state of the frame, replaced by `change` and `change_blocks`. Its label map and drawn borders change in
        place, by `apply`, `set_labels` and `draw` only, and it has no results: `snapshot` has them.
    origin : object
        What it was opened from; documents with the same origin are the same.
    key : str
        The path of the origin.
    results : Results
    """

    def __init__(self, state: FrameState, origin: object, key: str) -> None:
        blocks = state.blocks
        drawn = None if blocks.drawn is None else blocks.drawn.copy()
        blocks = replace(blocks, labels=np.array(blocks.labels, np.int32), drawn=drawn)
        self.state = replace(state, blocks=blocks, results={}, extrapolation=None)
        self.origin = origin
        self.key = key
        self.results = Results()
        self.key_frames = KeyFrames()
        self.proposal: NDArray[np.float32] | None = None
        """Depth [m] that is shown in place of the completed one until it is taken or dropped; NaN for none."""
        self.record_replay: Replay | None = None
        """The record that the document was opened from."""
        self._shown = CurrentDepth(state.frame.depth)
        self._tally: BlockTally | None = None
        self._fitting: dict[int, list[BlockResult]] = {}
        self._valid: dict[int, BlockResult] | None = None
        self._completion: Completion | None = None
        self._extrapolated: tuple[Completion, Extrapolation] | None = None
        self._copies: dict[str, Any] = {}
        """Read-only copies of label map and drawn borders, by name, as long as these have not changed."""

    def snapshot(self) -> FrameState:
        """Return the state as it is now, with the results; later changes do not affect it.

        Label map and drawn borders are copied only if they have changed since the last snapshot: else they are the
        same objects.
        """
        return replace(
            self.state,
            blocks=self._lasting_blocks(),
            results=dict(self.valid_results()),
            extrapolation=self._extrapolation(),
            runs=tuple(map(copy, self.state.runs)),
        )

    def summary(self) -> FrameSummary:
        """Return the summary of the frame as it is now."""
        return replace(self.state, results=self.valid_results()).summary(self.counts())

    def _lasting_blocks(self) -> Blocks:
        """The blocks with copies of the arrays that change in place."""
        for name in ("labels", "drawn"):
            if name not in self._copies:
                array = getattr(self.blocks, name)
                self._copies[name] = None if array is None else read_only(array)
        return replace(self.blocks, **self._copies)

    def _extrapolation(self) -> Extrapolation | None:
        """The extrapolated depth of the current completion; the same object until it changes."""
        completion = self.completion() if self.extrapolated else None
        if completion is None:
            return None
        if self._extrapolated is None or self._extrapolated[0] is not completion:
            self._extrapolated = completion, Extrapolation.of(completion)
        return self._extrapolated[1]

    def change(self, **fields: Any) -> None:
        """Replace fields of the state; `change_blocks` replaces those of its blocks, `take_frame` the frame."""
        self.state = replace(self.state, **fields)
        if "common" in fields:
            self._valid = None

    def change_blocks(self, **fields: Any) -> None:
        """Replace what is said about the blocks, other than the label map and depth by hand."""
        self.state = replace(self.state, blocks=replace(self.blocks, **fields))
        if "own" in fields:
            self._valid = None

    @property
    def id(self) -> str:
        """Unique among all frames of its project, open or not."""
        return self.state.id

    @property
    def frame(self) -> RGBDFrame:
        """The frame."""
        return self.state.frame

    @property
    def name(self) -> str:
        """The frame's name."""
        return self.frame.name

    @property
    def blocks(self) -> Blocks:
        """The blocks as they are now; label map and drawn borders change in place."""
        return self.state.blocks

    @property
    def labels(self) -> NDArray[np.int32]:
        """The label map, (H, W), which defines the blocks. It changes in place."""
        return self.state.blocks.labels

    @property
    def locked(self) -> frozenset[int]:
        """Labels that edits must not change."""
        return self.blocks.locked

    @property
    def selected(self) -> list[int]:
        """The selected blocks; edits and curves use the first one."""
        return list(self.state.selected)

    @property
    def compared(self) -> list[StoredRun]:
        """The runs of the history that are compared with the current result."""
        runs = {kept.number: kept for kept in self.state.runs}
        return [runs[number] for number in self.state.compared if number in runs]

    def has_inputs_of(self, run: Run) -> bool:
        """Whether blocks, drawn borders, known depth and additional depth are those of a run."""
        return (
            np.array_equal(self.labels, run.blocks.labels)
            and same_mask(self.blocks.drawn, run.blocks.drawn)
            and same_depth(self.blocks.by_hand, run.blocks.by_hand)
            and same_layers(self.frame, run.frame)
        )

    def run(self, common: Parameters, only: Collection[int] | None = None, extrapolate: bool = False) -> Run:
        """Return the run of the frame in its current state.

        Parameters
        ----------
        common : Parameters
            Of all blocks without own parameters.
        only : collection of int, optional
            Run only these blocks, in this order if the collection is ordered.
        extrapolate : bool
            Whether missing depth is extrapolated.
        """
        return Run(self.frame, self._lasting_blocks().without_absent(), common, only, extrapolate)

    def handmade(self) -> frozenset[int]:
        """Return the hand-made blocks, from before and after the last extraction."""
        older = self.blocks.handmade & set(self.counts())
        return older | made_by_hand(self.labels, self.blocks.extracted)

    def next_label(self) -> int:
        """Return a label that no block has or had: former names, locks and results stay with their blocks."""
        taken = {*self.counts(), *self.blocks.infos}
        following = max(taken, default=0) + 1
        if following <= LARGEST_LABEL:
            return following
        return next(label for label in range(1, LARGEST_LABEL + 1) if label not in taken)

    def info(self, label: int) -> BlockInfo:
        """Return the block's info; a new block gets a default name and colour."""
        if label not in self.blocks.infos:
            self._set_info(label, BlockInfo(f"Block {label}", block_colour(label)))
        return self.blocks.infos[label]

    def change_info(self, label: int, **changes: Any) -> None:
        """Set `name`, `colour`, `visible` or `locked` of a block."""
        self._set_info(label, replace(self.info(label), **changes))

    def _set_info(self, label: int, info: BlockInfo) -> None:
        self.change_blocks(infos={**self.blocks.infos, label: info})

    def label_at(self, x: float, y: float) -> int:
        """Return the block at image coordinates; 0 for none or outside the frame."""
        return int(values_at(self.labels, np.array([[x, y]]), beyond=0)[0])

    def take_blocks(self, blocks: Blocks) -> Blocks:
        """Replace all that is said about the blocks, other than depth by hand, and return the former blocks; the label
        map stays."""
        self.remember_parameters()
        former = self.blocks
        self.state = replace(self.state, blocks=replace(blocks, labels=former.labels, by_hand=former.by_hand))
        self._copies.pop("drawn", None)
        if former.extraction != blocks.extraction:
            self.results.extrapolation = None  # it used the edges of the former extraction
        self._forget_results()
        return former

    def take_frame(self, frame: RGBDFrame) -> None:
        """Replace the frame by itself with another invalid mask, guide or neighbours; its ground truth stays."""
        if frame.ground_truth is not self.frame.ground_truth:
            frame = frame.with_ground_truth(
                self.frame.ground_truth, None if self.frame.inputs is None else self.frame.inputs.ground_truth
            )
        self.change(frame=frame)
        self._tally = self._completion = None
        self._forget_results()

    def take_camera(self, read: RGBDFrame) -> None:
        """Replace the frame by itself with the camera and the notes of the same frame as `read`. Results of blocks
        stay valid; extrapolated depth is forgotten."""
        inputs = self.frame.inputs
        if inputs is not None and read.inputs is not None:
            inputs = replace(read.inputs, ground_truth=inputs.ground_truth)
        camera = {name: getattr(read, name) for name in ("intrinsics", "notes", "plausibility_warnings")}
        self.change(frame=self.frame.changed(inputs=inputs, **camera))
        self.results.extrapolation = None
        self._completion = None

    def remember_parameters(self) -> None:
        """Remember the current parameters of the blocks, because undo may bring them back."""
        self.results.remembered.update(self.parameters_of(label) for label in self.counts())

    def set_labels(self, labels: NDArray[np.int32]) -> None:
        """Replace the label map."""
        self.labels[:] = labels
        self._copies.pop("labels", None)
        self._tally = None
        self._forget_results()

    def apply(self, patch: LabelPatch, forward: bool = True) -> None:
        """Apply or revert a change of the label map."""
        if self._tally is not None:
            self._tally.add(patch.box, -1)
        (patch.apply if forward else patch.revert)(self.labels)
        self._copies.pop("labels", None)
        if self._tally is not None:
            self._tally.add(patch.box)
        self._shown.note(patch.box)
        for label in patch.touched:
            self._forget_result(label)

    def draw(self, box: Box, drawn: NDArray[np.bool_], blocks: Iterable[int]) -> None:
        """Set the drawn border pixels inside a box, as part of a change of these blocks."""
        whole = self.blocks.drawn
        if whole is None:
            whole = np.zeros(self.labels.shape, bool)
            self.change_blocks(drawn=whole)
            self._copies.pop("drawn", None)
        if not np.array_equal(whole[box], drawn):
            whole[box] = drawn
            self._copies.pop("drawn", None)
        for label in blocks:  # during a stroke, results were looked up before its borders were known
            self._forget_result(label)

    def take_by_hand(self, box: Box, depth: NDArray[np.float32]) -> frozenset[int]:
        """Set depth by hand [m] in a box and return the blocks with changed pixels."""
        former = self.blocks.by_hand or DepthByHand(np.full(self.labels.shape, np.nan, np.float32))
        whole = former.depth.copy()
        whole[box] = depth
        self.change_blocks(by_hand=as_by_hand(replace(former, depth=whole), self.labels.shape))
        before = former.depth[box]
        changed = (before != depth) & ~(np.isnan(before) & np.isnan(depth))
        blocks = frozenset(np.unique(self.labels[box][changed]).tolist()) - {0}
        for label in blocks:
            self._forget_result(label)
        return blocks

    def with_proposal(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return depth [m], float32 (H, W), with the proposal in its place, if there is one."""
        if self.proposal is None:
            return depth
        return np.where(np.isnan(self.proposal), depth, self.proposal)

    def add_extrapolation(self, base: Completion, extrapolation: Completion) -> None:
        """Store the extrapolation of a completion; valid while that completion is the current one."""
        self.results.extrapolation = base, extrapolation
        self._shown.note_all()

    def add_results(self, results: Sequence[BlockResult], frame: RGBDFrame | None = None) -> None:
        """Store results of blocks; `frame` is the frame as it was when they started, if it has changed since."""
        self.results.add(results, frame or self.frame)
        self._shown.keep(results)
        for result in results:
            self._forget_result(result.block.label)

    def put_back_results(self, former: FrameResults, known: FrameResults) -> None:
        """Replace the results that are `known` by former ones; those that have come since stay."""
        self.results.put_back(former, known)
        self._shown.forget()
        for results in self.results.kept.values():
            self._shown.keep(kept.result for kept in results)
        self._forget_results()

    def restore_results(self, results: Sequence[BlockResult], extrapolation: Extrapolation | None) -> FrameResults:
        """Make earlier results, with their extrapolation, the latest again; return the former results."""
        former = self.results.snapshot()
        self.add_results(results)
        completion = self._blocks_completion()
        if (
            extrapolation is not None
            and completion is not None
            and not completion.filled.ravel()[extrapolation.pixels].any()
        ):
            self.add_extrapolation(completion, extrapolation.added_to(completion))
        return former

    def counts(self) -> dict[int, BlockCounts]:
        """Return block label -> counts, in ascending order of labels."""
        if self._tally is None:
            self._tally = BlockTally(self.labels, ~self.frame.missing)
        return self._tally.counts()

    def parameters_of(self, label: int) -> Parameters:
        """Return the parameters of this block: its own parameters over the common ones."""
        return self.blocks.parameters_of(label, self.state.common)

    def valid_results(self) -> dict[int, BlockResult]:
        """Return block label -> result that fits the current state, in ascending order of labels.

        A result fits if the block's pixels, drawn borders, depth by hand, invalid mask, guide, depth of neighbours and
        the edges of the extraction are unchanged. Of several, the one with the current parameters; if there is none,
        the latest.
        """
        if self._valid is None:
            found = {label: self._best(label) for label in sorted(self.results.kept)}
            self._valid = {label: result for label, result in found.items() if result is not None}
            outdated = (label for label, result in self._valid.items() if not self._is_current(result))
            self._shown.note_results(self._valid, frozenset(outdated))
        return self._valid

    def _is_current(self, result: BlockResult) -> bool:
        """Whether a result has the current parameters of its block."""
        return result.parameters.same_effect(self.parameters_of(result.block.label))

    def results_of(self, run: Run) -> dict[int, BlockResult]:
        """Return the results that fit the blocks of a run; of several, the one with its parameters, else the latest.
        In ascending order of labels."""
        sizes = np.bincount(run.blocks.labels.ravel())
        found = {}
        for label in sorted(label for label in self.results.kept if label < sizes.size and sizes[label]):
            latest, size = reversed(self.results.kept[label]), int(sizes[label])
            fitting = [kept.result for kept in latest if kept.fits(run.blocks, size, run.frame)]
            found[label] = _best_of(fitting, run.parameters_of(label))
        return {label: result for label, result in found.items() if result is not None}

    def fitting_results(self, kept: StoredRun) -> list[BlockResult]:
        """Return the results of a stored run whose blocks have not changed since."""
        return [result for result in kept.results.values() if self._fits(StoredBlockResult(result, kept.run.frame))]

    def changed_blocks(self) -> list[int]:
        """Return the blocks without an up-to-date result, in ascending order."""
        return [label for label in self.counts() if not self.is_up_to_date(label)]

    def is_up_to_date(self, label: int) -> bool:
        """Whether the block has a result of its current state and parameters."""
        result = self.valid_results().get(label)
        return result is not None and self._is_current(result)

    def _best(self, label: int) -> BlockResult | None:
        if label not in self._fitting:
            self._fitting[label] = [kept.result for kept in reversed(self.results.kept[label]) if self._fits(kept)]
        return _best_of(self._fitting[label], self.parameters_of(label))

    def completion(self) -> Completion | None:
        """Return the completion from all valid results, extrapolated if that was done.

        None if there are no results; the same object until it changes.
        """
        completion = self._blocks_completion()
        return self.results.extrapolation_of(completion) or completion

    @property
    def extrapolated(self) -> bool:
        """Whether the current completion is extrapolated."""
        return self.results.extrapolation_of(self._blocks_completion()) is not None

    def _blocks_completion(self) -> Completion | None:
        results = self.valid_results()
        extrapolated = self.results.extrapolation
        for known in (self._completion, extrapolated and extrapolated[0]):
            if known is not None and _same(known.results, results):
                self._completion = known
                return known
        self._completion = compose(self.run(self.state.common), results, self._completion) if results else None
        return self._completion

    def expected_error(self) -> NDArray[np.float32] | None:
        """Return the expected error [m] of the current completion; None if it is not computed yet."""
        error_estimate = self.results.error_estimate_of(self.completion())
        return None if error_estimate is None else error_estimate.error

    def unsupported(self) -> NDArray[np.bool_] | None:
        """Return the unsupported pixels of the current completion; None if they are not computed yet."""
        error_estimate = self.results.error_estimate_of(self.completion())
        return None if error_estimate is None else error_estimate.unsupported

    def current_depth(self) -> NDArray[np.float32] | None:
        """Return the completed depth with the latest depth of running or changed blocks over it; None if there is
        neither. Changed in place."""
        self.update_depth()
        return self._shown.depth if self.results.kept or self.results.previews else None

    @property
    def stale(self) -> NDArray[np.bool_]:
        """Pixels of the current depth that belong to an earlier state, or other parameters, of their block."""
        return self._shown.stale

    def stale_blocks(self) -> list[int]:
        """Return the blocks with stale depth, in ascending order."""
        return [int(label) for label in np.unique(self.labels[self.stale]) if label]

    def update_depth(self) -> Box | None:
        """Update the current depth and return the changed box (rows, columns); None if nothing changed."""
        completion = self.completion()
        depth = self.frame.depth if completion is None else completion.depth
        return self._shown.update(self.labels, depth, self.results.previews.values())

    def records_of(self, label: int) -> Sequence[IterationRecord]:
        """Return the records of the block so far if it is running, else those of its result."""
        live = self.results.live.get(label)
        if live is not None:
            return live
        result = self.valid_results().get(label)
        return () if result is None else result.history

    def _fits(self, kept: StoredBlockResult) -> bool:
        count = self.counts().get(kept.result.block.label)
        return count is not None and kept.fits(self.blocks, count.pixels, self.frame)

    def _forget_result(self, label: int) -> None:
        """Drop what was computed from a block and its results."""
        self._valid = None
        self._fitting.pop(label, None)

    def _forget_results(self) -> None:
        self._valid = None
        self._fitting.clear()
        self._shown.note_all()


def _best_of(fitting: Sequence[BlockResult], wanted: Parameters) -> BlockResult | None:
    """Return the first result with these parameters, or else the first one; None for none."""
    return next((result for result in fitting if result.parameters.same_effect(wanted)), next(iter(fitting), None))


def _same(some: Mapping[int, BlockResult], others: Mapping[int, BlockResult]) -> bool:
    """Return whether these are the same result objects."""
    return some.keys() == others.keys() and all(result is others[label] for label, result in some.items())
