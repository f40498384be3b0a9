"""Limits, memory and colours of a frame's run history, and names of its runs. No widgets."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import replace
from functools import lru_cache
from zlib import crc32

import numpy as np

from ilf.data.blocks import Colour
from ilf.data.parameters import Parameters, nearest_preset, to_text
from ilf.data.results import Completion
from ilf.project.run_history import Extrapolation, StoredRun
from ilf.run.run import Run

from .frame_data import FrameData

MAX_COMPARED = 4
"""Maximum number of runs that are compared at a time."""

MAX_STORED = 200
"""Maximum number of runs in a frame's history; beyond it, the oldest run without a note is removed."""

MAX_MEMORY = 400 * 1024**2
"""Maximum memory [bytes] of a history: label maps of a frame that is edited often add up."""

_RECORD = 280
"""Approximate memory [bytes] of an iteration's record."""

_IN_NAMES = 2
"""Maximum number of parameters in a name."""

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
    checksum = crc32(run.blocks.labels.data)
    for other in kept:
        ours, theirs = run.blocks, other.run.blocks
        if other.checksum == checksum and np.array_equal(theirs.labels, ours.labels):
            same = ours.drawn is not None and theirs.drawn is not None and np.array_equal(ours.drawn, theirs.drawn)
            drawn = theirs.drawn if same else ours.drawn
            return replace(run, blocks=replace(ours, labels=theirs.labels, drawn=drawn))
    return run


def memory_of(kept: Iterable[StoredRun]) -> int:
    """Return the memory [bytes] of all runs together, without their frames."""
    sizes: dict[int, int] = {}
    for one in kept:
        added = () if one.extrapolation is None else one.extrapolation[:2]
        blocks = one.run.blocks
        by_hand = None if blocks.by_hand is None else blocks.by_hand.depth
        arrays = [blocks.labels, blocks.drawn, blocks.extracted, by_hand, *added]
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


def parameters_text(document: FrameData, run: Run, max_values: int | None = None) -> str:
    """Return the nearest preset, the parameters that differ from it and own parameters of blocks; `max_values` of
    each."""
    texts = [_likeness_text(run.parameters, max_values)]
    own = {label: _own_words(run.parameters_of(label), run.parameters, max_values) for label in run.blocks.own}
    own = {label: words for label, words in own.items() if words}
    if max_values is not None and len(own) > 1:
        return f"{texts[0]}; {len(own)} blocks with own parameters"
    texts += [f"{document.info(label).name}: {words}" for label, words in own.items()]
    return "; ".join(texts)


def run_name(document: FrameData, number: int, run: Run, edit: str = "", live: bool = False) -> str:
    """Return the default name of a run: its number, the edit that started it if any, and its parameters."""
    what = "; ".join(([edit] if edit else []) + [parameters_text(document, run, _IN_NAMES)])
    return f"{'Live' if live else 'Run'} {number}: {what}"


def recorded_history(document: FrameData, completion: Completion, extrapolation: Extrapolation | None) -> StoredRun:
    """Return the run of a record as the first of a frame's history."""
    run, results = replace(completion.run, only=None), completion.results
    name, done = run_name(document, 1, run), frozenset(results)
    return StoredRun(1, name, run, results, 0.0, COLOURS[0], done=done, extrapolation=extrapolation)


def title_of(name: str, document: FrameData, run: Run) -> str:
    """Return a name without the parameters of its default name; unchanged if they are not in it."""
    return name.removesuffix(parameters_text(document, run, _IN_NAMES)).rstrip(":; ") or name


# cached: every row needs these whenever the list changes


@lru_cache(maxsize=512)
def _likeness_text(parameters: Parameters, max_values: int | None) -> str:
    return nearest_preset(parameters).text(max_values)


@lru_cache(maxsize=2048)
def _own_words(parameters: Parameters, common: Parameters, max_values: int | None) -> str:
    return ", ".join(to_text(parameters.differences_from(common), max_values))
