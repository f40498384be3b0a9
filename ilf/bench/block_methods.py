"""The ways to make blocks that the bench compares: those of EBS, and two public segmentations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skimage.graph import cut_threshold, rag_mean_color
from skimage.segmentation import felzenszwalb, slic

from ..ebs import extract
from ..errors import InputError
from ..frame import RGBDFrame
from ..parameters import PAPER_BLOCKS
from .choices import chosen_names
from .evidence import margin_window

Labels = NDArray[np.int32]


@dataclass(frozen=True)
class BlockMethod:
    """A way to make blocks.

    Attributes
    ----------
    run : callable
        Takes a frame, returns its label map int32 (H, W), 0 = no block.
    settings : mapping
        All that the result depends on, by name.
    """

    run: Callable[[RGBDFrame], Labels]
    settings: Mapping[str, Any]


def _ebs(**changes: Any) -> BlockMethod:
    """EBS with contours and default parameters, some of them changed."""
    parameters = PAPER_BLOCKS.replace(**changes)

    def run(frame: RGBDFrame) -> Labels:
        extraction = extract(frame, parameters)
        if extraction.notes:
            raise InputError(" ".join(extraction.notes))
        return extraction.blocks

    return BlockMethod(run, parameters.to_dict())


def _public(segment: Callable[..., NDArray[np.integer]], **settings: Any) -> BlockMethod:
    """A segmentation of the colour inside the margins; its labels come as they are, from 1 on."""

    def run(frame: RGBDFrame) -> Labels:
        window = margin_window(frame.rgb)
        labels = np.zeros(frame.shape, np.int32)
        _, regions = np.unique(segment(frame.rgb[window], **settings), return_inverse=True)
        labels[window] = regions.reshape(labels[window].shape) + 1
        return labels

    return BlockMethod(run, settings)


def _felzenszwalb(rgb: NDArray[np.uint8], scale: float, sigma: float, min_share: float) -> NDArray[np.integer]:
    return felzenszwalb(rgb, scale=scale, sigma=sigma, min_size=round(min_share * rgb.shape[0] * rgb.shape[1]))


def _slic_merged(rgb: NDArray[np.uint8], segments: int, compactness: float, merged_below: float) -> NDArray[np.integer]:
    """Superpixels, and neighbours of similar mean colour merged: the difference in RGB of 0-255 is `merged_below`."""
    superpixels = slic(rgb, n_segments=segments, compactness=compactness, start_label=1)
    return cut_threshold(superpixels, rag_mean_color(rgb, superpixels, connectivity=1), merged_below)


# The settings of the public ones have the highest boundary F of several that were tried on seven real frames.
BLOCK_METHODS: dict[str, BlockMethod] = {
    "canny": _ebs(detector="canny", use_depth=False),
    "network": _ebs(use_depth=False),
    "canny+depth": _ebs(detector="canny"),
    "combined": _ebs(),
    "felzenszwalb": _public(_felzenszwalb, scale=400.0, sigma=0.8, min_share=0.004),
    "slic": _public(_slic_merged, segments=400, compactness=30.0, merged_below=29.0),
}
"""Name -> method, those of EBS first."""


def choose_block_methods(names: str) -> list[str]:
    """Names of the methods that a comma-separated list means, each once; "all" means all.

    Raises
    ------
    ParameterError
        For an unknown name, or if there is none.
    """
    return chosen_names(names, BLOCK_METHODS, {"all": tuple(BLOCK_METHODS)})
