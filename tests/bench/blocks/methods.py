"""Methods that make blocks: EBS in several forms, and two public segmentations of colour."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ilf.data.frame import RGBDFrame
from ilf.data.parameters import PAPER_BLOCKS
from ilf.errors import InputError
from ilf.segmentation.extraction import extract

from .measures import Labels, margin_window

BlockMethod = Callable[[RGBDFrame], Labels]
"""Takes a frame, returns its label map int32 (H, W), 0 = no block."""


def _ebs(**changes: Any) -> BlockMethod:
    """EBS with contours and default parameters, except for the given changes."""
    parameters = PAPER_BLOCKS.replace(**changes)

    def run(frame: RGBDFrame) -> Labels:
        extraction = extract(frame, parameters)
        if extraction.notes:
            raise InputError(" ".join(extraction.notes))
        return extraction.blocks

    return run


def _public(segment: Callable[..., NDArray[np.integer]], **settings: Any) -> BlockMethod:
    """A segmentation of the colour inside the margins; its labels are unchanged, from 1 on."""

    def run(frame: RGBDFrame) -> Labels:
        window = margin_window(frame.rgb)
        labels = np.zeros(frame.shape, np.int32)
        _, regions = np.unique(segment(frame.rgb[window], **settings), return_inverse=True)
        labels[window] = regions.reshape(labels[window].shape) + 1
        return labels

    return run


def _felzenszwalb(rgb: NDArray[np.uint8], scale: float, sigma: float, min_share: float) -> NDArray[np.integer]:
    from skimage.segmentation import felzenszwalb

    return felzenszwalb(rgb, scale=scale, sigma=sigma, min_size=round(min_share * rgb.shape[0] * rgb.shape[1]))


def _slic_merged(rgb: NDArray[np.uint8], segments: int, compactness: float, merged_below: float) -> NDArray[np.integer]:
    """Superpixels, merged with neighbours whose mean RGB (0-255) differs by less than `merged_below`."""
    from skimage.graph import cut_threshold, rag_mean_color
    from skimage.segmentation import slic

    superpixels = slic(rgb, n_segments=segments, compactness=compactness, start_label=1)
    return cut_threshold(superpixels, rag_mean_color(rgb, superpixels, connectivity=1), merged_below)


# Of several settings tried on seven real frames, those of the public methods gave the highest boundary F.
BLOCK_METHODS: dict[str, BlockMethod] = {
    "canny": _ebs(detector="canny", use_depth=False),
    "network": _ebs(use_depth=False),
    "canny+depth": _ebs(detector="canny"),
    "combined": _ebs(),
    "felzenszwalb": _public(_felzenszwalb, scale=400.0, sigma=0.8, min_share=0.004),
    "slic": _public(_slic_merged, segments=400, compactness=30.0, merged_below=29.0),
}
"""Name -> method, those of EBS first."""
