"""Which views there are, how they are called, and how they can be arranged."""

from __future__ import annotations

CELLS = {
    "colour": ("Colour + blocks", ""),
    "depth-in": ("Depth in", "m"),
    "depth-out": ("Depth out", "m"),
    "difference": ("Difference", "mm"),
    "expected-error": ("Expected error", "mm"),
}
"""Views of a frame and its results: name -> title, and the unit of its colours."""

_SQUARE, _LINE = ((0, 0), (0, 1), (1, 0), (1, 1)), ((0, 0), (0, 1), (0, 2), (0, 3))
_FIRST_THREE = ("colour", "depth-in", "depth-out")
GRIDS = {
    "grid": dict(zip((*_FIRST_THREE, "expected-error"), _SQUARE, strict=True)),
    "grid-difference": dict(zip((*_FIRST_THREE, "difference"), _SQUARE, strict=True)),
    "grid-extraction": dict(zip(("colour", "depth-in", "extraction", "depth-out"), _SQUARE, strict=True)),
    "row": dict(zip((*_FIRST_THREE, "expected-error"), _LINE, strict=True)),
}
"""Layouts of several views: name -> view -> row and column."""

LAYOUT_TEXTS = {
    "grid": "Four views",
    "grid-difference": "Four, difference",
    "grid-extraction": "Four, extraction",
    "row": "Side by side",
    **{name: title for name, (title, _) in CELLS.items()},
    "extraction": "Extraction",
}
"""Names that `LinkedViews.set_layout` takes, and what the user reads."""

LAYOUTS = tuple(LAYOUT_TEXTS)
"""The same names, in the order of the menu."""
