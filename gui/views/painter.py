"""What draws one content into a cell."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QBrush, QColor

from ilf.segmentation.edges.frame_edges import FrameEdges

from ..base.theme import Colours
from .colours import KINDS, Levels, Range, depth_table
from .contents import COMPARABLE, DIFFERENCE, EARLIER, INTERPOLATED, JUDGEMENT, RUNS, SIDES, TITLES, difference_of
from .view_cell import ViewCell

# All that the linked views have to show, in one place that every cell draws from. No Qt.

Depth = NDArray[np.float32]
Mask = NDArray[np.bool_]


Blocks = tuple[NDArray[np.int32], NDArray[np.uint8]]
"""A label map (H, W), and RGBA by label (N + 1, 4)."""


class ShownRun(NamedTuple):
    """What the views need of a kept run: name, depth [m] with what of it is a guess, its colour (R, G, B), and its
    blocks if they are others than the present ones."""

    name: str
    depth: Depth
    guessed: Mask | None = None
    colour: tuple[int, int, int] | None = None
    blocks: Blocks | None = None


class Layer(NamedTuple):
    """One depth [m], NaN missing; which of it is a guess, and which of an older state of its block."""

    depth: Depth
    guessed: Mask | None = None
    stale: Mask | None = None


class Spectrum(NamedTuple):
    """Spectrum of a block: log magnitudes 0-1 around k = 0 in the middle, and the half axes of the pass band [samples];
    `text` says of what."""

    magnitude: NDArray[np.float32]
    radii: tuple[float, float]
    text: str


class Material:
    """Pictures and depths of the frame shown; None is what there is not. Cells change nothing of it.

    Attributes
    ----------
    measured, depth_in : ndarray of float32, shape (H, W), or None
        Depth as it was measured, and less what of it is distrusted [m].
    outside_view : ndarray of bool, shape (H, W), or None
        Pixels that the depth camera could not see.
    result : Layer or None
    moment : str
        When the result was as it is, "" for now.
    runs : tuple of ShownRun
        Those ticked for comparison, at most four.
    earlier : ShownRun or None
        The kept run before the present result.
    chosen_sides : (str, str)
        Depths that are compared, as they were chosen; "" for the best choice.
    looks_at_a : bool
        Whether side A stands in for the result.
    swiped_at : int or None
        Column of the frame that parts side A from side B where the result is shown; None while it is not parted.
    ranges : dict
        Kind of `KINDS` -> Range.
    """

    def __init__(self) -> None:
        self.ranges = {kind: Range() for kind in KINDS}
        self.depth_map = "turbo"
        self.depth_table = depth_table(self.depth_map)
        self.chosen_sides = ("", "")
        self.swiped_at: int | None = None
        self.forget()

    def forget(self) -> None:
        """There is no frame."""
        self.rgb: NDArray[np.uint8] | None = None
        self.measured: Depth | None = None
        self.depth_in: Depth | None = None
        self.distrusted: Mask | None = None
        self.outside_view: Mask | None = None
        self.truth: Depth | None = None
        self.guide: Depth | None = None
        self.runs: tuple[ShownRun, ...] = ()
        self.earlier: ShownRun | None = None
        self.interpolated: Depth | None = None
        self.edges: FrameEdges | None = None
        self.spectrum: Spectrum | str = ""
        self.forget_result()

    def forget_result(self) -> None:
        """Nothing is completed."""
        self.result: Layer | None = None
        self.moment = ""
        self.expected: Depth | None = None
        self.unvouched: Mask | None = None
        self.error_is_outdated = False
        self.looks_at_a = False

    def layer(self, depth: str) -> Layer | None:
        """A depth by its name."""
        if depth == "result":
            return self.layer(self.sides[0]) if self.looks_at_a and self.sides[0] != "result" else self.result
        if depth == "depth-in":
            return _plain(self.depth_in)
        if depth == "truth":
            return _plain(self.truth)
        if depth == "guide":
            return _plain(self.guide)
        if depth == INTERPOLATED:
            return _plain(self.interpolated)
        run = self.run(depth)
        return None if run is None else Layer(run.depth, run.guessed)

    def swiped(self, column: int) -> Layer | None:
        """Side A left of a column, side B from there on; None if one of them is missing."""
        first, second = (self.layer(side) for side in self.sides)
        if first is None or second is None:
            return None
        depth = second.depth.copy()
        depth[:, :column] = first.depth[:, :column]
        marks: list[Mask | None] = []
        for left, right in ((first.guessed, second.guessed), (first.stale, second.stale)):
            both = None
            if left is not None or right is not None:
                both = np.zeros(depth.shape, bool) if right is None else right.copy()
                both[:, :column] = False if left is None else left[:, :column]
            marks.append(both)
        return Layer(depth, *marks)

    @property
    def side_blocks(self) -> tuple[Blocks | None, Blocks | None]:
        """Blocks of the two sides, where they are others than the present ones."""
        first, second = (None if (run := self.run(side)) is None else run.blocks for side in self.sides)
        return first, second

    def run(self, depth: str) -> ShownRun | None:
        """The run that a depth is of; None if it is of none."""
        if depth == EARLIER:
            return self.earlier
        number = RUNS.index(depth) if depth in RUNS else len(self.runs)
        return self.runs[number] if number < len(self.runs) else None

    @property
    def names(self) -> dict[str, str]:
        """Names of the depths that are of runs."""
        return {depth: run.name for depth in (*RUNS, EARLIER) if (run := self.run(depth)) is not None}

    @property
    def sides(self) -> tuple[str, str]:
        """The two depths that are compared, A and B."""
        first, second = self.chosen_sides
        return first or self._other(("run-1", EARLIER), "depth-in"), second or "result"

    def concrete(self, content: str) -> str:
        """What a content stands for as things are."""
        if content in SIDES:
            return self.sides[SIDES.index(content)]
        if content == JUDGEMENT:
            return "expected-error" if self.truth is None else "error"
        if content == DIFFERENCE:
            return difference_of("result", self._other(("run-1", EARLIER, "truth"), INTERPOLATED))
        return content

    def comparable(self) -> list[str]:
        """Depths that there are to compare, the result among them."""
        there = {"depth-in", "result", INTERPOLATED}
        return [depth for depth in COMPARABLE if depth in there or self.layer(depth) is not None]

    def _other(self, depths: tuple[str, ...], otherwise: str) -> str:
        """The first of some depths that there is, beside the result."""
        return next((depth for depth in depths if self.layer(depth) is not None), otherwise)


def _plain(depth: Depth | None) -> Layer | None:
    return None if depth is None else Layer(depth)


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
