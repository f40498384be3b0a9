"""The edges of a frame, found once for blocks and filter alike; where a network is missing, the next best stand in."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..frame import RGBDFrame
from ..models import DEPTH_EDGES, model_path
from ..parameters import BlockParameters
from ..per_frame import once_per_frame, once_per_image
from .depth_network import DepthEdgeNetwork, DepthEdges
from .detectors import canny_edges, colour_gradient, gradient_strength
from .network import EdgeNetwork, load_model
from .relief import Relief, find_relief

_BESIDE_CANNY = 0.9
"""Factor on the gradient's strength off Canny's lines, which must stand above what lies beside them."""

_STANDS_IN = {
    "rgbd": ("hed", "Contours of the colour image stand in for depth edges"),
    "hed": ("canny", "Canny's edges stand in for the network's"),
}
"""Detector -> which one takes its place where its network is missing or fails, and what there is to say of it."""


@dataclass(frozen=True, eq=False)
class FrameEdges:
    """Where surfaces may end, by colour and by known depth.

    Attributes
    ----------
    detected : ndarray of float32, shape (H, W)
        Strength in [0, 1] by the detector: the contours that a network or Canny finds in the colour, or the
        probability of a depth jump, which a network finds in colour and known depth.
    canny : ndarray of float32, shape (H, W)
        That by Canny: 1 along its lines, below elsewhere.
    lines : ndarray of bool, shape (H, W)
        Canny's lines.
    relief : Relief
        What the known depth says.
    strength : ndarray of float32, shape (H, W)
        `detected`, with depth jumps of any length at 1: the edges of the edge-aware filter.
    network : str or None
        SHA-256 of the network that `detected` is by; None if it is by Canny.
    crease : ndarray of float32, shape (H, W), or None
        Probability that the surface bends sharply, where the detector tells.
    notes : tuple of str
        Why other edges stand in for those that were asked for, if they do.
    """

    detected: NDArray[np.float32]
    canny: NDArray[np.float32]
    lines: NDArray[np.bool_]
    relief: Relief
    strength: NDArray[np.float32]
    network: str | None
    crease: NDArray[np.float32] | None = None
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
        Read-only. If the network that is asked for is missing or none, those of the next best detector, with a note.
    """
    network, notes = _working_network(frame, parameters)
    jumps = parameters if parameters.use_depth else BlockParameters()
    found = _find(
        frame,
        network,
        isinstance(network, EdgeNetwork) and parameters.multiscale,
        (parameters.canny_sigma, parameters.canny_high, parameters.canny_low_ratio),
        (jumps.depth_jump, jumps.depth_jump_share),
    )
    return dataclasses.replace(found, notes=notes)


def load_depth_network() -> DepthEdgeNetwork:
    """The network of depth edges that comes with the program.

    Raises
    ------
    InputError
        If its file is missing.
    FormatError
        If it is no such network.
    """
    return DepthEdgeNetwork.load(model_path(DEPTH_EDGES))


@once_per_frame
def depth_edges(frame: RGBDFrame, network: DepthEdgeNetwork) -> DepthEdges:
    """Where depth jumps and surfaces bend by colour and by the depth that the frame has, remembered with it."""
    return network.look(frame.rgb, frame.depth)


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


def _working_network(
    frame: RGBDFrame, parameters: BlockParameters
) -> tuple[DepthEdgeNetwork | EdgeNetwork | None, tuple[str, ...]]:
    """The first network that works, from that which is asked for on, None for Canny; and why others do not."""
    detector, notes = parameters.detector, []
    while detector in _STANDS_IN:
        try:
            network = load_depth_network() if detector == "rgbd" else load_model(parameters.model)
            _look(frame, network, parameters.multiscale)
        except InputError as error:
            detector, what = _STANDS_IN[detector]
            notes.append(f"{what}: {error}")
        else:
            return network, tuple(notes)
    return None, tuple(notes)


def _look(
    frame: RGBDFrame, network: DepthEdgeNetwork | EdgeNetwork, multiscale: bool
) -> tuple[NDArray[np.float32], NDArray[np.float32] | None]:
    """Strength of edges by a network, and of creases where it tells."""
    if isinstance(network, EdgeNetwork):
        return network_strength(frame.rgb, network, multiscale), None
    seen = depth_edges(frame, network)
    return seen.jump, seen.crease


@once_per_frame
def _find(
    frame: RGBDFrame,
    network: DepthEdgeNetwork | EdgeNetwork | None,
    multiscale: bool,
    canny: tuple[float, float, float],
    jump: tuple[float, float],
) -> FrameEdges:
    by_canny, lines = _canny_of_frame(frame.rgb, *canny)
    detected, crease = (by_canny, None) if network is None else _look(frame, network, multiscale)
    relief = find_relief(frame.depth, *jump)
    strength = np.where(relief.edges, np.float32(1), detected)
    sha256 = None if network is None else network.sha256
    return FrameEdges(detected, by_canny, lines, relief, strength, sha256, crease)
