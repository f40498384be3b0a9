"""DICP's second half: frame + blocks + parameters -> completed depth."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Iterator, Mapping
from contextlib import closing
from dataclasses import replace
from functools import cache, partial
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.cancellation import check_stopped
from .._runtime.formatting import counted
from .._runtime.memory import give_back
from .._runtime.threads import Steps, available_cores, one_by_one, side_by_side
from ..data.blocks import Block, checked_drawn, checked_labels, drawn_of, find_blocks
from ..data.frame import RGBDFrame, checked_frame
from ..data.guide import Guide
from ..data.parameters import BlockParameters, Parameters, as_parameters
from ..data.results import (
    NO_BLOCK,
    BlockOutcome,
    BlockResult,
    CompactHistory,
    Completion,
    IterationRecord,
    Progress,
    Status,
    compose,
    notes_of,
)
from ..errors import InputError
from ..segmentation.edges.frame_edges import FrameEdges
from ..segmentation.extraction import found_blocks
from .correction import UNCORRECTED, Correction, changes_any, corrections, corrects, load_correction_network, made_of
from .filter import Stepper, edge_parameters, edges_for, guide_carries, is_guided, make_stepper, most_pixels

_AT_ONCE, _FRAMES_AT_ONCE = 1 << 24, 1.2
"""Pixels that are worked on at a time, at most, or so many times those of the frame if that is more: each takes some 70
bytes, however many threads there are."""

ParameterChoice = Parameters | str | Mapping[int, Parameters | str]
"""Of all blocks, or block label -> parameters; a text is the name of a preset."""

Watch = Callable[[Block, IterationRecord, Stepper], None]
"""Is called after every iteration, in the thread that made it, with the block, the record and what iterates on it."""


class CompletionRun(Iterator[Progress]):
    """All blocks of a frame, one iteration per `next()`, several blocks at a time.

    Whoever drives it decides about pace, pause and cancelling: while nobody calls `next()`, no more is done than a few
    short slices of iterations. `results` holds the blocks whose end has been reported, which come in any order; what
    they hold does not depend on the number of threads. Blocks that are corrected come last, when all have been iterated
    on: there are steps then that tell of none. A run that is left before its end must be closed, by `close` or as a
    context manager.

    Parameters
    ----------
    frame : RGBDFrame
    labels : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    parameters : Parameters, str or mapping of label to either
        A text is the name of a preset.
    only : collection of int, optional
        Run just these blocks; in the order of a sequence, if they run one after the other.
    threads : int, optional
        Blocks that run at the same time; as many as there are cores if left out. With 1 they run one after the other
        in the caller's thread, each `next()` exactly one iteration.
    extraction : BlockParameters, optional
        What the blocks were extracted with, where that is known: the filter sees edges with the same parameters of
        Canny and depth jumps. Those of the defaults if left out.
    drawn : array_like of bool, shape (H, W), optional
        Pixels of blocks whose border, to another block or to none, was drawn by hand; see `complete`.
    watch : callable, optional
        A `Watch`, for those who want to look at the surface of every single iteration. The run waits for it.

    Raises
    ------
    InputError
        If label map or drawn borders do not fit the frame, or a block has no parameters.
    ParameterError
        For an unknown preset, or what are no parameters.
    """

    def __init__(
        self,
        frame: RGBDFrame,
        labels: NDArray[np.integer],
        parameters: ParameterChoice,
        only: Collection[int] | None = None,
        threads: int | None = None,
        extraction: BlockParameters | None = None,
        drawn: ArrayLike | None = None,
        watch: Watch | None = None,
    ) -> None:
        self._frame = frame
        borders = checked_drawn(drawn, frame.shape)
        self.blocks = find_blocks(checked_labels(labels, frame.shape), only)
        self.results: dict[int, BlockResult] = {}
        choice = parameters if isinstance(parameters, Mapping) else as_parameters(parameters)
        self._parameters = {label: _parameters_for(choice, label) for label in self.blocks}
        self.uncorrected: dict[int, BlockResult] = {}
        """Blocks that have been iterated on and wait for the correction, as they are without it."""
        self._live: dict[int, Stepper] = {}
        # a network's file is looked at once, not for every block
        edges = cache(partial(edges_for, frame, extraction=extraction))
        tasks = {
            label: _block_steps(
                frame, block, self._parameters[label], extraction, drawn_of(block, borders), self._live, watch, edges
            )
            for label, block in self.blocks.items()
        }
        width = min(available_cores() if threads is None else threads, len(tasks))
        if width > 1:
            sizes = {label: most_pixels(frame, self.blocks[label], self._parameters[label]) for label in tasks}
            largest_first = sorted(tasks, key=lambda label: sizes[label], reverse=True)
            self._steps = side_by_side(
                [tasks[label] for label in largest_first],
                width,
                [sizes[label] for label in largest_first],
                max(_AT_ONCE, _FRAMES_AT_ONCE * frame.depth.size),
            )
        else:
            self._steps = one_by_one(tasks.values())
        if any(map(corrects, self._parameters.values())):
            self._steps = _and_correct(self._steps, frame, extraction, threads, self.uncorrected)

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know of how the results so far came about, each sentence once."""
        return notes_of(self.results)

    def __next__(self) -> Progress:
        check_stopped()
        progress = next(self._steps)
        if progress.result is not None:
            self.results[progress.label] = progress.result
        return progress

    def close(self) -> None:
        """End the run where it is; no thread is left when this returns. Not from another thread than `next()`."""
        self._steps.close()
        self._live.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def preview(self) -> list[tuple[Block, NDArray[np.float32]]]:
        """The running blocks, those that wait for the correction among them, and what their depth [m] would be if they
        stopped now. From any thread."""
        running = [
            (
                self.blocks[label],
                block_depth(self._frame, self.blocks[label], iteration.surface, self._parameters[label]),
            )
            for label, iteration in list(self._live.items())
        ]
        return running + [(result.block, result.depth) for result in list(self.uncorrected.values())]


