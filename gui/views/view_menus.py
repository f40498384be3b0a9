"""View controls beside the tab of the views: opacity of the blocks, and layout."""

from __future__ import annotations

from collections.abc import Iterable

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction, QActionGroup, QResizeEvent
from PySide6.QtWidgets import QComboBox, QHBoxLayout, QMenu, QSlider, QToolButton, QWidget

from ..base.commands import TEMPORARY
from ..widgets.basics import PlainLabel
from .contents import capital, short_title
from .layouts import LAYOUT_TEXTS, LAYOUTS
from .linked_views import LinkedViews

_OPACITY = 45
_SPACE = 6


class ViewBar(QWidget):
    """Opacity slider and layout box of the linked views, and buttons for actions.

    Parameters
    ----------
    views : LinkedViews
    actions : iterable of QAction or None
        One button each; None for a space.
    """

    def __init__(self, views: LinkedViews, actions: Iterable[QAction | None]) -> None:
        super().__init__()
        self.opacity = QSlider(Qt.Orientation.Horizontal)
        self.opacity.setRange(0, 100)
        self.opacity.setAccessibleName("Opacity of the blocks")
        self.opacity.setFixedWidth(80)
        self.opacity.setToolTip("Opacity of the blocks over the colour image")
        self.opacity.valueChanged.connect(lambda value: views.set_overlay_opacity(value / 100))
        self.opacity.setValue(_OPACITY)
        self.layouts = QComboBox()
        self.layouts.setAccessibleName("Views")
        for name, text in LAYOUT_TEXTS.items():
            self.layouts.addItem(text, name)
        self.layouts.setToolTip("Layout of the views; double-click a title to enlarge a view or show it alone")
        self.layouts.activated.connect(lambda _: views.set_layout(self.layouts.currentData()))
        views.layoutChanged.connect(lambda name: self.layouts.setCurrentIndex(LAYOUTS.index(name)))
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 4, 1)
        layout.setSpacing(4)
        self._spare = (PlainLabel("Blocks"), self.opacity)
        for widget in (*self._spare, self.layouts):
            layout.addWidget(widget)
        for action in actions:
            if action is None:
                layout.addSpacing(_SPACE)
                continue
            button = QToolButton()
            button.setAutoRaise(True)
            button.setDefaultAction(action)
            layout.addWidget(button)
        layout.setSizeConstraint(QHBoxLayout.SizeConstraint.SetNoConstraint)
        self._full = layout.sizeHint()
        spare = sum(widget.sizeHint().width() + layout.spacing() for widget in self._spare)
        self._least = self._full - QSize(spare, 0)

    def sizeHint(self) -> QSize:
        return self._full

    def minimumSizeHint(self) -> QSize:
        return self._least

    def resizeEvent(self, event: QResizeEvent) -> None:
        super().resizeEvent(event)
        # a narrow window has no opacity slider
        for widget in self._spare:
            widget.setVisible(event.size().width() >= self._full.width())


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
        self._views.sides.choose(*sides)
