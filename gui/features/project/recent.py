"""Menus of recent frames and projects."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from PySide6.QtCore import QSettings
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMainWindow, QMenu

from ilf._runtime.schema import Section
from ilf.errors import FormatError
from ilf.sources.frame_source import FrameSource

from ...base import theme
from ...base.commands import TEMPORARY, WHY_NOT
from ...widgets.basics import literal_text
from ..context import Context, Feature
from ..menus import insert_menu

# Recently opened files with their reading options.

MOST = 12

T = TypeVar("T")

Origin = FrameSource | Path
"""A frame's files, the record of a run, or a project file."""


class RecentOrigins:
    """Recently opened origins, the latest first.

    Parameters
    ----------
    what : str
        Name of the list: "frames" or "projects".
    persistent : bool
        Whether the list is stored between program starts.
    """

    def __init__(self, what: str, persistent: bool) -> None:
        self._key = f"recent/{what}"
        self._persistent = persistent
        self.origins: list[Origin] = _read(str(QSettings().value(self._key, "[]"))) if persistent else []

    def note(self, origin: Origin) -> None:
        """Add an opened origin, if it can be stored with its reading options."""
        if _entry(origin) is not None:
            others = [other for other in self.origins if key_of(other) != key_of(origin)]
            self._set([origin, *others][:MOST])

    def remove_missing(self) -> None:
        """Remove origins whose files are missing."""
        self._set([origin for origin in self.origins if not is_missing(origin)])

    def clear(self) -> None:
        """Clear the list."""
        self._set([])

    def _set(self, origins: list[Origin]) -> None:
        self.origins = origins
        if self._persistent:
            entries = [entry for origin in origins if (entry := _entry(origin)) is not None]
            QSettings().setValue(self._key, json.dumps(entries))


def key_of(origin: Origin) -> str:
    """Return the path that identifies an origin: of its depth or of the record."""
    return os.path.abspath(origin.key if isinstance(origin, FrameSource) else origin)


def is_missing(origin: Origin) -> bool:
    """Whether one of its files is missing."""
    paths = (
        (origin.rgb, origin.depth, origin.ground_truth, origin.guide) if isinstance(origin, FrameSource) else (origin,)
    )
    return any(path is not None and not os.path.exists(path) for path in paths)


def name_of(origin: Origin) -> str:
    """Return a display name: the folder, or folder and file."""
    if isinstance(origin, Path):
        return f"{origin.parent.name}/{origin.name}"
    if origin.frame is not None:
        return origin.name
    if origin.depth is None:
        return Path(origin.rgb).name
    return f"{Path(origin.rgb).absolute().parent.name}/{Path(origin.rgb).name}"


def _entry(origin: Origin) -> dict[str, Any] | None:
    """Return an origin as values for JSON; None if it cannot be stored, such as with a camera object."""
    if isinstance(origin, Path):
        return {"file": os.path.abspath(origin)}
    camera = origin.intrinsics
    if camera is not None and not isinstance(camera, str):
        if not isinstance(camera, (tuple, list)):
            return None
        camera = [float(number) for number in camera]
    return {
        "rgb": _absolute(origin.rgb),
        "depth": _absolute(origin.depth),
        "units": origin.depth_units,
        "camera": camera,
        "ground_truth": _absolute(origin.ground_truth),
        "ground_truth_units": origin.ground_truth_units,
        "guide": _absolute(origin.guide),
        "encoding": origin.encoding,
        "invalid": origin.invalid,
        "frame": origin.frame,
        "confidence": _absolute(origin.confidence),
        "min_confidence": origin.min_confidence,
    }


def _absolute(path: str | None) -> str | None:
    return None if path is None else os.path.abspath(path)


def _read(text: str) -> list[Origin]:
    """Parse stored origins; return an empty list if they are damaged."""
    try:
        return [_origin(Section("entry", entry)) for entry in json.loads(text)][:MOST]
    except (ValueError, TypeError, RecursionError, FormatError):
        return []


def _origin(entry: Section) -> Origin:
    if "file" in entry.values:
        return Path(entry.get("file", str))

    def get(key: str, kind: type[T]) -> T | None:
        found: T | None = entry.get(key, kind, type(None))
        return found

    is_numbers = isinstance(entry.get("camera", str, list, type(None)), list)
    return FrameSource(
        entry.get("rgb", str),
        get("depth", str),
        get("units", float),
        tuple(entry.items("camera", float)) if is_numbers else get("camera", str),
        get("ground_truth", str),
        get("ground_truth_units", float),
        get("guide", str),
        get("encoding", str),
        get("invalid", float),
        frame=get("frame", str),
        confidence=get("confidence", str),
        min_confidence=get("min_confidence", float),
    )


