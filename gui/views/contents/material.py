"""All that the linked views have to show, in one place that every cell draws from. No Qt."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gui.views.colour_maps import depth_table
from gui.views.ranges import KINDS, Range
from ilf.edges import FrameEdges

from .names import COMPARABLE, DIFFERENCE, EARLIER, INTERPOLATED, JUDGEMENT, RUNS, SIDES, difference_of

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