def complete(
    frame: RGBDFrame,
    blocks: NDArray[np.integer],
    parameters: ParameterChoice | None = None,
    *,
    on_progress: Callable[[Progress], None] | None = None,
    threads: int | None = None,
    extraction: BlockParameters | None = None,
    drawn: ArrayLike | None = None,
    guide: ArrayLike | Guide | None = None,
) -> Completion:
    """Complete the depth of all blocks of a frame by iterative low-pass filtering (section 3).

    Parameters
    ----------
    frame : RGBDFrame
    blocks : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    parameters : Parameters, str or mapping of label to either, optional
        A text is the name of a preset. The default preset, "best", if left out.
    on_progress : callable, optional
        Called with every `Progress`; raise `Cancelled` in it to stop.
    threads : int, optional
        Blocks that run at the same time; as many as there are cores if left out. The result is the same.
    extraction : BlockParameters, optional
        What the blocks were extracted with, unless that were the defaults: the filter sees the same edges then.
    drawn : array_like of bool, shape (H, W), optional
        Pixels of blocks whose border, to another block or to none, was drawn by hand: no depth gets across there. Of a
        block's result, only those of its own pixels decide. The pass band has no use for them, since it sees nothing
        beyond a block.
    guide : array_like or Guide, optional
        Depth or inverse depth of the frame, metric or relative, shape (H, W) or of the same aspect: from a network
        that looks at colour, or another sensor. The frame's own, if it has one, if left out. NaN, infinite and zero
        mean that nothing is said there. The edge-aware filter follows it as far as the known depth bears it out; the
        pass band has no use for it.

    Returns
    -------
    Completion
        Blocks without enough known depth are reported in `outcomes` and stay missing.

    Raises
    ------
    InputError
        If label map or drawn borders do not fit the frame.
    ParameterError
        For an unknown preset, or what are no parameters.

    Examples
    --------
    >>> import numpy as np
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
    >>> result = ilf.complete(frame, np.ones((20, 30), np.int32))
    >>> int(result.filled.sum()), round(float(result.depth[10, 15]), 3), result.outcomes[1].status.value
    (40, 2.0, 'completed')
    """
    chosen = Parameters() if parameters is None else parameters
    guided = checked_frame(frame) if guide is None else checked_frame(frame).with_guide(guide)
    with CompletionRun(guided, blocks, chosen, threads=threads, extraction=extraction, drawn=drawn) as run:
        for progress in run:
            if on_progress is not None:
                on_progress(progress)
    return compose(guided, run.results)


