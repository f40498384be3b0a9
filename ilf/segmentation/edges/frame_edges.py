"""The edges of a frame, computed once for both blocks and filter: jumps and bends of known depth, and what detectors
find. A missing network is replaced by another detector."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import lru_cache, partial

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..._runtime.long_work import check_cancelled, run_beside
from ..._runtime.networks.models import BUNDLED
from ...data.arrays import without_mask
from ...data.frame import RGBDFrame
from ...data.frame_cache import clear_cached, once_per_frame, once_per_image
from ...data.parameters import BlockParameters, Parameters
from ...data.pixel_grids import Pairs, both, distance_to, filled_from_nearest, long_lines, mark, sides, strips
from ...errors import InputError
from .detectors import (
    Contours,
    DepthEdgeNetwork,
    EdgeNetwork,
    canny_edges,
    check_image,
    colour_gradient,
    gradient_strength,
    load_model,
)

Array = NDArray[np.float32]

# Jumps and bends of the known depth.

MAX_JUMP_DISTANCE = 3.0
"""Maximum distance [px] of a jump from known depth: farther inside a hole, a jump is an artefact of nearest-pixel
filling."""

JUMP_LENGTH = 10
"""Jumps separate surfaces in lines longer than this [px]; shorter ones are flying pixels and noise."""

_CONTINUITY_DISTANCE, _AVERAGED = 6, 9
"""Distance [px] to either side over which a surface must be continuous to count as smooth, and the side [px] of the
squares over which its depth is averaged first."""

_BEND_RADIUS = _CONTINUITY_DISTANCE + _AVERAGED // 2
"""Radius [px] of all depth that is used for a pixel's bend."""

_BEND_SHARE, _BEND_PER_METRE = 0.01, 0.003
"""Maximum deviation from a straight line over `_CONTINUITY_DISTANCE` on a smooth surface, as a fraction of the depth:
the larger of a constant, which a right-angled room corner in a Kinect's image exceeds by about half, and a term that
grows with depth like the noise of such sensors."""


@dataclass(frozen=True, eq=False)
class Relief:
    """Jumps and bends of the known depth, for every pixel or pair of neighbours.

    Attributes
    ----------
    near : ndarray of bool, shape (H, W)
        Pixels within `MAX_JUMP_DISTANCE` of known depth, where a jump would have been detected.
    all_jumps : pair of ndarray of bool
        Neighbours with a depth jump between them.
    jumps : pair of ndarray of bool
        Jumps in lines of more than `JUMP_LENGTH`.
    evaluated : ndarray of bool, shape (H, W)
        Pixels with a valid bend: with enough depth around them, and no jump.
    bend : ndarray of float32, shape (H, W)
        Deviation from a plane where `evaluated`, in multiples of the maximum for a smooth surface; 0 elsewhere.
    filled : ndarray of float32, shape (H, W)
        The depth in which they were found (`filled_depth`) [m]; NaN if none is known at all.
    """

    near: NDArray[np.bool_]
    all_jumps: Pairs
    jumps: Pairs
    evaluated: NDArray[np.bool_]
    bend: NDArray[np.float32]
    filled: NDArray[np.float32]

    @property
    def edges(self) -> NDArray[np.bool_]:
        """Jumps of any length as lines 1 px wide, bool (H, W)."""
        return mark(self.all_jumps)


def find_relief(depth: NDArray[np.float32], jump: float, share: float) -> Relief:
    """Find jumps and bends of the known depth.

    Neighbours of the filled depth (`filled_depth`) that differ by more than max(jump, share * depth) are a jump if
    both lie within 3 px of known depth; so jumps are detected across gaps of up to 6 px.

    A surface bends where the inverse depth, which is linear on a plane, averaged over 9 x 9 pixels, deviates from a
    straight line over 6 px to either side, along the row or along the column. The bend is valid where there is neither
    a jump nor a larger hole in the 21 x 21 pixels around.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.
    jump : float
        Smallest jump [m].
    share : float
        Smallest jump as a fraction of the nearer depth.
    """
    if np.isnan(depth).all():
        nowhere = np.zeros(depth.shape, bool)
        return Relief(nowhere, both(nowhere), both(nowhere), nowhere, np.zeros(depth.shape, np.float32), depth)
    filled = filled_depth(depth)
    check_cancelled()
    near = distance_to(~np.isnan(depth)) <= MAX_JUMP_DISTANCE
    jumps = both(near)
    for rows, *_ in strips(len(depth)):
        for (one, other), trusted in zip(sides(filled[rows.start : rows.stop + 1]), jumps, strict=True):
            here = trusted[rows]
            one, other = one[: len(here)], other[: len(here)]
            here &= np.abs(one - other) > np.maximum(jump, share * np.minimum(one, other))
    # pixels whose whole neighbourhood inside the image is surface
    square = np.ones((2 * _BEND_RADIUS + 1,) * 2, np.uint8)
    surface = (near & ~mark(jumps)).view(np.uint8)
    evaluated = cv2.erode(surface, square, borderType=cv2.BORDER_CONSTANT, borderValue=1) > 0
    return Relief(near, jumps, long_lines(jumps, JUMP_LENGTH), evaluated, _bend(filled, evaluated), filled)


