"""The edges of a frame, found once for blocks and filter alike, by Canny where the network is missing."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..frame import RGBDFrame
from ..parameters import BlockParameters
from ..per_frame import once_per_frame, once_per_image
from .detectors import canny_edges, colour_gradient, gradient_strength
from .network import EdgeNetwork, load_model
from .relief import Relief, find_relief

_BESIDE_CANNY = 0.9
"""Factor on the gradient's strength off Canny's lines, which must stand above what lies beside them."""


@dataclass(frozen=True, eq=False)
class FrameEdges:
    """Where surfaces may end, by colour and by known depth.

    Attributes
    ----------
    colour : ndarray of float32, shape (H, W)
        Strength of the colour's edges in [0, 1], by the network or by Canny.
    canny : ndarray of float32, shape (H, W)
        That by Canny: 1 along its lines, below elsewhere.
    lines : ndarray of bool, shape (H, W)
        Canny's lines.
    relief : Relief
        What the known depth says.
    strength : ndarray of float32, shape (H, W)
        `colour`, with depth jumps of any length at 1: the edges of the edge-aware filter.
    network : str or None
        SHA-256 of the edge network that `colour` is by; None if it is by Canny.
    notes : tuple of str
        Why Canny's edges stand in for the network's, if they do.
    """

    colour: NDArray[np.float32]
    canny: NDArray[np.float32]
    lines: NDArray[np.bool_]
    relief: Relief
    strength: NDArray[np.float32]
    network: str | None
    notes: tuple[str, ...] = ()


def find_edges(frame: RGBDFrame, parameters: BlockParameters) -> FrameEdges:
    """The frame's edges with the parameters of their detectors, worked out once and remembered with the frame.

    Parameters
    ----------
    frame : RGBDFrame
    parameters : BlockParameters
        Those under "Edges" but the threshold count. Where known depth does not, its jumps are those of the defaults.

    Returns
    -------
    FrameEdges
        Read-only. By Canny, with a note, if the network that is asked for is missing or none.
    """
    network: EdgeNetwork | None = None
    notes: tuple[str, ...] = ()
    if parameters.detector == "hed":
        try:
            network = load_model(parameters.model)
            network_strength(frame.rgb, network, parameters.multiscale)
        except InputError as error:
            network, notes = None, (f"Canny's edges stand in for the network's: {error}",)
    jumps = parameters if parameters.use_depth else BlockParameters()
    found = _find(
        frame,
        network,
        network is not None and parameters.multiscale,
        (parameters.canny_sigma, parameters.canny_high, parameters.canny_low_ratio),
        (jumps.depth_jump, jumps.depth_jump_share),
    )
    return dataclasses.replace(found, notes=notes)


@once_per_image
def network_strength(rgb: NDArray[np.uint8], network: EdgeNetwork, multiscale: bool) -> NDArray[np.float32]:
    """Boundary strength of a frame's colour by the network, remembered with the colour."""
    return network.strength(rgb, multiscale)


def canny_strength(
    rgb: NDArray[np.uint8], sigma: float, high: float, low_ratio: float
) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Strength by Canny, which is 1 along its lines and below elsewhere, and the lines."""
    dx, dy = colour_gradient(rgb, sigma)
    lines = canny_edges(dx, dy, high, low_ratio)
    beside = np.float32(_BESIDE_CANNY) * gradient_strength(dx, dy)
    return np.where(lines, np.float32(1), beside), lines


_canny_of_frame = once_per_image(canny_strength)


@once_per_frame
def _find(
    frame: RGBDFrame,
    network: EdgeNetwork | None,
    multiscale: bool,
    canny: tuple[float, float, float],
    jump: tuple[float, float],
) -> FrameEdges:
    by_canny, lines = _canny_of_frame(frame.rgb, *canny)
    colour = by_canny if network is None else network_strength(frame.rgb, network, multiscale)
    relief = find_relief(frame.depth, *jump)
    strength = np.where(relief.edges, np.float32(1), colour)
    return FrameEdges(colour, by_canny, lines, relief, strength, None if network is None else network.sha256)
