"""An extraction with its parameters."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.formatting import covered
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import BlockParameters
from ilf.segmentation.extraction import Extraction, extract


class FoundBlocks(NamedTuple):
    """The result of EBS for a frame."""

    parameters: BlockParameters
    extraction: Extraction


def find(frame: RGBDFrame, parameters: BlockParameters) -> FoundBlocks:
    """Extract the blocks of a frame."""
    return FoundBlocks(parameters, extract(frame, parameters))


def describe_blocks(count: int, labels: NDArray[np.int32]) -> str:
    """Return the number of blocks in a label map and their share of the frame, as text."""
    return covered(count, float((labels > 0).mean()))
