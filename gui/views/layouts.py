"""The views and layouts: names, titles and positions. No Qt."""

from __future__ import annotations

CELLS = {
    "colour": ("Colour + blocks", "colour"),
    "depth-in": ("Depth in", "depth-in"),
    "depth-out": ("Depth out", "result"),
    "difference": ("Difference", "difference"),
    "expected-error": ("Expected error", "expected-error"),
    "flicker": ("Flicker", "flicker"),
    "extraction": ("Extraction", "extraction"),
    "a": ("Side A", "a"),
    "b": ("Side B", "b"),
    "evaluation": ("Error", "evaluation"),
}
"""Cells: name -> title of the layout with this cell alone, and the default content."""

COMPARE = "compare"
"""Two depths side by side."""

_FIRST_THREE = ("colour", "depth-in", "depth-out")
GRIDS = {
    "grid": ((*_FIRST_THREE, "expected-error"), 2),
    "grid-difference": ((*_FIRST_THREE, "difference"), 2),
    "grid-flicker": ((*_FIRST_THREE, "flicker"), 2),
    "grid-extraction": (("colour", "depth-in", "extraction", "depth-out"), 2),
    "row": ((*_FIRST_THREE, "expected-error"), 4),
    COMPARE: (("a", "b", "difference", "evaluation"), 2),
}
"""Layouts of several views of one size: name -> views, row by row, and the number per row."""

CORRECT = "correct"
"""One large view and several small ones, any of which can be swapped with the large one."""
CORRECT_VIEWS = (*_FIRST_THREE, "expected-error")

LAYOUT_TEXTS = {
    "grid": "Four views",
    "grid-difference": "Four with difference",
    "grid-flicker": "Four with flicker",
    "grid-extraction": "Four with extraction",
    "row": "Four in a row",
    COMPARE: "Two compared",
    CORRECT: "One large, three small",
    **{name: title for name, (title, _) in CELLS.items()},
}
"""Names for `Sheet.set_layout`, and their texts in the window."""

LAYOUTS = tuple(LAYOUT_TEXTS)
"""The same names, in the order of the menu."""

LASTING = tuple(name for name in (*GRIDS, CORRECT) if name != COMPARE)
"""Layouts for work; single views and the comparison of two depths return to them."""

_GAP = 1
_SMALL_SHARES = (0.2, 0.36)
"""Minimum and maximum share of the area's side for the small views of `CORRECT`."""
_SHARES_TRIED = 33


Place = tuple[int, int, int, int]
"""Left, top, width and height of a cell in the area of the views [screen pixels]."""


def picture_area(place: Place, aspect: float, strip: int) -> float:
    """Area of a picture of this aspect ratio in a cell, below a title strip of this height."""
    width = min(float(place[2]), max(place[3] - strip, 0) * aspect)
    return width * width / aspect


def grid_places(count: int, columns: int, width: int, height: int, left: int = 0, top: int = 0) -> list[Place]:
    """Places of cells of one size, row by row, in an area of this size and corner."""
    columns = min(columns, count)
    rows = -(-count // columns)
    across, down = (width - (columns - 1) * _GAP) // columns, (height - (rows - 1) * _GAP) // rows
    return [
        (left + index % columns * (across + _GAP), top + index // columns * (down + _GAP), across, down)
        for index in range(count)
    ]


def correct_places(small: int, width: int, height: int, aspect: float, strip: int) -> list[Place]:
    """Places of the large cell and of `small` others at its right or below, for the largest pictures.

    Parameters
    ----------
    small : int
        Number of small cells.
    width, height : int
        Size of the area.
    aspect : float
        The frame's width over its height.
    strip : int
        Height of the cells' title strips.
    """
    low, high = _SMALL_SHARES
    choices = []
    for share in (low + (high - low) * step / (_SHARES_TRIED - 1) for step in range(_SHARES_TRIED)):
        left, top = width - round(share * width), height - round(share * height)
        choices += [
            [(0, 0, left - _GAP, height), *grid_places(small, 1, width - left, height, left=left)],
            [(0, 0, width, top - _GAP), *grid_places(small, small, width, height - top, top=top)],
        ]
    return max(choices, key=lambda places: sum(picture_area(place, aspect, strip) for place in places))
