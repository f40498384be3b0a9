"""The filter that parameters select, and the edges that it uses."""

from __future__ import annotations

from functools import lru_cache

from ..data.frame import RGBDFrame
from ..data.label_map import Block
from ..data.parameters import BlockParameters, Parameters
from ..segmentation.edges.frame_edges import FrameEdges, find_edges
from .edge_aware.fitted_guide import fit_guide
from .edge_aware.view import max_window


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


_SHARED = ("canny_sigma", "canny_high", "canny_low_ratio", "use_depth", "depth_jump", "depth_jump_share")
"""Parameters of edges that the filter has in common with the extraction."""


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
        **{name: getattr(shared, name) for name in _SHARED},
    )
