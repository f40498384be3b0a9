"""The optional last step for people who need depth at every pixel: guesses where no block could be completed."""

from __future__ import annotations

import numpy as np

from .completion import Completion, iterate
from .errors import InputError
from .frame import RGBDFrame
from .parameters import preset


def fill_rest(frame: RGBDFrame, completion: Completion) -> Completion:
    """Guess the depth that is still missing: between blocks, in their margin, and in blocks too poor in data.

    The frame as it is completed so far is taken for one block whose surfaces end at edges. Nothing vouches for the
    result: it is for programs that cannot do with gaps.

    Parameters
    ----------
    frame : RGBDFrame
    completion : Completion
        Of that frame.

    Returns
    -------
    Completion
        Without missing pixels; `guessed` says which ones this step has filled. What was there before is as it was.

    Raises
    ------
    InputError
        If there is no depth at all.
    """
    guessed = ~np.isfinite(completion.depth)
    if guessed.all():
        raise InputError("There is no depth in this frame, so there is nothing to guess from.")
    if not guessed.any():
        return completion
    completed = RGBDFrame(frame.rgb, completion.depth)
    iteration = iterate(completed, np.ones(frame.shape, np.int32), 1, preset("best", trend=False))
    for _ in iteration:
        pass
    surface = iteration.surface.reshape(frame.shape)
    nearest, farthest = np.nanmin(completion.depth), np.nanmax(completion.depth)
    depth = completion.depth.copy()
    depth[guessed] = np.clip(surface[guessed], nearest, farthest)
    notes = tuple(dict.fromkeys((*completion.notes, *iteration.notes)))
    return Completion(depth, completion.filled | guessed, completion.results, guessed, notes)
