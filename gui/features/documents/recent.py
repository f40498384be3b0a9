"""Menu of what was opened last."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from PySide6.QtCore import QSettings
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMainWindow, QMenu

from ilf._runtime.schema import Section
from ilf.errors import FormatError
from ilf.sources.frame_ref import FrameRef

from ...base.commands import TEMPORARY, WHY_NOT
from ...widgets.basics import literal_text

MOST = 20
_KEY = "recent/frames"

Origin = FrameRef | Path
"""A frame's files, the record of a run, or a project file."""


def key_of(origin: Origin) -> str:
    """Return the path that identifies an origin: of its depth or of the record."""
    return os.path.abspath(origin.key if isinstance(origin, FrameRef) else origin)


def is_missing(origin: Origin) -> bool:
    """Whether one of its files is missing."""
    paths = origin.paths if isinstance(origin, FrameRef) else (origin,)
    return not all(map(os.path.exists, paths))


def name_of(origin: Origin) -> str:
    """Return a display name: the folder, or folder and file."""
    if isinstance(origin, Path):
        return f"{origin.parent.name}/{origin.name}"
    if origin.frame is not None:
        return origin.name
    if origin.depth is None:
        return Path(origin.rgb).name
    return f"{Path(origin.rgb).absolute().parent.name}/{Path(origin.rgb).name}"


def _entry(origin: Origin) -> dict[str, Any]:
    """Return an origin as values for JSON."""
    return {"file": os.path.abspath(origin)} if isinstance(origin, Path) else origin.absolute().to_json()


def _read(text: str) -> list[Origin]:
    """Parse stored origins, without the damaged ones."""
    try:
        entries = json.loads(text)
    except (ValueError, RecursionError):
        return []
    origins: list[Origin] = []
    for entry in entries if isinstance(entries, list) else []:
        with suppress(FormatError):
            origins.append(_origin(entry))
    return origins[:MOST]


def _origin(entry: object) -> Origin:
    """Parse a stored origin; raises FormatError if it is damaged."""
    data = Section("list", {"entry": entry}).section("entry")
    return Path(data.get("file", str)) if "file" in data.values else FrameRef.from_json(data)


_DIGITS = 9


class RecentMenu(QMenu):
    """Menu of what was opened last, the latest first, each with its reading options, and commands to remove entries.

    Parameters
    ----------
    persistent : bool
        Whether the list is stored between program starts.
    open : callable
        Opens an origin.
    window : QMainWindow or None
        Owner of the actions.

    Attributes
    ----------
    origins : list of Origin
    """

    def __init__(self, persistent: bool, open: Callable[[Origin], object], window: QMainWindow | None) -> None:
        super().__init__("Open re&cent", window)
        self.setToolTipsVisible(True)
        self.aboutToShow.connect(self.fill)
        self._persistent = persistent
        self.origins = _read(str(QSettings().value(_KEY, "[]"))) if persistent else []
        self.open = open
        """Opens an origin."""
        self._window = window
        self._entries: dict[str, QAction] = {}
        self._remove = self._action("Remove the grey entries from this list", self.remove_missing)
        self._clear = self._action("Clear this list; files are not changed", lambda: self._set([]))
        self._clear.setText("&Clear this list")
        self.fill()

    def note(self, origin: Origin) -> None:
        """Add an opened origin; its entry is made when the menu opens."""
        others = [other for other in self.origins if key_of(other) != key_of(origin)]
        self._set([origin, *others][:MOST])

    def remove_missing(self) -> None:
        """Remove origins whose files are missing."""
        self._set([origin for origin in self.origins if not is_missing(origin)])

    def _set(self, origins: list[Origin]) -> None:
        self.origins = origins
        self.menuAction().setEnabled(bool(origins))
        if self._persistent:
            QSettings().setValue(_KEY, json.dumps(list(map(_entry, origins))))

    def fill(self) -> None:
        """Create the entries."""
        self.clear()
        for number, origin in enumerate(self.origins, 1):
            self.addAction(self._entry_of(number, origin))
        missing = sum(map(is_missing, self.origins))
        self._remove.setText(f"&Remove missing ({missing})")
        self._remove.setVisible(missing > 0)
        self.addSeparator()
        self.addActions([self._remove, self._clear])
        self.menuAction().setEnabled(bool(self.origins))

    def _entry_of(self, number: int, origin: Origin) -> QAction:
        """Return the action of an origin; always the same object, because lists of commands may hold it."""
        key, gone = key_of(origin), is_missing(origin)
        action = self._entries.get(key)
        if action is None:
            action = self._entries[key] = self._action(key, lambda: self.open(self._entries[key].data()))
            action.setObjectName(f"recent {key}")
            action.setProperty(WHY_NOT, "Its files are missing.")
        action.setData(origin)
        name = name_of(origin).replace("&", "&&")
        text = f"&{number}  {name}" if number <= _DIGITS else f"{number}  {name}"
        action.setText(f"{text} (missing)" if gone else text)
        action.setEnabled(not gone)
        return action

    def _action(self, hint: str, do: Callable[[], object]) -> QAction:
        action = QAction(self._window)
        action.setToolTip(literal_text(hint))
        action.setProperty(TEMPORARY, True)
        action.triggered.connect(lambda: do())
        return action
