"""Completion of the blocks of a frame: whether its guide is followed, the filters (`block`), the correction."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from contextlib import closing
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .._runtime.long_work import Steps, check_cancelled, run_beside, run_to_end
from ..data import presets
from ..data.blocks import Blocks, as_blocks, check_labels, find_blocks
from ..data.declarations import Value
from ..data.frame import RGBDFrame, checked_frame
from ..data.frame_cache import FrameCache, once_per_frame
from ..data.guide import Guide
from ..data.parameters import BlockParameters, Parameters
from ..data.results import NO_BLOCK, BlockResult, Step
from ..errors import InputError
from ..segmentation.extraction import found_blocks
from .block import BlockTask, Watch, filter_steps, is_guided
from .correction import BaseCompletion, Correction, correction_networks, find_base_completion, needs_correction
from .edge_aware.fitted_guide import fit_guide
from .guide_hold_out import GuideHoldOut, HeldOut, decided, held_out_frames, ranges_of_all
from .stepper import Stepper


def iterate(
    frame: RGBDFrame,
    blocks: Blocks | ArrayLike,
    label: int,
    preset: Parameters | str | None = None,
    *,
    extraction: BlockParameters | None = None,
    guide: ArrayLike | Guide | None = None,
    **changes: Value,
) -> Stepper:
    """Make the stepper of one block; iterating over it gives one record per iteration.

    Parameters
    ----------
    frame : RGBDFrame
    blocks : Blocks or array_like of int, shape (H, W)
        Label map, 0 = no block; with `Blocks`, what they say about the block counts.
    label : int
        The block.
    preset : Parameters or str, optional
        Parameters or the name of a preset; "best" if left out.
    extraction : BlockParameters, optional
        As in `ilf.complete`.
    guide : array_like or Guide, optional
        As in `ilf.complete`.
    **changes
        Any of the `Parameters`, by name.

    Returns
    -------
    Stepper
        Its `surface` is P_i at the block's pixels at any time; its `notes` are sentences for the user.

    Raises
    ------
    InputError
        If there is no such block, or it has no known depth.
    ParameterError
        For an unknown preset or parameter, or an object that is not parameters.

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
    parameters = presets.preset(preset, **changes)
    given = as_blocks(blocks, checked_frame(frame).shape)
    given = given if extraction is None else replace(given, extraction=extraction)
    found = find_blocks(given.labels)
    check_labels([label], found)
    task = BlockTask.of(frame if guide is None else frame.with_guide(guide), found[label], parameters, given)
    if task.by_hand is None and not np.isfinite(task.raw).any():
        raise InputError(f"Block {label} has no known depth to iterate on. Select another block.")
    if parameters.filter == "edge-aware" and task.frame.guide is not None:
        followed = guide_hold_out(task.frame).everywhere
        task = task if followed else replace(task, frame=_without_guide(task.frame))
    return task.stepper()


def completed_blocks(
    tasks: Mapping[int, BlockTask],
    live: dict[int, Stepper],
    uncorrected: dict[int, BlockResult],
    threads: int | None,
    watch: Watch | None,
) -> Steps[Step]:
    """Complete blocks, in stages: decide whether to follow the guide, filter the blocks, then correct."""
    frame = next((task.frame for task in tasks.values() if task.parameters.filter == "edge-aware"), None)
    test = None if frame is None or frame.guide is None else (yield from _hold_out_guide(frame, threads))
    if frame is None or test is None or test.everywhere:
        yield from _completed(tasks, live, uncorrected, threads, watch)
        return
    # also where the belief is 0: a block is filled from its frame without suspect depth, of which it may be larger
    bare, note = _without_guide(frame), f"The guide is {guide_text(frame)}."
    without = {label: replace(task, frame=bare, notes=(note,)) for label, task in tasks.items()}
    guided = (yield from _depths(tasks, threads)) if test.followed else {}
    with closing(_completed(without, live, uncorrected, threads, watch)) as steps:
        for step in steps:
            if (result := step.result) is not None and step.label in guided:
                depth = test.ranges.mixed(guided[step.label], result.depth)
                step = replace(step, result=replace(result, depth=depth))
            yield step


def _depths(
    tasks: Mapping[int, BlockTask], threads: int | None
) -> Generator[Step, None, dict[int, NDArray[np.float32]]]:
    """Depth [m] of the pixels of each block with its frame as it is; as steps of no block."""
    depths = {}
    with closing(_completed(tasks, {}, {}, threads, None)) as steps:
        for progress in steps:
            if progress.result is not None:
                depths[progress.label] = progress.result.depth
            yield NO_BLOCK
    return depths


