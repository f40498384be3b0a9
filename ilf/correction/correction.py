"""What the correction network changes about a frame's completed depth, block by block."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from ..blocks import Block
from ..frame import RGBDFrame
from ..per_frame import Memory

Array = NDArray[np.float32]

_SHARE = 0.85
"""Of every change so much is made: on frames of real sensors the network goes a little too far."""

_FADED, _FAR = 2.0, 8.0
"""Distance to known depth [px] up to which nothing is changed, and from which on changes are made in full."""

_ALIKE = 0.02
"""A block's log depth that is off so far from what the network has seen takes over 37 % of the change."""


@dataclass(frozen=True, eq=False)
class Correction:
    """What the network says of a frame, worked out once.

    Attributes
    ----------
    opinion : ndarray of float32, shape (H, W)
        The completed depth that it has seen [m]: of the frame as it is, its blocks as extracted and the filter as the
        preset `best` has it; NaN = missing.
    change : ndarray of float32, shape (H, W)
        By how much the logarithm of that is to be changed.
    network : str
        SHA-256 of the network.
    """

    opinion: Array
    change: Array
    network: str

    def applied(self, block: Block, raw: Array, depth: Array) -> Array:
        """A block's depth, corrected where it was missing, and as far as it is what the network has seen: other
        blocks, borders or values of the filter may have made something else of it.

        Parameters
        ----------
        block : Block
        raw, depth : ndarray of float32
            Known and completed depth [m] at the block's pixels, in the order of `block.mask`'s True values; NaN =
            missing.
        """
        opinion, change = self.opinion[block.box][block.mask], self.change[block.box][block.mask]
        with np.errstate(invalid="ignore", divide="ignore"):
            off = np.log(depth / opinion)
        agreement = np.exp(-np.square(np.where(np.isnan(off), np.inf, off / np.float32(_ALIKE))))
        return np.where(np.isnan(raw), depth * np.exp(agreement * change), depth).astype(np.float32)


def made_of(change: Array, known: NDArray[np.bool_]) -> Array:
    """The changes that are made of those that the network asks for.

    All are a little less, and those near known depth, which the filter follows better, fade.

    Parameters
    ----------
    change : ndarray of float32, shape (H, W)
        Of log depth.
    known : ndarray of bool, shape (H, W)
    """
    return np.asarray(np.float32(_SHARE) * _faded(known) * change, np.float32)


def changes_any(known: NDArray[np.bool_]) -> bool:
    """Whether any missing depth is far enough from known depth for a change to be made."""
    return bool(_faded(known).any())


def _faded(known: NDArray[np.bool_]) -> Array:
    """How much is left of changes, from 0 near known depth to 1."""
    faded = np.asarray(cv2.distanceTransform((~known).astype(np.uint8), cv2.DIST_L2, 5), np.float32)
    faded -= np.float32(_FADED)
    faded /= np.float32(_FAR - _FADED)
    return np.clip(faded, 0, 1, out=faded)


corrections = Memory[RGBDFrame, Correction]()
"""Of each frame, by the parameters that its blocks are extracted with."""
