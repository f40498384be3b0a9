"""Quality measures of block maps, from the frame's own known depth.

All measures but `frame_coverage` use only the pixels inside the margins that the extraction finds
(`Evidence.window`). These are the same for all methods.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from ilf.completion.block import required_known_pixels
from ilf.data.blocks import Box
from ilf.data.frame import RGBDFrame
from ilf.data.pixel_grids import Pairs, both, connected_regions, different_labels, mark, rim, sides
from ilf.data.presets import preset
from ilf.segmentation.edges.frame_edges import JUMP_LENGTH, find_relief
from ilf.segmentation.extraction import find_margins

Labels = NDArray[np.int32]

JUMP, JUMP_SHARE = 0.04, 0.04
"""Between neighbours that differ by more than the larger of the two [m, share of the nearer depth] lies a jump."""

TOLERANCE = 2
"""How far [px] a boundary may be off, here and in boundary recall and precision."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """Reference for the block maps of one frame, all inside the margins; (h, w) is the shape of `window`.

    Attributes
    ----------
    window : tuple of slice
        Rows and columns of the frame inside the margins that the extraction finds.
    known : ndarray of bool, shape (h, w)
        Pixels with depth.
    near_known : ndarray of bool, shape (h, w)
        Pixels within 3 px of known depth, where a jump can be detected.
    jumps : pair of ndarray of bool
        Neighbours between which depth jumps.
    smooth : pair of ndarray of bool
        Neighbours on one smooth surface.
    """

    window: Box
    known: NDArray[np.bool_]
    near_known: NDArray[np.bool_]
    jumps: Pairs
    smooth: Pairs


def margin_window(rgb: NDArray[np.uint8]) -> Box:
    """Rows and columns inside the margins of a colour image, as `find_margins` finds them."""
    top, bottom, left, right = find_margins(rgb)
    return slice(top, rgb.shape[0] - bottom), slice(left, rgb.shape[1] - right)


def find_reference(frame: RGBDFrame) -> Evidence:
    """Find jumps and smooth surfaces in a frame's known depth.

    Jumps are those of `ilf.segmentation.edges.frame_edges.find_relief` in lines of more than 10 px.

    A pixel lies on a smooth surface if its depth is known, there is no jump, of any length, and no larger hole in the
    21 x 21 pixels around it, and the surface does not bend there or within 2 px around, by the same function.
    """
    window = margin_window(frame.rgb)
    known = frame.known[window]
    relief = find_relief(frame.depth[window], JUMP, JUMP_SHARE)
    smooth = known & relief.evaluated & ~widened(relief.bend > 1, TOLERANCE)
    return Evidence(window, known, relief.near, relief.jumps, both(smooth))


def widened(mask: NDArray[np.bool_], radius: int) -> NDArray[np.bool_]:
    """Pixels within a distance of at most `radius` [px] of a mask of shape (H, W)."""
    if not mask.any():
        return np.zeros_like(mask)
    return distance_transform_edt(~mask) <= radius


PERIMETER_SHARE = 0.01
"""A jump inside a block counts if it is longer than this share of the block's perimeter, and than `JUMP_LENGTH`."""


def score_blocks(labels: Labels, evidence: Evidence) -> dict[str, Any]:
    """All measures of a block map of the whole frame, int32 (H, W), 0 = no block.

    Each is defined at the function of its name; `coverage` is inside the margins, `frame_coverage` of the whole frame.
    Shares are 0-1; None where there is nothing to compare.
    """
    inside = labels[evidence.window]
    blocks = int(np.count_nonzero(np.unique(inside)))
    recall, precision, f = boundary_score(inside, evidence)
    return {
        "blocks": blocks,
        "coverage": float(np.mean(inside > 0)),  # share of the pixels that lie in blocks
        "frame_coverage": float(np.mean(labels > 0)),
        "recoverable": recoverable_share(inside, evidence.known),
        "leaks": int(connected_regions(inside).max()) - blocks,  # regions beyond one for each block
        "purity": purity(inside, evidence),
        "cut_rate": cut_rate(inside, evidence),
        "recall": recall,
        "precision": precision,
        "f": f,
    }


