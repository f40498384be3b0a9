"""The state of the views: the zoom of each frame, and layout and contents, which are stored with the work."""

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


class Zooms(QObject):
    """Restores the zoom position of a frame when it is shown again.

    Zoom positions last as long as the window: another one may have another size, so it begins with the whole frame.
    """

    def __init__(self, workspace: Workspace, views: LinkedViews, refresh: Refresh) -> None:
        super().__init__(views)
        self._workspace = workspace
        self._views = views
        self._shown: Document | None = None
        self._places: dict[str, tuple[float, float, float] | None] = {}
        """Key of a frame -> its last zoom position."""
        workspace.on(Part.FRAME, self._remember)
        refresh.add("place", self._show, Part.FRAME)

    def _remember(self) -> None:
        if self._shown is not None:
            self._places[self._shown.key] = self._views.place

    def _show(self) -> None:
        document = self._workspace.current if self._workspace.has_current else None
        if document is self._shown:
            return
        self._shown = document
        place = None if document is None else self._places.get(document.key)
        if place is not None:
            self._views.set_place(*place)


def views_state(views: LinkedViews) -> dict[str, Any]:
    """Return layout and contents of the views as values for JSON."""
    return {_LAYOUT: views.sheet.layout_name, _CONTENTS: views.contents(), _SIDES: list(views.data.chosen_sides)}


def restore_views(views: LinkedViews, state: Mapping[str, Any]) -> None:
    """Restore what `views_state` has returned; unknown values are ignored."""
    contents, sides = state.get(_CONTENTS), state.get(_SIDES)
    if state.get(_LAYOUT) in LAYOUTS:
        views.sheet.set_layout(str(state[_LAYOUT]))
    for cell, content in contents.items() if isinstance(contents, Mapping) else ():
        with contextlib.suppress(ValueError):  # there is no such content
            views.set_content(str(cell), str(content))
    if isinstance(sides, list) and len(sides) == 2:
        with contextlib.suppress(ValueError):
            views.sides.choose(*map(str, sides))
