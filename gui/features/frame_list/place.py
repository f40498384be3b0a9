"""Where the panel of the frames is: in its dock, or as a strip under the images while that is closed."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QSettings
from PySide6.QtWidgets import QVBoxLayout, QWidget

from ...base.commands import command, commands_of
from ...state.parts import Part
from ...widgets.basics import lay_out
from ..context import Context
from ..edit_summary import EditSummaryFeature
from .panel import FramesPanel

_HEIGHT_SHARE = 0.0375
_HEIGHTS = 30, 60
"""Height of the strip: share of the window's height, minimum and maximum [px]."""
_KEY = "frames/film_strip"


class FramesPlace(QObject):
    """Puts the panel into its dock, or under the images while the list has several frames, unless that is switched off.

    Attributes
    ----------
    dock : QWidget
        Content of the dock.
    bar : QWidget
        The place under the images.
    """

    def __init__(self, context: Context, panel: FramesPanel) -> None:
        super().__init__(context.window)
        self._context, self._panel = context, panel
        self.dock, self.bar = QWidget(), QWidget()
        self._in_dock, self._in_bar = lay_out(QVBoxLayout(self.dock)), lay_out(QVBoxLayout(self.bar), panel)
        self.bar.hide()
        context.centre.add_before(context.feature(EditSummaryFeature).line, self.bar)
        context.actions.add(commands_of(self))
        self._on = context.actions["film_strip"]
        stored = QSettings().value(_KEY, True, bool) if context.panels.persistent else True
        self._on.setChecked(stored is True)
        context.refresh.add("film strip", self.update, Part.LIST, also=(self._on.toggled,))
        self.dock.installEventFilter(self)

    def update(self) -> None:
        """Move the panel to where it belongs, and show or hide the strip."""
        docked = self.dock.isVisibleTo(self._context.window)
        if self._panel.parentWidget() is not (self.dock if docked else self.bar):
            (self._in_dock if docked else self._in_bar).addWidget(self._panel)
            self._panel.show()  # at once: it may be given the focus
        least, most = _HEIGHTS
        height = min(max(round(_HEIGHT_SHARE * self._context.window.height()), least), most)
        self._panel.set_bar(0 if docked else height)
        several = len(self._context.workspace.entries) > 1
        shown, centre = not docked and several and self._on.isChecked(), self._context.centre
        self.bar.setVisible(shown)
        (centre.installEventFilter if shown else centre.removeEventFilter)(self)  # while its height matters
        self._context.refresh.mark("Frames")

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Follow the dock as it opens and closes, and the height of the window."""
        kinds = (QEvent.Type.Show, QEvent.Type.Hide) if watched is self.dock else (QEvent.Type.Resize,)
        if event.type() in kinds:
            self.update()
        return False

    @command("film_strip", "Film &strip", icon="ph.film-strip", checkable=True)
    def _keep(self, on: bool) -> None:
        """Show the frames under the images while there are several and their panel is closed; the bar has the colour of
        the state."""
        if self._context.panels.persistent:
            QSettings().setValue(_KEY, on)