def iterate(
    frame: RGBDFrame,
    blocks: NDArray[np.integer],
    label: int,
    parameters: Parameters | str | None = None,
    *,
    extraction: BlockParameters | None = None,
    drawn: ArrayLike | None = None,
    guide: ArrayLike | Guide | None = None,
) -> Stepper:
    """The stepper of one block: iterate over it for one record per iteration.

    Parameters
    ----------
    frame : RGBDFrame
    blocks : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    label : int
        The block.
    parameters : Parameters or str, optional
        Or the name of a preset. The default preset, "best", if left out.
    extraction : BlockParameters, optional
        As in `complete`.
    drawn : array_like of bool, shape (H, W), optional
        As in `complete`.
    guide : array_like or Guide, optional
        As in `complete`.

    Returns
    -------
    Stepper
        Its `surface` is P_i at the block's pixels at any time, and its `notes` say what there is to know.

    Raises
    ------
    InputError
        If there is no such block, or it has no known depth at all.
    ParameterError
        For an unknown preset, or what are no parameters.

    Examples
    --------
    >>> import numpy as np
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
    >>> stepper = ilf.iterate(frame, np.ones((20, 30), np.int32), 1, ilf.preset("released-code", max_iterations=3))
    >>> [(record.i, round(record.radii[0], 2)) for record in stepper]
    [(1, 1.0), (2, 1.89), (3, 2.78)]
    >>> stepper.surface.shape
    (600,)
    """
    found = find_blocks(checked_labels(blocks, checked_frame(frame).shape))
    if label not in found:
        raise InputError(f"There is no block {label}. Blocks: {', '.join(map(str, found)) or 'none'}.")
    block = found[label]
    if not np.isfinite(frame.depth[block.box][block.mask]).any():
        raise InputError(f"Block {label} has no known depth, so there is nothing to iterate on.")
    own = drawn_of(block, checked_drawn(drawn, frame.shape))
    guided = frame if guide is None else frame.with_guide(guide)
    return make_stepper(guided, block, as_parameters(parameters), extraction, own)


def prepare(frame: RGBDFrame, parameters: Parameters, extraction: BlockParameters | None = None) -> None:
    """Work out beforehand what every run of a frame with such parameters needs: the frame's edges, once."""
    edges_for(frame, parameters, extraction)


def _block_steps(
    frame: RGBDFrame,
    block: Block,
    parameters: Parameters,
    extraction: BlockParameters | None,
    drawn: NDArray[np.bool_] | None,
    live: dict[int, Stepper],
    watch: Watch | None,
    edges_of: Callable[[Parameters], FrameEdges | None],
) -> Generator[Progress, None, None]:
    """All steps of one block; while they go on, its stepper stands in `live`."""
    refusal = _refusal(frame, block, parameters)
    edges = edge_parameters(parameters, extraction)
    if refusal is not None:
        raw = frame.depth[block.box][block.mask]
        yield Progress(block.label, result=BlockResult(block, raw, refusal, (), parameters, edges=edges, drawn=drawn))
        return
    stepper = make_stepper(frame, block, parameters, extraction, drawn, edges_of(parameters))
    live[block.label] = stepper
    history: list[IterationRecord] = []
    truth = _hidden_truth(frame, block)
    if truth is not None:
        stepper.judge(*truth)
    for record in stepper:
        history.append(record)
        if watch is not None:
            watch(block, record, stepper)
        yield Progress(block.label, record=record)
    del live[block.label]
    depth = block_depth(frame, block, stepper.surface, parameters)
    outcome = _outcome(frame, block, depth, history, stepper, parameters)
    result = BlockResult(
        block,
        depth,
        outcome,
        CompactHistory(history),
        parameters,
        stepper.network,
        stepper.notes,
        edges,
        drawn,
        explained=stepper.explained,
    )
    del stepper
    give_back(block.mask.size)
    yield Progress(block.label, result=result)


def _and_correct(
    steps: Steps[Progress],
    frame: RGBDFrame,
    extraction: BlockParameters | None,
    threads: int | None,
    uncorrected: dict[int, BlockResult],
) -> Steps[Progress]:
    """The same steps, but that results which are to be corrected are, and come last."""
    waiting: list[BlockResult] = []
    with closing(steps):
        for progress in steps:
            result = progress.result
            if result is not None and _to_be_corrected(result):
                waiting.append(result)
                uncorrected[progress.label] = replace(result, parameters=result.parameters.replace(correction=False))
            else:
                yield progress
    if waiting:
        correction, notes = yield from _correction_steps(frame, extraction, list(uncorrected.values()), threads)
        for result in waiting:
            check_stopped()  # each is either handed over or still waits
            del uncorrected[result.block.label]
            yield Progress(result.block.label, result=_corrected(frame, result, correction, notes))


