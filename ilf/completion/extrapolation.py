"""Extrapolation, the optional last step: depth at the pixels where no block could be completed."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace

import numpy as np

from ..data.frame import RGBDFrame
from ..data.presets import preset
from ..data.results import Completion, IterationRecord
from .completion import iterate
from .suspects import suspect_islands


def extrapolation_steps(completion: Completion) -> Generator[IterationRecord, None, Completion]:
    """`ilf.extrapolate` step by step, for progress and cancellation: yields the record of every iteration and returns
    the completion.

    Parameters
    ----------
    completion : Completion
        Its run's parameters tell whether pixels outside the depth camera's view are extrapolated as well, and its edges
        are those of the blocks' extraction.
    """
    run, frame = completion.run, completion.frame
    dense = replace(completion, run=replace(run, extrapolate=True))
    extrapolated = ~np.isfinite(completion.depth)
    left = frame.unfilled_mask(run.parameters.outside_view)
    if left is not None:
        extrapolated &= ~left
    if not extrapolated.any():
        return dense
    trusted = np.where(suspect_islands(frame), np.float32(np.nan), completion.depth)
    completed = RGBDFrame(frame.edge_rgb, trusted, guide=frame.guide)
    whole = np.ones(frame.shape, np.int32)
    iteration = iterate(completed, whole, 1, preset("best", trend=False), extraction=run.blocks.extraction)
    yield from iteration
    surface = iteration.surface.reshape(frame.shape)
    nearest, farthest = np.nanmin(completion.depth), np.nanmax(completion.depth)
    depth = completion.depth.copy()
    depth[extrapolated] = np.clip(surface[extrapolated], nearest, farthest)
    notes = tuple(dict.fromkeys((*completion.notes, *iteration.notes)))
    return replace(
        dense,
        depth=depth,
        filled=completion.filled | extrapolated,
        extrapolated=extrapolated,
        notes=notes,
        extrapolation_network=iteration.network,
    )
