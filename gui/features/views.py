"""The linked views with the current frame, the commands on their display, and the comparison of two depths in them."""

from __future__ import annotations

from functools import partial

import numpy as np
from PySide6.QtCore import QSettings

from ilf.data.blocks import bounds

from ..base.commands import command
from ..base.needs import Need
from ..state.document import Document
from ..state.parts import Part
from ..views.colours import DEPTH_MAP
from ..views.layouts import COMPARE
from ..views.shown_blocks import BLOCK_PARTS
from ..views.view_data import ALL_READ, ALL_READ_LATER
from ..views.view_menus import ViewBar
from .context import Context, Feature

_TOLD_KEY = "depth_colours/told"
_ABOUT_MAP = f"Depth is drawn in {DEPTH_MAP}, which colour-blind people can read. Others are in View › Depth colours."


class ViewsFeature(Feature):
    """The linked views with the current frame, the commands on their display, and the comparison of two depths.

    The zoom of a frame is restored when it is shown again. Zooms last as long as the window: another one may have
    another size, so it begins with the whole frame.
    """

    at_start = True

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        menu = context.actions.menu("", context.window, "contours_only block_names show_missing fit")
        self.bar = ViewBar(self.views, context.centre, menu)
        refresh = context.refresh
        refresh.add("pictures", lambda: self.views.refresh(refresh.changed("pictures")), ALL_READ, ALL_READ_LATER)
        self._shown: Document | None = None
        self._zooms: dict[str, tuple[float, float, float] | None] = {}
        """Key of a frame -> its last zoom."""
        self._was_compared = False
        """Whether the layout *Compare two* was left to swipe."""
        self._replaced: dict[str, str] = {}
        """Content of a view before the result replaced it: name of its cell -> content."""
        self.workspace.on(Part.FRAME, self._remember_zoom)
        refresh.add("place", self._restore_zoom, Part.FRAME)  # after the pictures, which show another frame whole
        refresh.add("blocks", lambda: self.views.blocks.draw(refresh.changed("blocks")), BLOCK_PARTS)
        blink = context.actions["blink"]
        # an edit must show its effect on the result
        edits = (
            Part.FRAME | Part.REPLACED | Part.INVALID_MASK | Part.GUIDE | Part.NEIGHBOURS | Part.LABELS | Part.STROKE
        )
        refresh.add("blink", partial(blink.setChecked, False), edits)
        self.views.sheet.layoutChanged.connect(self._follow_layout)
        refresh.add("depth in", self._put_back, Part.FRAME | Part.GUIDE | Part.NEIGHBOURS)
        if context.persistent:
            refresh.add("depth colours", self._tell_map, Part.FRAME)

    def _tell_map(self) -> None:
        """In the first frame of a first start, say how depth is coloured."""
        if self.workspace.shown is not None and not QSettings().value(_TOLD_KEY, False, type=bool):
            QSettings().setValue(_TOLD_KEY, True)
            self.notes.offer(_ABOUT_MAP)

    def _put_back(self) -> None:
        """Show depth in again where there is none of the additional depth that its view has shown."""
        if (document := self.workspace.shown) is not None:
            frame = document.frame
            gone = {"guide": frame.guide is None, "from_neighbours": frame.from_neighbours is None}
            if gone.get(self.views.contents()["depth-in"]):
                self.views.set_content("depth-in", "depth-in")

    def _remember_zoom(self) -> None:
        if self._shown is not None:
            self._zooms[self._shown.key] = self.views.transform.place

    def _restore_zoom(self) -> None:
        document = self.workspace.shown
        if document is not self._shown:
            self._shown = document
            if document is not None and (place := self._zooms.get(document.key)) is not None:
                self.views.transform.look_at(*place)

    @command("fit", "&Fit frame", icon="ph.arrows-out", keys="Ctrl+0", needs=Need.FRAME)
    def _fit(self) -> None:
        """Show the whole frame."""
        self.views.transform.fit()

    @command("one_to_one", "&One to one", icon="ph.frame-corners", keys="Ctrl+9", needs=Need.FRAME)
    def _show_one_to_one(self) -> None:
        """Show one image pixel per screen pixel."""
        transform = self.views.transform
        transform.look_at(transform.x, transform.y, 1 / self.views.devicePixelRatioF())

    @command("contours_only", "&Contours only", icon="ph.polygon", keys="Ctrl+Shift+C", checkable=True)
    def _show_contours(self, on: bool) -> None:
        """Show blocks as outlines with a band of their colour, without fill."""
        self.views.blocks.set_contours_only(on)

    @command(
        "block_names",
        "Block &names",
        icon="ph.text-t",
        keys="Ctrl+Shift+T",
        checkable=True,
        remembered="views/block_names",
    )
    def _show_names(self, on: bool) -> None:
        """Show the names of the blocks over the images."""
        self.views.blocks.show_names(on)

    @command(
        "show_missing",
        "&Missing depth over colour",
        icon="ph.selection-slash",
        keys="Ctrl+Shift+H",
        checkable=True,
        remembered="views/show_missing",
    )
    def _show_missing(self, on: bool) -> None:
        """Stripe the colour image where depth is missing."""
        self.views.show_found(shows_missing=on)

    @command("zoom_block", "&Zoom to block", icon="ph.magnifying-glass-plus", keys="Ctrl+J", needs=Need.SELECTION)
    def zoom_to_blocks(self) -> None:
        """Zoom to the selected block."""
        document = self.workspace.current
        box = bounds(np.isin(document.labels, document.selected))
        if box is not None:
            self.views.transform.show(*box)

    @command("view_content", "&View content…", icon="ph.list", keys="Ctrl+Shift+V", needs=Need.FRAME)
    def _choose_content(self) -> None:
        """Choose the content of the view under the pointer, or of the view clicked last; same as a click on its
        title."""
        self.views.choose_content()

    @command("reset_contents", "R&eset view contents")
    def _reset_contents(self) -> None:
        """Restore the default content of every view."""
        self.views.reset_contents()

    @command("swap_sides", "&Swap A and B", icon="ph.swap", needs=Need.FRAME)
    def _swap_sides(self) -> None:
        """Swap the two sides of the comparison."""
        self.views.sides.choose(*reversed(self.views.data.sides))

    @command("blink", "S&how side A", icon="ph.eye", checkable=True, held="V", needs=Need.FRAME)
    def _show_side_a(self, on: bool) -> None:
        """Show side A instead of the result in all views; also while V is held."""
        self.views.sides.show_a_as_result(on)

    @command("compare_two", "Compare &two", icon="ph.columns", keys="Shift+F4", checkable=True, needs=Need.FRAME)
    def _compare_two(self, on: bool) -> None:
        """Show sides A and B, their difference, and the error or the expected error; again to go back."""
        if on != (self.views.sheet.layout_name == COMPARE):
            self.views.sheet.toggle_layout(COMPARE)

    def _follow_layout(self, name: str) -> None:
        """Switch swiping off in the side-by-side layout; in others, show the result while swiping."""
        self._was_compared = False
        self.context.actions["compare_two"].setChecked(name == COMPARE)
        if name == COMPARE:
            self.context.actions["swipe"].setChecked(False)
        elif self.views.sides.is_divided:
            self._restore_contents()
            self._show_result()

    @command(
        "swipe",
        "S&wipe between two",
        icon="ph.arrows-left-right",
        keys="Ctrl+Shift+X",
        checkable=True,
        needs=Need.FRAME,
    )
    def _swipe(self, on: bool) -> None:
        """Compare with a draggable divider: side A on the left, side B on the right.

        It is shown instead of both sides side by side; if no view shows the result, one does until it is switched off.
        """
        if not on:
            self.views.sides.divide(False)
            self._restore_contents()
            if self._was_compared:
                self.views.sheet.toggle_layout(COMPARE)
            return
        was_compared = self.views.sheet.layout_name == COMPARE
        if was_compared:
            self.views.sheet.toggle_layout(COMPARE)
        self._was_compared = was_compared  # until another layout is chosen
        self._show_result()
        self.views.sides.divide(True)

    def _show_result(self) -> None:
        """Show the result in the active view if no view does."""
        if not any(cell.concrete == "result" for cell in self.views.sheet.shown):
            name = next(name for name, cell in self.views.cells.items() if cell is self.views.active)
            self._replaced = {name: self.views.cells[name].content}
            self.views.set_content(name, "result")

    def _restore_contents(self) -> None:
        """Restore the content that the result has replaced, unless the user has chosen another since."""
        replaced, self._replaced = self._replaced, {}
        for cell, content in replaced.items():
            if self.views.cells[cell].content == "result":
                self.views.set_content(cell, content)
