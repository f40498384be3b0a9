"""View state of frames and window, which is stored with the work."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

from PySide6.QtCore import QObject

from ...state.document import Document
from ...state.parts import Part
from ...state.workspace import Workspace
from ...views.layouts import LAYOUTS
from ...views.linked_views import LinkedViews
from ...work.refresh import Refresh

_LAYOUT, _CONTENTS, _SIDES = "layout", "contents", "sides"


class ViewState(QObject):
    """Restores the zoom position of a frame when it is shown again, and returns the view state of the window.

    Zoom positions last as long as the window: another one may have another size, so it begins with the whole frame.
    """

    def __init__(self, workspace: Workspace, views: LinkedViews, refresh: Refresh) -> None:
        super().__init__(views)
        self._workspace = workspace
        self._views = views
        self._shown: Document | None = None
        self._places: dict[str, tuple[float, float, float] | None] = {}
        """Key of a frame -> its last zoom position."""
        workspace.about_to_change.connect(self._remember)
        refresh.add("place", self._show, Part.FRAME)

    def _remember(self) -> None:
        if self._workspace.has_current and self._workspace.current is self._shown:
            self._places[self._shown.key] = self._views.place

    def window_state(self) -> dict[str, Any]:
        """Return layout and contents of the views as values for JSON."""
        views = self._views
        return {_LAYOUT: views.sheet.layout_name, _CONTENTS: views.contents(), _SIDES: list(views.data.chosen_sides)}

    def take(self, view: Mapping[str, Any]) -> None:
        """Restore the view state of `window_state`; unknown values are ignored."""
        views, contents, sides = self._views, view.get(_CONTENTS), view.get(_SIDES)
        if view.get(_LAYOUT) in LAYOUTS:
            views.sheet.set_layout(str(view[_LAYOUT]))
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
        place = None if document is None else self._places.get(document.key)
        if place is not None:
            self._views.set_place(*place)
