"""How a command of the window is declared."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Command:
    """Declaration of an action.

    Attributes
    ----------
    name : str
    text : str
        As in a menu, with & before the letter that chooses it there.
    icon, shortcut, hint : str
        "" for none.
    group : str
        Actions of one group are checkable, one at a time.
    checkable : bool
    """

    name: str
    text: str
    icon: str = ""
    shortcut: str = ""
    hint: str = ""
    group: str = ""
    checkable: bool = False
