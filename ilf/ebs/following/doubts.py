"""Which carried blocks need a look, and why."""

from __future__ import annotations

import numpy as np

from .settling import Labels, Settled

_UNSEEN, _WON, _KEPT = 0.1, 0.07, 0.85
"""Share of a block that was not seen before, and that was carried as another's, from which on it needs a look, and
share of what was carried of it that it keeps at least."""


def doubts(labels: Labels, settled: Settled) -> dict[int, str]:
    """Blocks that need a look, with a sentence each.

    Parameters
    ----------
    labels : ndarray of int32, shape (H, W)
        Of the frame before.
    settled : Settled
    """
    now, was = settled.labels, settled.carried
    count = int(max(now.max(), labels.max())) + 1
    size = np.bincount(now.ravel(), minlength=count)
    unseen = np.bincount(now[was < 0], minlength=count)
    won = np.bincount(now[(was >= 0) & (was != now)], minlength=count)
    kept = np.bincount(now[was == now], minlength=count)
    carried = np.bincount(was[was >= 0], minlength=count)
    reasons: dict[int, str] = {}
    for label in (np.flatnonzero(size[1:]) + 1).tolist():
        if label in settled.new:
            reasons[label] = "It was not in the picture before."
        elif unseen[label] >= _UNSEEN * size[label]:
            reasons[label] = f"{unseen[label] / size[label]:.0%} of it could not be seen before."
        elif won[label] >= _WON * size[label]:
            reasons[label] = f"{won[label] / size[label]:.0%} of it was another block's before."
        elif kept[label] < _KEPT * carried[label]:
            reasons[label] = f"It has lost {1 - kept[label] / carried[label]:.0%} of what it was before to its edges."
    return reasons
