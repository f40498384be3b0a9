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
    name : str
        Identifier.
    text : str
        Displayed name.
    hint : str
    arrangement : Arrangement
        State after a reset.
    """

    name: str
    text: str
    hint: str
    arrangement: Arrangement


STANDARD, INSPECT, CORRECT, TUNE = "standard", "inspect", "correct", "tune"

BUILT_IN = (
    Layout(STANDARD, "Standard", "Blocks and parameters beside the views", Arrangement("grid", panels=None)),
    Layout(
        INSPECT,
        "Inspect",
        "Views with the difference; depth profile, measurements and colour range",
        Arrangement("grid-difference", panels=("Inspect", "Range")),
    ),
    Layout(
        CORRECT,
        "Correct",
        "One large view for correcting blocks, with their outlines; the others small beside it, no panels",
        Arrangement(CORRECT_VIEWS, contours=True),
    ),
    Layout(
        TUNE,
        "Tune",
        "Views with parameters, runs and convergence",
        Arrangement("grid", panels=("Parameters", "Runs", "Convergence")),
    ),
)
"""The built-in layouts."""

OWN = tuple(f"own_{number}" for number in range(1, 10))
"""Names of the user's own layouts, in the order of their shortcuts."""


# Storage of layouts between program starts.

_KEY = "layouts"
OWN_HINT = "A layout of your own"


class LayoutStore:
    """Layouts by name, with the current one and the last state of each.

    Parameters
    ----------
    persistent : bool
        Whether layouts are stored between program starts.
    """

    def __init__(self, persistent: bool) -> None:
        self._persistent = persistent
        self.layouts: dict[str, Layout] = {layout.name: layout for layout in BUILT_IN}
        self.changed: dict[str, Arrangement] = {}
        """Last state of layouts, if known."""
        self.present = STANDARD
        if persistent:
            self._read()

    @property
    def own(self) -> list[Layout]:
        """The user's own layouts, in order."""
        return [self.layouts[name] for name in OWN if name in self.layouts]

    def named(self, text: str) -> Layout | None:
        """Return the layout with this displayed name, ignoring case; None for none."""
        wanted = text.strip().casefold()
        return next((layout for layout in self.layouts.values() if layout.text.casefold() == wanted), None)

    def free_name(self) -> str | None:
        """Return the first free name of an own layout; None if there is none."""
        return next((name for name in OWN if name not in self.layouts), None)

    def put(self, name: str, text: str, arrangement: Arrangement) -> None:
        """Store an own layout."""
        self.layouts[name] = Layout(name, text, OWN_HINT, arrangement)
        self.changed.pop(name, None)
        self.write()

    def delete(self, name: str) -> Layout:
        """Delete an own layout and return it."""
        self.changed.pop(name, None)
        layout = self.layouts.pop(name)
        self.write()
        return layout

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
        kind = tuple[str, list[Layout], dict[str, Arrangement]]
        try:
            stored = zlib.decompress(QSettings().value(_KEY))
            present, own, changed = msgspec.json.decode(stored, type=kind)
        except (zlib.error, msgspec.DecodeError, TypeError):
            return  # there are none, or they are damaged: fall back to the built-in ones
        self.layouts |= {layout.name: layout for layout in own if layout.name in OWN}
        self.changed = {name: left for name, left in changed.items() if name in self.layouts}
        self.present = present if present in self.layouts else STANDARD
