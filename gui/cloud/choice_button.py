"""A button that opens a menu of choices and shows the present one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction, QActionGroup
from PySide6.QtWidgets import QMenu, QToolButton

Choice = TypeVar("Choice")


class ChoiceButton(QToolButton, Generic[Choice]):
    """One of several, to be chosen from a menu.

    Parameters
    ----------
    texts : mapping
        Choice -> what the user reads; the first is the present one.
    hint : str
        What is chosen.
    chosen : callable
        Takes the user's choice.
    """

    def __init__(self, texts: Mapping[Choice, str], hint: str, chosen: Callable[[Choice], None]) -> None:
        super().__init__()
        self.setToolTip(hint)
        self.setAccessibleName(hint)
        self.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        self.setAutoRaise(True)
        self.setStyleSheet("QToolButton::menu-indicator { image: none; }")
        menu = QMenu(self)
        menu.setToolTipsVisible(True)
        self.setMenu(menu)
        group = QActionGroup(menu)
        self._choices: dict[Choice, QAction] = {}
        widths = []
        for choice, text in texts.items():
            action = menu.addAction(text)
            action.setCheckable(True)
            action.triggered.connect(lambda _=False, choice=choice: chosen(choice))
            group.addAction(action)
            self._choices[choice] = action
            self.show_choice(choice)
            widths.append(self.sizeHint().width())
        # the bar keeps still when the choice changes; the icon comes with the theme
        self.setMinimumWidth(max(widths) + self.iconSize().width())
        self.show_choice(next(iter(texts)))

    def show_choice(self, choice: Choice) -> None:
        """Mark a choice as the present one."""
        self._choices[choice].setChecked(True)
        self.setText(f"{self._choices[choice].text()} \u25be")

    def allow(self, choice: Choice, allowed: bool, hint: str) -> None:
        """Whether a choice can be made, with what it is and why it cannot."""
        self._choices[choice].setEnabled(allowed)
        self._choices[choice].setToolTip(hint)
