"""An extraction with its frame, parameters and duration."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.formatting import covered
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.segmentation.extraction import Extraction, extract


@dataclass(frozen=True, eq=False)
class FoundBlocks:
    """The result of EBS for a frame; `seconds` is its duration [s]."""

    frame: RGBDFrame
    parameters: BlockParameters
    extraction: Extraction
    seconds: float

    def matches(self, frame: RGBDFrame, parameters: BlockParameters) -> bool:
        """Whether this is the extraction of that frame with those parameters."""
        return self.frame is frame and self.parameters == parameters


def find(frame: RGBDFrame, parameters: BlockParameters) -> FoundBlocks:
    """Extract the blocks of a frame."""
    begun = time.perf_counter()
    extraction = extract(frame, parameters)
    return FoundBlocks(frame, parameters, extraction, time.perf_counter() - begun)


def describe_blocks(count: int, labels: NDArray[np.int32]) -> str:
    """Return the number of blocks in a label map and their share of the frame, as text."""
    return covered(count, float((labels > 0).mean()))
