"""EBS: colour and depth -> operation blocks, stage by stage (section 2)."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..edges.frame_edges import find_edges, forget_evidence, lines_of, relief_of
from ..frame import RGBDFrame, checked_frame
from ..memory import give_back
from ..parameters import BlockParameters, Parameters, as_extraction
from ..per_frame import forget, once_per_frame, once_per_image
from ..stopping import check_stopped
from .boundaries import contract, dilate, regions_between, snap_to_jumps
from .existence import keep_existing
from .guide import Boundaries, find_boundaries
from .merging import Fitness, RegionGraph, numbered

_USUAL_LIMIT = 0.2
"""Cost of a border up to which regions merge at a granularity of 0.5; it is 1 at 0 and the square of this at 1."""


_OF_MERGING = {
    name: getattr(BlockParameters(), name) for name in ("granularity", "min_size", "min_known_share", "existence_rate")
}
"""Parameters that have a say only after the contraction, as the defaults have them."""


class FoundBlocks(NamedTuple):
    """What an extraction is made for.

    Attributes
    ----------
    blocks : ndarray of int32, shape (H, W)
        The label map: operation blocks 1, 2, ... from the largest down, 0 = none. Read-only: it is remembered.
    network : str or None
        SHA-256 of the edge network whose edges were really used; None where Canny's were.
    notes : tuple of str
        What the user should know of how it came about: none if all went as asked for.
    """

    blocks: NDArray[np.int32]
    network: str | None
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Extraction:
    """The pictures of all stages, each of shape (H, W).

    Attributes
    ----------
    strength : ndarray of float32
        Edge strength in [0, 1]; depth jumps stand at 1.
    edges : ndarray of bool
        The same, binarised.
    dilated : ndarray of bool
        The binarised edges, dilated.
    contracted : ndarray of int32
        Regions that touch each other after the contraction: more and smaller ones than blocks.
    blocks : ndarray of int32
        The label map: operation blocks 1, 2, ... from the largest down, 0 = none.
    network : str or None
        SHA-256 of the edge network whose edges were really used; None where Canny's were.
    notes : tuple of str
        What the user should know of how it came about: none if all went as asked for.
    """

    strength: NDArray[np.float32]
    edges: NDArray[np.bool_]
    dilated: NDArray[np.bool_]
    contracted: NDArray[np.int32]
    blocks: NDArray[np.int32]
    network: str | None = None
    notes: tuple[str, ...] = ()


def extract(frame: RGBDFrame, parameters: BlockParameters | None = None) -> Extraction:
    """Extract boundaries and surfaces, and keep the picture of every stage.

    The frame's edges, regions and blocks are remembered with it, so that other parameters cost only what follows them.

    Parameters
    ----------
    frame : RGBDFrame
    parameters : BlockParameters, optional
    """
    chosen = parameters or BlockParameters()
    blocks, network, notes = found_blocks(frame, chosen)
    boundaries = _boundaries(frame, chosen)
    return Extraction(
        boundaries.strength,
        boundaries.edges,
        dilate(boundaries.edges, chosen.dilation),
        _regions(frame, chosen.replace(**_OF_MERGING)),
        blocks.copy(),
        network,
        notes,
    )


def found_blocks(frame: RGBDFrame, parameters: BlockParameters | None) -> FoundBlocks:
    """The same blocks without the pictures of the stages, which take time and memory."""
    chosen = as_extraction(parameters)
    edges = find_edges(checked_frame(frame), chosen)
    return FoundBlocks(_blocks(frame, chosen), edges.network, edges.notes)


def forget_stages(frame: RGBDFrame) -> None:
    """Give up what is remembered for other extractions of a frame: regions and what they follow from, a third of all
    that is known of it. Blocks and edges stay."""
    forget(frame, _regions)
    forget_evidence(frame)


def _boundaries(frame: RGBDFrame, parameters: BlockParameters) -> Boundaries:
    edges, lines = find_edges(frame, parameters), lines_of(frame, parameters)
    return find_boundaries(edges, lines, relief_of(frame, parameters), parameters)


@once_per_frame
def _blocks(frame: RGBDFrame, parameters: BlockParameters) -> NDArray[np.int32]:
    """The label map, int32 (H, W)."""
    regions = _regions(frame, parameters.replace(**_OF_MERGING))
    found = _boundaries(frame, parameters)
    smallest = parameters.smallest_block(regions.size)
    check_stopped()
    graph = RegionGraph(regions, found.strength, frame, found.relief)
    give_back(regions.size)
    check_stopped()
    graph.merge_below(_USUAL_LIMIT ** (2 * parameters.granularity))
    graph.take_in_unfit(Fitness(smallest, parameters.min_known_share, Parameters().min_known_pixels))
    blocks = graph.labels()
    if parameters.existence_rate > 0:
        blocks = numbered(keep_existing(blocks, frame.known, parameters.existence_rate, smallest))
    return blocks


@once_per_frame
def _regions(frame: RGBDFrame, parameters: BlockParameters) -> NDArray[np.int32]:
    """The regions after the contraction, int32 (H, W)."""
    margins = find_margins(frame.rgb) if parameters.margin < 0 else (parameters.margin,) * 4
    inside = _inside(frame.shape, margins)
    found = _boundaries(frame, parameters)
    seeds = regions_between(found.edges, parameters.dilation, inside)
    check_stopped()
    regions = contract(seeds, found.guide, inside)
    check_stopped()
    return regions if found.relief is None else snap_to_jumps(regions, found.relief.jumps)


def extract_blocks(frame: RGBDFrame, parameters: BlockParameters | None = None) -> NDArray[np.int32]:
    """Operation blocks of a frame by EBS (section 2).

    Parameters
    ----------
    frame : RGBDFrame
    parameters : BlockParameters, optional

    Returns
    -------
    ndarray of int32, shape (H, W)
        Label map: blocks 1, 2, ... from the largest down, 0 = none. Neighbouring blocks touch, every block is one
        4-connected region, and all but the margin is in a block, unless nothing is known at all or an existence rate
        is asked for.

    Raises
    ------
    InputError
        For anything but a frame.
    ParameterError
        For other parameters, such as those of the filter.

    Warns
    -----
    RuntimeWarning
        If Canny's edges stand in for the network's, because it is missing or none. A bare label map cannot carry
        notes, and other blocks than asked for must not pass in silence; `ilf.ebs.extract` gives the same blocks with
        `notes` and without a warning.

    Examples
    --------
    >>> import ilf
    >>> from ilf.assets import asset_path
    >>> blocks = ilf.extract_blocks(ilf.load_frame(asset_path("samples/room")))
    >>> blocks.dtype, blocks.shape, bool((blocks == 1).sum() >= (blocks == 2).sum())
    (dtype('int32'), (480, 640), True)
    """
    blocks, _, notes = found_blocks(frame, parameters)
    for note in notes:
        warnings.warn(note, RuntimeWarning, stacklevel=2)
    return blocks.copy()


@once_per_image
def find_margins(rgb: NDArray[np.uint8]) -> tuple[int, int, int, int]:
    """Widths [px] of a white border at top, bottom, left and right, as NYU's colour images have it.

    All 0 unless there is white on all four sides: a bright wall is not a border.
    """
    white = np.minimum(np.minimum(rgb[..., 0], rgb[..., 1]), rgb[..., 2]) >= 240
    limit = min(white.shape) // 8
    top, bottom, left, right = (_white_lines(side, limit) for side in (white, white[::-1], white.T, white.T[::-1]))
    return (top, bottom, left, right) if min(top, bottom, left, right) > 0 else (0, 0, 0, 0)


def _white_lines(white: NDArray[np.bool_], limit: int) -> int:
    """How many lines from the first on are white nearly all over; 0 if that is more than a border would be."""
    shares = white[: limit + 1].mean(axis=1)
    darker = np.flatnonzero(shares < 0.9)
    return int(darker[0]) if darker.size else 0


def _inside(shape: tuple[int, int], margins: tuple[int, ...]) -> NDArray[np.bool_]:
    top, bottom, left, right = margins
    inside = np.zeros(shape, bool)
    inside[top : shape[0] - bottom, left : shape[1] - right] = True
    return inside
