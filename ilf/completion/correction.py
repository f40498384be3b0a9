"""The correction: changes of completed depth by a network.

The network's input is the frame's base completion: its blocks as extracted, completed with `UNCORRECTED`. So its output
depends only on the frame and its extraction, and a block's result only on frame and block, whatever else is run.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import partial, reduce

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.long_work import run_beside
from .._runtime.memory import release_memory
from .._runtime.networks.models import CORRECTION
from .._runtime.networks.network import OnnxNetwork, as_input, reflected, trial_images
from ..data.blocks import SPARSE, Block, find_blocks
from ..data.by_hand import DepthByHand
from ..data.frame import RGBDFrame
from ..data.frame_cache import FrameCache
from ..data.parameters import BlockParameters, Parameters
from ..data.pixel_grids import distance_to
from ..data.presets import preset
from ..data.results import BlockResult
from ..errors import FormatError, InputError
from ..segmentation.edges.detectors import DEPTH_CHANNELS, features_of, filled_log_depth
from ..segmentation.edges.frame_edges import FrameEdges, edges_for
from ..segmentation.extraction import found_blocks
from .banded import solve_linked
from .block import BlockTask, is_guided
from .sparse_correction import SparseCorrectionNetwork
from .suspects import suspect_islands, without_suspects

Array = NDArray[np.float32]
Floats = NDArray[np.floating]

# Input features of the correction network: the same in training and in use.

CHANNELS = (*DEPTH_CHANNELS, "completed", "departure", "completed relief", "contours")
"""The channels of `correction_features`, in this order."""

_DEPARTURE_GAIN, _RELIEF_GAIN = 4, 20
_FINE = 5


def correction_features(depth: Array, completed: Array, contours: Array) -> tuple[Array, Array]:
    """Compute the network's input from known and completed depth and contours, independent of scale.

    Parameters
    ----------
    depth : ndarray of float32, shape (H, W)
        Known depth [m], NaN = missing; at least one known pixel.
    completed : ndarray of float32, shape (H, W)
        Completed depth [m]; NaN where it has not been completed.
    contours : ndarray of float32, shape (H, W)
        Strength of the filter's edges, in [0, 1].

    Returns
    -------
    features : ndarray of float32, shape (10, H, W)
        In the order of `CHANNELS`: those of `depth_features`; the completed log depth; its difference from log depth
        with gaps filled from around; its difference from its mean in 5 x 5 pixels; the contours.
    log_depth : ndarray of float32, shape (H, W)
        The completed log depth minus the median of the known one, filled from around where it has not been completed.
    """
    filled, median = filled_log_depth(depth)
    filled -= np.float32(median)
    with np.errstate(invalid="ignore"):
        log_depth = np.where(np.isfinite(completed), np.log(completed) - np.float32(median), filled).astype(np.float32)
    further = (
        log_depth,
        _DEPARTURE_GAIN * (log_depth - filled),
        _RELIEF_GAIN * (log_depth - cv2.blur(log_depth, (_FINE, _FINE))),
        contours,
    )
    return features_of(filled, np.isfinite(depth), further), log_depth


# Changes of depth spread from cell to cell, according to the conductance of the links.

LEAK = 1e-8
"""Minimum weight with which every cell is pulled to 0, so that there is always a solution."""


def load_of(right: Floats, below: Floats, rise_right: Floats, rise_below: Floats, pull: Floats) -> Floats:
    """The right-hand side for rises along the links, and for the cells' target values times their weights."""
    load = pull.copy()
    load[:, 1:] += right * rise_right
    load[:, :-1] -= right * rise_right
    load[1:] += below * rise_below
    load[:-1] -= below * rise_below
    return load


def spread(links: NDArray[np.float32]) -> NDArray[np.float32]:
    """Compute the changes of the cells.

    Parameters
    ----------
    links : ndarray of float32, shape (6, H, W)
        Conductances of the links to the right (unused in the last column) and below (unused in the last row), the
        wanted rises of the change along them, the weight of each cell's target, and that weight times the target.

    Returns
    -------
    ndarray of float32, shape (H, W)
        The minimum of sum held u^2 - 2 pull u + sum conductance (u_next - u - rise)^2.
    """
    right, below, rise_right, rise_below, held, pull = links
    right, rise_right, below, rise_below = right[:, :-1], rise_right[:, :-1], below[:-1], rise_below[:-1]
    load = load_of(right, below, rise_right, rise_below, pull).astype(np.float64)
    return solve_linked(right, below, held.astype(np.float64) + LEAK, load[None])[0].astype(np.float32)


