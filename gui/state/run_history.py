"""Limits, memory and colours of a frame's run history. No widgets."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace
from zlib import crc32

import numpy as np

from ilf.project.run_history import Colour, StoredRun
from ilf.run.run import Run

MAX_COMPARED = 4
"""Maximum number of runs that are compared at a time."""

MAX_STORED = 200
"""Maximum number of runs in a frame's history; beyond it, the oldest run without a note is removed."""

MAX_MEMORY = 400 * 1024**2
"""Maximum memory [bytes] of a history: label maps of a frame that is edited often add up."""

_RECORD = 82
"""Approximate memory [bytes] of an iteration's record."""

COLOURS: tuple[Colour, ...] = (
    (230, 119, 34),
    (200, 66, 160),
    (38, 160, 92),
    (132, 98, 222),
    (186, 142, 14),
    (222, 66, 72),
    (20, 158, 170),
    (150, 104, 74),
)
"""Colours of runs, distinct on light and dark backgrounds and from the blue of the current result."""


def with_shared_arrays(run: Run, kept: Iterable[StoredRun]) -> Run:
    """Return the run, sharing label map and drawn borders with a stored run where they are equal."""
    checksum = crc32(run.blocks.data)
    for other in kept:
        if other.checksum == checksum and np.array_equal(other.run.blocks, run.blocks):
            drawn, theirs = run.drawn, other.run.drawn
            same = drawn is not None and theirs is not None and np.array_equal(drawn, theirs)
            return replace(run, blocks=other.run.blocks, drawn=theirs if same else drawn)
    return run


def memory_of(kept: Iterable[StoredRun]) -> int:
    """Return the memory [bytes] of all runs together, without their frames."""
    sizes: dict[int, int] = {}
    for one in kept:
        arrays = [one.run.blocks, one.run.drawn, *(one.extrapolation[:2] if one.extrapolation is not None else ())]
        sizes |= {id(array): array.nbytes for array in arrays if array is not None}
        sizes |= {
            id(result): result.depth.nbytes + result.block.mask.nbytes + _RECORD * len(result.history)
            for result in one.results.values()
        }
    return sum(sizes.values())


def next_colour(kept: Collection[StoredRun]) -> Colour:
    """Return a colour that none of the latest runs has."""
    latest = [one.colour for one in kept][-len(COLOURS) + 1 :]
    return next(colour for colour in COLOURS if colour not in latest)
