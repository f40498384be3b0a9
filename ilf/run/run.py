"""A run: all inputs of a completion, its execution step by step, and the completion."""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable, Collection, Generator, Iterator, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.formatting import counted
from .._runtime.long_work import check_cancelled, mapped_steps, run_to_end
from ..completion.block import BlockTask, Watch, block_depth
from ..completion.completion import completed_blocks
from ..completion.extrapolation import extrapolation_steps
from ..completion.stepper import Stepper
from ..data import presets
from ..data.blocks import Block, Blocks, as_blocks, check_labels, find_blocks, labels_in
from ..data.by_hand import USUAL_WEIGHT, DepthByHand
from ..data.declarations import ParameterSet, Value
from ..data.frame import RGBDFrame, checked_frame
from ..data.guide import Guide
from ..data.parameters import BlockParameters, Parameters, nearest_preset
from ..data.pictures import html_row, plot_row
from ..data.presets import chosen_parameters
from ..data.results import BlockResult, Completion, Step, compose
from ..drawing.blocks import block_overlay
from ..errors import InputError, ParameterError, check_kind, warn_of_reading
from ..io.block_files import read_blocks
from ..io.depth_doubts import marker_doubt
from ..io.frame_additions import load_by_hand
from ..io.images import read_mask
from ..segmentation.extraction import clear_stage_cache, found_blocks
from ..segmentation.reextraction import gaps_filled

EXTRAPOLATED = 0
"""In place of a block's label in the `Step` of the extrapolation."""


