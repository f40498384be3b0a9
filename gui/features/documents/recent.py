"""Menu of what was opened last."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import QSettings
from PySide6.QtWidgets import QMainWindow, QMenu

from ilf._runtime.schema import Section
from ilf.errors import FormatError
from ilf.sources.frame_ref import FrameRef

from ...base.commands import TEMPORARY
from ...widgets.basics import literal_text

MOST = 20
_KEY = "recent/frames"

Origin = FrameRef | Path
"""A frame's files, the record of a run, or a project file."""


def key_of(origin: Origin) -> str:
    """Return the path that identifies an origin: of its depth or of the record."""
    return os.path.abspath(origin.key if isinstance(origin, FrameRef) else origin)


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
        with suppress(FormatError):  # of damaged ones
            data = Section("list", {"entry": entry}).section("entry")
            origins.append(Path(data.get("file", str)) if "file" in data.values else FrameRef.from_json(data))
    return origins[:MOST]


class RecentMenu(QMenu):
    """Menu of what was opened last and is still there, the latest first, each with its reading options.

    Parameters
    ----------
    open : callable
        Opens an origin.
    window : QMainWindow or None

    Attributes
    ----------
    origins : list of Origin
        Also those whose files are not there now, as on a drive that is not connected.
    """

    def __init__(self, open: Callable[[Origin], object], window: QMainWindow | None) -> None:
        super().__init__("Open recen&t", window)
        self.setToolTipsVisible(True)
        self.aboutToShow.connect(self._fill)
        self.origins = _read(str(QSettings().value(_KEY, "[]")))
        self._open = open
        self.menuAction().setEnabled(bool(self.origins))

    def note(self, origin: Origin) -> None:
        """Add an opened origin."""
        others = [other for other in self.origins if key_of(other) != key_of(origin)]
        self._set([origin, *others][:MOST])

    def there(self) -> list[Origin]:
        """Return the origins whose files are there."""
        return [origin for origin in self.origins if _is_there(origin)]

    def _set(self, origins: list[Origin]) -> None:
        self.origins = origins
        self.menuAction().setEnabled(bool(origins))
        QSettings().setValue(_KEY, json.dumps(list(map(_entry, origins))))

    def _fill(self) -> None:
        self.clear()
        for number, origin in enumerate(self.there(), 1):
            name, key = name_of(origin).replace("&", "&&"), key_of(origin)
            self._add(f"&{number}  {name}", key, partial(self._open, origin))
        if self.origins:  # a menu that is off is still looked through for commands
            self.addSeparator()
            self._add("&Clear this list", "Clear this list; files are not changed", lambda: self._set([]))

    def _add(self, text: str, hint: str, do: Callable[[], object]) -> None:
        action = self.addAction(text, lambda: do())
        action.setObjectName(f"recent {hint}")
        action.setToolTip(literal_text(hint))
        action.setProperty(TEMPORARY, True)


def _is_there(origin: Origin) -> bool:
    """Whether all of its files are there."""
    return all(map(os.path.exists, origin.paths if isinstance(origin, FrameRef) else (origin,)))
