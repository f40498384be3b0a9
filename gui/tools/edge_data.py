"""Data of a frame that the tools need beside its blocks: edges to snap to, and regions of the extraction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.segmentation.editing.snapping import border_evidence, similar_pixels
from ilf.segmentation.extraction import extract


@dataclass(frozen=True, eq=False)
class EdgeData:
    """Edges and regions of a frame.

    Attributes
    ----------
    frame : RGBDFrame
    strength : ndarray of float32, shape (H, W)
        Edge strength in [0, 1].
    regions : ndarray of int32, shape (H, W)
        The regions that the extraction merges into blocks.
    evidence : ndarray of float32, shape (H, W)
        Evidence for a border, to which drawn lines snap.
    """

    frame: RGBDFrame
    strength: NDArray[np.float32]
    regions: NDArray[np.int32]
    evidence: NDArray[np.float32]


def find_edge_data(frame: RGBDFrame, parameters: BlockParameters) -> EdgeData:
    """Find the edges and regions of a frame by an extraction, for which its edges are cached."""
    extraction = extract(frame, parameters)
    return edge_data_of(frame, extraction.strength, extraction.contracted)


def edge_data_of(frame: RGBDFrame, strength: NDArray[np.float32], regions: NDArray[np.int32]) -> EdgeData:
    """Return the data of a frame with known edges and regions."""
    similar_pixels(frame, strength, 0, 0)  # computes and caches what it needs of the whole frame
    return EdgeData(frame, strength, regions, border_evidence(frame, strength))
