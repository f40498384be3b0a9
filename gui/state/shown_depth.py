"""The depth that the views show, kept up to date where something has changed."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np
from numpy.typing import NDArray

from gui.state.results import Preview
from ilf.blocks import Box, union
from ilf.frame import RGBDFrame
from ilf.outcomes import BlockResult, Completion

Depth = NDArray[np.float32]


class ShownDepth:
    """What is completed, the last depth of blocks that have changed since, and previews of the blocks that run.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        [m], NaN where there is none. Changed in place.
    stale : ndarray of bool, shape (H, W)
        Pixels whose depth is what a block had before it was changed. Changed in place.
    """

    def __init__(self, frame: RGBDFrame) -> None:
        self._raw = frame.depth
        self.depth: Depth = frame.depth.copy()
        self.stale: NDArray[np.bool_] = np.zeros(frame.shape, bool)
        self._last: Depth = np.full(frame.shape, np.nan, np.float32)
        self._changed: Box | None = None

    def take_frame(self, frame: RGBDFrame) -> None:
        """Go by another frame of the same shape, as when other depth is distrusted."""
        self._raw = frame.depth
        self.note_all()

    def keep(self, results: Iterable[BlockResult]) -> None:
        """What blocks have come to: shown until there is something newer, whatever becomes of the blocks."""
        for result in results:
            self._last[result.block.box][result.block.mask] = result.depth
            self.note(result.block.box)

    def forget(self) -> None:
        """There are no results any more."""
        self._last.fill(np.nan)
        self.note_all()

    def note(self, box: Box) -> None:
        """Something has changed inside a box (rows, columns)."""
        self._changed = box if self._changed is None else union(self._changed, box)

    def note_all(self) -> None:
        """Something has changed all over the frame."""
        self._changed = _whole(self._raw.shape)

    def update(
        self,
        labels: NDArray[np.int32],
        valid: Collection[int],
        completion: Completion | None,
        previews: Iterable[Preview],
    ) -> Box | None:
        """Bring `depth` and `stale` up to date.

        Parameters
        ----------
        labels : ndarray of int32, shape (H, W)
            The label map as it is.
        valid : collection of int
            Blocks whose results are of it.
        completion : Completion or None
            What they make, guesses included.
        previews : iterable of (Block, ndarray)

        Returns
        -------
        (slice, slice) or None
            Where they have changed; None if they have not.
        """
        box, self._changed = self._changed, None
        if box is None:
            return None
        part = (self._raw if completion is None else completion.depth)[box].copy()
        here = labels[box]
        fresh = np.zeros(max(int(here.max()), 0) + 1, bool)
        fresh[[0, *(label for label in valid if label < fresh.size)]] = True
        stale = ~fresh[here]
        if stale.any():
            last = self._last[box]
            stale &= np.isfinite(last)
            part = np.where(stale, last, part)
        self.depth[box], self.stale[box] = part, stale
        for block, preview in previews:
            still = labels[block.box][block.mask] == block.label  # it may have lost pixels since it began
            mask = block.mask.copy()
            mask[block.mask] = still
            self.depth[block.box][mask] = preview[still]
            self.stale[block.box][mask] = False
        return box


def _whole(shape: tuple[int, ...]) -> Box:
    return slice(0, shape[0]), slice(0, shape[1])
