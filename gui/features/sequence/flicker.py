"""Flicker of the current frame: reads the frame before it in the list while a view shows the change."""

from __future__ import annotations

from functools import partial

from ...state.parts import Part
from ...views.view_data import Before
from ...work.latest_request import LatestRequest
from ..context import Context, Feature
from ..frame_list.feature import FramesFeature
from .moments import Moment


class FlickerFeature(Feature):
    """The depth of the frame before the current one in the list, as the views of flicker need it."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._frames = context.feature(FramesFeature)
        self._questions = LatestRequest(self)
        context.workspace.on(Part.FRAME, self._questions.forget)
        context.refresh.add(
            "flicker",
            self.show,
            Part.FRAME | Part.LIST | Part.RESULTS | Part.INVALID_MASK,
            Part.SOME_RESULTS,
            also=(context.views.shownChanged,),
            when=partial(context.views.shows, "before"),
        )

    def show(self) -> None:
        """Find the change against the frame before, which a view shows."""
        workspace, views = self.context.workspace, self.context.views
        if not workspace.has_current:
            return
        entry, (shown, _) = workspace.current_entry, self._frames.shown()
        row = shown.index(entry) if entry in shown else 0
        now = None if entry is None else Moment.of_open(entry)
        if now is None or row == 0:
            views.show_found(before=Before(text="The list has no frame before this one"))
            return
        entry, store = shown[row - 1], self.context.recorder.store
        open_one = Moment.of_open(entry)
        self._questions.ask(
            lambda: now.since(open_one or Moment.read(entry, store)),
            lambda before: views.show_found(before=before),
            lambda error: views.show_found(before=Before(text=str(error))),
        )
