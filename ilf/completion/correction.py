"""The correction: changes of completed depth by a network.

The network's input is the frame's base completion: its blocks as extracted, completed with `UNCORRECTED`. So its output
depends only on the frame and its extraction, and a block's result only on frame and block, whatever else is run.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.memory import release_memory
from ..data.by_hand import DepthByHand
from ..data.frame import RGBDFrame
from ..data.frame_cache import FrameCache
from ..data.label_map import SPARSE, Block, find_blocks
from ..data.parameters import BlockParameters, Parameters
from ..data.presets import preset
from ..data.results import BlockResult
from ..errors import InputError
from ..segmentation.edges.frame_edges import FrameEdges, edges_for
from ..segmentation.extraction import found_blocks
from .block import BlockTask, is_guided
from .correction_network import Array, CorrectionNetwork, load_correction_network
from .sparse_correction import SparseCorrectionNetwork, load_sparse_correction_network
from .suspects import suspect_islands, without_suspects

UNCORRECTED = preset("best", correction=False)
"""Parameters of the completions that the network was trained on."""

_FADED, _FAR = 2.0, 5.0
"""Distance to known depth [px] up to which nothing is changed, and from which on changes are applied in full."""

_ALIKE = 0.02
"""Difference of a block's log depth from the network's input at which 37 % of the change is applied."""


@dataclass(frozen=True, eq=False)
class Correction:
    """The network's output for a frame, computed once.

    Attributes
    ----------
    base_depth : ndarray of float32, shape (H, W)
        The completed depth that it was given [m]: blocks as extracted, completed with the filter of the preset `best`;
        NaN = missing.
    change : ndarray of float32, shape (H, W)
        Change of the logarithm of that depth.
    networks : tuple of str
        SHA-256 of the correction network, and in sparse frames of that for sparse depth.
    """

    base_depth: Array
    change: Array
    networks: tuple[str, ...]

    def applied(self, block: Block, raw: Array, depth: Array, by_hand: DepthByHand | None = None) -> Array:
        """A block's depth, corrected where it was missing, as far as it equals the network's input: other blocks,
        borders or filter parameters may have changed it. Changes fade near depth by hand as near known depth.

        Parameters
        ----------
        block : Block
        raw, depth : ndarray of float32
            Known and completed depth [m] at the block's pixels, in the order of `block.mask`'s True values; NaN =
            missing.
        by_hand : DepthByHand, optional
            Depth by hand at the same pixels.
        """
        missing, places = np.isnan(raw), block.mask.copy()
        places[block.mask] = missing
        base_depth, change = self.base_depth[block.box][places], self.change[block.box][places]
        if by_hand is not None:
            stated = np.zeros(block.mask.shape, bool)
            stated[block.mask] = by_hand.pixels
            change = change * fading(stated)[places]
        corrected = depth.astype(np.float32)
        with np.errstate(invalid="ignore", divide="ignore"):
            off = np.log(corrected[missing] / base_depth)
        agreement = np.exp(-np.square(np.where(np.isnan(off), np.inf, off / np.float32(_ALIKE))))
        corrected[missing] *= np.exp(agreement * change)
        return corrected


def applied_change(change: Array, known: NDArray[np.bool_]) -> Array:
    """Convert the network's changes to the applied ones: they fade near known depth, where the filter is more accurate.

    Parameters
    ----------
    change : ndarray of float32, shape (H, W)
        Change of log depth.
    known : ndarray of bool, shape (H, W)
    """
    return fading(known) * change


def fading(known: NDArray[np.bool_]) -> Array:
    """Factor on the changes, from 0 near known depth to 1; float32 (H, W)."""
    faded = np.asarray(cv2.distanceTransform((~known).view(np.uint8), cv2.DIST_L2, 5), np.float32)
    faded -= np.float32(_FADED)
    faded /= np.float32(_FAR - _FADED)
    return np.clip(faded, 0, 1, out=faded)


Networks = tuple[CorrectionNetwork, SparseCorrectionNetwork | None]


def correction_networks(frame: RGBDFrame, edges: FrameEdges) -> Networks:
    """Load the correction network and, for a sparse frame, that for sparse depth.

    Raises
    ------
    InputError
        If one is missing or broken, or their input from the edge network is missing.
    """
    network = load_correction_network()
    if edges.network is None:
        raise InputError("the correction network needs the contours of the edge network.")
    return network, load_sparse_correction_network() if frame.known.mean() < SPARSE else None


def unapplied_change(frame: RGBDFrame, completed: Array, edges: FrameEdges) -> Array:
    """Run the networks on a frame's completed depth [m]: the change of log depth for `applied_change`, in this frame
    or where another one shows the same points.

    Raises
    ------
    InputError
        As `correction_networks`, or if a network's output is not finite.
    """
    network, further = correction_networks(frame, edges)
    change = network.change(frame.edge_rgb, frame.depth, completed, edges.probability)
    if further is None:
        return change
    applied = applied_change(change, frame.known)
    corrected = np.asarray(completed * np.exp(applied), np.float32)
    more = further.change(frame.edge_rgb, frame.depth, corrected, applied, edges.probability)
    return np.asarray(change + more, np.float32)


corrections = FrameCache[RGBDFrame, Correction]()
"""Cache by frame and extraction parameters."""


@dataclass(frozen=True, eq=False)
class BaseCompletion:
    """The base completion of a frame, not yet computed.

    Attributes
    ----------
    frame : RGBDFrame
    extraction : BlockParameters
    edges : FrameEdges
        The filter's edges.
    own : tuple of int
        Labels of the run's blocks that are as extracted and completed as in the base completion.
    rest : tuple of BlockTask
        All other extracted blocks.
    """

    frame: RGBDFrame
    extraction: BlockParameters
    edges: FrameEdges
    own: tuple[int, ...]
    rest: tuple[BlockTask, ...]

    def correction(self, networks: Networks, results: Iterable[BlockResult]) -> Correction:
        """Run the networks on the base completion and cache the correction with the frame.

        Parameters
        ----------
        networks : (CorrectionNetwork, SparseCorrectionNetwork or None)
        results : iterable of BlockResult
            Results of `own` and `rest`.

        Raises
        ------
        InputError
            If a network's output is not finite.
        """
        network, further = networks
        frame, completed = self.frame, self.frame.depth.copy()
        for result in results:
            completed[result.block.box][result.block.mask] = result.depth
        left = frame.unfilled_mask()
        if left is not None:  # whatever the run's parameters are
            completed[left] = np.nan
        contours = self.edges.probability
        trusted = without_suspects(frame)
        completed[suspect_islands(frame)] = np.nan
        change = applied_change(network.change(frame.edge_rgb, trusted.depth, completed, contours), trusted.known)
        if further is not None:
            corrected = np.asarray(completed * np.exp(change), np.float32)
            change = change + fading(trusted.known) * further.change(
                frame.edge_rgb, trusted.depth, corrected, change, contours
            )
        release_memory(change.size)
        used = tuple(one.sha256 for one in networks if one is not None)
        return corrections.keep(frame, self.extraction, Correction(completed, change, used))


def find_base_completion(tasks: Sequence[BlockTask]) -> BaseCompletion | Correction | None:
    """What the correction of a run's blocks starts from: the base to be completed, or the cached correction; None if
    nothing is to be corrected."""
    if not any(task.drawn is None and _corrects(task.parameters) for task in tasks):
        return None
    frame, extraction = tasks[0].frame, tasks[0].extraction
    known = corrections.find(frame, extraction)
    if known is not None or is_guided(frame) or not fading(frame.known).any():
        return known
    edges = edges_for(frame, UNCORRECTED, extraction)
    assert edges is not None  # of the edge-aware filter
    alike = {_block_key(task.block): task.block.label for task in tasks if _matches_base(task)}
    own, rest = [], []
    for block in find_blocks(found_blocks(frame, extraction).labels).values():
        label = alike.get(_block_key(block))
        if label is None:
            rest.append(BlockTask(frame, block, UNCORRECTED, extraction))
        else:
            own.append(label)
    return BaseCompletion(frame, extraction, edges, tuple(own), tuple(rest))


def needs_correction(result: BlockResult) -> bool:
    """Whether a block is to be corrected: not if its border was drawn by hand, since the user has defined it and no
    depth crosses it, and not if a smooth surface explains its known depth."""
    own = result.drawn is not None or result.explained
    return _corrects(result.parameters) and result.outcome.recovered > 0 and not own


def _corrects(parameters: Parameters) -> bool:
    return parameters.filter == "edge-aware" and parameters.correction


def _matches_base(task: BlockTask) -> bool:
    """Whether a block is completed as in the base completion, except perhaps for pixels outside the view."""
    by_user = task.drawn is not None or task.by_hand is not None
    return not by_user and task.parameters.replace(outside_view=False, correction=False).same_effect(UNCORRECTED)


def _block_key(block: Block) -> tuple[int, int, bytes]:
    """A key of the block's pixels."""
    return block.box[0].start, block.box[1].start, np.packbits(block.mask).tobytes()
