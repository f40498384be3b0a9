"""Shows the current frame, its blocks, its completed depth and the expected error in the linked views."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from ilf.completion.confidence.expected_error import expected_error, unsupported
from ilf.completion.suspects import suspect_islands
from ilf.data.frame import RGBDFrame
from ilf.data.label_map import Box
from ilf.data.results import Completion

from ..base.commands import Command
from ..base.needs import Need
from ..state.document import Document
from ..state.parts import EVERY_PART, Part
from ..state.results import ErrorEstimate
from ..state.workspace import Workspace
from ..views.linked_views import LinkedViews
from ..views.material import Before
from ..views.view_menus import ViewBar
from ..work.frame_runs import RunState
from ..work.latest_request import LatestRequest
from .context import Context, Feature


class ViewsPresenter(QObject):
    """Presenter of the frame's pictures, the block overlay and lines, and depth out.

    Signals
    -------
    names_toggled()
        Block names were switched on or off: call `show_blocks`.
    """

    names_toggled = Signal()

    def __init__(self, workspace: Workspace, views: LinkedViews) -> None:
        super().__init__(views)
        self._workspace = workspace
        self._views = views
        self._shown: Document | None = None
        self._table: NDArray[np.uint8] | None = None
        self._boxes: list[Box] = []
        self._colours_valid = False
        self._names_valid = False
        self._shows_names = False
        self._shows_other = False
        """Whether the views temporarily show other blocks and depth."""
        self._shows_played = False
        """Whether the views show frames that are played, until another frame is open."""
        for signal in (workspace.labels_changed, workspace.stroke_changed):
            signal.connect(self._boxes.append)

    def show_frame(self) -> None:
        """Show colour and depth in of a new frame; this clears the pictures of the frame before."""
        document = self._workspace.current if self._workspace.has_current else None
        if document is None and self._shows_played:
            self._shown = None
            return
        self._shows_played = False
        if document is not self._shown:
            self._shown, self._table, self._shows_other = document, None, False
            if document is None:
                self._views.clear()
            else:
                frame = document.frame
                self._views.set_frame(frame.rgb, frame.measured, frame.outside_view)
        if document is not None:
            frame, by_hand = document.frame, document.blocks.by_hand
            self._views.show_data(
                invalid_mask=frame.invalid_mask,
                from_neighbours=frame.from_neighbours,
                by_hand=None if by_hand is None else _any(by_hand.pixels & frame.missing),
            )

    def show_played(self, frame: RGBDFrame, depth: NDArray[np.float32] | None, text: str, before: Before) -> None:
        """Show a frame that is not open, its completed depth [m] with a text on how it was completed, and the depth of
        the frame before."""
        self._views.show_played(frame.rgb, frame.own_depth, depth, text, before)

    def keep_pictures(self, on: bool) -> None:
        """Keep the pictures while no frame is open and frames are played; with False, show that none is open."""
        self._shows_played = on
        if not on and not self._workspace.has_current:
            self._views.clear()

    def show_blocks(self, parts: Part = EVERY_PART) -> None:
        """Show the blocks (all if colours changed, else the changed boxes), the selection and the names."""
        if parts & (Part.FRAME | Part.INFOS | Part.SELECTION):  # a new block is selected before it is painted
            self._colours_valid = False
        if parts & (Part.FRAME | Part.INFOS | Part.LABELS):
            self._names_valid = False
        if self._shows_other:
            return
        boxes = self._boxes.copy()
        self._boxes.clear()
        if not self._workspace.has_current:
            return
        document = self._workspace.current
        table = self._colour_table(document, boxes)
        if self._table is None or not np.array_equal(table[: len(self._table)], self._table):
            self._views.set_blocks(document.labels, table)
        else:
            if len(table) > len(self._table):
                self._views.add_colours(table)
            for box in boxes:
                self._views.update_blocks_region(*box, document.labels[box])
        self._table = table
        self._views.set_selected(document.selected)
        self._views.set_to_check(sorted(document.state.to_check))
        if not self._names_valid:
            self._names_valid = True
            names = {label: document.info(label).name for label in document.counts()} if self._shows_names else None
            self._views.set_block_names(names)

    def show_names(self, on: bool) -> None:
        """Show or hide the blocks' names."""
        self._shows_names = on
        self._names_valid = False
        self.names_toggled.emit()

    def _colour_table(self, document: Document, boxes: list[Box]) -> NDArray[np.uint8]:
        """Colour table; the last one if it cannot have changed, as in a stroke with a block that has a colour."""
        if self._table is None:
            top, known = int(document.labels.max()), 0
        else:
            top, known = max((int(document.labels[box].max()) for box in boxes), default=0), len(self._table) - 1
        if self._table is None or not self._colours_valid or top > known:
            self._colours_valid = True
            return colour_table(document, max(top, known))
        return self._table

    def show_depth(self) -> None:
        """Show the completed depth, including running blocks, with stale pixels marked; or the depth of the iteration
        being viewed."""
        if self._workspace.has_current and not self._shows_other:
            document, viewed_iteration = self._workspace.current, self._workspace.viewed_iteration
            self._views.show_data(moment="" if viewed_iteration is None else viewed_iteration.text)
            if viewed_iteration is not None:
                self._views.set_result(viewed_iteration.depth)
                return
            completion = document.completion()
            extrapolated = None if completion is None else _any(completion.extrapolated)
            depth = document.current_depth()
            if document.proposal is not None:
                depth = document.with_proposal(document.frame.depth if depth is None else depth)
            self._views.set_result(depth, extrapolated, None if depth is None else document.stale)
            suspect = suspect_islands(completion.frame) if completion is not None and completion.suspect else None
            self._views.show_data(suspect=suspect)

    def show_other(self, labels: NDArray[np.int32], depth: NDArray[np.float32] | None) -> None:
        """Show other blocks of the current frame, int32 (H, W), and other completed depth [m], None for none,
        until `show_present`."""
        self.show_other_blocks(labels)
        self._views.set_result(depth)

    def show_other_blocks(self, labels: NDArray[np.int32]) -> None:
        """Show other blocks of the current frame, int32 (H, W), until `show_present`."""
        self._shows_other = True
        table = colour_table(self._workspace.current, int(labels.max()))
        self._views.set_blocks(labels, table)
        self._table = None

    def show_present(self) -> None:
        """Show the blocks and the depth of the current frame again."""
        self._shows_other = False
        self.show_frame()
        self.show_blocks()
        self.show_depth()

    def zoom_to_blocks(self) -> None:
        """Zoom to the selected blocks."""
        document = self._workspace.current
        rows, columns = np.nonzero(np.isin(document.labels, document.selected))
        if rows.size:
            self._views.zoom_to(
                slice(int(rows.min()), int(rows.max()) + 1), slice(int(columns.min()), int(columns.max()) + 1)
            )


