"""The correction: what a network that has learnt from generated scenes still changes about completed depth.

The network looks at the frame's base completion: its blocks as extracted, completed by `UNCORRECTED`. So what it says
depends on the frame and its extraction alone, and a block's result on frame and block, whatever else is run.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.memory import give_back
from ..data.blocks import Block, find_blocks
from ..data.frame import RGBDFrame
from ..data.frame_cache import Memory
from ..data.parameters import BlockParameters, Parameters, preset
from ..data.results import BlockResult
from ..errors import InputError
from ..segmentation.edges.frame_edges import FrameEdges
from ..segmentation.extraction import found_blocks
from .block import BlockTask
from .correction_network import Array, CorrectionNetwork, load_correction_network
from .filter import edges_for, is_guided

UNCORRECTED = preset("best", correction=False)
"""What the network has seen the depth completed with."""

_SHARE = 0.85
"""Of every change so much is made: on frames of real sensors the network goes a little too far."""

_FADED, _FAR = 2.0, 8.0
"""Distance to known depth [px] up to which nothing is changed, and from which on changes are made in full."""

_ALIKE = 0.02
"""A block's log depth that is off so far from what the network has seen takes over 37 % of the change."""


@dataclass(frozen=True, eq=False)
class Correction:
    """What the network says of a frame, worked out once.

    Attributes
    ----------
    opinion : ndarray of float32, shape (H, W)
        The completed depth that it has seen [m]: of the frame as it is, its blocks as extracted and the filter as the
        preset `best` has it; NaN = missing.
    change : ndarray of float32, shape (H, W)
        By how much the logarithm of that is to be changed.
    network : str
        SHA-256 of the network.
    """

    opinion: Array
    change: Array
    network: str

    def applied(self, block: Block, raw: Array, depth: Array) -> Array:
        """A block's depth, corrected where it was missing, and as far as it is what the network has seen: other
        blocks, borders or values of the filter may have made something else of it.

        Parameters
        ----------
        block : Block
        raw, depth : ndarray of float32
            Known and completed depth [m] at the block's pixels, in the order of `block.mask`'s True values; NaN =
            missing.
        """
        opinion, change = self.opinion[block.box][block.mask], self.change[block.box][block.mask]
        with np.errstate(invalid="ignore", divide="ignore"):
            off = np.log(depth / opinion)
        agreement = np.exp(-np.square(np.where(np.isnan(off), np.inf, off / np.float32(_ALIKE))))
        return np.where(np.isnan(raw), depth * np.exp(agreement * change), depth).astype(np.float32)


def made_of(change: Array, known: NDArray[np.bool_]) -> Array:
    """The changes that are made of those that the network asks for.

    All are a little less, and those near known depth, which the filter follows better, fade.

    Parameters
    ----------
    change : ndarray of float32, shape (H, W)
        Of log depth.
    known : ndarray of bool, shape (H, W)
    """
    return np.asarray(np.float32(_SHARE) * _faded(known) * change, np.float32)


def changes_any(known: NDArray[np.bool_]) -> bool:
    """Whether any missing depth is far enough from known depth for a change to be made."""
    return bool(_faded(known).any())


def _faded(known: NDArray[np.bool_]) -> Array:
    """How much is left of changes, from 0 near known depth to 1."""
    faded = np.asarray(cv2.distanceTransform((~known).astype(np.uint8), cv2.DIST_L2, 5), np.float32)
    faded -= np.float32(_FADED)
    faded /= np.float32(_FAR - _FADED)
    return np.clip(faded, 0, 1, out=faded)


corrections = Memory[RGBDFrame, Correction]()
"""Of each frame, by the parameters that its blocks are extracted with."""


@dataclass(frozen=True, eq=False)
class Base:
    """The base completion of a frame that is yet to be made.

    Attributes
    ----------
    frame : RGBDFrame
    extraction : BlockParameters
    edges : FrameEdges
        What the filter sees.
    own : tuple of int
        The run's blocks that are as extracted, and are completed as the network is to see them.
    rest : tuple of BlockTask
        All other blocks as extracted.
    """

    frame: RGBDFrame
    extraction: BlockParameters
    edges: FrameEdges
    own: tuple[int, ...]
    rest: tuple[BlockTask, ...]

    def network(self) -> CorrectionNetwork:
        """The network that is to look at it.

        Raises
        ------
        InputError
            If it is missing or broken, or there are no contours for it.
        """
        network = load_correction_network()
        if self.edges.network is None:
            raise InputError("the network that does so needs those of the edge network.")
        return network

    def correction(self, network: CorrectionNetwork, results: Iterable[BlockResult]) -> Correction:
        """What a network says of it, remembered with the frame.

        Parameters
        ----------
        network : CorrectionNetwork
        results : iterable of BlockResult
            Of `own` and `rest`.

        Raises
        ------
        InputError
            If the network gives no numbers.
        """
        frame, completed = self.frame, self.frame.depth.copy()
        for result in results:
            completed[result.block.box][result.block.mask] = result.depth
        left = frame.left_missing()
        if left is not None:  # whatever the run has asked for
            completed[left] = np.nan
        change = made_of(network.change(frame.rgb, frame.depth, completed, self.edges.detected), frame.known)
        give_back(change.size)
        return corrections.keep(frame, self.extraction, Correction(completed, change, network.sha256))


def find_base(tasks: Sequence[BlockTask]) -> Base | Correction | None:
    """What the correction of a run's blocks starts from: the base that is to be completed, or what the network has said
    of it already; None if nothing is to be corrected."""
    if not any(task.drawn is None and _corrects(task.parameters) for task in tasks):
        return None
    frame, extraction = tasks[0].frame, tasks[0].extraction
    known = corrections.find(frame, extraction)
    if known is not None or is_guided(frame) or not changes_any(frame.known):
        return known
    edges = edges_for(frame, UNCORRECTED, extraction)
    assert edges is not None  # of the edge-aware filter
    alike = {_place(task.block): task.block.label for task in tasks if _completes_alike(task)}
    own, rest = [], []
    for block in find_blocks(found_blocks(frame, extraction).blocks).values():
        label = alike.get(_place(block))
        if label is None:
            rest.append(BlockTask(frame, block, UNCORRECTED, extraction))
        else:
            own.append(label)
    return Base(frame, extraction, edges, tuple(own), tuple(rest))


def is_to_be_corrected(result: BlockResult) -> bool:
    """Not a block whose border was drawn by hand: it is what the user has made it, and no depth gets across there. Nor
    one whose known depth a smooth surface explains."""
    own = result.drawn is not None or result.explained
    return _corrects(result.parameters) and result.outcome.recovered > 0 and not own


def _corrects(parameters: Parameters) -> bool:
    return parameters.filter == "edge-aware" and parameters.correction


def _completes_alike(task: BlockTask) -> bool:
    """Whether a block is completed as the network is to see it, but perhaps for what lies outside the view."""
    return task.drawn is None and task.parameters.replace(outside_view=False, correction=False).same_effect(UNCORRECTED)


def _place(block: Block) -> tuple[int, int, bytes]:
    """Other for other pixels."""
    return block.box[0].start, block.box[1].start, np.packbits(block.mask).tobytes()
