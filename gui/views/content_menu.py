"""The menu of a cell's title: all contents, with the current one checked."""

from __future__ import annotations

from PySide6.QtWidgets import QMenu, QWidget

from .contents import DIFFERENCE, FLICKERS, RUNS, SIDES, TITLES, capital, difference_of, operands_of, short_title
from .layers import CONTENTS, lacking
from .view_data import ViewData

_ELSEWHERE = "colour", "expected-error"
"""Contents of the table of layers that lie in other groups of the menu."""
_SIDE_TEXTS = {"a": "Side A", "b": "Side B"}


class ContentMenu(QMenu):
    """Menu of contents, refilled each time it opens, since runs change. The data of an action is a content's name."""

    def __init__(self, parent: QWidget) -> None:
        super().__init__("Content of the view", parent, toolTipsVisible=True)

    def offer(self, data: ViewData, content: str) -> None:
        """Fill the menu with the available contents; check `content`."""
        self.clear()
        self._content, self._data = content, data
        self._add(self, "colour", CONTENTS["colour"].title)
        for name in ("depth-in", "result"):
            self._add(self, name, TITLES[name])
        for depth in RUNS:
            if depth in data.names:
                self._add(self, depth, f"Run: {data.names[depth]}")
        self._add(self, "ground_truth", TITLES["ground_truth"])
        self._add(self, "guide", TITLES["guide"])
        self.addSeparator()
        first, second = operands_of(data.concrete(DIFFERENCE)) or ("", "")
        pair = f"{short_title(first, data.names)} \N{MINUS SIGN} {short_title(second, data.names)}"
        self._add(self, DIFFERENCE, f"Difference ({pair})")
        self._add_differences(data)
        self._add(self, "error", TITLES["error"])
        self._add(self, "expected-error", CONTENTS["expected-error"].title)
        for name in FLICKERS:
            self._add(self, name, TITLES[name])
        self.addSeparator()
        for name in (name for name in CONTENTS if name not in _ELSEWHERE):
            self._add(self, name, CONTENTS[name].title)
        self.addSeparator()
        for side, depth in zip(SIDES, data.sides, strict=True):
            self._add(self, side, f"{_SIDE_TEXTS[side]} of the comparison ({short_title(depth, data.names)})")

    def _add_differences(self, data: ViewData) -> None:
        depths = data.comparable()
        menu = self.addMenu("Difference of")
        for first in depths:
            others = menu.addMenu(capital(short_title(first, data.names)).replace("&", "&&"))
            for second in depths:
                if second != first:
                    self._add(others, difference_of(first, second), f"less {short_title(second, data.names)}")

    def _add(self, menu: QMenu, content: str, text: str) -> None:
        action = menu.addAction(text.replace("&", "&&"))
        action.setData(content)
        action.setCheckable(True)
        action.setChecked(content == self._content)
        why_off = lacking(content, self._data)
        action.setEnabled(not why_off)
        action.setToolTip(why_off)
