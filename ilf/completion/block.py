"""Completion of one block, and of several blocks at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.formatting import counted, grouped
from .._runtime.long_work import Steps, available_cores, run_in_parallel
from .._runtime.memory import release_memory
from ..data.blocks import Block, Blocks, least_known_pixels
from ..data.by_hand import DepthByHand
from ..data.frame import RGBDFrame
from ..data.parameters import BlockParameters, Parameters
from ..data.results import BlockOutcome, BlockResult, IterationRecord, Status, Step
from ..segmentation.edges.frame_edges import FrameEdges, edge_parameters, edges_for
from .edge_aware.fitted_guide import fit_guide
from .edge_aware.iteration import EdgeAwareIteration
from .edge_aware.view import max_window
from .pass_band.iteration import PassBandIteration
from .rims import depth_at_rims
from .stepper import Stepper
from .suspects import frame_for, suspects_in

_MAX_PIXELS, _MAX_FRAMES = 1 << 23, 1.2
"""Maximum number of pixels processed at a time: this many, or this multiple of the frame's pixels if that is more. Each
needs about 70 bytes, whatever the number of threads."""

Watch = Callable[[Block, IterationRecord, Stepper], None]
"""Called after every iteration, in its thread, with the block, the record and the stepper."""

EdgesOf = Callable[[RGBDFrame, Parameters, BlockParameters], FrameEdges | None]
"""`edges_for`, or a cached version of it."""


@dataclass(frozen=True, eq=False)
class BlockTask:
    """A block to be completed, with everything that its result depends on.

    Attributes
    ----------
    frame : RGBDFrame
    block : Block
    parameters : Parameters
    extraction : BlockParameters
        Its parameters for Canny and depth jumps determine the filter's edges.
    drawn : ndarray of bool or None
        The block's pixels whose border was drawn by hand, in the order of `block.mask`'s True values; None for none.
    by_hand : DepthByHand or None
        Depth by hand at the block's missing pixels, in the same order; None for none.
    notes : tuple of str
        Notes for the user on the frame.
    found : FrameEdges or None
        The filter's edges, if they are not to be found in the frame.
    carried : ndarray of float32, shape (H, W), or None
        Depth [m] expected from the previous frame of a sequence, NaN = none.
    """

    frame: RGBDFrame
    block: Block
    parameters: Parameters
    extraction: BlockParameters
    drawn: NDArray[np.bool_] | None = None
    by_hand: DepthByHand | None = None
    notes: tuple[str, ...] = ()
    found: FrameEdges | None = None
    carried: NDArray[np.float32] | None = None

    @classmethod
    def of(cls, frame: RGBDFrame, block: Block, parameters: Parameters, blocks: Blocks) -> Self:
        """The task of one of a frame's blocks, with what is said about it."""
        extraction = blocks.extraction or BlockParameters()
        return cls(frame, block, parameters, extraction, blocks.drawn_of(block), blocks.by_hand_of(block, frame))

    @property
    def raw(self) -> NDArray[np.float32]:
        """Known depth [m] at the block's pixels, in the order of `block.mask`'s True values; NaN = missing."""
        return self.frame.depth[self.block.box][self.block.mask]

    @property
    def outside(self) -> NDArray[np.bool_]:
        """Which of the block's pixels lie outside the depth camera's view, in the same order."""
        if self.frame.outside_view is None:
            return np.zeros(np.count_nonzero(self.block.mask), bool)
        return self.frame.outside_view[self.block.box][self.block.mask]

    def stepper(self, edges_of: EdgesOf = edges_for) -> Stepper:
        """The stepper of the block: at least one pixel has known depth, unless a guide suffices or there is depth by
        hand."""
        frame, block, parameters = self.frame, self.block, self.parameters
        edges = self.found or edges_of(frame, parameters, self.extraction)
        if edges is None:
            return PassBandIteration(frame, block, parameters, self.by_hand)
        trusted = frame_for(frame, block, parameters)
        return EdgeAwareIteration(trusted, block, parameters, edges, self.drawn, self.by_hand, self.carried)

    def steps(self, edges_of: EdgesOf, live: dict[int, Stepper], watch: Watch | None) -> Steps[Step]:
        """All iterations, and the result at the end; meanwhile the stepper is in `live`."""
        block, parameters = self.block, self.parameters
        edges = edge_parameters(parameters, self.extraction)
        rejected = self._rejected_outcome()
        if rejected is not None:
            result = BlockResult(block, self.raw, rejected, (), parameters, edges=edges, drawn=self.drawn)
            yield Step(block.label, result=result)
            return
        stepper = self.stepper(edges_of)
        live[block.label] = stepper
        history: list[IterationRecord] = []
        ground_truth = self._hidden_truth()
        if ground_truth is not None:
            stepper.evaluate(*ground_truth)
        for record in stepper:
            history.append(record)
            if watch is not None:
                watch(block, record, stepper)
            yield Step(block.label, record=record)
        del live[block.label]
        depth = self._sharpened(block_depth(self.frame, block, stepper.surface, parameters))
        result = BlockResult(
            block,
            depth,
            self._outcome(depth, history, stepper),
            tuple(history),
            parameters,
            stepper.network,
            (*stepper.notes, *self.notes),
            edges,
            self.drawn,
            explained=stepper.explained,
            by_hand=self.by_hand,
        )
        del stepper
        release_memory(block.mask.size)
        yield Step(block.label, result=result)

    def _sharpened(self, depth: NDArray[np.float32]) -> NDArray[np.float32]:
        """Completed depth [m] with that of colour at rims of gaps at jumps, unless a guide is followed."""
        parameters = self.parameters
        at_jumps = parameters.filter == "edge-aware" and parameters.mode == "fill" and parameters.jump_share > 0
        if not at_jumps or self.frame.guide is not None:
            return depth
        by_colour = depth_at_rims(frame_for(self.frame, self.block, parameters), self.block, self.drawn)
        changed = np.isfinite(by_colour) & np.isnan(self.raw) & np.isfinite(depth)  # what is left missing stays so
        if self.by_hand is not None:
            changed &= ~self.by_hand.pixels
        return np.where(changed, by_colour, depth)

    def _rejected_outcome(self) -> BlockOutcome | None:
        """The outcome of a block that is not iterated on; None if it is."""
        label, parameters, raw = self.block.label, self.parameters, self.raw
        pixels, known = raw.size, int(np.count_nonzero(np.isfinite(raw)))
        outside = int(np.count_nonzero(self.outside))
        missing = pixels - known - outside * (not parameters.outside_view)
        if missing == 0 and parameters.mode == "fill":
            message = self._outside_note(outside) or "All depth is known."
            return BlockOutcome(label, Status.NOTHING_MISSING, message, pixels, known, outside=outside)
        density = np.count_nonzero(self.frame.known) / self.frame.known.size
        needed = int(required_known_pixels(pixels, parameters, density))
        if known < needed and self.by_hand is None and not self._guide_suffices():
            message = (
                f"{grouped(known)} of {counted(pixels, 'pixel')} have depth ({known / pixels:.1%}); at least "
                f"{grouped(needed)} are needed. "
                "Merge it with a neighbour on the same surface, give it depth by hand, or lower the limits under Data."
            )
            return BlockOutcome(label, Status.NOT_RECOVERABLE, message, pixels, known, outside=outside)
        return None

    def _guide_suffices(self) -> bool:
        """Whether the belief in the frame's guide is high enough to complete the block with hardly any known depth."""
        guided = self.parameters.filter == "edge-aware" and self.frame.guide is not None
        return guided and fit_guide(self.frame).suffices_for(self.block)

    def _outcome(
        self, completed: NDArray[np.float32], history: Sequence[IterationRecord], stepper: Stepper
    ) -> BlockOutcome:
        raw, outside = self.raw, self.outside
        beyond = int(np.count_nonzero(outside))
        missing = np.isnan(raw) & ~outside
        left = int(np.count_nonzero(missing & np.isnan(completed)))
        by_hand = 0 if self.by_hand is None else int(np.count_nonzero(self.by_hand.pixels))
        suspect = int(np.count_nonzero(suspects_in(self.frame, self.block, self.parameters)))
        sentences = (
            stepper.remark if stepper.settled else f"Not steady after {len(history)} iterations.",
            f"{counted(left, 'pixel')} left missing: the filter gave no positive depth there." if left else "",
            f"{counted(by_hand, 'pixel')} by hand." if by_hand else "",
            f"{counted(suspect, 'suspect pixel')} left out of the fill." if suspect else "",
            self._outside_note(beyond),
        )
        return BlockOutcome(
            label=self.block.label,
            status=Status.COMPLETED if stepper.settled and not stepper.remark else Status.ITERATION_LIMIT,
            message=" ".join(filter(None, sentences)),
            pixels=raw.size,
            known=int(np.count_nonzero(np.isfinite(raw))),
            recovered=int(np.count_nonzero(missing)) - left,
            iterations=len(history),
            stages=history[-1].stage,
            sigma_i=history[-1].sigma_i,
            outside=beyond,
            by_hand=by_hand,
            suspect=suspect,
        )

    def _outside_note(self, pixels: int) -> str:
        """A sentence on how pixels outside the depth camera's view are treated; "" if there are none."""
        if not pixels:
            return ""
        filled = self.parameters.outside_view
        how = "filled, although not measurable" if filled else "left missing"
        return f"{counted(pixels, 'pixel')} outside the depth camera's view {how}."

    def _hidden_truth(self) -> tuple[NDArray[np.bool_], NDArray[np.float64]] | None:
        """Which of the block's pixels in view lack depth but have ground truth, and that truth [m]; None if none do."""
        if self.frame.ground_truth is None:
            return None
        ground_truth = self.frame.ground_truth[self.block.box][self.block.mask]
        evaluated = self.frame.missing[self.block.box][self.block.mask] & np.isfinite(ground_truth)
        return (evaluated, ground_truth[evaluated].astype(np.float64)) if evaluated.any() else None


