"""The guide of a frame as the filter follows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....blocks import Block, Box
from ....frame import RGBDFrame
from ....nearest import nearest_values
from ....per_frame import once_per_frame
from .belief import Trial, try_guide
from .fitting import Array, fitted
from .sharpening import sharpened

_LEFT_ASIDE = "The guide was left aside: where known depth is hidden for a test, it does not come back better with it."

_CARRIES = 0.5
"""A guide that is followed so far at every pixel of a block is enough to complete it."""


@dataclass(frozen=True, eq=False)
class FittedGuide:
    """A guide in metres.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        What the guide says, fitted to the known depth [m]; NaN where it says nothing.
    confidence : ndarray of float32, shape (H, W)
        Its own, 0 where it says nothing.
    trial : Trial
    """

    depth: Array
    confidence: Array
    trial: Trial

    @property
    def belief(self) -> float:
        """How far the frame's known depth bears it out, 0-1."""
        return self.trial.belief()

    def in_words(self) -> str:
        """How far it is believed, for the user."""
        belief = self.belief
        if belief == 0:
            return "left aside: known depth that is hidden for a test does not come back better with it"
        return f"followed to {belief:.0%}, on the whole, by known depth that was hidden for a test"

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know of it."""
        return () if self.belief > 0 else (_LEFT_ASIDE,)

    def carries(self, block: Block) -> bool:
        """Whether it may stand for known depth that a block lacks."""
        return float(self.shares(block, block.box)[block.mask].min()) >= _CARRIES

    def shares(self, block: Block, box: Box) -> Array:
        """How far to follow it for a block, 0-1, at the pixels of a box."""
        mask = np.zeros(self.depth.shape, bool)
        mask[block.box] = block.mask
        return np.float32(self.trial.belief(mask)) * self.confidence[box]


@once_per_frame
def fit_guide(frame: RGBDFrame) -> FittedGuide | None:
    """The frame's guide in metres, and how far to believe it; None without one. Worked out once, of all known depth.

    Parameters
    ----------
    frame : RGBDFrame
    """
    guide = frame.guide
    if guide is None:
        return None
    said = np.isfinite(guide.values)
    if guide.confidence is None:
        confidence = said.astype(np.float32)
    else:
        confidence = np.where(said, guide.confidence, np.float32(0))
    values = np.where(said, sharpened(nearest_values(guide.values, said, 3)[1]), np.float32(np.nan))
    return FittedGuide(fitted(values, frame.depth, confidence), confidence, try_guide(values, frame.depth, confidence))