def filled_depth(depth: NDArray[np.float32]) -> NDArray[np.float32]:
    """Depth for finding jumps: gaps filled from the nearest known pixel, outliers removed by a 5 x 5 median.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Depth [m], NaN = missing; at least one known pixel.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth [m] everywhere.
    """
    return np.asarray(cv2.medianBlur(filled_from_nearest(depth), 5), np.float32)


def _bend(filled: NDArray[np.float32], evaluated: NDArray[np.bool_]) -> NDArray[np.float32]:
    # planes continue beyond the image
    beyond = np.pad(1 / filled, _BEND_RADIUS, mode="reflect", reflect_type="odd")
    rim = _BEND_RADIUS - _CONTINUITY_DISTANCE
    inverse = np.asarray(cv2.blur(beyond, (_AVERAGED, _AVERAGED))[rim:-rim, rim:-rim], np.float32)
    bend = np.empty_like(filled)
    for rows, *_ in strips(len(filled)):
        relative = _deviation(inverse[rows.start : rows.stop + 2 * _CONTINUITY_DISTANCE]) * filled[rows]
        relative /= np.maximum(_BEND_SHARE, _BEND_PER_METRE * filled[rows])
        bend[rows] = np.where(evaluated[rows], relative, np.float32(0))
    return bend


def _deviation(inverse: NDArray[np.float32]) -> NDArray[np.float32]:
    """Larger deviation from a straight line along the column or the row, without `_CONTINUITY_DISTANCE` on every
    side."""
    by = _CONTINUITY_DISTANCE
    centre, before, after = slice(by, -by), slice(None, -2 * by), slice(2 * by, None)
    twice = 2 * inverse[centre, centre]
    along_column = inverse[before, centre] - twice + inverse[after, centre]
    along_row = inverse[centre, before] - twice + inverse[centre, after]
    return np.maximum(np.abs(along_column), np.abs(along_row))


# Edges for the filter, from depth edges and contours combined.

_CREST_RADIUS, _CREST_EXPONENT = 3, 4
"""Radius [px] in which the crest of a line is enhanced, and the exponent."""

_CREST_GAIN = 1.4
"""Factor from the probability of a crest to its strength."""

_JUMP_RADIUS, _FULL_WEIGHT_PROBABILITY = 2, 0.5
"""A contour has full weight if a jump within this radius [px] has at least this probability."""


def joined(jump: Array, contours: Array | None = None) -> Array:
    """Edge strength: the crests of the jump probability, and contours weighted by whether a jump is possible there.

    Predicted depth edges are reliable but rarely exact to the pixel; contours are sharp and nearly complete, but also
    divide single surfaces. A gap in an edge does more harm than an extra edge.

    Parameters
    ----------
    jump : ndarray of float32, shape (H, W)
        Probability of a depth jump.
    contours : ndarray of float32, shape (H, W), optional
        Strength of contours in [0, 1].

    Returns
    -------
    ndarray of float32, shape (H, W)
        In [0, 1].
    """
    sharpness = jump / np.maximum(_largest_within(jump, _CREST_RADIUS), np.float32(1e-4))
    crest = _CREST_GAIN * jump * sharpness**_CREST_EXPONENT
    if contours is None:
        return np.minimum(crest, 1).astype(np.float32)
    possible = np.sqrt(np.minimum(_largest_within(jump, _JUMP_RADIUS) / np.float32(_FULL_WEIGHT_PROBABILITY), 1))
    return np.minimum(np.maximum(crest, possible * contours), 1).astype(np.float32)


def _largest_within(values: Array, radius: int) -> Array:
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * radius + 1,) * 2)
    return np.asarray(cv2.dilate(values, disk), np.float32)


# All edges of a frame: computed once, with a fallback for a missing network.

_OFF_LINE_FACTOR = 0.9
"""Factor on the gradient's strength off Canny's lines, which must be the highest."""

CANNY_INSTEAD = "Canny's edges replace those of the network"

_FALLBACKS = {
    "rgbd": ("hed", "Contours of the colour image replace depth edges"),
    "hed": ("canny", CANNY_INSTEAD),
}
"""Detector -> its fallback if its network is missing or fails, and the note about it."""