def filter_steps(
    tasks: Sequence[BlockTask], threads: int | None, live: dict[int, Stepper], watch: Watch | None = None
) -> Steps[Step]:
    """All iterations and results of some blocks of a frame, in any order if several threads run.

    Parameters
    ----------
    tasks : sequence of BlockTask
        In the order of completion if they run one after the other.
    threads : int or None
        Number of blocks completed at the same time; None for the number of cores. With 1 they are completed one after
        the other in the caller's thread, one step at a time.
    live : dict of label to Stepper
        The running steppers; filled and emptied here.
    watch : Watch, optional
    """
    # check a network's file once, not for every block
    edges_of = cache(edges_for)
    width = min(available_cores() if threads is None else threads, len(tasks))
    if width <= 1:
        return (step for task in tasks for step in task.steps(edges_of, live, watch))
    sizes = {task.block.label: max_pixels(task.frame, task.block, task.parameters) for task in tasks}
    largest_first = sorted(tasks, key=lambda task: sizes[task.block.label], reverse=True)
    return run_in_parallel(
        [task.steps(edges_of, live, watch) for task in largest_first],
        width,
        [sizes[task.block.label] for task in largest_first],
        max(_MAX_PIXELS, _MAX_FRAMES * tasks[0].frame.depth.size),
    )


