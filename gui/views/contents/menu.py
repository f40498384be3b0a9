"""The menu of a cell's title: all that the cell can show, and what it shows."""

from __future__ import annotations

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QWidget

from .material import Material
from .names import DIFFERENCE, RUNS, SIDES, TITLES, capital, compared_by, difference_of, short_title

_UNMADE = {
    "truth": "This frame has no truth",
    "error": "This frame has no truth to compare the result with",
}
_SIDE_TEXTS = {"a": "Side A", "b": "Side B"}


class ContentMenu(QMenu):
    """Filled anew whenever it is offered, since runs come and go. Actions have the names of contents as data."""

    def offer(self, material: Material, content: str) -> None:
        """Fill it for what there is to show; `content` is marked."""
        self.clear()
        self._content = content
        for name in ("colour", "depth-in", "result"):
            self._add(self, name, TITLES[name])
        for depth in RUNS:
            if depth in material.names:
                self._add(self, depth, f"Run: {material.names[depth]}")
        self._add(self, "truth", TITLES["truth"], material.truth is not None)
        self.addSeparator()
        first, second = compared_by(material.concrete(DIFFERENCE)) or ("", "")
        pair = f"{short_title(first, material.names)} \N{MINUS SIGN} {short_title(second, material.names)}"
        self._add(self, DIFFERENCE, f"Difference ({pair})")
        self._add_differences(material)
        self._add(self, "error", TITLES["error"], material.truth is not None)
        self._add(self, "expected-error", TITLES["expected-error"])
        self.addSeparator()
        for name in ("strength", "creases", "extraction", "guessed", "distrusted", "spectrum"):
            self._add(self, name, TITLES[name])
        self.addSeparator()
        for side, depth in zip(SIDES, material.sides, strict=True):
            self._add(self, side, f"{_SIDE_TEXTS[side]} of the comparison ({short_title(depth, material.names)})")

    def _add_differences(self, material: Material) -> None:
        depths = material.comparable()
        menu = self.addMenu("Difference of")
        for first in depths:
            others = menu.addMenu(capital(short_title(first, material.names)).replace("&", "&&"))
            for second in depths:
                if second != first:
                    self._add(others, difference_of(first, second), f"less {short_title(second, material.names)}")

    def _add(self, menu: QMenu, content: str, text: str, there: bool = True) -> QAction:
        action = menu.addAction(text.replace("&", "&&"))
        action.setData(content)
        action.setCheckable(True)
        action.setChecked(content == self._content)
        action.setEnabled(there)
        if not there:
            action.setToolTip(_UNMADE[content])
        return action


def content_menu(parent: QWidget) -> ContentMenu:
    """An empty menu."""
    menu = ContentMenu("Content of the view", parent)
    menu.setToolTipsVisible(True)
    return menu
