"""DICP's second half: frame + blocks + parameters -> completed depth."""

from __future__ import annotations

from collections.abc import Collection, Generator, Iterator, Mapping
from contextlib import closing
from dataclasses import replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.cancellation import check_stopped
from .._runtime.threads import Steps
from ..data.blocks import Block, checked_drawn, checked_labels, drawn_of, find_blocks
from ..data.declarations import Value
from ..data.frame import RGBDFrame, checked_frame
from ..data.guide import Guide
from ..data.parameters import BlockParameters, Parameters, as_parameters
from ..data.results import NO_BLOCK, BlockResult, Progress, notes_of
from ..errors import InputError
from .block import BlockTask, Watch, block_depth, filter_steps
from .correction import Base, Correction, find_base, is_to_be_corrected
from .filter import edges_for, make_stepper
from .stepper import Stepper

ParameterChoice = Parameters | str | Mapping[int, Parameters | str]
"""Of all blocks, or block label -> parameters; a text is the name of a preset."""


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
        Pixels of blocks whose border, to another block or to none, was drawn by hand; see
        `ilf.complete`.
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
        borders = checked_drawn(drawn, frame.shape)
        self.blocks = find_blocks(checked_labels(labels, frame.shape), only)
        self.results: dict[int, BlockResult] = {}
        self.uncorrected: dict[int, BlockResult] = {}
        """Blocks that have been iterated on and wait for the correction, as they are without it."""
        choice = parameters if isinstance(parameters, Mapping) else as_parameters(parameters)
        self._tasks = {
            label: BlockTask(
                frame,
                block,
                _parameters_for(choice, label),
                extraction or BlockParameters(),
                drawn_of(block, borders),
            )
            for label, block in self.blocks.items()
        }
        self._live: dict[int, Stepper] = {}
        self._steps = _stages(self._tasks, self._live, self.uncorrected, threads, watch)

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
        running = []
        for label, stepper in list(self._live.items()):
            task = self._tasks[label]
            running.append((task.block, block_depth(task.frame, task.block, stepper.surface, task.parameters)))
        return running + [(result.block, result.depth) for result in list(self.uncorrected.values())]


def iterate(
    frame: RGBDFrame,
    blocks: NDArray[np.integer],
    label: int,
    preset: Parameters | str | None = None,
    *,
    extraction: BlockParameters | None = None,
    drawn: ArrayLike | None = None,
    guide: ArrayLike | Guide | None = None,
    **changes: Value,
) -> Stepper:
    """The stepper of one block: iterate over it for one record per iteration.

    Parameters
    ----------
    frame : RGBDFrame
    blocks : ndarray of int, shape (H, W)
        Label map, 0 = no block.
    label : int
        The block.
    preset : Parameters or str, optional
        Or the name of a preset. The default preset, "best", if left out.
    extraction : BlockParameters, optional
        As in `ilf.complete`.
    drawn : array_like of bool, shape (H, W), optional
        As in `ilf.complete`.
    guide : array_like or Guide, optional
        As in `ilf.complete`.
    **changes
        Any of the `Parameters` by name.

    Returns
    -------
    Stepper
        Its `surface` is P_i at the block's pixels at any time, and its `notes` say what there is to know.

    Raises
    ------
    InputError
        If there is no such block, or it has no known depth at all.
    ParameterError
        For an unknown preset or parameter, or what are no parameters.

    Examples
    --------
    >>> import numpy as np
    >>> import ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> frame = ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth)
    >>> stepper = ilf.iterate(frame, np.ones((20, 30), np.int32), 1, "released-code", max_iterations=3)
    >>> [(record.i, round(record.radii[0], 2)) for record in stepper]
    [(1, 1.0), (2, 1.89), (3, 2.78)]
    >>> stepper.surface.shape
    (600,)
    """
    parameters = as_parameters(preset, **changes)
    found = find_blocks(checked_labels(blocks, checked_frame(frame).shape))
    if label not in found:
        raise InputError(f"There is no block {label}. Blocks: {', '.join(map(str, found)) or 'none'}.")
    block = found[label]
    if not np.isfinite(frame.depth[block.box][block.mask]).any():
        raise InputError(f"Block {label} has no known depth, so there is nothing to iterate on.")
    own = drawn_of(block, checked_drawn(drawn, frame.shape))
    guided = frame if guide is None else frame.with_guide(guide)
    return make_stepper(guided, block, parameters, extraction, own)


def prepare(frame: RGBDFrame, parameters: Parameters, extraction: BlockParameters | None = None) -> None:
    """Work out beforehand what every run of a frame with such parameters needs: the frame's edges, once."""
    edges_for(frame, parameters, extraction)


def _stages(
    tasks: Mapping[int, BlockTask],
    live: dict[int, Stepper],
    uncorrected: dict[int, BlockResult],
    threads: int | None,
    watch: Watch | None,
) -> Steps[Progress]:
    """The way of a run's data: blocks, those that the correction starts from among them, filter, correction."""
    base = find_base([*tasks.values()])
    done: dict[int, BlockResult] = {}
    with closing(filter_steps([*tasks.values()], threads, live, watch)) as steps:
        for progress in steps:
            if (result := progress.result) is not None:
                done[progress.label] = result
                if is_to_be_corrected(result):
                    plain = result.parameters.replace(correction=False)
                    uncorrected[progress.label] = replace(result, parameters=plain)
                    continue
            yield progress
    if not uncorrected:
        return
    correction, notes = yield from _look(base, done, threads)
    for label in list(uncorrected):
        check_stopped()  # each is either handed over or still waits
        del uncorrected[label]
        yield Progress(label, result=_corrected(tasks[label], done[label], correction, notes))


def _look(
    base: Base | Correction | None, done: Mapping[int, BlockResult], threads: int | None
) -> Generator[Progress, None, tuple[Correction | None, tuple[str, ...]]]:
    """What the correction network says of the frame, or why it says nothing; the rest of a base is completed before."""
    if not isinstance(base, Base):
        return base, ()
    try:
        network = base.network()
        results = [done[label] for label in base.own]
        with closing(filter_steps(base.rest, threads, {})) as steps:
            for progress in steps:
                if progress.result is not None:
                    results.append(progress.result)
                yield NO_BLOCK
        return base.correction(network, results), ()
    except InputError as error:
        return None, (f"Depth is not corrected: {error}",)


def _corrected(
    task: BlockTask, result: BlockResult, correction: Correction | None, notes: tuple[str, ...]
) -> BlockResult:
    if correction is None:
        return replace(result, notes=(*result.notes, *notes))
    depth = correction.applied(task.block, task.raw, result.depth)
    return replace(result, depth=depth, correction=correction.network)


def _parameters_for(parameters: Parameters | Mapping[int, Parameters | str], label: int) -> Parameters:
    if isinstance(parameters, Parameters):
        return parameters
    try:
        return as_parameters(parameters[label])
    except KeyError:
        raise InputError(f"No parameters are given for block {label}.") from None