_guide_hold_outs = FrameCache[RGBDFrame, GuideHoldOut]()
"""Cache by frame; the key is None."""


@once_per_frame
def _without_guide(frame: RGBDFrame) -> RGBDFrame:
    return frame.with_guide(None)


def guide_hold_out(frame: RGBDFrame) -> GuideHoldOut:
    """Test a frame's guide: hide known depth where the frame's own gaps lie when they are turned, complete it with the
    guide and without it, and compare. Computed once per frame. The quick test of `fit_guide` decides alone where it is
    against the guide, or no depth can be hidden.

    Parameters
    ----------
    frame : RGBDFrame
        With a guide.
    """
    return run_to_end(_hold_out_guide(frame, None), lambda _: check_cancelled())


def guide_text(frame: RGBDFrame) -> str:
    """Describe, after "The guide is", how a frame's guide is used, and why.

    Parameters
    ----------
    frame : RGBDFrame
        With a guide.
    """
    test = guide_hold_out(frame)
    return test.to_text() if test.compared else fit_guide(frame).to_text()


def _hold_out_guide(frame: RGBDFrame, threads: int | None) -> Generator[Step, None, GuideHoldOut]:
    known = _guide_hold_outs.find(frame, None)
    if known is not None:
        return known
    tested: list[HeldOut] = []
    for held_out in held_out_frames(frame) if is_guided(frame) else ():
        depths = []
        for one in (held_out, _without_guide(held_out)):
            depths.append((yield from _complete_as_extracted(one, threads)))
        tested.append(HeldOut.of(frame, held_out, *depths))
        if not tested[-1].better and not any(ranges_of_all(tested)):
            break
    return _guide_hold_outs.keep(frame, None, decided(tested, is_guided(frame)))


def _complete_as_extracted(frame: RGBDFrame, threads: int | None) -> Generator[Step, None, NDArray[np.float32]]:
    """Depth [m] of a frame with its blocks as extracted, completed by the default preset; as steps of no block."""
    extraction = BlockParameters()
    blocks = find_blocks(found_blocks(frame, extraction).labels)
    tasks = {label: BlockTask(frame, block, Parameters(), extraction) for label, block in blocks.items()}
    depth = frame.depth.copy()
    for label, found in (yield from _depths(tasks, threads)).items():
        depth[blocks[label].box][blocks[label].mask] = found
    return depth


def _completed(
    tasks: Mapping[int, BlockTask],
    live: dict[int, Stepper],
    uncorrected: dict[int, BlockResult],
    threads: int | None,
    watch: Watch | None,
) -> Steps[Step]:
    """Filter the blocks, including those that the correction starts from, then correct."""
    done: dict[int, BlockResult] = {}
    everything = [*tasks.values()]
    with (
        run_beside(partial(find_base_completion, everything)) as base,
        closing(filter_steps(everything, threads, live, watch)) as steps,
    ):
        for progress in steps:
            if (result := progress.result) is not None:
                done[progress.label] = result
                if needs_correction(result):
                    plain = result.parameters.replace(correction=False)
                    uncorrected[progress.label] = replace(result, parameters=plain)
                    continue
            yield progress
    if not uncorrected:
        return
    correction, notes = yield from _compute_correction(base.result(), done, threads)
    for label in list(uncorrected):
        check_cancelled()  # every block has either been yielded or still waits
        del uncorrected[label]
        yield Step(label, result=_corrected(tasks[label], done[label], correction, notes))


def _compute_correction(
    base: BaseCompletion | Correction | None, done: Mapping[int, BlockResult], threads: int | None
) -> Generator[Step, None, tuple[Correction | None, tuple[str, ...]]]:
    """Complete the rest of a base and run the correction networks; the correction or None, and notes on why not."""
    if not isinstance(base, BaseCompletion):
        return base, ()
    try:
        networks = correction_networks(base.frame, base.edges)
        results = [done[label] for label in base.own]
        with closing(filter_steps(base.rest, threads, {})) as steps:
            for progress in steps:
                if progress.result is not None:
                    results.append(progress.result)
                yield NO_BLOCK
        return base.correction(networks, results), ()
    except InputError as error:
        return None, (f"Depth is not corrected: {error}",)


def _corrected(
    task: BlockTask, result: BlockResult, correction: Correction | None, notes: tuple[str, ...]
) -> BlockResult:
    if correction is None:
        return replace(result, notes=(*result.notes, *notes))
    depth = correction.applied(task.block, task.raw, result.depth, task.by_hand)
    return replace(result, depth=depth, correction=correction.networks)