@dataclass(frozen=True, eq=False)
class FrameEdges:
    """Edges of a frame from colour and known depth.

    Attributes
    ----------
    detected : ndarray of float32, shape (H, W)
        Strength in [0, 1] by the detector: contours that a network predicts from colour; Canny's edges, 1 along its
        lines and lower elsewhere; or the probability of a depth jump that a network predicts from colour and known
        depth.
    probability : ndarray of float32, shape (H, W)
        The same as probabilities of a boundary, if the network gives them (`Contours`).
    strength : ndarray of float32, shape (H, W)
        Edges for the edge-aware filter: `probability` (for depth edges, their crests combined with contours by
        `joined`), and depth jumps of any length at 1.
    network : str or None
        SHA-256 of the network of `detected`; None for Canny.
    crease : ndarray of float32, shape (H, W), or None
        Probability that the surface bends sharply, if the detector predicts it.
    notes : tuple of str
        Why another detector replaces the requested one, if so.
    """

    detected: NDArray[np.float32]
    probability: NDArray[np.float32]
    strength: NDArray[np.float32]
    network: str | None
    crease: NDArray[np.float32] | None = None
    notes: tuple[str, ...] = ()


def find_edges(frame: RGBDFrame, parameters: BlockParameters) -> FrameEdges:
    """Find the frame's edges with the parameters of their detectors; they are cached with the frame.

    Parameters
    ----------
    frame : RGBDFrame
    parameters : BlockParameters
        Those under "Edges" except the threshold are used. Without `use_depth`, jumps are found with the defaults.

    Returns
    -------
    FrameEdges
        Read-only. If the requested network is missing or invalid, the edges of the next best detector, with a note.
    """
    detector, notes = parameters.detector, []
    while True:
        try:
            found = _edges_by(frame, detector, parameters)
        except InputError as error:
            if detector not in _FALLBACKS:
                raise
            detector, what = _FALLBACKS[detector]
            notes.append(f"{what}: {error}")
        else:
            return dataclasses.replace(found, notes=(*notes, *found.notes))


def _edges_by(frame: RGBDFrame, detector: str, parameters: BlockParameters) -> FrameEdges:
    """The edges by one detector; InputError if its network is missing or invalid."""
    network: DepthEdgeNetwork | EdgeNetwork | None = None
    if detector != "canny":
        is_rgbd = detector == "rgbd"
        network = DepthEdgeNetwork.bundled() if is_rgbd else load_model(parameters.model)
    multiscale = detector == "hed" and parameters.multiscale
    return _find(frame, network, multiscale, _canny(parameters), _jump(parameters))


def relief_of(frame: RGBDFrame, parameters: BlockParameters) -> Relief:
    """Jumps and bends of a frame's known depth, cached with it; without `use_depth`, with the default smallest
    jumps."""
    return _relief(frame, *_jump(parameters))


def canny_lines(frame: RGBDFrame, parameters: BlockParameters) -> NDArray[np.bool_]:
    """Canny's lines in a frame's colour, bool (H, W), cached with the colour."""
    return _lines(frame.edge_rgb, *_canny(parameters))


def clear_evidence_cache(frame: RGBDFrame) -> None:
    """Clear the cached relief and lines, which only another extraction uses; edges stay."""
    clear_cached(frame, _relief)
    clear_cached(frame.edge_rgb, _lines)


@once_per_frame
def depth_edges(frame: RGBDFrame, network: DepthEdgeNetwork) -> tuple[Array, Array]:
    """Depth jumps and creases predicted from the frame's colour and depth, cached with the frame."""
    return network.look(frame.edge_rgb, frame.depth)


@once_per_image
def network_contours(rgb: NDArray[np.uint8], network: EdgeNetwork, multiscale: bool) -> Contours:
    """Contours of a frame's colour by the network, cached with the colour."""
    return network.contours(rgb, multiscale)


def canny_strength(rgb: NDArray[np.uint8], sigma: float, high: float, low_ratio: float) -> NDArray[np.float32]:
    """Strength of Canny's edges: 1 along its lines and lower elsewhere."""
    dx, dy = colour_gradient(rgb, sigma)
    beside = np.float32(_OFF_LINE_FACTOR) * gradient_strength(dx, dy)
    return np.where(canny_edges(dx, dy, high, low_ratio), np.float32(1), beside)


_canny_of_frame = once_per_image(canny_strength)


@once_per_image
def _lines(rgb: NDArray[np.uint8], sigma: float, high: float, low_ratio: float) -> NDArray[np.bool_]:
    return canny_edges(*colour_gradient(rgb, sigma), high, low_ratio)


@once_per_frame
def _relief(frame: RGBDFrame, jump: float, share: float) -> Relief:
    return find_relief(frame.depth, jump, share)


def _canny(parameters: BlockParameters) -> tuple[float, float, float]:
    return parameters.canny_sigma, parameters.canny_high, parameters.canny_low_ratio


