"""Quality checks on one frame with deliberate faults: which flagged places are at a fault, and what remedies mend."""

import zlib
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import ilf
from ilf.data.pixel_grids import different_labels, long_lines, mark
from ilf.evaluation.quality.checks import find_places
from ilf.evaluation.quality.places import Place
from ilf.evaluation.quality.remedies import find_remedy
from ilf.segmentation.edges.frame_edges import JUMP_LENGTH, find_relief

from .faults import KINDS, Fault, Labels, Mask, make_faults, widened, with_holes

_FINE = ilf.BlockParameters(min_size=0.1)
"""Finer than by default, so that few blocks contain several surfaces before the faults."""

_JUMP, _RIM, _NEAR = 0.04, 3.5, 8
"""Jumps of true depth [m, share of the depth] at more than this distance [px] from a border count as errors; maximum
distance [px] of a place from one."""


@dataclass(frozen=True, eq=False)
class Finding:
    """A flagged place and its cause: the number of a fault, or a true jump inside a block of the extraction."""

    place: Place
    fault: int | None
    before: bool


@dataclass(frozen=True)
class Mending:
    """The remedy for the first place at a fault: its kind, "" for none, and the IoU of the blocks without the fault
    with those before and after the remedy."""

    remedy: str
    before: float
    after: float

    @property
    def mends(self) -> bool:
        """Whether the remedy brings the blocks back: it halves what the IoU lacks."""
        return 1 - self.after <= 0.5 * (1 - self.before)


@dataclass(frozen=True, eq=False)
class Trial:
    """A frame with faults, its flagged places in order, and the remedies for the faults that were found."""

    name: str
    faults: list[Fault]
    found: list[Finding]
    mended: dict[int, Mending]

    def hits(self, top: int) -> set[int]:
        """Faults found by the first places."""
        return {finding.fault for finding in self.found[:top] if finding.fault is not None}


def try_frame(ground_truth: ilf.RGBDFrame, faults: int, seed: int) -> Trial:
    """Cut holes into a frame without missing depth, make faults in its blocks, and run the quality checks."""
    rng = np.random.default_rng([seed, zlib.crc32(ground_truth.name.encode())])
    frame = with_holes(ground_truth, rng)
    kinds = [KINDS[number % len(KINDS)] for number in rng.permutation(faults)]
    labels, made = make_faults(ilf.extract_blocks(ground_truth, _FINE), ground_truth.depth, ~frame.known, kinds, rng)
    there = _true_jumps(ground_truth, labels)
    found, mended, strength = list[Finding](), dict[int, Mending](), ilf.edge_strength(frame)
    for place in find_places(frame, labels, strength):
        column, row = (int(value) for value in place.point)
        about = next((number for number, fault in enumerate(made) if fault.zone[row, column]), None)
        if about is not None and about not in mended and made[about].overlap(labels, labels) < 1:
            mended[about] = _mend(made[about], place, frame, labels, strength)
        found.append(Finding(place, about, about is None and bool(there[row, column])))
    return Trial(ground_truth.name, made, found, mended)


def _mend(fault: Fault, place: Place, frame: ilf.RGBDFrame, labels: Labels, strength: NDArray[np.float32]) -> Mending:
    remedy, after = find_remedy(place, frame, labels, strength), labels.copy()
    if remedy is not None and remedy.patch is not None:
        remedy.patch.apply(after)
    return Mending("" if remedy is None else remedy.kind, fault.overlap(labels, labels), fault.overlap(labels, after))


def _true_jumps(ground_truth: ilf.RGBDFrame, labels: Labels) -> Mask:
    """Return pixels around true depth jumps inside a block."""
    right, below = find_relief(ground_truth.depth, _JUMP, _JUMP).jumps
    inside = ~widened(mark(different_labels(labels)), _RIM)
    return widened(mark(long_lines((right & inside[:, :-1], below & inside[:-1]), JUMP_LENGTH)), _NEAR)
