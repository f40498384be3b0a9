"""What the views show: the current document, or what stands in for it for a while. Layers are functions of it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import or_
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtGui import QAction, QPalette

from ilf.completion.suspects import suspect_islands
from ilf.data.frame import RGBDFrame
from ilf.data.results import Completion
from ilf.project.run_history import StoredRun
from ilf.segmentation.edges.frame_edges import FrameEdges

from ..base import theme
from ..state.document import Document
from ..state.parts import EVERY_PART, NO_PART, Part
from ..state.workspace import Workspace
from .colours import DEPTH_MAP, KINDS, Range, depth_table

# Names of contents: a kind ("strength"), a depth ("result", "run-2"), or a difference with its two depths
# ("difference:result:run-1"). `ViewData.concrete` resolves those that depend on the data: "difference", "evaluation",
# and the two sides of a comparison, "a" and "b".

RUNS = ("run-1", "run-2", "run-3", "run-4")
"""Depths of the runs ticked for comparison, in their order."""
EARLIER, INTERPOLATED = "earlier", "interpolated"
"""Depth of the stored run before the current result, and depth in with interpolated holes: to compare with."""
BEFORE_IN, BEFORE_OUT = "before-in", "before-out"
"""Depth in and depth out of the frame before, where the current frame shows their points."""
DEPTHS = ("depth-in", "result", *RUNS, "ground_truth", "guide")
"""Depths that a cell can show."""
COMPARABLE = (*DEPTHS, EARLIER, INTERPOLATED)
"""Depths that a difference can be of."""

DIFFERENCE, EVALUATION = "difference", "evaluation"
FLICKERS = {"flicker": ("result", BEFORE_OUT), "flicker-in": ("depth-in", BEFORE_IN)}
"""Differences against the frame before, and their two depths."""
_NAMED = {"error": ("result", "ground_truth"), **FLICKERS}
"""Differences with a name of their own."""
SIDES = ("a", "b")

_SHORT = {BEFORE_IN: "the frame before", BEFORE_OUT: "the frame before"}


def difference_of(first: str, second: str) -> str:
    """Name of the difference of two depths: the first minus the second.

    Examples
    --------
    >>> difference_of("result", "run-1")
    'difference:result:run-1'
    """
    return f"{DIFFERENCE}:{first}:{second}"


def operands_of(content: str) -> tuple[str, str] | None:
    """The two depths of a difference; None for other contents.

    Examples
    --------
    >>> operands_of("difference:ground_truth:result")
    ('ground_truth', 'result')
    >>> operands_of("error")
    ('result', 'ground_truth')
    """
    if content in _NAMED:
        return _NAMED[content]
    kind, *depths = content.split(":")
    return (depths[0], depths[1]) if kind == DIFFERENCE and len(depths) == 2 else None


def short_title(depth: str, names: dict[str, str]) -> str:
    """Short name of a depth in the title of a difference; `names` are those of runs."""
    return names.get(depth) or _SHORT.get(depth) or depth.replace("-", " ").replace("_", " ")


def capital(text: str) -> str:
    """Capitalise the first letter of a text and leave the others as they are.

    Examples
    --------
    >>> capital("run of Tuesday")
    'Run of Tuesday'
    """
    return text[:1].upper() + text[1:]


# The data.

Depth = NDArray[np.float32]
Mask = NDArray[np.bool_]


class MarkedDepth(NamedTuple):
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


class ShownStage(NamedTuple):
    """The shown stage of the extraction, one of `STAGES`: its picture from `stage_picture`, or a message while there is
    none; a text about it, and the meaning of its colours."""

    name: str = "blocks"
    picture: NDArray[np.uint8] | None = None
    message: str = ""
    text: str = ""
    legend: Sequence[tuple[tuple[int, int, int], str]] = ()


class FormerState(NamedTuple):
    """Blocks and completed depth [m] that are shown in place of the current document's, as before an edit."""

    labels: NDArray[np.int32]
    depth: Depth | None