def _any(mask: NDArray[np.bool_]) -> NDArray[np.bool_] | None:
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


class ViewsFeature(Feature):
    """The linked views with the current frame, and the commands on their display."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        workspace, views = context.workspace, context.views
        self.presenter = presenter = ViewsPresenter(workspace, views)
        context.actions.add(
            (
                Command(
                    "zoom_block",
                    "&Zoom to block",
                    "Zoom to the selected block",
                    icon="ph.magnifying-glass-plus",
                    keys="Ctrl+J",
                    handler=presenter.zoom_to_blocks,
                    needs=Need.SELECTION,
                ),
                Command(
                    "fit",
                    "&Fit frame",
                    "Show the whole frame",
                    icon="ph.arrows-out",
                    keys="Ctrl+0",
                    handler=views.fit,
                    needs=Need.FRAME,
                ),
                Command(
                    "one_to_one",
                    "&One to one",
                    "Show one image pixel per screen pixel",
                    icon="ph.frame-corners",
                    keys="Ctrl+9",
                    handler=views.one_to_one,
                    needs=Need.FRAME,
                ),
                Command(
                    "contours_only",
                    "&Contours only",
                    "Show blocks as outlines, without fill",
                    icon="ph.polygon",
                    keys="Ctrl+Shift+C",
                    checkable=True,
                    handler=views.set_contours_only,
                ),
                Command(
                    "block_names",
                    "Block &names",
                    "Show the names of the blocks over the images",
                    icon="ph.text-t",
                    keys="Ctrl+Shift+T",
                    checkable=True,
                    handler=presenter.show_names,
                ),
                Command(
                    "show_missing",
                    "&Missing depth over colour",
                    "Stripe the colour image where depth is missing",
                    icon="ph.selection-slash",
                    keys="Ctrl+Shift+H",
                    checkable=True,
                    handler=views.set_missing_shown,
                ),
            )
        )
        shown = ("contours_only", "block_names", "show_missing", "fit")
        self.bar = ViewBar(views, context.centre, [context.actions[name] for name in shown])
        add = context.refresh.add
        add("picture", presenter.show_frame, Part.FRAME | Part.INVALID_MASK | Part.NEIGHBOURS | Part.BY_HAND)
        add(
            "blocks",
            lambda: presenter.show_blocks(context.refresh.changed("blocks")),
            Part.FRAME | Part.LABELS | Part.STROKE | Part.INFOS | Part.SELECTION,
            also=(presenter.names_toggled,),
        )
        add(
            "depth",
            presenter.show_depth,
            Part.FRAME | Part.LABELS | Part.PROPOSAL | Part.RESULTS | Part.ITERATION,
            # in a drag of a slider, the next preview is there before what is stale is marked
            Part.SOME_RESULTS | Part.PREVIEWS | Part.PARAMETERS,
        )


# The expected error of the completed depth, computed in a worker thread while a view shows it.


class _Question(NamedTuple):
    document: Document
    completion: Completion


class ErrorFeature(Feature):
    """The expected error. A completion for which it failed is not tried again."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._workspace = context.workspace
        self._runs = context.runs
        self._views = views = context.views
        self._failed_completion: Completion | None = None
        self._watchers: list[Callable[[], bool]] = []
        self._questions = LatestRequest[_Question, ErrorEstimate](_find, self)
        self._questions.answered.connect(self._take)
        self._questions.failed.connect(self._fail)
        self.busy_changed = self._questions.begun, self._questions.ended
        context.refresh.add(
            "error",
            self.show,
            Part.FRAME | Part.LABELS | Part.RESULTS | Part.EXPECTED_ERROR | Part.RUNNING,
            also=(context.cloud.colours_changed, views.shownChanged, context.centre.turned),
        )

    @property
    def busy(self) -> bool:
        """Whether an expected error is being computed."""
        return self._questions.busy

    def watch(self, is_seen: Callable[[], bool]) -> None:
        """Compute it also while `is_seen()` is true."""
        self._watchers.append(is_seen)

    def show(self) -> None:
        """Show the expected error of the current results; compute it if it is visible and no run is changing them."""
        if not self._workspace.has_current:
            return
        document = self._workspace.current
        completion, error = document.completion(), document.expected_error()
        # the last error stays until a newer one is available, as the depth does
        hopeless = completion is not None and completion is self._failed_completion
        outdated = error is None and document.current_depth() is not None and not hopeless
        if not outdated:
            self._views.show_data(expected=error, unsupported=document.unsupported())
        self._views.show_data(error_is_outdated=outdated)
        if (
            completion is not None
            and error is None
            and completion is not self._failed_completion
            and (self._views.shows("expected") or any(is_seen() for is_seen in self._watchers))
            and self._runs.state in (RunState.IDLE, RunState.PAUSED)
        ):
            self._questions.ask(_Question(document, completion))

    def _take(self, question: _Question, error_estimate: ErrorEstimate) -> None:
        question.document.store_error_estimate(question.completion, error_estimate)

    def _fail(self, question: _Question, error: Exception) -> None:
        self._failed_completion = question.completion
        self.context.notes.report("Expected error", error)


def _find(question: _Question) -> ErrorEstimate:
    """Compute the estimate; runs in a worker thread."""
    return ErrorEstimate(expected_error(question.completion), unsupported(question.completion))
