"""EBS: colour and depth -> operation blocks, stage by stage (section 2)."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.long_work import check_cancelled
from .._runtime.memory import release_memory
from ..data.blocks import Blocks
from ..data.declarations import Value
from ..data.frame import RGBDFrame, checked_frame
from ..data.frame_cache import clear_cached, once_per_frame, once_per_image
from ..data.parameters import BlockParameters, Parameters, as_block_parameters
from ..data.pixel_grids import Pairs, connected_regions, different_labels, distance_to, flood, long_lines, mark, spread
from .edges.detectors import otsu_edges
from .edges.frame_edges import JUMP_LENGTH, FrameEdges, Relief, canny_lines, clear_evidence_cache, find_edges, relief_of
from .merging import RegionGraph, keep_existing, numbered

# Boundaries from a frame's edges: their strength, binarised edges, and the guide of the contraction.

_CANNY_RAISE, _JUMP_HEIGHT, _CREASE_HEIGHT = 0.3, 1.5, 0.9
"""In the guide of the contraction: the weight of Canny's lines added to the network's strength, and the heights of
jumps and of the sharpest creases."""

_HALF_HEIGHT_BEND = 1.5
"""Bend at which a crease has half the height of the sharpest one."""


def find_boundaries(
    found: FrameEdges, lines: NDArray[np.bool_], relief: Relief, parameters: BlockParameters
) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
    """Find possible boundaries of blocks from a frame's edges.

    Parameters
    ----------
    found : FrameEdges
    lines : ndarray of bool, shape (H, W)
        Canny's lines.
    relief : Relief
    parameters : BlockParameters
        The same as for `find_edges`, `canny_lines` and `relief_of`.

    Returns
    -------
    edges : ndarray of bool, shape (H, W)
        The binarised strength, and depth jumps in long lines if depth is used.
    guide : ndarray of float32, shape (H, W)
        Landscape of the contraction: boundaries follow its crests.
    """
    edges, guide = lines, found.detected
    if found.network is not None:
        strength = _detected(found, parameters)
        edges = otsu_edges(strength, parameters.threshold)
        guide = np.where(lines, strength + np.float32(_CANNY_RAISE), strength)
    if not parameters.use_depth:
        return edges, guide
    if parameters.use_creases and found.crease is None:
        # single pixels are noise
        edges = edges | (cv2.morphologyEx((relief.bend > 1).astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3))) > 0)
        sharpness = relief.bend / (relief.bend + np.float32(_HALF_HEIGHT_BEND))
        guide = np.maximum(guide, np.float32(_CREASE_HEIGHT) * sharpness).astype(np.float32)
    jumps = mark(relief.jumps)
    return edges | jumps, np.where(jumps, np.float32(_JUMP_HEIGHT), guide)


def edge_and_jump_strength(
    found: FrameEdges, relief: Relief | None, parameters: BlockParameters
) -> NDArray[np.float32]:
    """Edge strength in [0, 1], float32 (H, W); depth jumps in long lines are at 1 if there is a relief. If creases
    count as edges and the detector finds them, the larger of edge and crease."""
    strength = _detected(found, parameters)
    return strength if relief is None else np.where(mark(relief.jumps), np.float32(1), strength)


def _detected(found: FrameEdges, parameters: BlockParameters) -> NDArray[np.float32]:
    """Strength by the detector, and by its creases if they count."""
    if parameters.use_depth and parameters.use_creases and found.crease is not None:
        return np.maximum(found.detected, found.crease)
    return found.detected


# From edges to watertight boundaries: dilation, and contraction with the edges as the guide (section 2).

_EXTRA_DILATIONS = (32, 16, 8, 4, 2)
"""Additional dilations [px] at which regions are searched, to separate regions that only a neck connects."""

_SNAP_DISTANCE = 5
"""Maximum distance [px] of a boundary from a depth jump to which it is moved."""

_FAR, _NEAR = 1, 2
"""Sides of a depth jump."""

_MIN_REGION_PIXELS = 4
"""Minimum number of pixels of a region before it grows."""


def dilate(edges: NDArray[np.bool_], radius: float) -> NDArray[np.bool_]:
    """Edges dilated by a disk, so that gaps of up to two radii close.

    Parameters
    ----------
    edges : ndarray of bool, shape (H, W)
    radius : float
        Radius of the disk [px].
    """
    return distance_to(edges) <= radius


def regions_between(edges: NDArray[np.bool_], radius: float, inside: NDArray[np.bool_]) -> NDArray[np.int32]:
    """4-connected regions between dilated edges: those of the widest dilation, and additional ones of narrower ones.

    The edges of a surface are rarely closed all around; a gap is a neck between two regions, which closes at some
    dilation. Regions that are separated only because of that are merged again later.

    Parameters
    ----------
    edges : ndarray of bool, shape (H, W)
    radius : float
        The narrowest dilation [px].
    inside : ndarray of bool, shape (H, W)
        Pixels in which regions may lie.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Regions 1, 2, ...; 0 on the dilated edges and outside. If the edges cover everything, the regions of `inside`.
    """
    distance = distance_to(edges)
    distance[~inside] = -1
    regions, parts, largest = np.zeros(edges.shape, np.int32), None, 0
    for further in (*_EXTRA_DILATIONS, 0):
        parts = _parts(distance > radius + further, parts)
        largest = _add_new_parts(parts.ravel(), regions.ravel(), largest)
    if not regions.any():
        # edges everywhere separate nothing
        regions = _parts(inside)
    return regions


def _add_new_parts(parts: NDArray[np.int32], regions: NDArray[np.int32], largest: int) -> int:
    """Add the parts without any region as new regions, in place; takes and returns the largest region number.

    Part 0 and parts of fewer than `_MIN_REGION_PIXELS` pixels are ignored.
    """
    new = np.bincount(parts) >= _MIN_REGION_PIXELS
    new[0] = False
    new[parts[regions > 0]] = False
    numbers = np.where(new, np.cumsum(new, dtype=np.int32) + np.int32(largest), 0)
    np.copyto(regions, numbers[parts], where=new[parts])
    return int(numbers.max(initial=largest))


def _parts(mask: NDArray[np.bool_], memory: NDArray[np.int32] | None = None) -> NDArray[np.int32]:
    """The 4-connected parts of a mask; in the memory of earlier ones, since fresh memory takes as long as the parts."""
    return np.asarray(cv2.connectedComponents(mask.view(np.uint8), memory, connectivity=4)[1], np.int32)


def contract(
    regions: NDArray[np.int32], strength: NDArray[np.float32], inside: NDArray[np.bool_] | None = None
) -> NDArray[np.int32]:
    """Grow the regions into the dilated boundary until they meet where the edges are strongest.

    This is a watershed from the regions over the edge strength: every pixel ends in one region, so the result is
    watertight by construction.

    Parameters
    ----------
    regions : ndarray of int32, shape (H, W)
        Regions > 0 to grow, 0 elsewhere.
    strength : ndarray of float32, shape (H, W)
        Edge strength; the edges that guide the contraction have the highest values.
    inside : ndarray of bool, shape (H, W), optional
        Pixels into which regions may grow; everywhere if left out.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Regions that touch each other, 0 outside; all 0 where there was no region to start from.
    """
    if not regions.any():
        return regions.copy()
    # pixels deep inside a region do not matter, and would only fill the queue
    open_ground = (regions == 0) if inside is None else (regions == 0) & inside
    seam = cv2.dilate(open_ground.view(np.uint8), np.ones((3, 3), np.uint8)) > 0
    grown = flood(strength, regions, seam if inside is None else seam & inside)
    np.copyto(grown, regions, where=~open_ground)
    return grown


def snap_to_jumps(regions: NDArray[np.int32], jumps: Pairs) -> NDArray[np.int32]:
    """Move boundaries that run a few pixels beside a depth jump to it.

    Edges of colour lie slightly off those of depth. Around jumps inside a region, a narrow band of the regions is
    cleared, and the regions grow into it again from all sides, but not across a jump.

    Parameters
    ----------
    regions : ndarray of int32, shape (H, W)
        Regions > 0, 0 for none.
    jumps : pair of ndarray of bool
        Neighbours with a depth jump between them.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Regions, some of them of several pieces.
    """
    parted = different_labels(regions)
    inner = mark((jumps[0] & ~parted[0], jumps[1] & ~parted[1])) & (regions > 0)
    if not inner.any():
        return regions
    band = distance_to(inner) <= _SNAP_DISTANCE
    passages = ~jumps[0], ~jumps[1]
    grown = spread(np.where(band, 0, regions), band & (regions > 0), passages, 2 * _SNAP_DISTANCE)
    return np.where(grown > 0, grown, regions)


def cut_at_jumps(regions: NDArray[np.int32], guide: NDArray[np.float32], relief: Relief) -> NDArray[np.int32]:
    """Divide regions with a depth jump inside into the pixels on its near side and those on its far side.

    Both sides grow from the jump until they meet, where the guide is highest or, without edges, straight on from the
    jump's end. So every region with a jump inside becomes several, also where edges of colour lie slightly off those of
    depth; merging joins what no jump parts.

    Parameters
    ----------
    regions : ndarray of int32, shape (H, W)
        Regions > 0, 0 for none.
    guide : ndarray of float32, shape (H, W)
        Landscape of the contraction.
    relief : Relief

    Returns
    -------
    ndarray of int32, shape (H, W)
        Regions, each of them 4-connected, in any order.
    """
    parted = different_labels(regions)
    inner = long_lines((relief.jumps[0] & ~parted[0], relief.jumps[1] & ~parted[1]), JUMP_LENGTH)
    depth, side = relief.filled.ravel(), np.zeros(regions.size, np.int32)
    width = regions.shape[1]
    here = np.concatenate([np.flatnonzero(np.pad(inner[0], ((0, 0), (0, 1)))), np.flatnonzero(inner[1])])
    beyond = here + np.repeat([1, width], [np.count_nonzero(jumps) for jumps in inner])
    closer = depth[here] < depth[beyond]
    side[np.where(closer, beyond, here)] = _FAR
    side[np.where(closer, here, beyond)] = _NEAR  # also a pixel between two jumps, as part of the object in front
    side[regions.ravel() == 0] = 0
    sides = side.reshape(regions.shape)
    cut = np.zeros(int(regions.max()) + 1, bool)
    cut[regions[sides > 0]] = True
    grown = flood(np.where(sides > 0, np.float32(0), guide), sides, cut[regions])
    grown += 3 * regions
    return connected_regions(grown)


# The extraction: all stages, each cached with the frame.

_MEDIUM_MERGE_COST = 0.2
"""Maximum cost of a border for merging regions at a granularity of 0.5; it is 1 at 0 and the square of this at 1."""


_MERGING_DEFAULTS = {
    name: getattr(BlockParameters(), name) for name in ("granularity", "min_size", "min_known_share", "existence_rate")
}
"""Default values of the parameters that matter only after the contraction."""


@dataclass(frozen=True, eq=False)
class Extraction:
    """The results of all stages, each of shape (H, W).

    Attributes
    ----------
    strength : ndarray of float32
        Edge strength in [0, 1]; depth jumps are at 1.
    edges : ndarray of bool
        The same, binarised.
    dilated : ndarray of bool
        The binarised edges, dilated.
    contracted : ndarray of int32
        Regions after the contraction, without gaps between them: more and smaller ones than blocks.
    blocks : ndarray of int32
        The label map: operation blocks 1, 2, ... in order of decreasing size, 0 = none.
    network : str or None
        SHA-256 of the edge network that was actually used; None if Canny's edges were.
    notes : tuple of str
        Notes for the user, such as a substituted edge detector; empty if all was as requested.
    """

    strength: NDArray[np.float32]
    edges: NDArray[np.bool_]
    dilated: NDArray[np.bool_]
    contracted: NDArray[np.int32]
    blocks: NDArray[np.int32]
    network: str | None = None
    notes: tuple[str, ...] = ()


def extract(frame: RGBDFrame, parameters: BlockParameters | None = None) -> Extraction:
    """Extract boundaries and surfaces, and return the result of every stage.

    The frame's edges, regions and blocks are cached with it, so that changing a parameter repeats only later stages.

    Parameters
    ----------
    frame : RGBDFrame
    parameters : BlockParameters, optional
    """
    chosen = parameters or BlockParameters()
    found = found_blocks(frame, chosen)
    edges, _ = _boundaries(frame, chosen)
    return Extraction(
        edge_and_jump_strength(find_edges(frame, chosen), _relief(frame, chosen), chosen),
        edges,
        dilate(edges, chosen.dilation),
        _regions(frame, chosen.replace(**_MERGING_DEFAULTS)),
        found.labels.copy(),
        found.network,
        found.notes,
    )


def found_blocks(frame: RGBDFrame, parameters: BlockParameters | None) -> Blocks:
    """The blocks alone, without the results of the stages, which take time and memory. The label map is cached."""
    chosen = as_block_parameters(parameters)
    edges = find_edges(checked_frame(frame), chosen)
    labels = _blocks(frame, chosen)
    return Blocks(labels, extraction=chosen, network=edges.network, extracted=labels, notes=edges.notes)


def clear_stage_cache(frame: RGBDFrame) -> None:
    """Clear the cached regions of a frame and the data that they depend on, a third of all that is cached for it.
    Blocks and edges stay."""
    clear_cached(frame, _regions)
    clear_evidence_cache(frame)


def _relief(frame: RGBDFrame, parameters: BlockParameters) -> Relief | None:
    """Jumps and bends of the known depth; None if depth is not used."""
    return relief_of(frame, parameters) if parameters.use_depth else None


def _boundaries(frame: RGBDFrame, parameters: BlockParameters) -> tuple[NDArray[np.bool_], NDArray[np.float32]]:
    edges, lines = find_edges(frame, parameters), canny_lines(frame, parameters)
    return find_boundaries(edges, lines, relief_of(frame, parameters), parameters)


@once_per_frame
def _blocks(frame: RGBDFrame, parameters: BlockParameters) -> NDArray[np.int32]:
    """The label map, int32 (H, W)."""
    regions = _regions(frame, parameters.replace(**_MERGING_DEFAULTS))
    relief = _relief(frame, parameters)
    strength = edge_and_jump_strength(find_edges(frame, parameters), relief, parameters)
    smallest = parameters.smallest_block(regions.size)
    check_cancelled()
    graph = RegionGraph(regions, strength, frame, relief)
    release_memory(regions.size)
    check_cancelled()
    limit = _MEDIUM_MERGE_COST ** (2 * parameters.granularity)
    graph.merge_below(limit)
    density = float(frame.known.mean())
    graph.merge_unfit(smallest, parameters.min_known_share, Parameters().min_known_pixels, density)
    graph.merge_below(limit)  # borders and planes have changed
    blocks = graph.labels()
    if parameters.existence_rate > 0:
        blocks = numbered(keep_existing(blocks, frame.known, parameters.existence_rate, smallest))
    return blocks


@once_per_frame
def _regions(frame: RGBDFrame, parameters: BlockParameters) -> NDArray[np.int32]:
    """The regions after the contraction, int32 (H, W)."""
    top, bottom, left, right = find_margins(frame.edge_rgb) if parameters.margin < 0 else (parameters.margin,) * 4
    inside = np.zeros(frame.shape, bool)
    inside[top : frame.shape[0] - bottom, left : frame.shape[1] - right] = True
    edges, guide = _boundaries(frame, parameters)
    seeds = regions_between(edges, parameters.dilation, inside)
    check_cancelled()
    regions = contract(seeds, guide, inside)
    check_cancelled()
    relief = _relief(frame, parameters)
    return regions if relief is None else cut_at_jumps(snap_to_jumps(regions, relief.jumps), guide, relief)


def extract_blocks(frame: RGBDFrame, parameters: BlockParameters | None = None, **changes: Value) -> NDArray[np.int32]:
    """Extract the operation blocks of a frame by EBS (section 2).

    Parameters
    ----------
    frame : RGBDFrame
    parameters : BlockParameters, optional
        The defaults if left out.
    **changes
        Any of the `BlockParameters` by name.

    Returns
    -------
    ndarray of int32, shape (H, W)
        Label map: blocks 1, 2, ... in order of decreasing size, 0 = none. Neighbouring blocks touch, every block is one
        4-connected region, and everything except the margin is in a block, unless there is no known depth at all or an
        existence rate is set.

    Raises
    ------
    InputError
        If the input is not a frame.
    ParameterError
        For other parameters, such as those of the filter, or values out of range.

    Warns
    -----
    RuntimeWarning
        If Canny's edges replace those of the network, because it is missing or invalid. Unlike the result of
        `ilf.complete`, a label map cannot contain notes.

    Examples
    --------
    >>> import numpy as np, ilf
    >>> rgb = np.full((40, 60, 3), 60, np.uint8)
    >>> rgb[:, 20:] = 200  # a light wall, twice as large as the dark one before it
    >>> frame = ilf.RGBDFrame(rgb, np.where(rgb[..., 0] == 60, 1.0, 2.0))
    >>> blocks = ilf.extract_blocks(frame)
    >>> blocks.dtype, blocks.shape, blocks[0].tolist() == [2] * 20 + [1] * 40
    (dtype('int32'), (40, 60), True)
    >>> int(ilf.extract_blocks(frame, use_depth=False, granularity=0.0).max())
    1
    """
    found = found_blocks(frame, as_block_parameters(parameters, **changes))
    clear_stage_cache(frame)
    for note in found.notes:
        warnings.warn(note, RuntimeWarning, stacklevel=2)
    return found.labels.copy()


@once_per_image
def find_margins(rgb: NDArray[np.uint8]) -> tuple[int, int, int, int]:
    """Widths [px] of a white border at top, bottom, left and right, as in NYU's colour images.

    All are 0 unless there is white on all four sides: a bright wall is not a border.
    """
    white = np.minimum(np.minimum(rgb[..., 0], rgb[..., 1]), rgb[..., 2]) >= 240
    limit = min(white.shape) // 8
    top, bottom, left, right = (_white_lines(side, limit) for side in (white, white[::-1], white.T, white.T[::-1]))
    return (top, bottom, left, right) if min(top, bottom, left, right) > 0 else (0, 0, 0, 0)


def _white_lines(white: NDArray[np.bool_], limit: int) -> int:
    """Number of lines from the first on that are almost entirely white; 0 if there are too many for a border."""
    shares = white[: limit + 1].mean(axis=1)
    darker = np.flatnonzero(shares < 0.9)
    return int(darker[0]) if darker.size else 0
