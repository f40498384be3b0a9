"""The right side of the menu bar: view controls and the buttons of the layouts."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QEvent, QObject, QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QHBoxLayout, QMenu, QMenuBar, QToolButton, QWidget

from ...base import theme
from ...views.view_menus import ViewBar
from ...widgets.basics import Themed, lay_out, menu_button

_GAP = 14
"""Space between the view controls and the layouts [px]."""
_SPACING = 2


class _LayoutButton(QToolButton):
    """Button that switches to its layout, but never back as its action does."""

    def nextCheckState(self) -> None:
        if not self.isChecked():
            super().nextCheckState()


class LayoutBar(Themed, QWidget):
    """Row with a button for each layout; the button of the current layout is marked and has no effect."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._row = lay_out(QHBoxLayout(self), spacing=_SPACING)
        self._buttons: dict[QAction, QToolButton] = {}
        self._take_theme()

    def set_actions(self, actions: Iterable[QAction]) -> None:
        """Show buttons for these actions."""
        wanted = list(actions)
        if list(self._buttons) == wanted:
            return
        for button in self._buttons.values():
            button.hide()
            button.deleteLater()
        self._buttons = {}
        for action in wanted:
            button = _LayoutButton()
            button.setDefaultAction(action)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextOnly)
            button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            self._row.addWidget(button)
            self._buttons[action] = button

    def fit(self, room: int) -> None:
        """Show the button of the current layout, and as many others as there is room for; all are in the menu."""
        for action, button in sorted(self._buttons.items(), key=lambda item: not item[0].isChecked()):
            room -= _width(button)
            button.setVisible(room >= 0 or action.isChecked())
        self.updateGeometry()

    @property
    def hidden(self) -> list[QAction]:
        """The layouts whose buttons have no room."""
        return [action for action, button in self._buttons.items() if button.isHidden()]

    def sizeHint(self) -> QSize:
        shown = [button for button in self._buttons.values() if not button.isHidden()]
        return QSize(sum(map(_width, shown)), max((button.sizeHint().height() for button in shown), default=0))

    def _take_theme(self) -> None:
        colours = theme.colours(self.palette())
        sheet = (
            "QToolButton { border: none; padding: 1px 7px; background: transparent; "
            f"color: {colours.muted.name()}; }}"
            f"QToolButton:hover {{ color: {colours.text.name()}; }}"
            f"QToolButton:checked {{ color: {colours.text.name()}; border-bottom: 2px solid {colours.accent.name()}; }}"
        )
        if sheet != self.styleSheet():
            self.setStyleSheet(sheet)


def _width(button: QToolButton) -> int:
    return button.sizeHint().width() + _SPACING


class Header(QWidget):
    """View controls and layouts in the corner of the menu bar; what has no room is in the menu of a button."""

    def __init__(self, menu_bar: QMenuBar, views: ViewBar, layouts: LayoutBar) -> None:
        super().__init__()
        self._menu_bar = menu_bar
        self._views = views
        self._layouts = layouts
        self.more = menu_button(QMenu(self), "»", "What has no room here")
        self.more.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.more.menu().aboutToShow.connect(self._fill_more)
        lay_out(QHBoxLayout(self), views, layouts, self.more, spacing=_GAP)
        menu_bar.setCornerWidget(self)
        menu_bar.installEventFilter(self)

    def fit(self) -> None:
        """Show what there is room for beside the menus; at least half of the layouts' buttons before the views'."""
        bar = self._menu_bar
        room = (
            bar.width() - (bar.sizeHint().width() - self.sizeHint().width()) - 2 * _GAP - self.more.sizeHint().width()
        )
        self._layouts.fit(room // 2)
        self._views.fit(room - self._layouts.sizeHint().width() - _GAP)
        self.more.setVisible(bool(self._hidden))
        bar.setCornerWidget(self)  # updates its place

    @property
    def _hidden(self) -> list[QAction]:
        return [*self._views.hidden, *self._layouts.hidden]

    def _fill_more(self) -> None:
        menu = self.more.menu()
        menu.clear()
        menu.addActions(self._hidden)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:
        """Fit the parts to the width of the menu bar."""
        if event.type() == QEvent.Type.Resize:
            self.fit()
        return False
