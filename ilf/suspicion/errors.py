"""Filled depth that may be far off."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from .ground import Ground
from .groups import largest_groups, number_groups
from .place import Place

_HIGH, _HIGH_SHARE = 0.1, 0.05
"""An expected error is high above the larger of the two [m, share of the depth around]."""

_BLAME = 0.1
"""How much of a high expected error is to be put down to blocks: most of it is there because so much is missing."""


def find_high_errors(ground: Ground, error: NDArray[np.float32]) -> Iterator[Place]:
    """Areas of high expected error [m], float32 (H, W), NaN where nothing was filled."""
    high = ground.missing & (np.nan_to_num(error) > np.maximum(_HIGH, _HIGH_SHARE * ground.depth))
    numbers = number_groups(high, ground.labels)
    totals = np.bincount(numbers[high], error[high], minlength=int(numbers.max()) + 1)
    for group in largest_groups(numbers, _BLAME * totals, ground.labels):
        typical = float(np.median(error[group.rows, group.columns]))
        reason = f"Expected error {1000 * typical:.0f} mm over {group.rows.size:,} px of Block {group.label}."
        yield Place("error", group.box, (group.label,), group.point, group.harm, reason)
