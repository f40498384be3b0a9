"""Data of a frame that the tools need beside its blocks: edges to snap to, and regions of the extraction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.segmentation.editing.snapping import border_evidence, similar_pixels

from ..state.document import Document
from ..work.found_blocks import FoundBlocks, find
from ..work.latest_request import LatestRequest


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


class EdgeDataSource:
    """Computes the aid of one document's frame at a time, in a background thread.

    Later changes of the invalid mask do not change the aid.
    """

    def __init__(self, requests: LatestRequest) -> None:
        self._document: Document | None = None
        self._edge_data: EdgeData | None = None
        self._extraction: FoundBlocks | None = None
        self._requests = requests

    def of(self, document: Document, parameters: BlockParameters) -> EdgeData | None:
        """Return the aid of a document's frame; None while it is being computed.

        If no extraction of the frame is stored, it is extracted with `parameters`.
        """
        if document is not self._document:
            self._document, self._edge_data = document, None
            held = self._extraction if self._extraction and self._extraction.frame is document.frame else None
            self._requests.forget()
            self._requests.ask(partial(_find, document.frame, parameters, held), self._take)
        return self._edge_data

    def hold(self, extraction: FoundBlocks) -> None:
        """Store an extraction, so that the aid of its frame needs no new one."""
        self._extraction = extraction
        if self._edge_data is not None and self._edge_data.frame is extraction.frame:
            self._document = self._edge_data = None

    def turn_to(self, document: Document | None) -> None:
        """Drop the data of all frames but that of this document."""
        if self._extraction is not None and (document is None or self._extraction.frame is not document.frame):
            self._extraction = None
        if document is not self._document:
            self._document = self._edge_data = None
            self._requests.forget()

    def _take(self, edge_data: EdgeData) -> None:
        self._edge_data = edge_data


def _find(frame: RGBDFrame, parameters: BlockParameters, found: FoundBlocks | None) -> EdgeData:
    """Compute the aid; called in the background thread."""
    extraction = (found or find(frame, parameters)).extraction
    return edge_data_of(frame, extraction.strength, extraction.contracted)


def edge_data_of(frame: RGBDFrame, strength: NDArray[np.float32], regions: NDArray[np.int32]) -> EdgeData:
    """Return the aid of a frame with known edges and regions."""
    similar_pixels(frame, strength, 0, 0)  # computes and caches what it needs of the whole frame
    return EdgeData(frame, strength, regions, border_evidence(frame, strength))
