"""The depth that the views show, updated only where it changed; and an earlier iteration of it."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ilf.data.label_map import Box, union, whole
from ilf.data.results import BlockResult

from .results import Preview

Depth = NDArray[np.float32]


class ShownDepth:
    """The completed depth, the last depth of blocks that have changed since, and previews of running blocks.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        [m], NaN where missing. Changed in place.
    stale : ndarray of bool, shape (H, W)
        Pixels whose depth is from before their block or its parameters changed. Changed in place.
    """

    def __init__(self, depth: Depth) -> None:
        self.depth = depth.copy()
        self.stale: NDArray[np.bool_] = np.zeros(depth.shape, bool)
        self._last: Depth = np.full(depth.shape, np.nan, np.float32)
        self._changed: Box | None = None

    def keep(self, results: Iterable[BlockResult]) -> None:
        """Store the depth of results; it is shown until there is newer depth, also when the blocks change."""
        for result in results:
            self._last[result.block.box][result.block.mask] = result.depth
            self.note(result.block.box)

    def forget(self) -> None:
        """Drop the depth of all results."""
        self._last.fill(np.nan)
        self.note_all()

    def note(self, box: Box) -> None:
        """Mark a box (rows, columns) as changed."""
        self._changed = box if self._changed is None else union(self._changed, box)

    def note_all(self) -> None:
        """Mark the whole frame as changed."""
        self._changed = whole(self.depth.shape)

    def update(
        self,
        labels: NDArray[np.int32],
        valid: Collection[int],
        depth: Depth,
        previews: Iterable[Preview],
        outdated: Collection[int],
    ) -> Box | None:
        """Bring `depth` and `stale` up to date.

        Parameters
        ----------
        labels : ndarray of int32, shape (H, W)
            The current label map.
        valid : collection of int
            Blocks whose results are up to date with it.
        depth : ndarray of float32, shape (H, W)
            The completion from these results, extrapolated depth included; or what is known without any.
        previews : iterable of (Block, ndarray)
        outdated : collection of int
            Blocks whose results have other parameters than the current ones.

        Returns
        -------
        (slice, slice) or None
            The changed box; None if nothing changed.
        """
        box, self._changed = self._changed, None
        if box is None:
            return None
        part, here = depth[box].copy(), labels[box]
        fresh = np.zeros(max(int(here.max()), 0) + 1, bool)
        fresh[[0, *(label for label in valid if label < fresh.size)]] = True
        stale = ~fresh[here]
        if stale.any():
            last = self._last[box]
            stale &= np.isfinite(last)
            part = np.where(stale, last, part)
        if outdated:
            stale |= np.isin(here, list(outdated)) & np.isfinite(part)
        self.depth[box], self.stale[box] = part, stale
        for block, preview in previews:
            still = labels[block.box][block.mask] == block.label  # it may have lost pixels since it started
            mask = block.mask.copy()
            mask[block.mask] = still
            self.depth[block.box][mask] = preview[still]
            self.stale[block.box][mask] = False
        return box


@dataclass(frozen=True, eq=False)
class ViewedIteration:
    """The depth of the current frame after an earlier iteration of its last run.

    Attributes
    ----------
    depth : ndarray of float32, shape (H, W)
        [m], NaN where it was missing.
    iteration : int
        The iteration of every block after which it was so.
    """

    depth: NDArray[np.float32]
    iteration: int

    @property
    def text(self) -> str:
        """Its label in the window."""
        return f"as of iteration {self.iteration}"