@dataclass(frozen=True, eq=False, init=False)
class Run:
    """All inputs of a run; its results depend on nothing else.

    Parameters
    ----------
    frame : RGBDFrame
        Including its inputs, if it was read from files, its invalid mask and its guide.
    blocks : Blocks or array_like of int, shape (H, W)
        Blocks with all that is said about them, or a label map, 0 = no block.
    parameters : Parameters or str, optional
        Parameters or preset name for all blocks without own parameters; the preset "best" if left out. `Run.of` takes
        them by keyword.
    only : collection of int, optional
        Run only these blocks; in the order of a sequence if they run one after the other.
    extrapolate : bool
        Whether depth that is still missing after the blocks is extrapolated (`ilf.extrapolate`).

    Raises
    ------
    InputError
        If the label map, the mask of drawn borders or depth by hand does not fit the frame.
    ParameterError
        For an unknown preset or an object that is not parameters.

    Examples
    --------
    >>> import numpy as np
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> run = ilf.Run.of(ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth), max_iterations=20)
    >>> int(run.complete().filled.sum())
    40
    """

    frame: RGBDFrame
    blocks: Blocks
    parameters: Parameters
    only: Collection[int] | None
    extrapolate: bool

    def __init__(
        self,
        frame: RGBDFrame,
        blocks: Blocks | ArrayLike,
        parameters: Parameters | str | None = None,
        only: Collection[int] | None = None,
        extrapolate: bool = False,
    ) -> None:
        if not isinstance(parameters, Parameters):
            parameters = presets.preset(parameters)
        values = checked_frame(frame), as_blocks(blocks, frame.shape), parameters, only, extrapolate
        for name, value in zip(self.__dataclass_fields__, values, strict=True):
            object.__setattr__(self, name, value)

    @classmethod
    def of(
        cls,
        frame: RGBDFrame,
        blocks: Blocks | ArrayLike | None = None,
        preset: Parameters | str | os.PathLike[str] | None = None,
        *,
        own: Mapping[int, Parameters | str] | None = None,
        extraction: BlockParameters | None = None,
        extrapolate: bool = False,
        drawn: ArrayLike | None = None,
        guide: ArrayLike | Guide | None = None,
        by_hand: ArrayLike | DepthByHand | None = None,
        **changes: Value,
    ) -> Self:
        """Make the run that `ilf.complete` executes for the same arguments; warns as that does."""
        if isinstance(blocks, str | ParameterSet):
            raise ParameterError(
                f"The second argument is the label map of the blocks, not {blocks!r:.60}: give presets and parameters "
                "of the filter as preset=, those of the extraction as extraction=."
            )
        keywords = inspect.signature(complete).parameters
        parameters, chosen, of_blocks = chosen_parameters(preset, extraction, changes, *keywords)
        guided = checked_frame(frame) if guide is None else checked_frame(frame).with_guide(guide)
        if frame.inputs is None and (doubt := marker_doubt(frame.measured, frame.measured)):
            constant = f"{frame.name}: a constant depth of {doubt.invalid_depth:.6g} m"
            warn_of_reading(f"{constant} most likely marks missing depth, but counts as measured. Make it NaN.")
        if blocks is None:
            given = found_blocks(guided, chosen)
            clear_stage_cache(guided)
        elif of_blocks:
            told = f"{', '.join(of_blocks)} would have no effect, because blocks are given"
            raise ParameterError(f"{told}: extract them with it by ilf.extract_blocks.")
        else:
            given = as_blocks(blocks, guided.shape)
            if extraction is not None:
                given = replace(given, extraction=extraction, extracted=None)
        added: dict[str, Any] = {"drawn": drawn, "by_hand": by_hand}
        given = replace(given, **{name: value for name, value in added.items() if value is not None})
        if own is not None:
            check_labels(own, labels_in(given.labels))
            given = given.with_parameters({label: presets.preset(one) for label, one in own.items()}, parameters)
        return cls(guided, given, parameters, extrapolate=extrapolate)._checked()

    def _checked(self) -> Self:
        """The same; raises InputError if depth by hand counts nowhere."""
        if self.blocks.by_hand is not None:
            self.blocks.by_hand.check_counts(self.frame, self.blocks.labels)
        return self

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {self.summary()}>"

    def summary(self) -> str:
        """Return name and size of the frame, number of blocks and parameters, in one line."""
        height, width = self.frame.shape
        count = np.count_nonzero(np.unique(self.blocks.labels))
        preset = nearest_preset(self.parameters).text(most=3)
        own = f", {counted(len(self.blocks.own), 'block')} with own parameters" if self.blocks.own else ""
        return f"{self.frame.name!r}: {width} x {height} pixels, {counted(count, 'block')}, {preset}{own}"

    def _repr_html_(self) -> str:
        return html_row(self.summary(), self._images())

    def plot(self) -> NDArray[Any]:
        """Plot colour, blocks and depth by matplotlib.

        Returns
        -------
        ndarray of matplotlib.axes.Axes, shape (3,)
            `axes[0].figure` is the figure.

        Raises
        ------
        InputError
            If matplotlib is not installed (extra `plot`).
        """
        return plot_row(self._images())

    def _images(self) -> dict[str, NDArray[Any]]:
        blocks = block_overlay(self.frame.rgb, self.blocks.labels)
        return {"Colour": self.frame.rgb, "Blocks": blocks, "Depth": self.frame.depth}

    def parameters_of(self, label: int) -> Parameters:
        """Parameters of a block."""
        return self.blocks.parameters_of(label, self.parameters)

    def with_parameters(self, parameters: Parameters, own: Mapping[int, Parameters] | None = None) -> Self:
        """Return the run with other common parameters and own ones; other blocks with own parameters keep theirs."""
        kept = {label: self.parameters_of(label) for label in self.blocks.own}
        blocks = self.blocks.with_parameters({**kept, **(own or {})}, parameters)
        return replace(self, blocks=blocks, parameters=parameters)

    def steps(self, threads: int | None = None, watch: Watch | None = None) -> Execution:
        """Execute the run step by step, for progress and cancellation.

        Parameters
        ----------
        threads : int, optional
            Number of blocks that run at the same time; the number of cores if left out. It does not affect the result.
            With 1 they run one after the other in the caller's thread, and each `next()` is exactly one iteration.
        watch : callable, optional
            A `Watch`, called after every iteration of a block, in its thread; the run waits for it.
        """
        return Execution(self, threads, watch)

    def complete(self, *, on_progress: Callable[[Step], None] | None = None, threads: int | None = None) -> Completion:
        """Run to the end.

        Parameters
        ----------
        on_progress : callable, optional
            Called with every `Step`; an exception in it stops the run.
        threads : int, optional
            As in `steps`.

        Returns
        -------
        Completion
            Blocks without enough known depth are reported in its `outcomes` and stay missing, unless the run is dense.
        """
        with self.steps(threads) as steps:
            for progress in steps:
                if on_progress is not None:
                    on_progress(progress)
        return steps.completion()