def _to_be_corrected(result: BlockResult) -> bool:
    """Not a block whose border was drawn by hand: it is what the user has made it, and no depth gets across there. Nor
    one whose known depth a smooth surface explains."""
    own = result.drawn is not None or result.explained
    return corrects(result.parameters) and result.outcome.recovered > 0 and not own


def _corrected(
    frame: RGBDFrame, result: BlockResult, correction: Correction | None, notes: tuple[str, ...]
) -> BlockResult:
    if correction is None:
        return replace(result, notes=(*result.notes, *notes))
    block = result.block
    depth = correction.applied(block, frame.depth[block.box][block.mask], result.depth)
    return replace(result, depth=depth, correction=correction.network)


def _correction_steps(
    frame: RGBDFrame, extraction: BlockParameters | None, ready: list[BlockResult], threads: int | None
) -> Generator[Progress, None, tuple[Correction | None, tuple[str, ...]]]:
    """What the correction network says of a frame, remembered with it, or why it says nothing.

    It depends on the frame and the extraction's parameters alone; results that are `ready` and of blocks as extracted
    spare work.
    """
    chosen = extraction or BlockParameters()
    known = corrections.find(frame, chosen)
    if known is not None or is_guided(frame) or not changes_any(frame.known):
        return known, ()
    edges = edges_for(frame, UNCORRECTED, chosen)
    try:
        network = load_correction_network()
    except InputError as error:
        return None, (f"Depth is not corrected: {error}",)
    if edges is None or edges.network is None:
        return None, ("Depth is not corrected: the network that does so needs those of the edge network.",)
    labels = found_blocks(frame, chosen).blocks
    check_stopped()
    results = _same_blocks(frame, find_blocks(labels), ready)
    rest = set(np.unique(labels[labels > 0]).tolist()) - set(results)
    with CompletionRun(frame, labels, UNCORRECTED, rest, threads, chosen) as run:
        for _ in run:
            yield NO_BLOCK
    completed = compose(frame, results | run.results).depth
    try:
        change = made_of(network.change(frame.rgb, frame.depth, completed, edges.detected), frame.known)
    except InputError as error:
        return None, (f"Depth is not corrected: {error}",)
    give_back(change.size)
    return corrections.keep(frame, chosen, Correction(completed, change, network.sha256)), ()


def _same_blocks(frame: RGBDFrame, blocks: Mapping[int, Block], ready: list[BlockResult]) -> dict[int, BlockResult]:
    """Of the blocks those that have been completed already, as the network is to see them."""
    plain = {
        _place(result.block): _in_view(frame, result)
        for result in ready
        if result.parameters.replace(outside_view=False).same_effect(UNCORRECTED)
    }
    found = {label: plain.get(_place(block)) for label, block in blocks.items()}
    return {label: replace(result, block=blocks[label]) for label, result in found.items() if result is not None}


def _in_view(frame: RGBDFrame, result: BlockResult) -> BlockResult:
    """A result as if nothing outside the view had been asked for."""
    left = frame.left_missing()
    if left is None or not result.parameters.outside_view:
        return result
    block = result.block
    return replace(result, depth=np.where(left[block.box][block.mask], np.float32(np.nan), result.depth))


def _place(block: Block) -> tuple[int, int, bytes]:
    """Other for other pixels."""
    return block.box[0].start, block.box[1].start, np.packbits(block.mask).tobytes()


def _hidden_truth(frame: RGBDFrame, block: Block) -> tuple[NDArray[np.bool_], NDArray[np.float64]] | None:
    """Which of the block's pixels in view have no depth but a truth, and that truth [m]; None if there are none."""
    if frame.truth is None:
        return None
    truth = frame.truth[block.box][block.mask]
    judged = frame.missing[block.box][block.mask] & np.isfinite(truth)
    return (judged, truth[judged].astype(np.float64)) if judged.any() else None


def _parameters_for(parameters: Parameters | Mapping[int, Parameters | str], label: int) -> Parameters:
    if isinstance(parameters, Parameters):
        return parameters
    try:
        return as_parameters(parameters[label])
    except KeyError:
        raise InputError(f"No parameters are given for block {label}.") from None


