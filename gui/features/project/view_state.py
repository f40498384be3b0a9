"""View state of frames and window, which is stored with the work."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Mapping
from typing import Any

from PySide6.QtCore import QObject

from ...state.document import Document
from ...state.parts import Part
from ...state.workspace import Workspace
from ...views.layouts import LAYOUTS
from ...views.linked_views import LinkedViews
from ...work.refresh import Refresh

_PLACE = "place"
_LAYOUT, _CONTENTS, _SIDES = "layout", "contents", "sides"


class ViewState(QObject):
    """Restores the zoom position of a frame when it is shown, and returns the view state of the window."""

    def __init__(self, workspace: Workspace, views: LinkedViews, refresh: Refresh) -> None:
        super().__init__(views)
        self._workspace = workspace
        self._views = views
        self._shown: Document | None = None
        workspace.about_to_change.connect(self.remember)
        refresh.add("place", self._show, Part.FRAME)

    def remember(self) -> None:
        """Store the zoom position in the current frame's session."""
        if self._workspace.has_current and self._workspace.current is self._shown:
            place = self._views.place
            view = {key: value for key, value in self._shown.state.view.items() if key != _PLACE}
            if place is not None:
                view[_PLACE] = [round(number, 4) for number in place]
            self._shown.change(view=view)

    def window_state(self) -> dict[str, Any]:
        """Return layout and contents of the views as values for JSON."""
        views = self._views
        return {_LAYOUT: views.layout_name, _CONTENTS: views.contents(), _SIDES: list(views.sides.chosen)}

    def take(self, view: Mapping[str, Any]) -> None:
        """Restore the view state of `window_state`; unknown values are ignored."""
        views, contents, sides = self._views, view.get(_CONTENTS), view.get(_SIDES)
        if view.get(_LAYOUT) in LAYOUTS:
            views.set_layout(str(view[_LAYOUT]))
        for cell, content in contents.items() if isinstance(contents, Mapping) else ():
            with contextlib.suppress(ValueError):  # there is no such content
                views.set_content(str(cell), str(content))
        if isinstance(sides, list) and len(sides) == 2:
            with contextlib.suppress(ValueError):
                views.sides.choose(*map(str, sides))

    def _show(self) -> None:
        document = self._workspace.current if self._workspace.has_current else None
        if document is self._shown:
            return
        self._shown = document
        place = None if document is None else document.state.view.get(_PLACE)
        if isinstance(place, list) and len(place) == 3 and all(_is_number(number) for number in place):
            self._views.set_place(*place)


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
