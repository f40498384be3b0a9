"""What the user has set for the tools: it holds from tool to tool for as long as the program runs."""

from __future__ import annotations

from dataclasses import dataclass

BRUSH_RADII = (1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 18.0, 27.0, 40.0, 60.0)
"""Where the steps between brush sizes lead, in pixels."""

LARGEST_LEASH = 20
LARGEST_AMOUNT = 30


@dataclass
class ToolOptions:
    """Options of all tools. A tool names those that it has.

    Attributes
    ----------
    brush_radius : float
        Of the round brush, in pixels.
    leash : int
        How far a drawn line may move to lie on an edge, in pixels of the screen, as it is there that a hand trembles;
        0 leaves it as drawn. Never farther than `LARGEST_LEASH` pixels of the image.
    similar_only : bool
        Whether a stroke keeps to pixels like those where it begins.
    to_no_block : bool
        Whether erased pixels belong to no block afterwards, instead of the neighbour that they fit best.
    amount : int
        By how many pixels blocks grow, shrink or are smoothed.
    """

    brush_radius: float = 8.0
    leash: int = 6
    similar_only: bool = False
    to_no_block: bool = False
    amount: int = 2

    def step_brush(self, steps: int) -> None:
        """A larger or smaller brush, by steps that are larger for large ones."""
        nearest = min(range(len(BRUSH_RADII)), key=lambda k: abs(BRUSH_RADII[k] - self.brush_radius))
        self.brush_radius = BRUSH_RADII[min(max(nearest + steps, 0), len(BRUSH_RADII) - 1)]
