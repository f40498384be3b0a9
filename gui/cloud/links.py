"""Links the points of the cloud with the pixels of the images, both ways."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtCore import QObject

from gui.cloud.canvas import CloudCanvas
from gui.state.workspace import Workspace
from gui.tools.editor import Editor
from gui.views.linked_views import LinkedViews
from gui.views.pointer import PointerEvent, PointerKind


class CloudLinks(QObject):
    """What the pointer is at is marked in cloud and images alike; a click on a point chooses its block, or is for the
    tool if points are all that it needs.

    Parameters
    ----------
    shows_present : callable
        Whether the cloud is of the present frame.
    """

    def __init__(
        self,
        workspace: Workspace,
        editor: Editor,
        canvas: CloudCanvas,
        views: LinkedViews,
        shows_present: Callable[[], bool],
    ) -> None:
        super().__init__(canvas)
        self._workspace = workspace
        self._editor = editor
        self._canvas = canvas
        self._views = views
        self._shows_present = shows_present
        views.cursorMoved.connect(canvas.mark)
        canvas.hovered.connect(self._hover)
        canvas.picked.connect(self._pick)

    def _hover(self, pixel: tuple[int, int] | None) -> None:
        if self._shows_present():
            self._views.point_at(pixel)

    def _pick(self, x: int, y: int, adds: bool) -> None:
        if not self._shows_present():
            return
        if self._editor.tool.points_only:
            for kind in (PointerKind.PRESS, PointerKind.RELEASE):
                self._editor.pointer(PointerEvent(kind, x + 0.5, y + 0.5))
        else:
            self._choose(x, y, adds)

    def _choose(self, x: int, y: int, adds: bool) -> None:
        session = self._workspace.session
        label = int(session.labels[y, x])
        if label and adds:
            chosen = [one for one in session.selected if one != label]
            self._workspace.select(chosen if label in session.selected else [*chosen, label])
        elif not adds:
            self._workspace.select([label] if label else [])
