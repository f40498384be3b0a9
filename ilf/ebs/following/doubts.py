"""Which carried blocks need a look, and why."""

from __future__ import annotations

import numpy as np

from .settling import Labels, Settled
from .sources import Sources

_UNSEEN, _MOVED = 0.25, 0.2
"""Share of a block that was not seen before, and that was taken from others, from which on it needs a look."""

_SHRUNK = 0.5
"""Share of what was carried of a block that it keeps at least."""

_LOST = 0.4
"""Share of the picture with a sure source below which nothing can be relied on."""


def doubts(labels: Labels, settled: Settled, sources: Sources) -> tuple[dict[int, str], tuple[str, ...]]:
    """Blocks that need a look with a sentence each, and notes on the whole."""
    now, was = settled.labels, settled.carried
    count = int(max(now.max(), labels.max())) + 1
    size = np.bincount(now.ravel(), minlength=count)
    unseen = np.bincount(now[was < 0], minlength=count)
    won = np.bincount(now[(was >= 0) & (was != now)], minlength=count)
    kept = np.bincount(now[was == now], minlength=count)
    carried = np.bincount(was[was >= 0], minlength=count)
    reasons: dict[int, str] = {}
    all_of_it = np.count_nonzero(sources.sure) < _LOST * now.size
    for label in np.flatnonzero(size).tolist():
        if label == 0:
            continue
        if label in settled.new:
            reasons[label] = "It was not in the picture before."
        elif all_of_it:
            reasons[label] = "Too little of the picture is like the frame before."
        elif unseen[label] >= _UNSEEN * size[label]:
            reasons[label] = f"{unseen[label] / size[label]:.0%} of it could not be seen before."
        elif won[label] >= _MOVED * size[label]:
            reasons[label] = f"{won[label] / size[label]:.0%} of it was carried as another block's."
        elif kept[label] < _SHRUNK * carried[label]:
            reasons[label] = f"Only {kept[label] / carried[label]:.0%} of what was carried of it lies within its edges."
    notes: tuple[str, ...] = ()
    if all_of_it:
        share = np.count_nonzero(sources.sure) / now.size
        notes = (
            f"Only {share:.0%} of the picture could be followed from the frame before: look at all blocks, or extract "
            "them anew.",
        )
    return reasons, notes
