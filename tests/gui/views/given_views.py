"""Linked views of a workspace whose document has the results that a test gives it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QPoint, QPointF

import ilf
from gui.state.document import Document
from gui.state.parts import Part
from gui.state.workspace import Workspace
from gui.views.image_view import ImageView
from gui.views.linked_views import LinkedViews
from ilf.project.project import FrameSummary
from ilf.project.run_history import StoredRun
from ilf.segmentation.editing.patches import patch_between

Depth = NDArray[np.float32]


def place(view: ImageView, x: float, y: float) -> QPoint:
    """Return the whole viewport point nearest to an image point."""
    return view.transform.map(QPointF(x, y)).toPoint()


def colour_at(view: ImageView, position: QPoint) -> tuple[int, ...]:
    """Return what is painted at a point of the viewport."""
    return view.viewport().grab().toImage().pixelColor(position).getRgb()[:3]


RESULT: Any = object()
"""The result of a block in a run that the current result is of."""


class GivenDocument(Document):
    """A document whose results are given, not computed."""

    given: dict[str, Any]

    def current_depth(self) -> Depth | None:
        return self.given.get("depth")

    @property
    def stale(self) -> NDArray[np.bool_]:
        stale: NDArray[np.bool_] | None = self.given.get("stale")
        return np.zeros(self.frame.shape, bool) if stale is None else stale

    def valid_results(self) -> dict[int, Any]:
        return {1: RESULT} if self.state.runs else {}

    def summary(self) -> FrameSummary:
        return self.state.summary(self.counts())

    def completion(self) -> None:
        return None

    def expected_error(self) -> Depth | None:
        return self.given.get("expected")

    def unsupported(self) -> NDArray[np.bool_] | None:
        return self.given.get("unsupported")


class GivenViews(LinkedViews):
    """Views that follow their workspace at once."""

    def __init__(self) -> None:
        self.workspace = Workspace()
        super().__init__(self.workspace)
        self.workspace.changed.connect(self._follow)

    def _follow(self, parts: Part) -> None:
        self.refresh(parts)
        self.blocks.draw(parts)

    @property
    def document(self) -> GivenDocument:
        document = self.workspace.current
        assert isinstance(document, GivenDocument)
        return document

    def open(self, rgb: NDArray[np.uint8], depth: Depth, outside_view: NDArray[np.bool_] | None = None) -> None:
        """Open a frame without blocks."""
        frame = ilf.RGBDFrame(rgb, depth, outside_view=outside_view)
        document = GivenDocument.of(ilf.Run(frame, np.zeros(frame.shape, np.int32)), object(), "key")
        document.given = {}
        self.workspace.open_document(document)
        self.workspace.tell()

    def give(self, **given: Any) -> None:
        """Give the document results: `depth`, `stale`, `expected`, `unsupported`; or `runs`, `ground_truth`,
        `invalid_mask`."""
        document = self.document
        if "runs" in given:
            runs = given.pop("runs")
            document.change(runs=tuple(runs), compared=tuple(run.number for run in runs if run.done))
            document.note(Part.HISTORY | Part.COMPARED)
        if "ground_truth" in given:
            document.set_ground_truth(given.pop("ground_truth"))
        if "invalid_mask" in given:
            document.set_invalid_mask(given.pop("invalid_mask"), "Invalid")
        document.given |= given
        document.note(Part.RESULTS | Part.EXPECTED_ERROR)
        self.workspace.tell()

    def run(
        self,
        name: str,
        depth: Depth,
        number: int = 1,
        colour: tuple[int, int, int] = (1, 2, 3),
        labels: NDArray[np.int32] | None = None,
        is_ticked: bool = True,
        is_result: bool = False,
    ) -> StoredRun:
        """Make a run of the history, ticked for comparison or not."""
        frame = self.document.frame
        run = ilf.Run(frame, self.document.labels.copy() if labels is None else labels)
        done = frozenset([1]) if is_ticked else frozenset()
        stored = StoredRun(number, name, run, {1: RESULT} if is_result else {}, 1.0, colour, done=done)
        completion: Any = SimpleNamespace(depth=depth, extrapolated=np.zeros(frame.shape, bool))
        stored.take_extrapolation = lambda *_: None  # type: ignore[method-assign]
        stored._composed = lambda: completion  # type: ignore[assignment]
        return stored

    def paint(self, labels: NDArray[np.int32], colours: NDArray[np.uint8]) -> None:
        """Set all blocks, with RGBA by label; alpha 0 hides a block."""
        document = self.document
        for label, (*colour, alpha) in enumerate(colours.tolist()[1:], 1):
            document.change_info(label, colour=tuple(colour), visible=alpha > 0)
        document.note(Part.INFOS)
        document.edit(patch_between(document.labels, labels), "Paint")
        self.workspace.tell()

    def stroke(self, rows: slice, columns: slice, label: int) -> None:
        """Paint a box as a stroke does."""
        labels = self.document.labels.copy()
        labels[rows, columns] = label
        self.document.stroke(patch_between(self.document.labels, labels))
        self.workspace.tell()

    def select(self, *labels: int) -> None:
        """Select blocks."""
        self.workspace.select(labels)
        self.workspace.tell()
