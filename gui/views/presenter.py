"""Shows the current frame, its blocks and its completed depth in the linked views."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject, Signal

from ilf.data.blocks import Box

from ..state.session import Session
from ..state.workspace import Workspace
from .linked_views import LinkedViews


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
        self._shown: Session | None = None
        self._invalid_mask: NDArray[np.bool_] | None = None
        self._table: NDArray[np.uint8] | None = None
        self._boxes: list[Box] = []
        self._colours_valid = False
        self._names_valid = False
        self._shows_names = False
        self._shows_other = False
        """Whether the views temporarily show other blocks and depth."""
        for signal in (workspace.blocks.labels_changed, workspace.blocks.stroke_changed):
            signal.connect(self._boxes.append)
        for doubtful in (workspace.blocks.infos_changed, workspace.frames.session_changed):
            doubtful.connect(self._invalidate_colours)
            doubtful.connect(self._invalidate_names)
        workspace.blocks.selection_changed.connect(
            self._invalidate_colours
        )  # a new block is selected before it is painted
        workspace.blocks.labels_changed.connect(self._invalidate_names)

    def show_frame(self) -> None:
        """Show colour and depth in of a new frame; this clears the pictures of the frame before."""
        session = self._workspace.session if self._workspace.has_session else None
        if session is not self._shown:
            self._shown, self._table, self._invalid_mask = session, None, None
            self._shows_other = False
            if session is None:
                self._views.clear()
            else:
                frame = session.frame
                self._views.set_frame(frame.rgb, frame.measured, frame.outside_view)
        if session is not None and session.frame.invalid_mask is not self._invalid_mask:
            self._invalid_mask = session.frame.invalid_mask
            self._views.set_invalid_mask(self._invalid_mask)

    def show_blocks(self) -> None:
        """Show the blocks (all if colours changed, else the changed boxes), the selection and the names."""
        if self._shows_other:
            return
        boxes = self._boxes.copy()
        self._boxes.clear()
        if not self._workspace.has_session:
            return
        session = self._workspace.session
        table = self._colour_table(session, boxes)
        if self._table is None or not np.array_equal(table[: len(self._table)], self._table):
            self._views.set_blocks(session.labels, table)
        else:
            if len(table) > len(self._table):
                self._views.add_colours(table)
            for box in boxes:
                self._views.update_blocks_region(*box, session.labels[box])
        self._table = table
        self._views.set_selected(session.selected)
        self._views.set_to_check(sorted(session.to_check))
        if not self._names_valid:
            self._names_valid = True
            names = {label: session.info(label).name for label in session.counts()} if self._shows_names else None
            self._views.set_block_names(names)

    def show_names(self, on: bool) -> None:
        """Show or hide the blocks' names."""
        self._shows_names = on
        self._names_valid = False
        self.names_toggled.emit()

    def _colour_table(self, session: Session, boxes: list[Box]) -> NDArray[np.uint8]:
        """Colour table; the last one if it cannot have changed, as in a stroke with a block that has a colour."""
        if self._table is None:
            top, known = int(session.labels.max()), 0
        else:
            top, known = max((int(session.labels[box].max()) for box in boxes), default=0), len(self._table) - 1
        if self._table is None or not self._colours_valid or top > known:
            self._colours_valid = True
            return colour_table(session, max(top, known))
        return self._table

    def _invalidate_colours(self) -> None:
        self._colours_valid = False

    def _invalidate_names(self) -> None:
        self._names_valid = False

    def show_depth(self) -> None:
        """Show the completed depth, including running blocks, with stale pixels marked; or the depth of the iteration
        being viewed."""
        if self._workspace.has_session and not self._shows_other:
            session, viewed_iteration = self._workspace.session, self._workspace.runs.viewed_iteration
            self._views.set_moment("" if viewed_iteration is None else viewed_iteration.text)
            if viewed_iteration is not None:
                self._views.set_result(viewed_iteration.depth)
                return
            completion = session.completion()
            extrapolated = completion.extrapolated if completion is not None and completion.extrapolated.any() else None
            depth = session.current_depth()
            self._views.set_result(depth, extrapolated, None if depth is None else session.stale)

    def show_other(self, labels: NDArray[np.int32], depth: NDArray[np.float32] | None) -> None:
        """Show other blocks of the current frame, int32 (H, W), and other completed depth [m], None for none,
        until `show_present`."""
        self._shows_other = True
        table = colour_table(self._workspace.session, int(labels.max()))
        self._views.set_blocks(labels, table)
        self._views.set_result(depth)
        self._table = None

    def show_present(self) -> None:
        """Show the blocks and the depth of the current frame again."""
        self._shows_other = False
        self.show_frame()
        self.show_blocks()
        self.show_depth()

    def zoom_to_blocks(self) -> None:
        """Zoom to the selected blocks."""
        session = self._workspace.session
        rows, columns = np.nonzero(np.isin(session.labels, session.selected))
        if rows.size:
            self._views.zoom_to(
                slice(int(rows.min()), int(rows.max()) + 1), slice(int(columns.min()), int(columns.max()) + 1)
            )


def colour_table(session: Session, min_label: int) -> NDArray[np.uint8]:
    """RGBA by label for the overlay, up to a label and any selected one; hidden blocks are transparent."""
    top = max([*session.selected, min_label])
    table = np.zeros((top + 1, 4), np.uint8)
    for label in range(1, top + 1):
        info = session.info(label)
        table[label] = (*info.colour, 255 if info.visible else 0)
    return table
