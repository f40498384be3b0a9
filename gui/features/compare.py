"""Contents of the views, and the comparison of two depths."""

from __future__ import annotations

from functools import partial

from ..base.commands import command
from ..base.needs import Need
from ..state.parts import Part
from ..views.layouts import COMPARE
from .context import Context, Feature


class CompareFeature(Feature):
    """Contents of the views, and the commands of the comparison of two depths."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._was_compared = False
        self._replaced: dict[str, str] = {}
        """Content of a view before the result replaced it: name of its cell -> content."""
        blink = context.actions["blink"]
        # an edit must show its effect on the result
        edits = (
            Part.FRAME | Part.REPLACED | Part.INVALID_MASK | Part.GUIDE | Part.NEIGHBOURS | Part.LABELS | Part.STROKE
        )
        context.refresh.add("blink", partial(blink.setChecked, False), edits)
        context.views.sheet.layoutChanged.connect(self._follow_layout)

    @command("view_content", "&View content…", icon="ph.list", keys="Ctrl+Shift+V", needs=Need.FRAME)
    def _choose_content(self) -> None:
        """Choose the content of the view under the pointer, or of the view clicked last; same as a click on its
        title."""
        self.context.views.choose_content()

    @command("reset_contents", "R&eset view contents")
    def _reset_contents(self) -> None:
        """Restore the default content of every view."""
        self.context.views.reset_contents()

    @command("swap_sides", "Swap A and &B", icon="ph.swap", needs=Need.FRAME)
    def _swap_sides(self) -> None:
        """Swap the two sides of the comparison."""
        views = self.context.views
        views.sides.choose(*reversed(views.data.sides))

    @command("blink", "Show side &A", icon="ph.eye", checkable=True, held="V", needs=Need.FRAME)
    def _show_side_a(self, on: bool) -> None:
        """Show side A instead of the result in all views; also while V is held."""
        views = self.context.views
        views.sides.show_a_as_result(on)

    @command("compare_two", "Compare &two", icon="ph.columns", keys="Shift+F4", checkable=True, needs=Need.FRAME)
    def _compare_two(self, on: bool) -> None:
        """Show sides A and B, their difference, and the error or the expected error; again to go back."""
        if on != (self.context.views.sheet.layout_name == COMPARE):
            self.context.views.sheet.toggle_layout(COMPARE)

    def _follow_layout(self, name: str) -> None:
        """Switch swiping off in the side-by-side layout; in others, show the result while swiping."""
        self._was_compared = False
        self.context.actions["compare_two"].setChecked(name == COMPARE)
        if name == COMPARE:
            self.context.actions["swipe"].setChecked(False)
        elif self.context.views.sides.is_divided:
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
        views = self.context.views
        if not on:
            views.sides.divide(False)
            self._restore_contents()
            if self._was_compared:
                views.sheet.toggle_layout(COMPARE)
            return
        was_compared = views.sheet.layout_name == COMPARE
        if was_compared:
            views.sheet.toggle_layout(COMPARE)
        self._was_compared = was_compared  # until another layout is chosen
        self._show_result()
        views.sides.divide(True)

    def _show_result(self) -> None:
        """Show the result in the active view if no view does."""
        views = self.context.views
        if not any(cell.concrete == "result" for cell in views.sheet.shown):
            name = next(name for name, cell in views.cells.items() if cell is views.active)
            self._replaced = {name: views.cells[name].content}
            views.set_content(name, "result")

    def _restore_contents(self) -> None:
        """Restore the content that the result has replaced, unless the user has chosen another since."""
        views, replaced = self.context.views, self._replaced
        self._replaced = {}
        for cell, content in replaced.items():
            if views.cells[cell].content == "result":
                views.set_content(cell, content)
