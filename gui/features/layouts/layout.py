"""What a layout of the window is, and those that there are from the first. No widgets."""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from PySide6.QtCore import QSettings

from ...views.layouts import CORRECT as CORRECT_VIEWS


@dataclass(frozen=True)
class Arrangement:
    """How the window is arranged.

    Attributes
    ----------
    views : str
        How the views are arranged, by one of `gui.views.layouts.LAYOUTS`.
    contents : mapping of str to str
        What the views show: name of a cell -> name of its content; what they show at first where that is not said.
    panels : tuple of str
        Titles of the open panels; None for those that are open from the first.
    places : bytes
        Where the panels stand and how large they are; empty for where they stand at first.
    sides : (str, str)
        The depths that are compared, A and B, as they were chosen; "" for the best choice.
    cloud_beside : bool
        Whether the cloud stands beside the images.
    """

    views: str
    contents: Mapping[str, str] = field(default_factory=dict)
    panels: tuple[str, ...] | None = ()
    places: bytes = b""
    sides: tuple[str, str] = ("", "")
    cloud_beside: bool = False

    def packed(self) -> dict[str, Any]:
        """As JSON can hold it."""
        return {**asdict(self), "places": base64.b64encode(self.places).decode(), "seal": zlib.crc32(self.places)}

    @staticmethod
    def unpacked(values: Mapping[str, Any]) -> Arrangement:
        """What was packed. Places that are not as they were packed are left out: Qt would crash at some.

        Raises
        ------
        ValueError, TypeError, KeyError, AttributeError
            If it is something else.
        """
        places = base64.b64decode(values["places"])
        return Arrangement(
            str(values["views"]),
            {str(cell): str(content) for cell, content in values["contents"].items()},
            None if values["panels"] is None else tuple(str(title) for title in values["panels"]),
            places if values["seal"] == zlib.crc32(places) else b"",
            _two(values["sides"]),
            bool(values["cloud_beside"]),
        )


def _two(values: Any) -> tuple[str, str]:
    first, second = values
    return str(first), str(second)


@dataclass(frozen=True)
class Layout:
    """A named arrangement; what is changed in it stays until it is reset.

    Attributes
    ----------
    name : str
        Tells it from others.
    text : str
        What the user reads.
    hint : str
    arrangement : Arrangement
        What it is reset to.
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
        "The views with the difference, and depth profile, measure and range",
        Arrangement("grid-difference", panels=("Profile", "Measure", "Range")),
    ),
    Layout(
        CORRECT,
        "Correct",
        "One large view to correct blocks in, the others small beside it, and no panels",
        Arrangement(CORRECT_VIEWS),
    ),
    Layout(
        TUNE,
        "Tune",
        "The views with parameters, convergence and runs",
        Arrangement("grid", panels=("Parameters", "Convergence", "Runs")),
    ),
)
"""Those that are always there."""

OWN = tuple(f"own_{number}" for number in range(1, 10))
"""Names of the user's own layouts, by the keys that they have."""


# Layouts as they are kept from session to session.

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
