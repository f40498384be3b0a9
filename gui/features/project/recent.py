"""The menu of the frames that were opened last."""

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
from ...base.commands import PASSING, WHY_NOT
from ...widgets.basics import as_it_is
from ..context import Desk, Part
from ..menus import insert_menu

# What was opened last, and how it was read.

MOST = 12

T = TypeVar("T")

Origin = FrameSource | Path
"""A frame's files, the record of a run, or a project file."""


class RecentOrigins:
    """What was opened, the last first.

    Parameters
    ----------
    what : str
        Tells it from other lists: "frames" or "projects".
    remembers : bool
        Whether it is that of the last time, and is kept for the next.
    """

    def __init__(self, what: str, remembers: bool) -> None:
        self._key = f"recent/{what}"
        self._remembers = remembers
        self.origins: list[Origin] = _read(str(QSettings().value(self._key, "[]"))) if remembers else []

    def note(self, origin: Origin) -> None:
        """This has been opened. Only what can be read again in the same way is kept."""
        if _entry(origin) is not None:
            others = [other for other in self.origins if key_of(other) != key_of(origin)]
            self._set([origin, *others][:MOST])

    def remove_missing(self) -> None:
        """Forget what is not there any more."""
        self._set([origin for origin in self.origins if not is_missing(origin)])

    def clear(self) -> None:
        """Forget all."""
        self._set([])

    def _set(self, origins: list[Origin]) -> None:
        self.origins = origins
        if self._remembers:
            entries = [entry for origin in origins if (entry := _entry(origin)) is not None]
            QSettings().setValue(self._key, json.dumps(entries))


def key_of(origin: Origin) -> str:
    """The path of what holds the depth, or of the record."""
    return os.path.abspath(origin.key if isinstance(origin, FrameSource) else origin)


def is_missing(origin: Origin) -> bool:
    """Whether one of its files is not there any more."""
    paths = (origin.rgb, origin.depth, origin.truth, origin.guide) if isinstance(origin, FrameSource) else (origin,)
    return any(path is not None and not os.path.exists(path) for path in paths)


def name_of(origin: Origin) -> str:
    """What to call it: its folder, or its file where that says more."""
    if isinstance(origin, Path):
        return f"{origin.parent.name}/{origin.name}"
    if origin.frame is not None:
        return origin.name
    if origin.depth is None:
        return Path(origin.rgb).name
    return f"{Path(origin.rgb).absolute().parent.name}/{Path(origin.rgb).name}"


def _entry(origin: Origin) -> dict[str, Any] | None:
    """As settings can hold it; None of what cannot be held, such as a camera that was made by a program."""
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
        "truth": _absolute(origin.truth),
        "truth_units": origin.truth_units,
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
    """What settings held; nothing if it is not as it should be."""
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
        get("truth", str),
        get("truth_units", float),
        get("guide", str),
        get("encoding", str),
        get("invalid", float),
        frame=get("frame", str),
        confidence=get("confidence", str),
        min_confidence=get("min_confidence", float),
    )


# A menu of what was opened last.

_DIGITS = 9


class RecentMenu(QMenu):
    """An entry per origin, the last first, and what takes entries out.

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
        self._remove = self._action("Take the grey ones out of this list", origins.remove_missing)
        self._clear = self._action("Forget what was opened; no file is touched", origins.clear)
        self._clear.setText("&Clear this list")

    def note(self, origin: Origin) -> None:
        """This has been opened."""
        self._origins.note(origin)
        self._allow()  # the entries are made when they are looked at

    def fill(self) -> None:
        """Make the entries."""
        self.clear()
        for number, origin in enumerate(self._origins.origins, 1):
            self.addAction(self._entry(number, origin))
        missing = sum(map(is_missing, self._origins.origins))
        self._remove.setText(f"&Remove what is missing ({missing})")
        self._remove.setVisible(missing > 0)
        self.addSeparator()
        self.addActions([self._remove, self._clear])
        self._allow()

    def _allow(self) -> None:
        self.menuAction().setEnabled(bool(self._origins.origins))

    def _entry(self, number: int, origin: Origin) -> QAction:
        """The entry of an origin, once made always the same: whoever lists the commands may hold it."""
        key, gone = key_of(origin), is_missing(origin)
        action = self._entries.get(key)
        if action is None:
            action = self._entries[key] = self._action(key, lambda: self._open_key(key))
            action.setObjectName(f"recent {key}")
            action.setProperty(WHY_NOT, "Its files are not there any more.")
        name = name_of(origin).replace("&", "&&")
        text = f"&{number}  {name}" if number <= _DIGITS else f"{number}  {name}"
        action.setText(f"{text} (missing)" if gone else text)
        action.setEnabled(not gone)
        return action

    def _action(self, hint: str, do: Callable[[], None]) -> QAction:
        action = QAction(self._window)
        action.setToolTip(as_it_is(hint))
        action.setProperty(PASSING, True)
        action.triggered.connect(lambda: do())
        action.triggered.connect(lambda: self._allow())
        return action

    def _open_key(self, key: str) -> None:
        origin = next((origin for origin in self._origins.origins if key_of(origin) == key), None)
        if origin is not None:
            self._open(origin)


class RecentPart(Part):
    """Notes what is opened, and opens it again, read in the same way."""

    def __init__(self, desk: Desk) -> None:
        super().__init__(desk)
        self.frames = RecentOrigins("frames", desk.panels.remembers)
        self._noted: set[str] = set()
        self.menu = RecentMenu("Open re&cent", self.frames, self._open, desk.window)
        desk.workspace.sessions_changed.connect(self._note)
        desk.loader.listed.connect(self.menu.note)

    def begin(self) -> None:
        """Stand in the menu beside what opens frames otherwise."""
        self.menu.setIcon(theme.icon("ph.clock-counter-clockwise", self.menu.palette()))
        insert_menu(self.desk.window.menuBar(), self.menu, self.desk.actions["open_run"])
        self.menu.fill()

    def _note(self) -> None:
        """Note what has been opened since the last time, but for what a project or a folder has brought."""
        workspace = self.desk.workspace
        open_now = {session.key: session for session in workspace.sessions}
        for key, session in open_now.items():
            entry = workspace.entries.of(session.id)
            brought = entry is not None and (entry.has_state or entry.of_folder)
            if key not in self._noted and not brought and isinstance(session.origin, FrameSource | Path):
                self.menu.note(session.origin)
        self._noted = set(open_now)

    def _open(self, origin: Origin) -> None:
        if isinstance(origin, Path):
            self.desk.loader.open_run(origin)
        else:
            self.desk.documents.open_source(origin)
