"""The filter that parameters select, and the edges that it uses."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..data.by_hand import DepthByHand
from ..data.frame import RGBDFrame
from ..data.label_map import Block
from ..data.parameters import BlockParameters, Parameters
from ..segmentation.edges.frame_edges import FrameEdges, find_edges
from .edge_aware.fitted_guide import fit_guide
from .edge_aware.iteration import EdgeAwareIteration
from .edge_aware.view import max_window
from .pass_band.iteration import PassBandIteration
from .stepper import Stepper
from .suspects import frame_for


def make_stepper(
    frame: RGBDFrame,
    block: Block,
    parameters: Parameters,
    extraction: BlockParameters | None = None,
    drawn: NDArray[np.bool_] | None = None,
    by_hand: DepthByHand | None = None,
    edges: FrameEdges | None = None,
    carried: NDArray[np.float32] | None = None,
) -> Stepper:
    """Make the stepper of a block.

    Parameters
    ----------
    frame : RGBDFrame
    block : Block
        The pixels to iterate on, at least one of them with known depth, unless a guide suffices or there is depth by
        hand.
    parameters : Parameters
    extraction : BlockParameters, optional
        Parameters of the blocks' extraction, if known; see `edges_for`.
    drawn : ndarray of bool, optional
        The block's pixels, in the order of `block.mask`'s True values, whose border was drawn by hand: an edge of full
        strength for the edge-aware filter, ignored by the pass band, which sees nothing beyond the block.
    by_hand : DepthByHand, optional
        Depth by hand at the same pixels, where they are missing: samples of its weight for the edge-aware filter, known
        depth for the pass band.
    edges : FrameEdges, optional
        Result of `edges_for` with these parameters, if already computed.
    carried : ndarray of float32, shape (H, W), optional
        Depth [m] expected from the previous frame of a sequence, NaN = none: a start and a weak hint for the edge-aware
        filter, ignored by the pass band.
    """
    edges = edges or edges_for(frame, parameters, extraction)
    if edges is None:
        return PassBandIteration(frame, block, parameters, by_hand)
    trusted = frame_for(frame, block, parameters)
    return EdgeAwareIteration(trusted, block, parameters, edges, drawn, by_hand, carried)


def max_pixels(frame: RGBDFrame, block: Block, parameters: Parameters) -> int:
    """Maximum number of pixels that a block's stepper processes; its memory is proportional to it."""
    if parameters.filter != "edge-aware":
        return block.mask.size
    rows, columns = max_window(frame.shape, block.box, parameters.mode)
    return (rows.stop - rows.start) * (columns.stop - columns.start)


def guide_suffices(frame: RGBDFrame, block: Block, parameters: Parameters) -> bool:
    """Whether the belief in the frame's guide is high enough to complete a block with hardly any known depth."""
    guide = fit_guide(frame) if parameters.filter == "edge-aware" else None
    return guide is not None and guide.suffices_for(block)


def is_guided(frame: RGBDFrame) -> bool:
    """Whether the frame has a guide with a belief above 0."""
    guide = fit_guide(frame)
    return guide is not None and guide.belief > 0


def edges_for(frame: RGBDFrame, parameters: Parameters, extraction: BlockParameters | None = None) -> FrameEdges | None:
    """The frame's edges for a filter with these parameters; None for the pass band, which uses no edges.

    Parameters
    ----------
    frame : RGBDFrame
    parameters : Parameters
        They select the edge network, if any.
    extraction : BlockParameters, optional
        Its parameters for Canny and depth jumps are used, so that filter and blocks see the same edges; the defaults
        if left out.
    """
    wanted = edge_parameters(parameters, extraction)
    return None if wanted is None else find_edges(frame, wanted)


@lru_cache(maxsize=64)
def edge_parameters(parameters: Parameters, extraction: BlockParameters | None = None) -> BlockParameters | None:
    """The parameters with which `edges_for` finds edges, everything irrelevant set to its default; None for the pass
    band. Results with equal block, parameters and edge parameters are equal."""
    if parameters.filter != "edge-aware":
        return None
    shared = extraction or BlockParameters()
    return BlockParameters(
        detector="hed" if parameters.edges == "combined" else parameters.edges,
        model=parameters.model,
        multiscale=parameters.multiscale,
        canny_sigma=shared.canny_sigma,
        canny_high=shared.canny_high,
        canny_low_ratio=shared.canny_low_ratio,
        use_depth=shared.use_depth,
        depth_jump=shared.depth_jump,
        depth_jump_share=shared.depth_jump_share,
    )
