"""Layouts of the window, and the built-in ones. No widgets."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field

import msgspec
from PySide6.QtCore import QByteArray, QSettings

from ...views.layouts import CORRECT as CORRECT_VIEWS


@dataclass(frozen=True)
class Arrangement:
    """Arrangement of the window.

    Attributes
    ----------
    views : str
        Arrangement of the views, one of `gui.views.layouts.LAYOUTS`.
    contents : mapping of str to str
        Contents of the views: name of a cell -> name of its content; default contents for cells that are not listed.
    panels : tuple of str
        Titles of the open panels; None for the default ones.
    places : bytes
        Positions and sizes of the panels; empty for the defaults.
    sides : (str, str)
        The compared depths, A and B, as chosen; "" for automatic.
    cloud_beside : bool
        Whether the cloud is shown beside the images.
    contours : bool
        Whether blocks are drawn as outlines, without fill.
    """

    views: str
    contents: Mapping[str, str] = field(default_factory=dict)
    panels: tuple[str, ...] | None = ()
    places: bytes = b""
    sides: tuple[str, str] = ("", "")
    cloud_beside: bool = False
    contours: bool = False


@dataclass(frozen=True)
class Layout:
    """Named arrangement; changes to it are kept until it is reset.

    Attributes
    ----------
    text : str
        Displayed name.
    arrangement : Arrangement
        State after a reset.
    """

    text: str
    arrangement: Arrangement


STANDARD, INSPECT, CORRECT, TUNE = "standard", "inspect", "correct", "tune"

BUILT_IN = {
    STANDARD: Layout("Standard", Arrangement("grid", panels=None)),
    INSPECT: Layout("Inspect", Arrangement("grid-difference", panels=("Inspect", "Range"))),
    CORRECT: Layout("Correct", Arrangement(CORRECT_VIEWS, contours=True)),
    TUNE: Layout("Tune", Arrangement("grid", panels=("Parameters", "Runs", "Convergence"))),
}
"""The built-in layouts by name."""

OWN = tuple(f"own_{number}" for number in range(1, 10))
"""Names of the user's own layouts, in the order of their shortcuts."""


# Storage of layouts between program starts.

_KEY = "layouts"


class LayoutStore:
    """Layouts by name, with the current one and the last state of each.

    Parameters
    ----------
    persistent : bool
        Whether layouts are stored between program starts.
    """

    def __init__(self, persistent: bool) -> None:
        self._persistent = persistent
        self.layouts = dict(BUILT_IN)
        self.changed: dict[str, Arrangement] = {}
        """Last state of layouts, if known."""
        self.present = STANDARD
        if persistent:
            self._read()

    @property
    def own(self) -> dict[str, Layout]:
        """The user's own layouts, in order."""
        return {name: self.layouts[name] for name in OWN if name in self.layouts}

    def named(self, text: str) -> str | None:
        """Return the name of the layout with this displayed name, ignoring case; None for none."""
        return next((name for name, one in self.layouts.items() if one.text.casefold() == text.casefold()), None)

    def free_name(self) -> str | None:
        """Return the first free name of an own layout; None if there is none."""
        return next((name for name in OWN if name not in self.layouts), None)

    def put(self, name: str, layout: Layout | None) -> None:
        """Store an own layout; None deletes it."""
        self.changed.pop(name, None)
        if layout is None:
            del self.layouts[name]
        else:
            self.layouts[name] = layout
        self.write()

    def left(self, name: str) -> Arrangement:
        """Return the last state of a layout, or its default."""
        return self.changed.get(name, self.layouts[name].arrangement)

    def write(self) -> None:
        """Store all layouts."""
        if self._persistent:
            stored = msgspec.json.encode((self.present, self.own, self.changed))
            # with its checksum: Qt may crash on damaged places
            QSettings().setValue(_KEY, QByteArray(zlib.compress(stored)))

    def _read(self) -> None:
        kind = tuple[str, dict[str, Layout], dict[str, Arrangement]]
        try:
            stored = zlib.decompress(QSettings().value(_KEY))
            present, own, changed = msgspec.json.decode(stored, type=kind)
        except (zlib.error, msgspec.DecodeError, TypeError):
            return  # there are none, or they are damaged: fall back to the built-in ones
        self.layouts |= {name: layout for name, layout in own.items() if name in OWN}
        self.changed = {name: left for name, left in changed.items() if name in self.layouts}
        self.present = present if present in self.layouts else STANDARD
