"""The right side of the menu bar: view controls and the layouts."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject
from PySide6.QtWidgets import QHBoxLayout, QMenuBar, QTabBar, QWidget

from ...views.view_menus import ViewBar
from ...widgets.basics import lay_out

_GAP = 14
"""Space between the view controls and the layouts [px]."""
_LEAST = 60
"""Width of the layouts in which at least one can be seen, and others scrolled to [px]."""


class Header(QWidget):
    """View controls and layouts in the corner of the menu bar. In a narrow window, layouts are scrolled to, or
    in the menu only."""

    def __init__(self, menu_bar: QMenuBar, views: ViewBar, layouts: QTabBar) -> None:
        super().__init__()
        self._menu_bar, self._views, self._layouts = menu_bar, views, layouts
        lay_out(QHBoxLayout(self), views, layouts, spacing=_GAP)
        menu_bar.setCornerWidget(self)
        menu_bar.installEventFilter(self)

    def fit(self) -> None:
        """Show the layouts that there is room for beside the menus and the view controls."""
        bar = self._menu_bar
        menus = bar.sizeHint().width() - self.sizeHint().width()
        left = bar.width() - menus - _GAP - self._views.sizeHint().width()
        self._layouts.setVisible(left >= _LEAST)
        self._layouts.setMaximumWidth(min(self._layouts.sizeHint().width(), max(left, 0)))
        bar.setCornerWidget(self)  # updates its place

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Fit the parts to the width of the menu bar."""
        if event.type() == QEvent.Type.Resize:
            self.fit()
        return False
