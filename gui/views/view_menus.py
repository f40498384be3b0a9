"""View controls in the first line of the window, and the menus of the compared depths."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QMenu, QSlider, QToolButton, QWidget, QWidgetAction

from ..base.commands import TEMPORARY
from ..widgets.basics import PlainLabel
from .centre import Centre
from .contents import capital, short_title
from .layouts import LAYOUT_TEXTS, LAYOUTS
from .linked_views import LinkedViews

_OPACITY = 45
_SPACE = 6


class ViewBar(QWidget):
    """Tabs of the centre, opacity of the blocks, the views shown, and buttons for actions.

    Parameters
    ----------
    views : LinkedViews
    centre : Centre
    actions : iterable of QAction
        One button each.
    """

    def __init__(self, views: LinkedViews, centre: Centre, actions: Iterable[QAction]) -> None:
        super().__init__()
        self.opacity = _opacity_slider()
        self.opacity.valueChanged.connect(lambda value: views.set_overlay_opacity(value / 100))
        self.opacity.setValue(_OPACITY)
        self._opacity_action = self._make_opacity_action()
        self.layouts = QComboBox()
        self.layouts.setAccessibleName("View set")
        for name, text in LAYOUT_TEXTS.items():
            self.layouts.addItem(text, name)
        self.layouts.setToolTip("View set: the views shown; double-click a title to enlarge a view or show it alone")
        self.layouts.setMaximumHeight(self.fontMetrics().height() + 6)
        self.layouts.activated.connect(lambda _: views.set_layout(self.layouts.currentData()))
        views.layoutChanged.connect(lambda name: self.layouts.setCurrentIndex(LAYOUTS.index(name)))
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(_SPACE)
        self._buttons = QWidget()
        self._row = QHBoxLayout(self._buttons)
        self._row.setContentsMargins(0, 0, 0, 0)
        self._row.setSpacing(0)
        self._parts = (centre.tabs, self.opacity, self.layouts, self._buttons)
        for part in self._parts:
            layout.addWidget(part)
        self._spare = (self.opacity, self._buttons)
        for part in self._parts[1:]:
            centre.turned.connect(lambda part=part: part.setEnabled(not centre.shows_cloud_alone))

        for action in actions:
            self.add_button(action)

    def add_button(self, action: QAction) -> None:
        """Add a button for an action."""
        button = QToolButton()
        button.setAutoRaise(True)
        button.setDefaultAction(action)
        self._row.addWidget(button)

    @property
    def hidden(self) -> list[QAction]:
        """The actions of what has no room."""
        buttons = [button.defaultAction() for button in self._buttons.findChildren(QToolButton)]
        return [self._opacity_action] * self.opacity.isHidden() + buttons * self._buttons.isHidden()

    def _make_opacity_action(self) -> QAction:
        """Make an action that is the opacity's slider in a menu."""
        row, slider = QWidget(), _opacity_slider()
        layout = QHBoxLayout(row)
        layout.addWidget(PlainLabel("Opacity of the blocks"))
        layout.addWidget(slider)
        slider.setValue(self.opacity.value())
        slider.valueChanged.connect(self.opacity.setValue)
        self.opacity.valueChanged.connect(slider.setValue)
        action = QWidgetAction(self)
        action.setDefaultWidget(row)
        return action

    def sizeHint(self) -> QSize:
        shown = [part.sizeHint() for part in self._parts if not part.isHidden()]
        return QSize(sum(size.width() + _SPACE for size in shown), max(size.height() for size in shown))

    def fit(self, room: int) -> None:
        """Leave out the opacity, then the buttons, in a narrow window: see `hidden`."""
        for part in self._spare:
            part.show()
        for part in self._spare:
            part.setVisible(self.sizeHint().width() <= room)
        self.updateGeometry()


def _opacity_slider() -> QSlider:
    slider = QSlider(Qt.Orientation.Horizontal)
    slider.setRange(0, 100)
    slider.setAccessibleName("Opacity of the blocks")
    slider.setFixedWidth(70)
    slider.setToolTip("Opacity of the blocks over the colour image")
    return slider


# The menus that select the two depths to compare.

_TEXTS = "Side &A", "Side &B"


class SidesMenu(QMenu):
    """Menu of one of the two sides; filled when it opens, since runs change."""

    def __init__(self, views: LinkedViews, side: int, parent: QWidget) -> None:
        super().__init__(_TEXTS[side], parent)
        self._views = views
        self._side = side
        self.aboutToShow.connect(self.fill)
        self.fill()

    def fill(self) -> None:
        """Fill the menu with all available depths, with the current one checked."""
        self.clear()
        material, group = self._views.material, QActionGroup(self)
        for depth in ("", *material.comparable()):
            text = short_title(depth, material.names) if depth else "automatic"
            action = self.addAction(capital(text).replace("&", "&&"))
            action.setProperty(TEMPORARY, True)
            action.setCheckable(True)
            action.setChecked(material.chosen_sides[self._side] == depth)
            group.addAction(action)
            action.triggered.connect(lambda _=False, depth=depth: self._choose(depth))

    def _choose(self, depth: str) -> None:
        sides = list(self._views.material.chosen_sides)
        sides[self._side] = depth
        if self._views.material.is_same(*sides):
            sides[1 - self._side] = ""
        self._views.sides.choose(*sides)
