"""The zoom of each frame."""

from __future__ import annotations

from PySide6.QtCore import QObject

from ..state.document import Document
from ..state.parts import Part
from ..state.workspace import Workspace
from ..views.linked_views import LinkedViews
from ..work.refresh import Refresh


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