# The menu.

_DIGITS = 9


class RecentMenu(QMenu):
    """Menu with an entry per origin, the latest first, and commands to remove entries.

    Parameters
    ----------
    title : str
    origins : RecentOrigins
    open : callable
        Opens an origin.
    window : QMainWindow
    """

    def __init__(
        self, title: str, origins: RecentOrigins, open: Callable[[Origin], object], window: QMainWindow
    ) -> None:
        super().__init__(title, window)
        self.setToolTipsVisible(True)
        self.aboutToShow.connect(self.fill)
        self._origins = origins
        self._open = open
        self._window = window
        self._entries: dict[str, QAction] = {}
        self._remove = self._action("Remove the grey entries from this list", origins.remove_missing)
        self._clear = self._action("Clear this list; files are not changed", origins.clear)
        self._clear.setText("&Clear this list")

    def note(self, origin: Origin) -> None:
        """Add an opened origin."""
        self._origins.note(origin)
        self._allow()  # the entries are created when the menu opens

    def fill(self) -> None:
        """Create the entries."""
        self.clear()
        for number, origin in enumerate(self._origins.origins, 1):
            self.addAction(self._entry(number, origin))
        missing = sum(map(is_missing, self._origins.origins))
        self._remove.setText(f"&Remove missing ({missing})")
        self._remove.setVisible(missing > 0)
        self.addSeparator()
        self.addActions([self._remove, self._clear])
        self._allow()

    def _allow(self) -> None:
        self.menuAction().setEnabled(bool(self._origins.origins))

    def _entry(self, number: int, origin: Origin) -> QAction:
        """Return the action of an origin; always the same object, because lists of commands may hold it."""
        key, gone = key_of(origin), is_missing(origin)
        action = self._entries.get(key)
        if action is None:
            action = self._entries[key] = self._action(key, lambda: self._open_key(key))
            action.setObjectName(f"recent {key}")
            action.setProperty(WHY_NOT, "Its files are missing.")
        name = name_of(origin).replace("&", "&&")
        text = f"&{number}  {name}" if number <= _DIGITS else f"{number}  {name}"
        action.setText(f"{text} (missing)" if gone else text)
        action.setEnabled(not gone)
        return action

    def _action(self, hint: str, do: Callable[[], None]) -> QAction:
        action = QAction(self._window)
        action.setToolTip(literal_text(hint))
        action.setProperty(TEMPORARY, True)
        action.triggered.connect(lambda: do())
        action.triggered.connect(lambda: self._allow())
        return action

    def _open_key(self, key: str) -> None:
        origin = next((origin for origin in self._origins.origins if key_of(origin) == key), None)
        if origin is not None:
            self._open(origin)


class RecentFeature(Feature):
    """Records opened frames, and opens them again with the same options."""

    def __init__(self, context: Context) -> None:
        super().__init__(context)
        self.frames = RecentOrigins("frames", context.panels.persistent)
        self._noted: set[str] = set()
        self.menu = RecentMenu("Open re&cent", self.frames, self._open, context.window)
        context.workspace.frames.sessions_changed.connect(self._note)
        context.loader.listed.connect(self.menu.note)

    def begin(self) -> None:
        """Insert the menu of recent frames."""
        self.menu.setIcon(theme.icon("ph.clock-counter-clockwise", self.menu.palette()))
        insert_menu(self.context.window.menuBar(), self.menu, self.context.actions["open_run"])
        self.menu.fill()

    def _note(self) -> None:
        """Record newly opened frames, except those of a project or a folder."""
        workspace = self.context.workspace
        open_now = {session.key: session for session in workspace.frames.sessions}
        for key, session in open_now.items():
            entry = workspace.frames.entries.of(session.id)
            brought = entry is not None and (entry.has_state or entry.from_folder)
            if key not in self._noted and not brought and isinstance(session.origin, FrameSource | Path):
                self.menu.note(session.origin)
        self._noted = set(open_now)

    def _open(self, origin: Origin) -> None:
        if isinstance(origin, Path):
            self.context.loader.open_run(origin)
        else:
            self.context.documents.open_source(origin)
