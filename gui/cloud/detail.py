"""How much of a cloud is drawn while it moves, by what drawing takes on this machine. No widgets."""

from __future__ import annotations

MOVING_S = 0.03
"""Time that a frame of a moving cloud may take."""

_POINT_S = 12e-9
_PIXEL_S = 22e-9
"""What a point and a pixel of the picture take on a usual machine."""

_LADDER = ((1, 1 << 62), (1, 400_000), (2, 400_000), (2, 150_000), (3, 100_000), (4, 50_000))
"""From fine to coarse: side of a pixel of the picture in pixels of the screen, and most points."""

_LEAST, _MOST = 0.2, 20.0
_SETTLED = 0.8
_WEIGHT = 0.3


class Detail:
    """Chooses from a ladder of pictures, from whole to coarse, the finest that is quick enough.

    How quick this machine is follows from the pictures that have been drawn; finer ones are taken up again only when
    there is time to spare, so that the picture does not change to and fro.
    """

    def __init__(self) -> None:
        self._slowness = 1.0
        """Time over what a usual machine takes."""
        self._rung = 0

    def choose(self, points: int, pixels: int) -> tuple[int, int]:
        """For a cloud of so many points on so many pixels of the screen: the side of a pixel of the picture, and how
        many points to draw."""
        costs = [_cost(min(points, most), pixels / side**2) for side, most in _LADDER]
        fitting = [rung for rung, cost in enumerate(costs) if self._slowness * cost <= MOVING_S]
        best = fitting[0] if fitting else len(_LADDER) - 1
        if best < self._rung and self._slowness * costs[best] > _SETTLED * MOVING_S:
            best = self._rung
        self._rung = best
        side, most = _LADDER[best]
        return side, min(points, most)

    def note(self, seconds: float, points: int, pixels: float) -> None:
        """Drawing so many points on so many pixels of the picture took that long."""
        found = seconds / _cost(points, pixels)
        self._slowness += _WEIGHT * (min(max(found, _LEAST), _MOST) - self._slowness)


def _cost(points: int, pixels: float) -> float:
    return _POINT_S * points + _PIXEL_S * pixels
