"""The linked views with the current frame, and the commands on their display."""

from __future__ import annotations

import numpy as np

from ilf.segmentation.editing.patches import bounds

from ..base.commands import command
from ..base.needs import Need
from ..state.document import Document
from ..state.parts import Part
from ..views.shown_blocks import BLOCK_PARTS
from ..views.view_data import ALL_READ, ALL_READ_LATER
from ..views.view_menus import ViewBar
from .context import Context, Feature


class ViewsFeature(Feature):
    """The linked views with the current frame, and the commands on their display.

    The zoom of a frame is restored when it is shown again. Zooms last as long as the window: another one may have
    another size, so it begins with the whole frame.
    """

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        workspace, views = context.workspace, context.views
        self._workspace, self._views = workspace, views
        menu = context.actions.menu("", context.window, "contours_only block_names show_missing fit")
        self.bar = ViewBar(views, context.centre, menu)
        refresh = context.refresh
        refresh.add("pictures", lambda: views.refresh(refresh.changed("pictures")), ALL_READ, ALL_READ_LATER)
        self._shown: Document | None = None
        self._zooms: dict[str, tuple[float, float, float] | None] = {}
        """Key of a frame -> its last zoom."""
        workspace.on(Part.FRAME, self._remember_zoom)
        refresh.add("place", self._restore_zoom, Part.FRAME)  # after the pictures, which show another frame whole
        refresh.add("blocks", lambda: views.blocks.draw(refresh.changed("blocks")), BLOCK_PARTS)

    def _remember_zoom(self) -> None:
        if self._shown is not None:
            self._zooms[self._shown.key] = self._views.place

    def _restore_zoom(self) -> None:
        document = self._workspace.current if self._workspace.has_current else None
        if document is not self._shown:
            self._shown = document
            if document is not None and (place := self._zooms.get(document.key)) is not None:
                self._views.set_place(*place)

    @command("fit", "&Fit frame", icon="ph.arrows-out", keys="Ctrl+0", needs=Need.FRAME)
    def _fit(self) -> None:
        """Show the whole frame."""
        self._views.fit()

    @command("one_to_one", "&One to one", icon="ph.frame-corners", keys="Ctrl+9", needs=Need.FRAME)
    def _show_one_to_one(self) -> None:
        """Show one image pixel per screen pixel."""
        self._views.one_to_one()

    @command("contours_only", "&Contours only", icon="ph.polygon", keys="Ctrl+Shift+C", checkable=True)
    def _show_contours(self, on: bool) -> None:
        """Show blocks as outlines with a band of their colour, without fill."""
        self._views.blocks.set_contours_only(on)

    @command("block_names", "Block &names", icon="ph.text-t", keys="Ctrl+Shift+T", checkable=True)
    def _show_names(self, on: bool) -> None:
        """Show the names of the blocks over the images."""
        self._views.blocks.show_names(on)

    @command(
        "show_missing", "&Missing depth over colour", icon="ph.selection-slash", keys="Ctrl+Shift+H", checkable=True
    )
    def _show_missing(self, on: bool) -> None:
        """Stripe the colour image where depth is missing."""
        self._views.set_missing_shown(on)

    @command("zoom_block", "&Zoom to block", icon="ph.magnifying-glass-plus", keys="Ctrl+J", needs=Need.SELECTION)
    def zoom_to_blocks(self) -> None:
        """Zoom to the selected block."""
        document = self._workspace.current
        box = bounds(np.isin(document.labels, document.selected))
        if box is not None:
            self._views.zoom_to(*box)