def recoverable_share(labels: Labels, known: NDArray[np.bool_]) -> float | None:
    """Share of the missing pixels that lie in blocks with enough known depth to be completed; None if none is missing.

    Enough is what `ilf.complete` requires with the default preset. Missing pixels that lie in no block count as not
    recoverable.
    """
    missing = ~known
    if not missing.any():
        return None
    pixels = np.bincount(labels.ravel())
    with_depth = np.bincount(labels[known], minlength=pixels.size)
    enough = with_depth >= required_known_pixels(pixels, preset())
    enough[0] = False
    return float(np.mean(enough[labels[missing]]))


def purity(labels: Labels, evidence: Evidence) -> float | None:
    """Share of the blocks, by area, whose known depth has no jump inside; None if no block has known depth.

    A block has a jump inside if an 8-connected line of depth jumps (see `find_reference`) between its own pixels is
    longer than 10 px and longer than 1 % of the block's perimeter, so that single flying pixels do not make a wall
    impure. Blocks without known depth are left out. More and smaller blocks are purer, so read it with the cut rate.
    """
    area = np.bincount(labels.ravel())
    evaluated = np.bincount(labels[evidence.known], minlength=area.size) > 0
    evaluated[0] = False
    if not evaluated.any():
        return None
    parted = different_labels(labels)
    inner = mark((evidence.jumps[0] & ~parted[0], evidence.jumps[1] & ~parted[1]))
    lines = connected_regions(np.where(inner, labels, 0), diagonal=True)
    length = np.bincount(lines.ravel())
    owner = np.zeros(length.size, np.int64)
    owner[lines[inner]] = labels[inner]
    longest = np.zeros(area.size, np.int64)
    np.maximum.at(longest, owner[1:], length[1:])
    pure = longest <= np.maximum(JUMP_LENGTH, PERIMETER_SHARE * _perimeters(labels))
    return float(area[evaluated & pure].sum() / area[evaluated].sum())


def cut_rate(labels: Labels, evidence: Evidence) -> float | None:
    """Share of the smooth neighbouring pairs (see `find_reference`) that have different labels; None if there are none.

    The depth gives no evidence for a boundary between these pixels.
    """
    smooth = np.concatenate([pairs.ravel() for pairs in evidence.smooth])
    parted = np.concatenate([pairs.ravel() for pairs in different_labels(labels)])
    return float(parted[smooth].mean()) if smooth.any() else None


def boundary_score(labels: Labels, evidence: Evidence) -> tuple[float | None, float | None, float | None]:
    """Recall, precision and F of boundaries against depth jumps, both as lines 1 px wide, with a tolerance of 2 px.

    Recall is the share of the jumps' pixels with a boundary within 2 px; precision the share of the boundaries'
    pixels with a jump within 2 px, of those within 3 px of known depth, where a jump can be detected; F their harmonic
    mean. Boundaries at creases and between colours of one surface count as wrong, so precision is low for all
    methods. All are None where depth has no jump; precision is None where no boundary can be evaluated.
    """
    jumps = mark(evidence.jumps)
    if not jumps.any():
        return None, None, None
    parted, seen = different_labels(labels), both(evidence.near_known)
    boundaries = mark(parted)
    evaluated = mark((parted[0] & seen[0], parted[1] & seen[1]))
    recall = float(np.mean(widened(boundaries, TOLERANCE)[jumps]))
    if not evaluated.any():
        return recall, None, 0.0
    precision = float(np.mean(widened(jumps, TOLERANCE)[evaluated]))
    total = recall + precision
    return recall, precision, 2 * recall * precision / total if total > 0 else 0.0


def _perimeters(labels: Labels) -> NDArray[np.int64]:
    """Perimeter of each label: pixel sides that border on another label or on the rim of the map."""
    pixels = [rim(labels)]
    for ends, parted in zip(sides(labels), different_labels(labels), strict=True):
        pixels += [end[parted] for end in ends]
    return np.bincount(np.concatenate(pixels), minlength=int(labels.max()) + 1)
