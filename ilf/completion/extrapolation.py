"""The optional last step for people who need depth at every pixel: guesses where no block could be completed."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

import numpy as np

from ..data.frame import RGBDFrame
from ..data.parameters import BlockParameters, preset
from ..data.results import Completion, IterationRecord
from .completion import iterate


def fill_rest(
    frame: RGBDFrame,
    completion: Completion,
    *,
    extraction: BlockParameters | None = None,
    outside_view: bool = False,
) -> Completion:
    """Guess the depth that is still missing: between blocks, in their margin, and in blocks too poor in data.

    The frame as it is completed so far is taken for one block whose surfaces end at edges. Nothing vouches for the
    result: it is for programs that cannot do with gaps.

    Parameters
    ----------
    frame : RGBDFrame
    completion : Completion
        Of that frame.
    extraction : BlockParameters, optional
        As in `ilf.complete`.
    outside_view : bool
        Whether what lies outside the depth camera's view is guessed, too.

    Returns
    -------
    Completion
        Without missing pixels, but for those outside the view; `guessed` says which ones this step has filled. What
        was there before is as it was.

    Examples
    --------
    >>> import numpy as np, ilf
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[5:9, 5:9] = 0
    >>> frame = ilf.RGBDFrame(rgb=np.zeros((20, 30, 3), np.uint8), depth=depth)
    >>> nothing_run = ilf.complete(frame, np.zeros((20, 30), int))
    >>> int(ilf.fill_rest(frame, nothing_run).guessed.sum())
    16
    """
    steps = guess_steps(frame, completion, extraction, outside_view)
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value


def guess_steps(
    frame: RGBDFrame,
    completion: Completion,
    extraction: BlockParameters | None = None,
    outside_view: bool = False,
) -> Generator[IterationRecord, None, Completion]:
    """`fill_rest` step by step, for those who show its progress or may give it up: yields the record of every
    iteration, and returns the completion. With the edges of the blocks' extraction, where that is known."""
    guessed = ~np.isfinite(completion.depth)
    left = frame.left_missing(outside_view)
    if left is not None:
        guessed &= ~left
    if not guessed.any():
        return completion
    completed = RGBDFrame(frame.rgb, completion.depth, guide=frame.guide)
    whole = np.ones(frame.shape, np.int32)
    iteration = iterate(completed, whole, 1, preset("best", trend=False), extraction=extraction)
    yield from iteration
    surface = iteration.surface.reshape(frame.shape)
    nearest, farthest = np.nanmin(completion.depth), np.nanmax(completion.depth)
    depth = completion.depth.copy()
    depth[guessed] = np.clip(surface[guessed], nearest, farthest)
    notes = tuple(dict.fromkeys((*completion.notes, *iteration.notes)))
    return replace(
        completion,
        depth=depth,
        filled=completion.filled | guessed,
        guessed=guessed,
        notes=notes,
        guess_network=iteration.network,
    )
