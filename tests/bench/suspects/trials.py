"""One frame spoilt and looked at: which of its places are about what was spoilt."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from ilf import BlockParameters, edge_strength, extract_blocks
from ilf.data.frame import RGBDFrame
from ilf.data.pixel_grids import apart, long_lines, mark
from ilf.evaluation.quality.places import Place
from ilf.evaluation.quality.ranking import suspicious_places
from ilf.segmentation.edges.relief import JUMP_LENGTH, find_relief

from .spoiling import KINDS, Fault, Labels, Mask, spoil, widened, with_holes

_FINE = BlockParameters(min_size=0.1)
"""Finer than by default, so that few blocks hold several surfaces before they are spoilt."""

_JUMP, _RIM, _NEAR = 0.04, 3.5, 8
"""Jumps of true depth [m, share of the depth] count as a fault farther [px] from a border than that, and a place as
about one that is so near [px]."""


@dataclass(frozen=True, eq=False)
class Finding:
    """A place and what it is about: the number of a fault, or a true jump that the blocks held before."""

    place: Place
    fault: int | None
    before: bool


@dataclass(frozen=True, eq=False)
class Trial:
    """A spoilt frame and what was found in it, in the order of the places."""

    name: str
    faults: list[Fault]
    found: list[Finding]

    def hits(self, top: int) -> set[int]:
        """Faults that the first places are about."""
        return {finding.fault for finding in self.found[:top] if finding.fault is not None}


def try_frame(truth: RGBDFrame, faults: int, seed: int) -> Trial:
    """Cut holes into a frame without missing depth, spoil its blocks in some places, and look for them."""
    rng = np.random.default_rng([seed, zlib.crc32(truth.name.encode())])
    frame = with_holes(truth, rng)
    kinds = [KINDS[number % len(KINDS)] for number in rng.permutation(faults)]
    labels, made = spoil(extract_blocks(truth, _FINE), truth.depth, ~frame.known, kinds, rng)
    there = _true_jumps(truth, labels)
    found = []
    for place in suspicious_places(frame, labels, edge_strength(frame)):
        column, row = (int(value) for value in place.point)
        about = next((number for number, fault in enumerate(made) if fault.zone[row, column]), None)
        found.append(Finding(place, about, about is None and bool(there[row, column])))
    return Trial(truth.name, made, found)


def _true_jumps(truth: RGBDFrame, labels: Labels) -> Mask:
    """Around the places at which true depth jumps inside a block."""
    right, below = find_relief(truth.depth, _JUMP, _JUMP).jumps
    inside = ~widened(mark(apart(labels)), _RIM)
    return widened(mark(long_lines((right & inside[:, :-1], below & inside[:-1]), JUMP_LENGTH)), _NEAR)
