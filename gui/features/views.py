"""The linked views with the current frame, and the commands on their display."""

from __future__ import annotations

import numpy as np

from ..base.commands import Command
from ..base.needs import Need
from ..views.shown_blocks import BLOCK_PARTS
from ..views.view_data import ALL_READ, ALL_READ_LATER
from ..views.view_menus import ViewBar
from .context import Context, Feature


class ViewsFeature(Feature):
    """The linked views with the current frame, and the commands on their display."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        workspace, views = context.workspace, context.views
        self._workspace, self._views = workspace, views
        context.actions.add(
            (
                Command(
                    "zoom_block",
                    "&Zoom to block",
                    "Zoom to the selected block",
                    icon="ph.magnifying-glass-plus",
                    keys="Ctrl+J",
                    handler=self.zoom_to_blocks,
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
                    "Show blocks as outlines with a band of their colour, without fill",
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
                    handler=views.blocks.show_names,
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
        menu = context.actions.menu("", context.window, "contours_only block_names show_missing fit")
        self.bar = ViewBar(views, context.centre, menu)
        refresh = context.refresh
        refresh.add("pictures", lambda: views.refresh(refresh.changed("pictures")), ALL_READ, ALL_READ_LATER)
        refresh.add("blocks", lambda: views.blocks.draw(refresh.changed("blocks")), BLOCK_PARTS)

    def zoom_to_blocks(self) -> None:
        """Zoom to the selected blocks."""
        document = self._workspace.current
        rows, columns = np.nonzero(np.isin(document.labels, document.selected))
        if rows.size:
            self._views.zoom_to(
                slice(int(rows.min()), int(rows.max()) + 1), slice(int(columns.min()), int(columns.max()) + 1)
            )