READ = {
    "frame": Part.FRAME,
    "invalid_mask": Part.FRAME | Part.INVALID_MASK,
    "from_neighbours": Part.FRAME | Part.NEIGHBOURS,
    "by_hand": Part.FRAME | Part.BY_HAND | Part.INVALID_MASK | Part.NEIGHBOURS,
    "result": Part.FRAME | Part.LABELS | Part.PROPOSAL | Part.RESULTS | Part.ITERATION,
    "runs": Part.FRAME | Part.HISTORY | Part.COMPARED,
    "ground_truth": Part.FRAME | Part.GROUND_TRUTH,
    "expected": Part.FRAME | Part.LABELS | Part.RESULTS | Part.EXPECTED_ERROR,
}
"""What is read of the document -> the parts that it depends on. Layers name what they use by these names."""

READ_LATER = {
    # in a drag of a slider, the next preview is there before what is stale is marked
    "result": Part.SOME_RESULTS | Part.PREVIEWS | Part.PARAMETERS,
    "runs": Part.LABELS | Part.RESULTS,
}
"""The same for parts that change several times a second by themselves, which can wait."""

ALL_READ, ALL_READ_LATER = (reduce(or_, table.values()) for table in (READ, READ_LATER))


class ViewData:
    """What the views show of the current document, read by `read`; None where not available. Cells only look at it.

    Attributes
    ----------
    frame : RGBDFrame or None
        Of the document, or the one that is played.
    invalid_mask, suspect, by_hand : ndarray of bool, shape (H, W), or None
        Measured pixels that are invalid, those whose depth the fill has left out, and those with depth by hand.
    result : MarkedDepth or None
    moment : str
        Which earlier iteration the result is from; "" for the current one.
    runs : list of StoredRun
        Runs ticked for comparison, at most four.
    earlier : StoredRun or None
        The stored run before the current result.
    played : RGBDFrame or None
        The frame of a sequence that is shown in place of a document.
    former : FormerState or None
    edges, interpolated, guide, spectrum, before
        What workers have found for the views.
    under_way : str
        What is being done for the first result; "" for nothing.
    without_error : Completion or None
        The one whose expected error could not be computed.
    chosen_sides : (str, str)
        Selected depths to compare; "" for automatic.
    shows_a_as_result : bool
        Whether side A is shown in place of the result.
    swipe_column : int or None
        Column of the frame that divides side A from side B in the result; None while it is not divided.
    stage : ShownStage
    stage_actions : sequence of QAction
        The commands that select a stage.
    ranges : dict
        Kind of `KINDS` -> Range.
    colours : Colours
        Of the theme.
    """

    def __init__(self, workspace: Workspace) -> None:
        self._workspace = workspace
        self.stage = ShownStage()
        self.stage_actions: Sequence[QAction] = ()
        self.ranges = {kind: Range() for kind in KINDS}
        self.depth_map = DEPTH_MAP
        self.depth_table = depth_table(self.depth_map)
        self.colours = theme.colours(QPalette())
        self.chosen_sides = ("", "")
        self.swipe_column: int | None = None
        self.shows_missing = False
        """Whether missing depth is striped over the colour image."""
        self.keeps_picture = False
        """Whether the picture stays while no frame is open, since frames are going to be played."""
        self._forget(None)

    def _forget(self, document: Document | None) -> None:
        """Begin with another document."""
        self.document = document
        self.played: RGBDFrame | None = None
        self.former: FormerState | None = None
        self.shows_a_as_result = False
        self.frame: RGBDFrame | None = None
        self.invalid_mask: Mask | None = None
        self.by_hand: Mask | None = None
        self.suspect: Mask | None = None
        self.result: MarkedDepth | None = None
        self.moment = ""
        self.runs: list[StoredRun] = []
        self.earlier: StoredRun | None = None
        self._compared_completions: list[Completion] = []
        self._earlier_completion: Completion | None = None
        self.result_number = 0
        """Number of the stored run that the result is of; 0 for none."""
        self._run_labels: dict[int, NDArray[np.int32]] = {}
        """Number of each run with other blocks than the current ones -> their label map."""
        self.expected: Depth | None = None
        self.unsupported: Mask | None = None
        self.error_is_outdated = False
        self.edges: FrameEdges | None = None
        self.interpolated: Depth | None = None
        self.guide: Depth | None = None
        self.spectrum: Spectrum | str = ""
        self.before = Before()
        self.under_way = ""
        self.without_error: Completion | None = None

    def read(self, parts: Part) -> set[str]:
        """Read what has changed of the current document; return the names, from `READ`, of what was read."""
        document = self._workspace.shown
        if document is None and (self.keeps_picture or self.frame is None):
            return set()
        self.keeps_picture = False
        if document is None or document is not self.document:
            self._forget(document)
            parts = EVERY_PART
        changed = {name for name, on in READ.items() if parts & (on | READ_LATER.get(name, NO_PART))}
        if document is not None:
            self.frame = document.frame
            for name, read in (
                ("by_hand", self._read_masks),
                ("result", self._read_result),
                ("runs", self._read_runs),
                ("expected", self._read_error),
            ):
                if name in changed:
                    read(document)
        return changed

    def _read_masks(self, document: Document) -> None:
        frame, by_hand = document.frame, document.blocks.by_hand
        self.invalid_mask = _invalid(frame)
        self.by_hand = None if by_hand is None else _any(by_hand.pixels & frame.missing)

    def _read_result(self, document: Document) -> None:
        """The completed depth, with running blocks and stale pixels; or the depth of the iteration being viewed."""
        viewed = self._workspace.viewed_iteration
        self.moment = "" if viewed is None else viewed.text
        if self.former is not None:
            self.result = _plain(self.former.depth)
            return
        if viewed is not None:
            self.result = MarkedDepth(viewed.depth)
            return
        completion, depth = document.completion(), document.current_depth()
        if document.proposal is not None:
            depth = document.with_proposal(document.frame.depth if depth is None else depth)
        extrapolated = None if completion is None else _any(completion.extrapolated)
        self.result = None if depth is None else MarkedDepth(depth, extrapolated, document.stale)
        self.suspect = suspect_islands(completion.frame) if completion is not None and completion.suspect else None

    def _read_runs(self, document: Document) -> None:
        newest, results = [*reversed(document.state.runs)], document.valid_results()
        present = [
            kept for kept in newest if all(kept.results.get(label) is result for label, result in results.items())
        ]
        self.runs, self.earlier = document.compared, next((kept for kept in newest if kept not in present), None)
        self._compared_completions = [kept.completion for kept in self.runs]  # keeps them from being composed again
        self.result_number = present[0].number if present and results else 0
        self._run_labels = {}
        for kept in (*self.runs, *([] if self.earlier is None else [self.earlier])):
            labels = kept.run.blocks.labels
            if not np.array_equal(labels, document.labels):
                self._run_labels[kept.number] = labels

    def _read_error(self, document: Document) -> None:
        """The expected error; the last one stays until a newer one is available, as the depth does."""
        completion, error = document.completion(), document.expected_error()
        hopeless = completion is not None and completion is self.without_error
        self.error_is_outdated = error is None and document.current_depth() is not None and not hopeless
        if not self.error_is_outdated:
            unsupported = document.unsupported()
            self.expected, self.unsupported = error, None if unsupported is None else _any(unsupported)

    def play(self, frame: RGBDFrame, depth: Depth | None, text: str, before: Before) -> None:
        """Show a frame of a sequence in place of a document."""
        if self.played is None or self.played.shape != frame.shape:
            self._forget(None)
        self.played, self.frame, self.before, self.moment = frame, frame, before, text
        self.invalid_mask, self.result = _invalid(frame), _plain(depth)

    @property
    def labels(self) -> NDArray[np.int32] | None:
        """The label map to draw: the document's, or one that stands in for it."""
        if self.document is None:
            return None
        if self.former is not None:
            return self.former.labels
        if self.shows_a_as_result:
            return self._labels_of(self.sides[0], self.document)
        if self.swipe_column is None or self.side_labels is None:
            return self.document.labels
        columns = np.arange(self.document.labels.shape[1]) < self.swipe_column
        return np.where(columns, *self.side_labels)

    @property
    def no_result(self) -> str:
        """What to do where there is no result."""
        if self.played is not None:
            return NOT_PLAYED
        if self.under_way:
            return self.under_way
        return NO_RESULT if self.document is None or self.document.counts() else NO_BLOCKS

    def depth(self, depth: str) -> MarkedDepth | None:
        """Depth by its name, with side A in place of the result if it is shown there; None if it is not available."""
        return self.own_depth(self.sides[0] if depth == "result" and self.shows_a_as_result else depth)

    def own_depth(self, depth: str) -> MarkedDepth | None:
        """Depth by its name; None if it is not available."""
        if depth == "result":
            return self.result
        frame = self.frame
        plain = {
            "depth-in": None if frame is None else frame.own_depth,
            "ground_truth": None if frame is None else frame.ground_truth,
            "guide": self.guide,
            INTERPOLATED: self.interpolated,
            BEFORE_IN: self.before.depth_in,
            BEFORE_OUT: self.before.depth_out,
        }
        if depth in plain:
            return _plain(plain[depth])
        run = self.run(depth)
        if run is None:
            return None
        completion = run.completion
        if depth == EARLIER:
            self._earlier_completion = completion  # keeps it from being composed again every time
        return MarkedDepth(completion.depth, _any(completion.extrapolated))

    def swiped(self, column: int) -> MarkedDepth | None:
        """Depth of side A left of a column and of side B from there on; None if one of them is missing."""
        first, second = (self.depth(side) for side in self.sides)
        if first is None or second is None:
            return None
        columns = np.arange(first.depth.shape[1]) < column
        marks: list[Mask | None] = []
        for left, right in ((first.extrapolated, second.extrapolated), (first.stale, second.stale)):
            there = (False if mask is None else mask for mask in (left, right))
            marks.append(None if left is right is None else np.where(columns, *there))
        return MarkedDepth(np.where(columns, first.depth, second.depth), *marks)

    @property
    def side_labels(self) -> tuple[NDArray[np.int32], NDArray[np.int32]] | None:
        """Label maps of the two sides; None if they have the same, or a side is missing."""
        if self.document is None or any(self.depth(side) is None for side in self.sides):
            return None
        first, second = (self._labels_of(side, self.document) for side in self.sides)
        return None if first is second else (first, second)

    def _labels_of(self, side: str, document: Document) -> NDArray[np.int32]:
        run = self.run(side)
        return document.labels if run is None else self._run_labels.get(run.number, document.labels)

    def run(self, depth: str) -> StoredRun | None:
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
            return "expected-error" if self.own_depth("ground_truth") is None else "error"
        if content == DIFFERENCE:
            return difference_of("result", self._other((*RUNS, EARLIER, "ground_truth"), INTERPOLATED, "result"))
        return content

    def comparable(self) -> list[str]:
        """Depths available for comparison, including the result."""
        there = {"depth-in", "result", INTERPOLATED}
        return [depth for depth in COMPARABLE if depth in there or self._is_there(depth)]

    def _other(self, depths: tuple[str, ...], otherwise: str, than: str) -> str:
        """The first available one of some depths that is another one than `than`."""
        there = (depth for depth in depths if self._is_there(depth) and not self.is_same(depth, than))
        return next(there, otherwise)

    def _is_there(self, depth: str) -> bool:
        """Whether depth is available; that of a run is not composed for the answer."""
        return self.run(depth) is not None or self.depth(depth) is not None


def _plain(depth: Depth | None) -> MarkedDepth | None:
    return None if depth is None else MarkedDepth(depth)


def _invalid(frame: RGBDFrame) -> Mask | None:
    """Return the invalid pixels of a frame: only measured ones can be; None if it has no invalid mask."""
    return None if frame.invalid_mask is None else frame.invalid_mask & np.isfinite(frame.measured)


def _any(mask: Mask) -> Mask | None:
    """Return the mask, or None if it has no pixels."""
    return mask if mask.any() else None


def colour_table(document: Document, min_label: int) -> NDArray[np.uint8]:
    """RGBA by label for the overlay, up to a label and any selected one; hidden blocks are transparent."""
    top = max([*document.selected, min_label])
    table = np.zeros((top + 1, 4), np.uint8)
    for label in range(1, top + 1):
        info = document.info(label)
        table[label] = (*info.colour, 255 if info.visible else 0)
    return table


NO_RESULT, NO_BLOCKS = "No result yet: run the blocks (F5)", "No blocks yet"
NOT_PLAYED = "No result is stored for this frame"