def _refusal(frame: RGBDFrame, block: Block, parameters: Parameters) -> BlockOutcome | None:
    """Why a block is not iterated on, or None if it is."""
    pixels = int(np.count_nonzero(block.mask))
    known = int(np.count_nonzero(np.isfinite(frame.depth[block.box][block.mask])))
    outside = int(np.count_nonzero(_outside(frame, block)))
    missing = pixels - known - outside * (not parameters.outside_view)
    if missing == 0 and parameters.mode == "fill":
        message = _told_outside(outside, parameters) or "All depth is known."
        return BlockOutcome(block.label, Status.NOTHING_MISSING, message, pixels, known, outside=outside)
    needed = int(known_needed(pixels, parameters))
    if known < needed and not guide_carries(frame, block, parameters):
        message = (
            f"{known} of {pixels} pixels have depth ({known / pixels:.1%}); at least {needed} are needed. "
            "Merge it with a neighbour on the same surface, or lower the limits under Data."
        )
        return BlockOutcome(block.label, Status.NOT_RECOVERABLE, message, pixels, known, outside=outside)
    return None


def known_needed(pixels: ArrayLike, parameters: Parameters) -> NDArray[np.floating]:
    """Known pixels that blocks of so many pixels need at least to be iterated on."""
    share = np.ceil(parameters.min_known_share * np.asarray(pixels))
    return np.minimum(np.maximum(parameters.min_known_pixels, share), pixels)


def block_depth(
    frame: RGBDFrame, block: Block, surface: NDArray[np.float64], parameters: Parameters
) -> NDArray[np.float32]:
    """Raw depth with P_i put in where it is depth at all (> 0): in the defective area, or all over the block; outside
    the depth camera's view only if the parameters ask for it.

    Parameters
    ----------
    frame : RGBDFrame
    block : Block
    surface : ndarray of float64
        P_i [m] at the block's pixels, in the order of `block.mask`'s True values.
    parameters : Parameters
        Their mode and `outside_view`.

    Returns
    -------
    ndarray of float32
        Depth [m] at the same pixels, NaN = missing.
    """
    raw = frame.depth[block.box][block.mask]
    replace = surface > 0
    if parameters.mode == "fill":
        replace &= np.isnan(raw)
    left = frame.left_missing(parameters.outside_view)
    if left is not None:
        replace &= ~left[block.box][block.mask]
    return np.where(replace, surface, raw).astype(np.float32)


def _outside(frame: RGBDFrame, block: Block) -> NDArray[np.bool_]:
    """Which of the block's pixels lie outside the depth camera's view, in the order of `block.mask`'s True values."""
    if frame.outside_view is None:
        return np.zeros(np.count_nonzero(block.mask), bool)
    return frame.outside_view[block.box][block.mask]


def _told_outside(pixels: int, parameters: Parameters) -> str:
    """What becomes of the pixels outside the depth camera's view, as a sentence; "" if there are none."""
    if not pixels:
        return ""
    how = "filled, though nothing could be measured there" if parameters.outside_view else "left missing"
    return f"{counted(pixels, 'pixel')} outside the depth camera's view {how}."


def _outcome(
    frame: RGBDFrame,
    block: Block,
    completed: NDArray[np.float32],
    history: list[IterationRecord],
    stepper: Stepper,
    parameters: Parameters,
) -> BlockOutcome:
    raw = frame.depth[block.box][block.mask]
    outside = _outside(frame, block)
    beyond = int(np.count_nonzero(outside))
    missing = np.isnan(raw) & ~outside
    left = int(np.count_nonzero(missing & np.isnan(completed)))
    message = stepper.remark if stepper.settled else f"Not steady after {len(history)} iterations."
    if left:
        message = f"{message} {left} pixels stay missing: the filter gave no positive depth there.".strip()
    message = f"{message} {_told_outside(beyond, parameters)}".strip()
    return BlockOutcome(
        label=block.label,
        status=Status.COMPLETED if stepper.settled else Status.ITERATION_LIMIT,
        message=message,
        pixels=raw.size,
        known=int(np.count_nonzero(np.isfinite(raw))),
        recovered=int(np.count_nonzero(missing)) - left,
        iterations=len(history),
        stages=history[-1].stage,
        sigma_i=history[-1].sigma_i,
        outside=beyond,
    )
