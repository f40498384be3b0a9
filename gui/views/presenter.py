"""Brings the present frame, its blocks and its completed depth to the linked views."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PySide6.QtCore import QObject

from gui.state.session import Session
from gui.state.workspace import Workspace
from gui.views.linked_views import LinkedViews
from ilf.blocks import Box


class ViewsPresenter(QObject):
    """Pictures of the frame, overlay and outlines of its blocks, depth out."""

    def __init__(self, workspace: Workspace, views: LinkedViews) -> None:
        super().__init__(views)
        self._workspace = workspace
        self._views = views
        self._shown: Session | None = None
        self._table: NDArray[np.uint8] | None = None
        self._boxes: list[Box] = []
        workspace.labels_changed.connect(self._boxes.append)
        workspace.stroke_changed.connect(self._boxes.append)

    def show_frame(self) -> None:
        """Colour and depth in, if they are not there yet; the rest of the pictures goes with the frame before."""
        session = self._workspace.session if self._workspace.has_session else None
        if session is self._shown:
            return
        self._shown, self._table = session, None
        if session is None:
            self._views.clear()
        else:
            self._views.set_frame(session.frame.rgb, session.frame.depth)

    def show_blocks(self) -> None:
        """The overlay: all of it if colours have changed, else the boxes that have; and the chosen blocks' outlines."""
        boxes = self._boxes.copy()
        self._boxes.clear()
        if not self._workspace.has_session:
            return
        session = self._workspace.session
        table = colour_table(session)
        if self._table is None or not np.array_equal(table, self._table):
            self._views.set_blocks(session.labels, table)
        else:
            for box in boxes:
                self._views.update_blocks_region(*box, session.labels[box])
        self._table = table
        self._views.set_selected(session.selected)

    def show_depth(self) -> None:
        """The completed depth as far as it goes, with that of the blocks that run."""
        if self._workspace.has_session:
            session = self._workspace.session
            completion = session.completion()
            guessed = completion.guessed if completion is not None and completion.guessed.any() else None
            self._views.set_result(session.present_depth(), guessed)

    def show_other(self, labels: NDArray[np.int32], depth: NDArray[np.float32] | None) -> None:
        """Show other blocks of the present frame, int32 (H, W), and other completed depth [m], None for none, for a
        while."""
        table = colour_table(self._workspace.session, int(labels.max()))
        self._views.set_blocks(labels, table)
        self._views.set_result(depth)
        self._table = None

    def show_present(self) -> None:
        """Show the blocks and the depth that there are."""
        self.show_blocks()
        self.show_depth()

    def zoom_to_blocks(self) -> None:
        """Show the chosen blocks large."""
        session = self._workspace.session
        rows, columns = np.nonzero(np.isin(session.labels, session.selected))
        if rows.size:
            self._views.zoom_to(
                slice(int(rows.min()), int(rows.max()) + 1), slice(int(columns.min()), int(columns.max()) + 1)
            )


def colour_table(session: Session, least: int = 0) -> NDArray[np.uint8]:
    """RGBA by label for the overlay, up to `least` and all chosen labels; hidden blocks are transparent."""
    top = max([int(session.labels.max()), least, *session.selected])
    table = np.zeros((top + 1, 4), np.uint8)
    for label in range(1, top + 1):
        info = session.info(label)
        table[label] = (*info.colour, 255 if info.visible else 0)
    return table
