"""Readings of the paper's text: what it leaves open about the filter, value by value."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ..parameters import PRESETS, Parameters

UNKNOWNS: dict[str, tuple[Any, ...]] = {
    "start": ("mean", "1 / longest", "1 / shortest"),
    "step": (0.5, 1.0, 2.0),
    "wavelength_px": (15.0, 60.0),
    "mean": ("left in", "taken off"),
    "padding": (1.0, 2.0),
    "colour": ("weighted", "not used"),
}
"""What is open about the filter: the fields of `Reading` with the values that are tried."""

NAMES = {
    "start": "start",
    "step": "step [basebands]",
    "wavelength_px": "shortest wave [px]",
    "mean": "mean depth",
    "padding": "padding",
    "colour": "colour spectrum",
}
"""The same in words."""


@dataclass(frozen=True)
class Reading:
    """One reading of what the text says about the filter.

    Attributes
    ----------
    start : str
        First cut-off frequency: the mean alone, or 1 / longest or 1 / shortest length of the block.
    step : float
        By which the cut-off frequency grows, in basebands.
    wavelength_px : float
        Shortest wave of the last pass band, in pixels of the full grid.
    mean : str
        Whether the mean of the known depth is taken off before.
    padding : float
        Side of the padded grid, in sides of the block.
    colour : str
        Whether the colour spectrum weights the first iterations.
    """

    start: str
    step: float
    wavelength_px: float
    mean: str
    padding: float
    colour: str

    def parameters(self, shape: tuple[int, int], every: int) -> Parameters:
        """The preset `paper`, read so, for a block of this shape of which every so many-th pixel was taken."""
        paper = PRESETS["paper"]
        starts = {"mean": 0.0, "1 / longest": 1.0, "1 / shortest": max(shape) / min(shape)}
        return paper.replace(
            mode="fill+denoise",
            staged_start=starts[self.start],
            stage_step=self.step,
            shortest_wavelength=max(self.wavelength_px / every, 2.0),
            centred=self.mean == "taken off",
            padding=self.padding,
            rgb_iterations=paper.rgb_iterations if self.colour == "weighted" else 0,
        )


PRESET = Reading("mean", 0.5, 15.0, "left in", 2.0, "weighted")
"""The reading that the preset `paper` follows."""


def in_words(values: dict[str, Any], names: Iterable[str] = UNKNOWNS) -> str:
    """ "start 1 / shortest, mean depth taken off" of a row or the like."""
    return ", ".join(f"{NAMES[name]} {_shown(values[name])}" for name in names)


def _shown(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
