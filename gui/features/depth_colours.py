"""The colour map of depth: the user's choice is remembered, and the default is told once."""

from __future__ import annotations

from PySide6.QtCore import QSettings

from ..state.parts import Part
from ..views.colours import DEPTH_MAP, DEPTH_MAPS
from .context import Context, Feature

_CHOSEN, _TOLD = "depth_colours/map", "depth_colours/told"
_TEXT = f"Depth is drawn in {DEPTH_MAP}, which colour-blind people can read. Others are in View › Depth colours."


class DepthColoursFeature(Feature):
    """Restores and stores the colour map of depth; in the first frame of a first start, says which one it is."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self._ranges = context.views.ranges
        if not context.panels.persistent:
            return
        chosen = str(QSettings().value(_CHOSEN, DEPTH_MAP))
        if chosen in DEPTH_MAPS:
            self._ranges.set_depth_map(chosen)
        self._chosen = context.views.data.depth_map
        self._ranges.changed.connect(self._remember)
        context.refresh.add("depth colours", self._tell, Part.FRAME)

    def _remember(self) -> None:
        if self.context.views.data.depth_map != self._chosen:
            self._chosen = self.context.views.data.depth_map
            QSettings().setValue(_CHOSEN, self._chosen)

    def _tell(self) -> None:
        if self.context.workspace.has_current and not QSettings().value(_TOLD, False, type=bool):
            QSettings().setValue(_TOLD, True)
            self.context.notes.offer(_TEXT)
