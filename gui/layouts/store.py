"""Layouts as they are kept from session to session."""

from __future__ import annotations

import json
from typing import Any

from PySide6.QtCore import QSettings

from gui.layouts.layout import BUILT_IN, OWN, STANDARD, Arrangement, Layout

_PRESENT, _OWN, _CHANGED = "layouts/present", "layouts/own", "layouts/changed"
_OWN_HINT = "A layout of your own"


class LayoutStore:
    """The layouts by name, which one is present, and how each was left.

    Parameters
    ----------
    remembers : bool
        Whether they are those of the last time, and are kept for the next.
    """

    def __init__(self, remembers: bool) -> None:
        self._remembers = remembers
        self.layouts: dict[str, Layout] = {layout.name: layout for layout in BUILT_IN}
        self.changed: dict[str, Arrangement] = {}
        """How layouts were left, where that is known."""
        self.present = STANDARD
        if remembers:
            self._read()

    @property
    def own(self) -> list[Layout]:
        """The user's own layouts, in their places."""
        return [self.layouts[name] for name in OWN if name in self.layouts]

    def is_own(self, name: str) -> bool:
        """Whether a layout is one of the user's own."""
        return name in OWN and name in self.layouts

    def named(self, text: str) -> Layout | None:
        """The layout that the user reads this name of, in small or capital letters."""
        wanted = text.strip().casefold()
        return next((layout for layout in self.layouts.values() if layout.text.casefold() == wanted), None)

    def free_name(self) -> str | None:
        """The first place for an own layout that is free; None if none is."""
        return next((name for name in OWN if name not in self.layouts), None)

    def put(self, name: str, text: str, arrangement: Arrangement) -> None:
        """Keep an own layout."""
        self.layouts[name] = Layout(name, text, _OWN_HINT, arrangement)
        self.changed.pop(name, None)
        self.write()

    def delete(self, name: str) -> Layout:
        """Forget an own layout; returns what it was."""
        self.changed.pop(name, None)
        layout = self.layouts.pop(name)
        self.write()
        return layout

    def left(self, name: str) -> Arrangement:
        """How a layout was left, or is from the first."""
        return self.changed.get(name, self.layouts[name].arrangement)

    def write(self) -> None:
        """Keep all for the next time."""
        if not self._remembers:
            return
        settings = QSettings()
        own = [(layout.name, layout.text, layout.arrangement.packed()) for layout in self.own]
        settings.setValue(_PRESENT, self.present)
        settings.setValue(_OWN, json.dumps(own))
        settings.setValue(_CHANGED, json.dumps({name: left.packed() for name, left in self.changed.items()}))

    def _read(self) -> None:
        settings = QSettings()
        try:
            kept: list[Any] = json.loads(str(settings.value(_OWN, "[]")))
            own = [Layout(str(name), str(text), _OWN_HINT, Arrangement.unpacked(packed)) for name, text, packed in kept]
            changed = {
                str(name): Arrangement.unpacked(packed)
                for name, packed in json.loads(str(settings.value(_CHANGED, "{}"))).items()
            }
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            return  # what is not as it should be gives way to what there is from the first
        self.layouts |= {layout.name: layout for layout in own if layout.name in OWN}
        self.changed = {name: left for name, left in changed.items() if name in self.layouts}
        present = str(settings.value(_PRESENT, STANDARD))
        self.present = present if present in self.layouts else STANDARD
