"""View controls in the first line of the window, and the menus of the compared depths."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QHBoxLayout, QMenu, QSlider, QWidget, QWidgetAction

from ..base.commands import TEMPORARY
from ..widgets.basics import PlainLabel, add_choices, combo, lay_out, menu_button, page, row
from .centre import Centre
from .layouts import LAYOUT_TEXTS, LAYOUTS
from .linked_views import LinkedViews
from .view_data import capital, short_title

_OPACITY = 45


class ViewBar(QWidget):
    """Tabs of the centre, the views shown, and a menu of what is drawn over them.

    Parameters
    ----------
    views : LinkedViews
    centre : Centre
    menu : QMenu
        Commands of the menu, under the opacity of the blocks.
    """

    def __init__(self, views: LinkedViews, centre: Centre, menu: QMenu) -> None:
        super().__init__()
        self.opacity = QSlider(Qt.Orientation.Horizontal)
        self.opacity.setRange(0, 100)
        self.opacity.setAccessibleName("Opacity of the blocks")
        self.opacity.setToolTip("Opacity of the blocks over the colour image")
        self.opacity.valueChanged.connect(lambda value: views.blocks.set_opacity(value / 100))
        self.opacity.setValue(_OPACITY)
        slider = QWidgetAction(self)
        slider.setDefaultWidget(page(row(PlainLabel("Opacity of the blocks"), self.opacity)))
        hint = "View set: the views shown; double-click a title to enlarge a view or show it alone"
        self.layouts = combo(LAYOUT_TEXTS, hint, "View set")
        self.layouts.setMaximumHeight(self.fontMetrics().height() + 6)
        self.layouts.activated.connect(lambda _: views.sheet.set_layout(self.layouts.currentData()))
        views.sheet.layoutChanged.connect(lambda name: self.layouts.setCurrentIndex(LAYOUTS.index(name)))
        self.shown = menu_button(menu, "Show \u25be", "What is drawn over the views")
        menu.insertAction(menu.actions()[0], slider)
        lay_out(QHBoxLayout(self), centre.tabs, self.layouts, self.shown, spacing=6)
        for part in (self.layouts, self.shown):
            centre.turned.connect(lambda part=part: part.setEnabled(not centre.shows_cloud_alone))


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
        data = self._views.data
        texts = {"": "Automatic", **{depth: capital(short_title(depth, data.names)) for depth in data.comparable()}}
        literal = {depth: text.replace("&", "&&") for depth, text in texts.items()}
        for action in add_choices(self, literal, data.chosen_sides[self._side], self._choose).values():
            action.setProperty(TEMPORARY, True)

    def _choose(self, depth: str) -> None:
        sides = list(self._views.data.chosen_sides)
        sides[self._side] = depth
        if self._views.data.is_same(*sides):
            sides[1 - self._side] = ""
        self._views.sides.choose(*sides)
