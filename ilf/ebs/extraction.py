"""EBS: colour and depth -> operation blocks, stage by stage (section 2)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..frame import RGBDFrame
from ..parameters import BlockParameters
from .boundaries import contract, dilate, regions_between
from .strength import find_edges


@dataclass(frozen=True, eq=False)
class Extraction:
    """The pictures of all stages, each of shape (H, W).

    Attributes
    ----------
    strength : ndarray of float32
        Edge strength in [0, 1]; Canny edges and depth jumps stand at 1.
    edges : ndarray of bool
        Canny edges of the colour, and depth jumps where they are asked for.
    dilated : ndarray of bool
        The same, dilated until watertight.
    contracted : ndarray of int32
        Regions after the contraction, small ones and those without depth still among them.
    blocks : ndarray of int32
        The label map: operation blocks 1, 2, ... from the largest down, 0 = none.
    """

    strength: NDArray[np.float32]
    edges: NDArray[np.bool_]
    dilated: NDArray[np.bool_]
    contracted: NDArray[np.int32]
    blocks: NDArray[np.int32]


def extract(frame: RGBDFrame, parameters: BlockParameters | None = None) -> Extraction:
    """Extract boundaries and surfaces, and keep the picture of every stage.

    Parameters
    ----------
    frame : RGBDFrame
    parameters : BlockParameters, optional
    """
    chosen = parameters or BlockParameters()
    strength, edges = find_edges(frame, chosen)
    dilated = dilate(edges, chosen.dilation)
    margins = find_margins(frame.rgb) if chosen.margin < 0 else (chosen.margin,) * 4
    inside = _inside(frame.shape, margins)
    contracted = contract(regions_between(dilated | ~inside), strength, inside)
    blocks = grow_over_small(contracted, strength, inside, frame.known, chosen)
    return Extraction(strength, edges, dilated, contracted, blocks)


def extract_blocks(frame: RGBDFrame, parameters: BlockParameters | None = None) -> NDArray[np.int32]:
    """Operation blocks of a frame by EBS (section 2).

    Parameters
    ----------
    frame : RGBDFrame
    parameters : BlockParameters, optional

    Returns
    -------
    ndarray of int32, shape (H, W)
        Label map: blocks 1, 2, ... from the largest down, 0 = none. Neighbouring blocks touch.
    """
    return extract(frame, parameters).blocks


def grow_over_small(
    regions: NDArray[np.int32],
    strength: NDArray[np.float32],
    inside: NDArray[np.bool_],
    known: NDArray[np.bool_],
    parameters: BlockParameters,
) -> NDArray[np.int32]:
    """Let neighbours take in the regions that cannot be blocks: too small, or with too little known depth.

    Parameters
    ----------
    regions : ndarray of int32, shape (H, W)
        Watertight regions.
    strength : ndarray of float32, shape (H, W)
        Edge strength; a region goes to the neighbour behind the weakest edge.
    inside : ndarray of bool, shape (H, W)
        False in the margin, which belongs to no block.
    known : ndarray of bool, shape (H, W)
        Pixels with depth.
    parameters : BlockParameters

    Returns
    -------
    ndarray of int32, shape (H, W)
        Label map, blocks numbered from the largest down. All 0 if no region is fit to be a block.
    """
    smallest = parameters.min_size / 100 * regions.size
    count = int(regions.max()) + 1
    sizes = np.bincount(regions[inside], minlength=count)
    with_depth = np.bincount(regions[inside & known], minlength=count)
    fit = (sizes >= max(smallest, 1)) & (with_depth >= parameters.min_known_share * sizes)
    fit[0] = False
    seeds = np.where(fit[regions] & inside, regions, 0).astype(np.int32)
    grown = contract(seeds, strength, inside)
    order = np.argsort(-np.bincount(grown.ravel(), minlength=count)[1:], kind="stable") + 1
    numbers = np.zeros(count, np.int32)
    numbers[order] = np.arange(1, count)
    return numbers[grown]


def find_margins(rgb: NDArray[np.uint8]) -> tuple[int, int, int, int]:
    """Widths [px] of a white border at top, bottom, left and right, as NYU's colour images have it.

    All 0 unless there is white on all four sides: a bright wall is not a border.
    """
    white = rgb.min(axis=2) >= 240
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
