"""What was opened last, and how it was read."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, TypeVar

from PySide6.QtCore import QSettings

from ilf.errors import FormatError
from ilf.io.frame_source import FrameSource
from ilf.sections import Section

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
            QSettings().setValue(self._key, json.dumps([_entry(origin) for origin in origins]))


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
        """Null where entries of before had no such key, too."""
        found: T | None = entry.get(key, kind, type(None)) if key in entry.values else None
        return found

    is_numbers = isinstance(entry.get("camera", str, list, type(None)), list)
    return FrameSource(
        entry.get("rgb", str),
        entry.get("depth", str, type(None)),
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
