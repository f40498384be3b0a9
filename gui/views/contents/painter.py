"""What draws one content into a cell."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush, QColor

from gui.theme import Colours
from gui.views.ranges import Levels
from gui.views.view_cell import ViewCell

from .material import Material
from .names import TITLES

NO_RESULT = "No result yet"
NO_GUIDE = "No guide: this frame has none"


class Painter:
    """Draws one content into a cell, and takes from it what it has added when it leaves.

    Attributes
    ----------
    uses : frozenset of str
        Parts of the material that it draws from; when another one changes, it need not draw.
    range_kind : str
        Which of the ranges its colours have; "" for none.
    unit : str
        Of the colour bar.
    """

    uses: frozenset[str] = frozenset()
    range_kind = ""
    unit = ""

    def __init__(self, content: str, cell: ViewCell, material: Material) -> None:
        self.content = content
        self.cell = cell
        self.material = material
        cell.bar.set_unit(self.unit)
        cell.strip.set_title(self.title)

    @property
    def title(self) -> str:
        """What stands in the cell's title strip."""
        return TITLES[self.content]

    def set_colours(self, colours: Colours, hatch: QBrush) -> None:
        """Take the colours of the theme; `draw` follows."""

    def draw(self) -> None:
        """Draw what there is, as far as it is not drawn already."""
        raise NotImplementedError

    def value_at(self, x: int, y: int) -> float | None:
        """The number at a pixel, in the unit of the colour bar; None if there is none."""
        return None

    def values(self) -> NDArray[np.floating] | None:
        """Numbers that are shown, in the unit of the colour bar, NaN for none: all or a fair sample; None for none."""
        return None

    def leave(self) -> None:
        """Take back what this content alone has in the cell."""

    def show_nothing(self, message: str) -> None:
        """No picture, but why there is none."""
        self.cell.view.set_message(message)
        self.cell.view.set_picture(None)
        self.cell.bar.set_levels(None)


def number_at(values: NDArray[Any] | None, x: int, y: int, factor: float = 1.0) -> float | None:
    """A number of an array (H, W) or None: None where it is NaN or there is no such pixel."""
    if values is None or not (0 <= y < values.shape[0] and 0 <= x < values.shape[1]):
        return None
    value = factor * float(values[y, x])
    return value if np.isfinite(value) else None


def levels_of(
    material: Material,
    kind: str,
    robust: Callable[[], Levels],
    values: Callable[[], NDArray[np.floating]],
) -> Levels:
    """The levels of a kind for some values, in its unit, whose robust ones are these."""
    return material.ranges[kind].find(robust, lambda: full_levels(values()))


def full_levels(values: NDArray[np.floating]) -> Levels:
    """Least and largest of the known values, a little apart; (0, 1) where none is known."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0, 1.0
    low, high = float(known.min()), float(known.max())
    return (low, high) if high - low > 1e-3 else (low - 0.05, high + 0.05)


def mark_table(*colours: QColor) -> NDArray[np.uint8]:
    """Table that shows 1, 2, ... in these colours and 0 not at all."""
    table = np.zeros((256, 4), np.uint8)
    for index, colour in enumerate(colours, 1):
        table[index] = colour.red(), colour.green(), colour.blue(), colour.alpha()
    return table