@dataclass(frozen=True)
class BlockChoice:
    """How any frame gets the blocks of its run: extracted, or read from files.

    Parameters
    ----------
    extraction : BlockParameters
        The defaults if left out.
    file : str, optional
        Path of existing blocks (`ilf.io.block_files.read_blocks`); they are extracted if left out.
    fill_gaps : bool
        Whether blocks are extracted where the file has none.
    drawn : str, optional
        Path of the mask of pixels whose border was drawn by hand.
    by_hand : str, optional
        Path of depth by hand, in the encoding of the frame's depth or, as floating-point numbers, in metres.
    by_hand_weight : float
        Its weight.
    """

    extraction: BlockParameters = field(default_factory=BlockParameters)
    file: str | None = None
    fill_gaps: bool = False
    drawn: str | None = None
    by_hand: str | None = None
    by_hand_weight: float = USUAL_WEIGHT

    def run_of(self, frame: RGBDFrame, parameters: Parameters | None = None, extrapolate: bool = False) -> Run:
        """Make the run of a frame. Intermediate results of the extraction are not cached.

        Raises
        ------
        InputError
            If a given file cannot be read or does not fit the frame, or there are no blocks.
        """
        blocks = self._extracted_or_read(frame)
        if not blocks.labels.any():
            remedy = (
                "Lower min_size or min_known_share of the extraction, or give blocks."
                if self.file is None or self.fill_gaps
                else f"{self.file} contains none: give a file with blocks, or fill its gaps."
            )
            raise InputError(f"There are no blocks to complete. {remedy}")
        drawn = None if self.drawn is None else read_mask(self.drawn, frame.shape)
        by_hand = None if self.by_hand is None else load_by_hand(self.by_hand, frame, self.by_hand_weight)
        blocks = replace(blocks, drawn=drawn, by_hand=by_hand)
        return Run(frame, blocks, parameters, extrapolate=extrapolate)._checked()

    def _extracted_or_read(self, frame: RGBDFrame) -> Blocks:
        if self.file is None:
            blocks = found_blocks(frame, self.extraction)
        else:
            image = None if frame.inputs is None else frame.inputs.rgb.path
            given = read_blocks(self.file, frame.shape, image=image)
            if not self.fill_gaps:
                return given
            blocks = gaps_filled(given, frame, self.extraction)
        clear_stage_cache(frame)
        return blocks


class Execution(AbstractContextManager["Execution"], Iterator[Step]):
    """All steps of a run: those of its blocks, then those of the extrapolation if it is dense.

    The caller controls pace, pause and cancellation: without calls of `next()`, only a few short slices of iterations
    are computed ahead. `results` contains the finished blocks, in any order; it does not depend on the number of
    threads. Corrected blocks come last, when all have been iterated on; steps in between belong to no block. A run that
    is abandoned must be closed, by `close` or as a context manager.

    Parameters
    ----------
    run : Run
    threads, watch
        As for `Run.steps`.
    """

    def __init__(self, run: Run, threads: int | None, watch: Watch | None) -> None:
        self.blocks = find_blocks(run.blocks.labels, run.only)
        self.results: dict[int, BlockResult] = {}
        self.uncorrected: dict[int, BlockResult] = {}
        """Blocks that have been iterated on and wait for the correction, with their uncorrected depth."""
        self._run = run
        self._tasks = {
            label: BlockTask.of(run.frame, block, run.parameters_of(label), run.blocks)
            for label, block in self.blocks.items()
        }
        self._live: dict[int, Stepper] = {}
        self._dense: Completion | None = None
        # a function, so that an execution that nobody has any more ends
        self._steps = _steps(
            run, completed_blocks(self._tasks, self._live, self.uncorrected, threads, watch), self.results
        )

    def __next__(self) -> Step:
        check_cancelled()
        try:
            progress = next(self._steps)
        except StopIteration as end:
            self._dense = self._dense or end.value
            raise
        if progress.result is not None:
            self.results[progress.label] = progress.result
        return progress

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the run and wait for its threads. Call it from the same thread as `next()`."""
        self._steps.close()
        self._live.clear()

    def preview(self) -> list[tuple[Block, NDArray[np.float32]]]:
        """The running blocks, including those that wait for the correction, with their current depth [m]. From any
        thread."""
        running = []
        for label, stepper in list(self._live.items()):
            task = self._tasks[label]
            running.append((task.block, block_depth(task.frame, task.block, stepper.surface, task.parameters)))
        return running + [(result.block, result.depth) for result in list(self.uncorrected.values())]

    def completion(self) -> Completion:
        """The frame's depth, as far as it is completed, with the notes on the blocks."""
        found = self._dense or compose(self._run, self.results)
        return replace(found, notes=tuple(dict.fromkeys((*self._run.blocks.notes, *found.notes))))


def _steps(
    run: Run, blocks: Generator[Step, None, None], results: Mapping[int, BlockResult]
) -> Generator[Step, None, Completion | None]:
    """The steps of blocks, whose results are in `results` then, and those of the extrapolation if the run is dense;
    returns the dense completion."""
    yield from blocks
    if not run.extrapolate:
        return None
    steps = extrapolation_steps(compose(run, results))
    return (yield from mapped_steps(steps, lambda record: Step(EXTRAPOLATED, record=record)))


# `ilf.complete`, and the optional extrapolation.


