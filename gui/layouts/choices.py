"""What the user has chosen to see over the pictures, known from session to session."""

from __future__ import annotations

from PySide6.QtCore import QSettings

from gui.actions import Actions

_KEY = "views"
_CHOICES = "contours_only", "block_names", "show_missing"


def remember_choices(actions: Actions) -> None:
    """Choose what was chosen the last time, and keep what is chosen from now on."""
    settings = QSettings()
    for name in _CHOICES:
        action = actions[name]
        action.setChecked(settings.value(f"{_KEY}/{name}", False, bool) is True)
        action.toggled.connect(lambda on, name=name: QSettings().setValue(f"{_KEY}/{name}", on))
