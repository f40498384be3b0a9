"""The data of the linked views, which all layers are made from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ilf.segmentation.edges.frame_edges import FrameEdges

from .colours import DEPTH_MAP, KINDS, Range, depth_table
from .contents import (
    BEFORE_IN,
    BEFORE_OUT,
    COMPARABLE,
    DIFFERENCE,
    EARLIER,
    EVALUATION,
    INTERPOLATED,
    RUNS,
    SIDES,
    difference_of,
)
from .stages import StageModel

Depth = NDArray[np.float32]
Mask = NDArray[np.bool_]


Blocks = tuple[NDArray[np.int32], NDArray[np.uint8]]
"""A label map (H, W), and RGBA by label (N + 1, 4)."""


@dataclass(frozen=True, eq=False)
class ShownRun:
    """A stored run as the views need it: name, depth [m] with the mask of extrapolated pixels, colour (R, G, B),
    blocks if they differ from the current ones, and its number, 0 for none."""

    name: str
    depth: Depth
    extrapolated: Mask | None = None
    colour: tuple[int, int, int] | None = None
    blocks: Blocks | None = None
    number: int = 0

    def __eq__(self, other: object) -> bool:
        """Whether both have the identical depth under the same name; the blocks of a run never change."""
        return (
            isinstance(other, ShownRun)
            and self.depth is other.depth
            and (self.name, self.colour, self.number) == (other.name, other.colour, other.number)
            and (self.blocks is None) == (other.blocks is None)
        )

    __hash__ = None  # type: ignore[assignment]


class ShownDepth(NamedTuple):
    """One depth [m], NaN = missing, with masks of extrapolated pixels and of pixels from an older state of a block."""

    depth: Depth
    extrapolated: Mask | None = None
    stale: Mask | None = None


class Before(NamedTuple):
    """Depth in and depth out [m] of the frame before where the current frame shows their points, None for none; a text
    on which frame it is, or why there is none."""

    depth_in: Depth | None = None
    depth_out: Depth | None = None
    text: str = ""


class Spectrum(NamedTuple):
    """Spectrum of a block: log magnitudes 0-1 around k = 0 in the middle, and the half axes of the pass band [samples];
    `text` is its title."""

    magnitude: NDArray[np.float32]
    radii: tuple[float, float]
    text: str


class Material:
    """Pictures and depths of the frame shown; None where not available. Cells only read it.

    Attributes
    ----------
    measured, depth_in : ndarray of float32, shape (H, W), or None
        Measured depth [m], with and without invalid depth.
    outside_view : ndarray of bool, shape (H, W), or None
        Pixels that the depth camera could not see.
    from_neighbours : ndarray of bool, shape (H, W), or None
        Pixels whose depth only neighbours have measured.
    suspect, by_hand : ndarray of bool, shape (H, W), or None
        Pixels whose depth the fill has left out, and those with depth by hand.
    result : ShownDepth or None
    moment : str
        Which earlier iteration the result is from; "" for the current one.
    runs : tuple of ShownRun
        Runs ticked for comparison, at most four.
    earlier : ShownRun or None
        The stored run before the current result.
    before : Before
        The frame before, for flicker.
    chosen_sides : (str, str)
        Selected depths to compare; "" for automatic.
    shows_a_as_result : bool
        Whether side A is shown in place of the result.
    swipe_column : int or None
        Column of the frame that divides side A from side B in the result; None while it is not divided.
    stage : StageModel
        The stage of the extraction.
    ranges : dict
        Kind of `KINDS` -> Range.
    is_running : bool
        Whether the first result is being computed.
    played : bool
        Whether the frames of a sequence are being played: colour ranges stay as they are.
    """

    def __init__(self, stage: StageModel) -> None:
        self.stage = stage
        self.ranges = {kind: Range() for kind in KINDS}
        self.depth_map = DEPTH_MAP
        self.depth_table = depth_table(self.depth_map)
        self.chosen_sides = ("", "")
        self.swipe_column: int | None = None
        self.forget()

    def forget(self) -> None:
        """Drop all data: no frame is open."""
        self.rgb: NDArray[np.uint8] | None = None
        self.measured: Depth | None = None
        self.depth_in: Depth | None = None
        self.invalid_mask: Mask | None = None
        self.outside_view: Mask | None = None
        self.from_neighbours: Mask | None = None
        self.suspect: Mask | None = None
        self.by_hand: Mask | None = None
        self.ground_truth: Depth | None = None
        self.guide: Depth | None = None
        self.runs: tuple[ShownRun, ...] = ()
        self.earlier: ShownRun | None = None
        self.result_number = 0
        """Number of the stored run that the result is of; 0 for none."""
        self.before = Before()
        self.played = False
        self.interpolated: Depth | None = None
        self.edges: FrameEdges | None = None
        self.spectrum: Spectrum | str = ""
        self.clear_result()

    def clear_result(self) -> None:
        """Drop the result and its errors."""
        self.result: ShownDepth | None = None
        self.moment = ""
        self.expected: Depth | None = None
        self.unsupported: Mask | None = None
        self.error_is_outdated = False
        self.shows_a_as_result = False
        self.is_running = False

    def set_invalid_mask(self, mask: Mask | None) -> None:
        """Set the invalid mask: measured depth there is wrong and counts as missing; None for none."""
        measured = self.measured
        # only measured pixels can be invalid
        wrong = None if mask is None or measured is None else mask & np.isfinite(measured)
        self.invalid_mask = wrong
        self.depth_in = measured
        if wrong is not None and measured is not None:
            self.depth_in = np.where(wrong, np.float32(np.nan), measured)

    @property
    def no_result(self) -> str:
        """What to do where there is no result."""
        if self.played:
            return NOT_PLAYED
        return "Completing\N{HORIZONTAL ELLIPSIS}" if self.is_running else NO_RESULT

    def depth(self, depth: str) -> ShownDepth | None:
        """Depth by its name, with side A in place of the result if it is shown there; None if it is not available."""
        return self.own_depth(self.sides[0] if depth == "result" and self.shows_a_as_result else depth)

    def own_depth(self, depth: str) -> ShownDepth | None:
        """Depth by its name; None if it is not available."""
        if depth == "result":
            return self.result
        if depth == "depth-in":
            return _plain(self.depth_in)
        if depth == "ground_truth":
            return _plain(self.ground_truth)
        if depth == "guide":
            return _plain(self.guide)
        if depth == INTERPOLATED:
            return _plain(self.interpolated)
        if depth == BEFORE_IN:
            return _plain(self.before.depth_in)
        if depth == BEFORE_OUT:
            return _plain(self.before.depth_out)
        run = self.run(depth)
        return None if run is None else ShownDepth(run.depth, run.extrapolated)

    def swiped(self, column: int) -> ShownDepth | None:
        """Depth of side A left of a column and of side B from there on; None if one of them is missing."""
        first, second = (self.depth(side) for side in self.sides)
        if first is None or second is None:
            return None
        depth = second.depth.copy()
        depth[:, :column] = first.depth[:, :column]
        marks: list[Mask | None] = []
        for left, right in ((first.extrapolated, second.extrapolated), (first.stale, second.stale)):
            both = None
            if left is not None or right is not None:
                both = np.zeros(depth.shape, bool) if right is None else right.copy()
                both[:, :column] = False if left is None else left[:, :column]
            marks.append(both)
        return ShownDepth(depth, *marks)

    @property
    def side_blocks(self) -> tuple[Blocks | None, Blocks | None]:
        """Blocks of the two sides, where they differ from the current ones."""
        first, second = (None if (run := self.run(side)) is None else run.blocks for side in self.sides)
        return first, second

    def run(self, depth: str) -> ShownRun | None:
        """The run that a depth belongs to; None if it is not a run's."""
        if depth == EARLIER:
            return self.earlier
        number = RUNS.index(depth) if depth in RUNS else len(self.runs)
        return self.runs[number] if number < len(self.runs) else None

    @property
    def names(self) -> dict[str, str]:
        """Names of the depths that belong to runs."""
        return {depth: run.name for depth in (*RUNS, EARLIER) if (run := self.run(depth)) is not None}

    @property
    def sides(self) -> tuple[str, str]:
        """The two depths that are compared, A and B: never a run and itself."""
        first, second = self.chosen_sides
        if first and not second and self.is_same(first, "result"):
            return first, self._other((*RUNS, EARLIER), "depth-in" if first != "depth-in" else "result", first)
        second = second or "result"
        if not first or self.is_same(first, second):
            first = self._other((*RUNS, EARLIER), "depth-in" if second != "depth-in" else "result", second)
        return first, second

    def is_same(self, one: str, other: str) -> bool:
        """Whether two names are of the same depth, such as that of the run that the result is of."""
        return self._identity(one) == self._identity(other)

    def _identity(self, depth: str) -> str | int:
        run = self.run(depth)
        number = self.result_number if depth == "result" else 0 if run is None else run.number
        return number or depth

    def concrete(self, content: str) -> str:
        """Resolve a content to the concrete one that it currently stands for."""
        if content in SIDES:
            return self.sides[SIDES.index(content)]
        if content in (EVALUATION, "error"):
            return "expected-error" if self.ground_truth is None else "error"
        if content == DIFFERENCE:
            return difference_of("result", self._other((*RUNS, EARLIER, "ground_truth"), INTERPOLATED, "result"))
        return content

    def comparable(self) -> list[str]:
        """Depths available for comparison, including the result."""
        there = {"depth-in", "result", INTERPOLATED}
        return [depth for depth in COMPARABLE if depth in there or self.depth(depth) is not None]

    def _other(self, depths: tuple[str, ...], otherwise: str, than: str) -> str:
        """The first available one of some depths that is another one than `than`."""
        there = (depth for depth in depths if self.depth(depth) is not None and not self.is_same(depth, than))
        return next(there, otherwise)


def _plain(depth: Depth | None) -> ShownDepth | None:
    return None if depth is None else ShownDepth(depth)


NO_RESULT = "No result yet: run the blocks (F5)"
NOT_PLAYED = "No result is stored for this frame"
