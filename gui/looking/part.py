"""What the views show: contents of the cells, and two depths compared by swipe, blink and side by side."""

from __future__ import annotations

from collections.abc import Callable

from gui.desk import Desk, Part
from gui.looking.commands import COMMANDS
from gui.looking.comparison import Comparison
from gui.views.derived import DerivedPresenter
from gui.views.layouts import COMPARE

_NEED_A_FRAME = "view_content", "compare_two", "swipe", "blink", "swap_sides"


class LookingPart(Part):
    """Brings the views what their cells want to show, and carries out what is asked of two depths."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        workspace, views, actions = desk.workspace, desk.views, desk.actions
        actions.add(COMMANDS)
        self.comparison = Comparison(workspace, views, desk.view_presenter)
        self.derived = DerivedPresenter(workspace, views)
        self._was_compared = False
        self._replaced: dict[str, str] = {}
        """What a view showed before it had to show the result: name of its cell -> content."""
        self.derived.failed.connect(lambda error: desk.notes.report("What a view shows", error))
        compared = workspace.kept_runs_changed, workspace.compared_changed, workspace.truth_changed
        results = workspace.session_changed, workspace.labels_changed, workspace.results_changed
        turned, *later = results
        desk.refresh.add("comparison", self.comparison.show, (turned, *compared), tuple(later))
        desk.refresh.add(
            "derived",
            self.derived.show,
            (
                *results,
                *compared,
                *(workspace.distrusted_changed, workspace.guide_changed),
                *(workspace.selection_changed, views.shownChanged),
            ),
            (workspace.results_added,),
        )
        handlers: dict[str, Callable[[], object]] = {
            "view_content": views.choose_content,
            "reset_contents": views.reset_contents,
            "compare_two": lambda: views.toggle_layout(COMPARE),
            "swap_sides": lambda: views.sides.choose(*reversed(views.sides.names)),
        }
        for name, handler in handlers.items():
            actions[name].triggered.connect(lambda _=False, handler=handler: handler())
        actions["swipe"].toggled.connect(self._swipe)
        actions["blink"].toggled.connect(self.comparison.look_at_a)
        views.layoutChanged.connect(self._follow_layout)
        edits = workspace.stroke_changed, workspace.labels_changed, workspace.distrusted_changed
        for changed in (workspace.session_changed, workspace.guide_changed, *edits):
            changed.connect(lambda *_: actions["blink"].setChecked(False))  # who edits sees what comes of it
        workspace.session_changed.connect(self._allow)
        self._allow()

    def _allow(self) -> None:
        no_frame = "" if self.desk.workspace.has_session else "Open a frame first."
        self.desk.actions.allow(no_frame, *_NEED_A_FRAME)

    def _follow_layout(self, name: str) -> None:
        """Side by side, neither side is parted."""
        self._was_compared = False
        self.desk.actions["compare_two"].setChecked(name == COMPARE)
        if name == COMPARE:
            self.desk.actions["swipe"].setChecked(False)

    def _swipe(self, on: bool) -> None:
        """The handle, in place of both sides beside each other, and the result to see it over if that is shown
        nowhere; what gave way for it comes back after it."""
        views = self.desk.views
        if not on:
            views.sides.set_swiping(False)
            for cell, content in self._replaced.items():
                if views.cells[cell].content == "result":
                    views.set_content(cell, content)
            self._replaced = {}
            if self._was_compared:
                views.toggle_layout(COMPARE)
            return
        was_compared = views.layout_name == COMPARE
        if was_compared:
            views.toggle_layout(COMPARE)
        self._was_compared = was_compared  # until there is another layout
        if not any(cell.isVisible() and cell.concrete == "result" for cell in views.cells.values()):
            name = next(name for name, cell in views.cells.items() if cell is views.active)
            self._replaced = {name: views.cells[name].content}
            views.set_content(name, "result")
        views.sides.set_swiping(True)

    def shutdown(self) -> bool:
        """Stop for good, before the window closes. True if no thread is left."""
        return self.derived.shutdown()
