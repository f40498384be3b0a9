"""Colours as pages and plots write them."""

from __future__ import annotations

import colorsys

from ..drawing.colour_tables import Colour

_BRIGHTNESS = 0.21
"""Of lines: seen as well on white as on near black."""


def hex_of(colour: Colour) -> str:
    """A colour as HTML and SVG write it."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


def line_colour(colour: Colour) -> Colour:
    """The colour of a block, as dark or bright as lines are on any ground; hue and saturation stay."""
    hue, _, saturation = colorsys.rgb_to_hls(*(part / 255 for part in colour))
    low, high = 0.0, 1.0
    for _ in range(12):
        middle = (low + high) / 2
        bright = _luminance(colorsys.hls_to_rgb(hue, middle, saturation)) > _BRIGHTNESS
        low, high = (low, middle) if bright else (middle, high)
    red, green, blue = (round(255 * part) for part in colorsys.hls_to_rgb(hue, low, saturation))
    return red, green, blue


def _luminance(rgb: tuple[float, float, float]) -> float:
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in rgb)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
