"""The menu that chooses the two depths to compare."""

from __future__ import annotations

from PySide6.QtGui import QActionGroup
from PySide6.QtWidgets import QMenu, QWidget

from gui.inventory import PASSING

from .contents.names import capital, short_title
from .linked_views import LinkedViews

_TEXTS = "Side &A", "Side &B"


class SidesMenu(QMenu):
    """One of the two sides; filled when it opens, since runs come and go."""

    def __init__(self, views: LinkedViews, side: int, parent: QWidget) -> None:
        super().__init__(_TEXTS[side], parent)
        self._views = views
        self._side = side
        self.aboutToShow.connect(self.fill)
        self.fill()

    def fill(self) -> None:
        """All depths that there are, with the present one marked."""
        self.clear()
        material, group = self._views.material, QActionGroup(self)
        for depth in ("", *material.comparable()):
            text = short_title(depth, material.names) if depth else "what is best"
            action = self.addAction(capital(text).replace("&", "&&"))
            action.setProperty(PASSING, True)
            action.setCheckable(True)
            action.setChecked(material.chosen_sides[self._side] == depth)
            group.addAction(action)
            action.triggered.connect(lambda _=False, depth=depth: self._choose(depth))

    def _choose(self, depth: str) -> None:
        sides = list(self._views.material.chosen_sides)
        sides[self._side] = depth
        self._views.sides.choose(*sides)