def complete(
    frame: RGBDFrame,
    blocks: Blocks | ArrayLike | None = None,
    preset: Parameters | str | os.PathLike[str] | None = None,
    *,
    own: Mapping[int, Parameters | str] | None = None,
    extraction: BlockParameters | None = None,
    extrapolate: bool = False,
    drawn: ArrayLike | None = None,
    guide: ArrayLike | Guide | None = None,
    by_hand: ArrayLike | DepthByHand | None = None,
    on_progress: Callable[[Step], None] | None = None,
    threads: int | None = None,
    **changes: Value,
) -> Completion:
    """Complete the depth of a frame by iterative low-pass filtering, block by block (section 3).

    Parameters
    ----------
    frame : RGBDFrame
    blocks : Blocks or array_like of int, shape (H, W), optional
        Label map, 0 = no block; a bool mask is one block. Extracted from the frame if left out. With `Blocks`, what
        they say counts where none of the keywords does.
    preset : Parameters or str, optional
        Parameters of the filter, or a preset by name (`ilf.PRESETS`, or your own) or file, with its parameters of the
        extraction; "best" if left out.
    own : mapping of int to Parameters or str, optional
        Block label -> own parameters.
    extraction : BlockParameters, optional
        Parameters of the blocks' extraction, now or earlier; the defaults if left out. The filter uses the same edges.
    extrapolate : bool
        Whether depth that is still missing after the blocks is extrapolated, as by `ilf.extrapolate`.
    drawn : array_like of bool, shape (H, W), optional
        Pixels of blocks whose border, to another block or to none, was drawn by hand: no depth crosses it. A block's
        result depends only on its own pixels of these. The pass band ignores them, since it sees nothing beyond a
        block.
    guide : array_like or Guide, optional
        Depth or inverse depth of the frame, metric or relative, shape (H, W) or of the same aspect: from a monocular
        depth network or another sensor. The frame's own, if any, if left out. NaN, infinite and zero values are
        ignored. The edge-aware filter follows it as far as the known depth supports it; the pass band ignores it.
    by_hand : array_like or DepthByHand, optional
        Depth [m] that you state, shape (H, W), NaN or 0 = none, as a constraint with a weight. It counts in blocks
        where depth is missing or marked invalid, and lets a block with too little known depth be completed. It never
        counts as measured: the result is filled and unsupported there (`Completion.by_hand`). The pass band treats it
        as known depth.
    on_progress : callable, optional
        Called with every `Step` (`ilf.data.results`), in this thread: the block's label and the record of an
        iteration, or the block's result. Raise `ilf.Cancelled` in it to stop.
    threads : int, optional
        Number of blocks that run at the same time; the number of cores if left out. It does not affect the result.
    **changes
        Any of the `Parameters`, by name, and, if blocks are extracted, any of the `BlockParameters` with another name.

    Returns
    -------
    Completion
        Blocks without enough known depth are reported in `outcomes` and stay missing.

    Raises
    ------
    InputError
        If label map, drawn borders or depth by hand do not fit the frame, depth by hand counts nowhere, or there is no
        block that is to have own parameters.
    ParameterError
        For an unknown preset or parameter, a value out of range, a parameter without effect in combination with the
        others, or an object that is not parameters.

    Warns
    -----
    DepthWarning
        If a constant in a frame that was not read from files most likely marks missing depth, such as 65.535 m.

    Examples
    --------
    >>> import numpy as np
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
    >>> ilf.complete(frame)
    <Completion of 'frame': 30 x 20 pixels, 1 block, 40 pixels filled, 0 still missing>
    >>> result = ilf.complete(frame, np.ones((20, 30), np.int32), "paper", max_iterations=50)
    >>> round(float(result.depth[10, 15]), 3), result.outcomes[1].iterations
    (2.0, 24)
    """
    run = Run.of(
        frame,
        blocks,
        preset,
        own=own,
        extraction=extraction,
        extrapolate=extrapolate,
        drawn=drawn,
        guide=guide,
        by_hand=by_hand,
        **changes,
    )
    return run.complete(on_progress=on_progress, threads=threads)


def extrapolate(completion: Completion) -> Completion:
    """Extrapolate the depth that is still missing: between blocks, in the margin, and in blocks with too little data.

    The completed frame is treated as one block whose surfaces end at edges. The result is unsupported by measurements:
    it is for programs that need dense depth. `ilf.complete` with `extrapolate=True` gives the same.

    Parameters
    ----------
    completion : Completion

    Returns
    -------
    Completion
        Without missing pixels, except those outside the depth camera's view unless the run's parameters include them;
        `extrapolated` is the mask of pixels filled by this step. All other depth is unchanged.

    Examples
    --------
    >>> import numpy as np, ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[5:9, 5:9] = 0
    >>> frame = ilf.RGBDFrame(rgb=np.zeros((20, 30, 3), np.uint8), depth=depth)
    >>> nothing_run = ilf.complete(frame, np.zeros((20, 30), int))
    >>> int(ilf.extrapolate(nothing_run).extrapolated.sum())
    16
    """
    check_kind(completion, Completion, "The first argument must be a completion", "give what ilf.complete returns.")
    return run_to_end(extrapolation_steps(completion))
