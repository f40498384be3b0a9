"""What a layout of the window is, and those that there are from the first. No widgets."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from gui.views.layouts import CORRECT as CORRECT_VIEWS


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
            places if values.get("seal") == zlib.crc32(places) else b"",
            _two(values.get("sides", ("", ""))),
            bool(values.get("cloud_beside", False)),
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