# The correction network in use: changes of completed depth from colour, known and completed depth.

CELL = 4
"""Side [px] of the cells that changes spread between."""

MULTIPLE = 32
"""The sides of the network's input are multiples of this."""

LARGEST = 1.0
"""Maximum change of log depth."""

LONGEST_SIDE = 640
"""A frame with a longer side [px] is scaled down to this: the network was trained at this size."""

_LINKS, _AROUND, _PAIR = 6, 9, 2

_NOISE_LEVEL = 0.008
"""Change of log depth above which most of it is applied: smaller changes are no better than noise."""

_MEDIAN = 5
"""Side [px] of the median filter that removes single cells."""

_WINDOW, _DIFFERENCE, _NEAR = 7, 0.03, 2.0
"""The bilateral filter that removes the cells' grid, at half the size: its side [px] and its standard deviations, in
change of log depth and in position [px]."""


class CorrectionNetwork(OnnxNetwork):
    """A correction network, ready to run. `bundled` creates one; it may be used from any thread.

    The file is an ONNX network of two inputs, `image`, RGB in [0, 1] as float32 (1, 3, H, W), and `features`, the
    `correction_features`, H and W multiples of 32. Its outputs are `links`, (1, 6, H/4, W/4), in the order that
    `spread` expects, and `logits`, (1, 36, H/2, W/2): for each pixel the unnormalised logarithms of its weights for the
    9 cells around it; those of 2 x 2 pixels together.
    """

    KIND, NAME = "correction network", CORRECTION

    def change(self, rgb: NDArray[np.uint8], depth: Array, completed: Array, contours: Array) -> Array:
        """Compute the change of the logarithm of completed depth.

        Parameters
        ----------
        rgb : ndarray of uint8, shape (H, W, 3)
        depth : ndarray of float32, shape (H, W)
            Known depth [m], NaN = missing; at least one known pixel.
        completed : ndarray of float32, shape (H, W)
            Completed depth [m], NaN where it is missing.
        contours : ndarray of float32, shape (H, W)
            Strength of the filter's contours, in [0, 1].

        Returns
        -------
        ndarray of float32, shape (H, W)
        """
        height, width = depth.shape
        scale = LONGEST_SIDE / max(height, width)
        if scale < 1:
            size = max(1, round(width * scale)), max(1, round(height * scale))
            rgb, contours = (cv2.resize(one, size, interpolation=cv2.INTER_AREA) for one in (rgb, contours))  # type: ignore[assignment]
            small = cv2.resize(depth, size, interpolation=cv2.INTER_NEAREST)
            if np.isfinite(small).any():
                completed = cv2.resize(completed, size, interpolation=cv2.INTER_NEAREST)  # type: ignore[assignment]
                found = self._predict(rgb, np.asarray(small, np.float32), completed, contours)
                return np.asarray(cv2.resize(found, (width, height), interpolation=cv2.INTER_LINEAR), np.float32)
            return np.zeros(depth.shape, np.float32)
        return self._predict(rgb, depth, completed, contours)

    def _predict(self, rgb: NDArray[np.uint8], depth: Array, completed: Array, contours: Array) -> Array:
        image, window = reflected(rgb, MULTIPLE)
        features, _ = correction_features(depth, completed, contours)
        size = image.shape[:2]
        whole, _ = reflected(features, MULTIPLE, axis=1)
        outputs = self._forward({"image": as_input(image), "features": whole[None]})
        shapes = [one.shape for one in outputs]
        cells, pairs = (tuple(side // length for side in size) for length in (CELL, _PAIR))
        if shapes != [(1, _LINKS, *cells), (1, _AROUND * _PAIR**2, *pairs)]:
            raise FormatError(self._unlike(f"its output shapes for an image of {size} are {shapes}."))
        if not all(np.isfinite(one).all() for one in outputs):
            raise FormatError(f"{self.path.name} returns values that are not finite for this frame.")
        links, logits = outputs[0][0], outputs[1][0]
        with run_beside(partial(spread, links)) as changes:
            weights = _weights_of(logits)
        return smoothed(_weighted(changes.result(), weights))[window]

    def _try(self) -> None:
        for ramp in trial_images():
            depth = np.asarray(1 + ramp[..., 0] / 255, np.float32)
            known = np.where(ramp[..., 1] > 128, depth, np.float32(np.nan))
            found = self._predict(ramp, known, depth, np.zeros_like(depth))
            if not np.isfinite(found).all():
                raise FormatError(self._unlike("its changes are not finite."))


def smoothed(change: Array) -> Array:
    """Remove small changes, specks and the grid of the cells; edges stay."""
    change = np.clip(change, -LARGEST, LARGEST)
    found = np.asarray(change * -np.expm1(-np.square(change / np.float32(_NOISE_LEVEL))), np.float32)
    for _ in range(2):
        found = np.asarray(cv2.medianBlur(found, _MEDIAN), np.float32)
    half = cv2.resize(found, (found.shape[1] // 2, found.shape[0] // 2), interpolation=cv2.INTER_AREA)
    # what the filter takes away at half the size, so that edges keep their sharpness
    rough = half - cv2.bilateralFilter(half, _WINDOW, _DIFFERENCE, _NEAR)
    return np.asarray(found - cv2.resize(rough, found.shape[::-1], interpolation=cv2.INTER_LINEAR), np.float32)


def _weights_of(logits: Array) -> Array:
    """The weights of the cells around every pair of pixels, of any sum, (9, 4, H/2, W/2)."""
    of_cells = logits.reshape(_AROUND, _PAIR**2, *logits.shape[1:])
    weights = of_cells - of_cells.max(axis=0)
    return np.exp(weights, out=weights)


def _weighted(cells: Array, weights: Array) -> Array:
    """For every pixel, the weighted mean over its cell and those around it."""
    height, width = weights.shape[2:]
    # a cell's value is repeated at each of its pairs of pixels, like the logits
    around = np.pad(cells, 1, mode="edge").repeat(CELL // _PAIR, axis=0).repeat(CELL // _PAIR, axis=1)
    total = np.zeros_like(weights[0])
    for k, weight in enumerate(weights):
        row, column = (place * (CELL // _PAIR) for place in divmod(k, 3))
        total += weight * around[row : row + height, column : column + width]
    mean = (total / weights.sum(axis=0)).reshape(_PAIR, _PAIR, height, width)
    return np.ascontiguousarray(mean.transpose(2, 0, 3, 1)).reshape(_PAIR * height, _PAIR * width)


# The correction of a frame: by the network, and in sparse frames by a second one.

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
    faded = distance_to(known)
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
    network = CorrectionNetwork.bundled()
    if edges.network is None:
        raise InputError("the correction network needs the contours of the edge network.")
    return network, SparseCorrectionNetwork.bundled() if frame.known.mean() < SPARSE else None


def unapplied_change(frame: RGBDFrame, completed: Array, edges: FrameEdges) -> Array:
    """Run the networks on a frame's completed depth [m]: the change of log depth for `applied_change`, in this frame
    or where another one shows the same points.

    Raises
    ------
    InputError
        As `correction_networks`, or if a network's output is not finite.
    """
    return reduce(np.add, _changes(correction_networks(frame, edges), frame, completed, edges.probability))


def _changes(networks: Networks, frame: RGBDFrame, completed: Array, contours: Array) -> tuple[Array, ...]:
    """Changes of log depth by each network, which sees the effect of those before."""
    network, further = networks
    change = network.change(frame.edge_rgb, frame.depth, completed, contours)
    if further is None:
        return (change,)
    applied = applied_change(change, frame.known)
    corrected = np.asarray(completed * np.exp(applied), np.float32)
    return change, further.change(frame.edge_rgb, frame.depth, corrected, applied, contours)


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
        frame, completed = self.frame, self.frame.depth.copy()
        for result in results:
            completed[result.block.box][result.block.mask] = result.depth
        left = frame.unfilled_mask()
        if left is not None:  # whatever the run's parameters are
            completed[left] = np.nan
        completed[suspect_islands(frame)] = np.nan
        trusted = without_suspects(frame)
        changes = _changes(networks, trusted, completed, self.edges.probability)
        change = reduce(np.add, (applied_change(one, trusted.known) for one in changes))
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
