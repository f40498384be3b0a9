"""Edge strength of a frame: from colour and depth, for blocks and for the filter alike."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..assets import asset_path
from ..frame import RGBDFrame
from ..parameters import BlockParameters
from ..per_frame import once_per_frame
from .edges import canny_edges, colour_gradient, depth_edges, gradient_strength
from .network import EdgeNetwork


def find_edges(frame: RGBDFrame, parameters: BlockParameters) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Edge strength, and the edges themselves.

    Parameters
    ----------
    frame : RGBDFrame
    parameters : BlockParameters

    Returns
    -------
    strength : ndarray of float32, shape (H, W)
        In [0, 1]; edges stand at 1 and all else below.
    edges : ndarray of bool, shape (H, W)
        Canny edges of the colour, and depth jumps where they are asked for.
    """
    dx, dy = colour_gradient(frame.rgb, parameters.canny_sigma)
    edges = canny_edges(dx, dy, parameters.canny_high, parameters.canny_low_ratio)
    if parameters.use_depth:
        edges |= depth_edges(frame.depth, parameters.depth_jump, parameters.depth_jump_share)
    strength = gradient_strength(dx, dy)
    # A line of full strength is all that guides the contraction of blocks; what lies beside it must stay below.
    return np.where(edges, np.float32(1.0), 0.9 * strength).astype(np.float32), edges


@once_per_frame
def network_strength(frame: RGBDFrame) -> NDArray[np.float32]:
    """Edge strength of a frame in [0, 1], float32 (H, W): by the bundled edge network, and depth jumps at 1.

    Raises InputError if the network's file is missing or no edge network.
    """
    network = EdgeNetwork.load(asset_path("models/edges.onnx"))
    defaults = BlockParameters()
    jumps = depth_edges(frame.depth, defaults.depth_jump, defaults.depth_jump_share)
    return np.where(jumps, np.float32(1.0), network.strength(frame.rgb))


@once_per_frame
def canny_strength(frame: RGBDFrame) -> NDArray[np.float32]:
    """Edge strength of a frame in [0, 1], float32 (H, W): by Canny and depth jumps, as the extraction finds them."""
    strength, _ = find_edges(frame, BlockParameters())
    return strength