def max_pixels(frame: RGBDFrame, block: Block, parameters: Parameters) -> int:
    """Maximum number of pixels that a block's stepper processes; its memory is proportional to it."""
    if parameters.filter != "edge-aware":
        return block.mask.size
    rows, columns = max_window(frame.shape, block.box, parameters.mode)
    return (rows.stop - rows.start) * (columns.stop - columns.start)


def is_guided(frame: RGBDFrame) -> bool:
    """Whether the frame has a guide with a belief above 0."""
    return frame.guide is not None and fit_guide(frame).belief > 0


def required_known_pixels(pixels: ArrayLike, parameters: Parameters, density: float = 1.0) -> NDArray[np.floating]:
    """Minimum number of known pixels that blocks of these sizes [px] need to be iterated on, in a frame with this
    fraction of pixels with depth."""
    # the pass band, unlike the edge-aware filter, sees no depth beyond the block
    density = density if parameters.filter == "edge-aware" else 1.0
    return least_known_pixels(pixels, parameters.min_known_share, parameters.min_known_pixels, density)


def block_depth(
    frame: RGBDFrame, block: Block, surface: NDArray[np.float64], parameters: Parameters
) -> NDArray[np.float32]:
    """Raw depth with P_i inserted where it is positive: in the defective area, where the frame itself has measured
    nothing, or in the whole block; outside the depth camera's view only if enabled in the parameters.

    Parameters
    ----------
    frame : RGBDFrame
    block : Block
    surface : ndarray of float64
        P_i [m] at the block's pixels, in the order of `block.mask`'s True values.
    parameters : Parameters
        Of these, `mode` and `outside_view`.

    Returns
    -------
    ndarray of float32
        Depth [m] at the same pixels, NaN = missing.
    """
    raw = frame.depth[block.box][block.mask]
    replace = surface > 0
    if parameters.mode == "fill":
        replace &= ~frame.own[block.box][block.mask]
    else:
        replace &= ~suspects_in(frame, block, parameters)
    left = frame.unfilled_mask(parameters.outside_view)
    if left is not None:
        replace &= ~left[block.box][block.mask]
    return np.where(replace, surface, raw).astype(np.float32)
