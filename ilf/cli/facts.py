"""Facts that `ilf info` shows: collected one by one, printed as lines or as one JSON object."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from ..data.camera import Camera, camera_text
from ..errors import InputError
from .output import fact_lines


class Facts:
    """All facts about a source, a frame or a run.

    Parameters
    ----------
    kind : str
        Its key in the JSON document.
    """

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._lines: list[tuple[str, str]] = []
        self.entries: dict[str, Any] = {}
        """Of the JSON document."""
        self.table: Sequence[str] = ()
        """Lines below the others."""

    def add(self, name: str, text: str, /, **entries: Any) -> None:
        """Add a line, and its entries in the JSON document."""
        self._lines.append((name, text))
        self.entries |= entries

    def add_camera(self, name: str, camera: Camera | None) -> None:
        """Add a camera, whose entry has its name."""
        self.add(name, camera_text(camera), **{name.replace(" ", "_"): None if camera is None else camera.to_json()})

    def tell(self, kind: str, *texts: str) -> None:
        """Add lines of a kind: "warning" (of plausibility), "note" or "problem"; no line for an empty text."""
        self._lines += [(kind, text) for text in texts if text]

    @contextmanager
    def problems(self) -> Iterator[None]:
        """Within the block, an input that cannot be read is a problem, which ends the block."""
        try:
            yield
        except InputError as error:
            self.tell("problem", str(error))

    def told(self, kind: str) -> list[str]:
        """The texts of a kind."""
        return [text for name, text in self._lines if name == kind]

    def record(self) -> dict[str, Any]:
        """Return the facts for the JSON document."""
        lists = {"plausibility_warnings": "warning", "notes": "note", "problems": "problem"}
        return self.entries | {name: self.told(kind) for name, kind in lists.items()}

    def lines(self) -> list[str]:
        """Format the facts as lines."""
        return fact_lines(self._lines) + (["", *self.table] if self.table else [])
