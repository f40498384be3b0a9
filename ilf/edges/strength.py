"""Edges of a frame: from colour and depth, for blocks and for the filter alike."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from ..frame import RGBDFrame
from ..models import BUNDLED
from ..parameters import BlockParameters
from ..per_frame import once_per_frame
from .detectors import canny_edges, colour_gradient, gradient_strength, otsu_edges
from .network import EdgeNetwork, check_image, load_model
from .pairs import mark
from .relief import Relief, find_relief

DETECTORS = ("combined", "hed", "canny", "depth")
"""What `edge_strength` takes."""

_BESIDE_CANNY = 0.9
"""Factor on the gradient's strength off Canny's lines, which must stand above what lies beside them."""

_CANNY_RAISE, _JUMP_HEIGHT, _CREASE_HEIGHT = 0.3, 1.5, 0.9
"""What Canny's lines add to the network's strength as the guide of the contraction, and how high jumps and the
sharpest creases stand in it."""

_MIDDLING_BEND = 1.5
"""Bend at which a crease stands half as high as the sharpest."""


@dataclass(frozen=True, eq=False)
class FrameEdges:
    """Where surfaces may end.

    Attributes
    ----------
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1]; depth jumps stand at 1.
    edges : ndarray of bool, shape (H, W)
        The same, binarised.
    guide : ndarray of float32, shape (H, W)
        Along its crests, boundaries are drawn.
    relief : Relief or None
        What the known depth says, where it is asked for.
    note : str
        Why Canny's edges stand in for the network's, if so.
    """

    strength: NDArray[np.float32]
    edges: NDArray[np.bool_]
    guide: NDArray[np.float32]
    relief: Relief | None
    note: str


def edge_strength(
    image: RGBDFrame | ArrayLike, detector: str = "combined", *, model: str = BUNDLED, multiscale: bool = False
) -> NDArray[np.float32]:
    """Edge strength by one detector (section 2).

    Parameters
    ----------
    image : RGBDFrame, or array of uint8, shape (H, W, 3)
        A frame, or a colour image (RGB), which serves "hed" and "canny".
    detector : str
        "hed": the edge network. "canny": Canny's edges at 1, the colour gradient up to 0.9 elsewhere. "depth": 1 at
        jumps of the known depth, 0 elsewhere. "combined": the larger of "hed" and "depth".
    model : str
        Name of the edge network, one of `ilf.models.model_names()`.
    multiscale : bool
        Let the network look at three scales: slightly better, 3.5 times as slow.

    Returns
    -------
    ndarray of float32, shape (H, W)
        In [0, 1].

    Raises
    ------
    InputError
        For an unknown detector, an image of another kind or without depth where that is needed, or an edge network
        that is missing or none.
    """
    if detector not in DETECTORS:
        raise InputError(f"There is no detector {detector!r}. Choose one of {', '.join(DETECTORS)}.")
    if not isinstance(image, RGBDFrame):
        rgb = np.asarray(image)
        if detector in ("depth", "combined"):
            raise InputError(
                f"The detector {detector!r} needs a frame with depth; 'hed' and 'canny' take colour alone."
            )
        check_image(rgb)
        return load_model(model).strength(rgb, multiscale) if detector == "hed" else _canny(rgb, BlockParameters())[0]
    if detector == "hed":
        return _network_strength(image, load_model(model), multiscale).copy()
    if detector == "canny":
        return _canny(image.rgb, BlockParameters())[0]
    if detector == "depth":
        return _default_relief(image).edges.astype(np.float32)
    return combined_strength(image, load_model(model), multiscale).copy()


def find_edges(frame: RGBDFrame, parameters: BlockParameters) -> FrameEdges:
    """What the extraction of blocks needs to know.

    Parameters
    ----------
    frame : RGBDFrame
    parameters : BlockParameters
    """
    canny, lines = _canny(frame.rgb, parameters)
    note = ""
    strength, edges, guide = canny, lines, canny
    if parameters.detector == "hed":
        try:
            strength = _network_strength(frame, load_model(parameters.model), parameters.multiscale)
        except InputError as error:
            note = f"Canny's edges stand in for the network's: {error}"
        else:
            edges = otsu_edges(strength, parameters.threshold)
            guide = strength + np.where(lines, np.float32(_CANNY_RAISE), np.float32(0))
    if not parameters.use_depth:
        return FrameEdges(strength, edges, guide, None, note)
    relief = find_relief(frame.depth, parameters.depth_jump, parameters.depth_jump_share)
    if parameters.use_creases:
        # single pixels are noise
        edges = edges | (cv2.morphologyEx((relief.bend > 1).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3))) > 0)
        sharpness = relief.bend / (relief.bend + np.float32(_MIDDLING_BEND))
        guide = np.maximum(guide, np.float32(_CREASE_HEIGHT) * sharpness).astype(np.float32)
    jumps = mark(relief.jumps)
    return FrameEdges(
        np.where(jumps, np.float32(1), strength),
        edges | jumps,
        np.where(jumps, np.float32(_JUMP_HEIGHT), guide),
        relief,
        note,
    )


@once_per_frame
def combined_strength(frame: RGBDFrame, network: EdgeNetwork, multiscale: bool) -> NDArray[np.float32]:
    """`edge_strength` by "combined", remembered."""
    return np.where(_default_relief(frame).edges, np.float32(1.0), _network_strength(frame, network, multiscale))


@once_per_frame
def canny_strength(frame: RGBDFrame) -> NDArray[np.float32]:
    """Edge strength of a frame in [0, 1], float32 (H, W): by Canny and depth jumps, remembered."""
    return np.where(_default_relief(frame).edges, np.float32(1.0), _canny(frame.rgb, BlockParameters())[0])


@once_per_frame
def _network_strength(frame: RGBDFrame, network: EdgeNetwork, multiscale: bool) -> NDArray[np.float32]:
    return network.strength(frame.rgb, multiscale)


def _canny(rgb: NDArray[np.uint8], parameters: BlockParameters) -> tuple[NDArray[np.float32], NDArray[np.bool_]]:
    """Strength, which is 1 along Canny's lines and below elsewhere, and the lines."""
    dx, dy = colour_gradient(rgb, parameters.canny_sigma)
    lines = canny_edges(dx, dy, parameters.canny_high, parameters.canny_low_ratio)
    beside = np.float32(_BESIDE_CANNY) * gradient_strength(dx, dy)
    return np.where(lines, np.float32(1), beside), lines


def _default_relief(frame: RGBDFrame) -> Relief:
    defaults = BlockParameters()
    return find_relief(frame.depth, defaults.depth_jump, defaults.depth_jump_share)
