"""The points of a frame that are measured between."""

from __future__ import annotations

from dataclasses import dataclass, field

Point = tuple[float, float]


@dataclass
class Chains:
    """Measurements of a frame: chains of points in image coordinates.

    Attributes
    ----------
    chains : list of list of Point
        The oldest first.
    is_open : bool
        Whether the next point belongs to the last one.
    reference : int
        The block whose plane heights are measured over; 0 for the image's upright.
    """

    chains: list[list[Point]] = field(default_factory=list)
    is_open: bool = False
    reference: int = 0