def _jump(parameters: BlockParameters) -> tuple[float, float]:
    """Smallest jump [m], and smallest jump as a fraction of depth."""
    counts = parameters if parameters.use_depth else BlockParameters()
    return counts.depth_jump, counts.depth_jump_share


@once_per_frame
def _find(
    frame: RGBDFrame,
    network: DepthEdgeNetwork | EdgeNetwork | None,
    multiscale: bool,
    canny: tuple[float, float, float],
    jump: tuple[float, float],
) -> FrameEdges:
    crease: Array | None = None
    notes: tuple[str, ...] = ()
    with run_beside(partial(_relief, frame, *jump)):
        if isinstance(network, EdgeNetwork):
            detected, probability = network_contours(frame.edge_rgb, network, multiscale)
        elif network is None:
            detected = probability = _canny_of_frame(frame.edge_rgb, *canny)
        else:
            probability, crease = depth_edges(frame, network)
            detected = probability
    strength = probability
    if isinstance(network, DepthEdgeNetwork):
        contours, notes = _bundled_contours(frame)
        strength = joined(strength, contours)
    strength = np.where(_relief(frame, *jump).edges, np.float32(1), strength)
    sha256 = None if network is None else network.sha256
    return FrameEdges(detected, probability, strength, sha256, crease, notes)


def _bundled_contours(frame: RGBDFrame) -> tuple[NDArray[np.float32] | None, tuple[str, ...]]:
    """Contours by the bundled network, to be combined with depth edges; or a note on why there are none."""
    try:
        return network_contours(frame.edge_rgb, EdgeNetwork.bundled(), False)[1], ()
    except InputError as error:
        return None, (f"Depth edges are not combined with contours of the colour image: {error}",)


# The edges that a filter with given parameters uses.


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


# Edge strength of a frame or of a colour image, by one detector.

DETECTORS = ("rgbd", "combined", "hed", "canny", "depth")
"""Detectors of `edge_strength`."""

_NEEDING_DEPTH = ("rgbd", "combined", "depth")
"""Detectors that need known depth."""


def edge_strength(
    image: RGBDFrame | ArrayLike, detector: str = "combined", *, model: str = BUNDLED, multiscale: bool = False
) -> NDArray[np.float32]:
    """Edge strength by one detector (section 2).

    Parameters
    ----------
    image : RGBDFrame, or array of uint8, shape (H, W, 3)
        A frame, or a colour image (RGB) for "hed" and "canny".
    detector : str
        "hed": contours by the edge network. "canny": Canny's edges at 1, the colour gradient up to 0.9 elsewhere.
        "depth": 1 at jumps of the known depth, 0 elsewhere. "combined": the larger of the probability of a contour and
        "depth", as the filter sees them. "rgbd": the probability of a depth jump by the network for colour and known
        depth, and 1 at jumps of the known depth.
    model : str
        Name of the network of "hed" and "combined", one of `ilf._runtime.networks.models.model_names()`.
    multiscale : bool
        Run that network at three scales: slightly better, 3.5 times as slow.

    Returns
    -------
    ndarray of float32, shape (H, W)
        In [0, 1].

    Raises
    ------
    InputError
        For an unknown detector, an unsuitable image, a missing depth where it is needed, or an edge network that is
        missing or invalid.

    Examples
    --------
    >>> import numpy as np
    >>> rgb = np.zeros((20, 30, 3), np.uint8)
    >>> rgb[:, 15:] = 200
    >>> edge_strength(rgb, "canny")[10, [3, 14]].tolist()
    [0.0, 1.0]
    """
    if detector not in DETECTORS:
        raise InputError(f"There is no detector {detector!r}. Select one of {', '.join(DETECTORS)}.")
    defaults = BlockParameters(detector="hed", model=model, multiscale=multiscale)
    frame = image if isinstance(image, RGBDFrame) else None
    if frame is None and detector in _NEEDING_DEPTH:
        raise InputError(f"The detector {detector!r} needs a frame with depth (ilf.RGBDFrame), not colour alone.")
    rgb = image.edge_rgb if isinstance(image, RGBDFrame) else without_mask(image)
    check_image(rgb)
    if detector == "canny":
        return canny_strength(rgb, defaults.canny_sigma, defaults.canny_high, defaults.canny_low_ratio)
    if frame is None:
        return load_model(model).strength(rgb, multiscale)
    if detector == "depth":
        return find_relief(frame.depth, defaults.depth_jump, defaults.depth_jump_share).edges.astype(np.float32)
    # no fallback for a missing network here
    if detector == "hed":
        return network_contours(frame.edge_rgb, load_model(model), multiscale)[0].copy()
    return _edges_by(frame, "rgbd" if detector == "rgbd" else "hed", defaults).strength.copy()
