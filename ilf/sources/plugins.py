"""Kinds of recordings and layouts of other packages: the entry points `ilf.sources`."""

from __future__ import annotations

from functools import cache
from importlib.metadata import EntryPoint
from pathlib import Path

from .._runtime.plugins import FAILURES, SOURCES, entry_points, failure
from .layout import Layout
from .recording import Recording


class SourcePlugins:
    """What the entry points name: subclasses of `Recording`, and layouts. One that fails is left out.

    Attributes
    ----------
    layouts : list of Layout
    kinds : dict of type to EntryPoint
    notes : list of str
        A sentence for each plugin that failed.
    """

    def __init__(self) -> None:
        self.layouts: list[Layout] = []
        self.notes: list[str] = []
        self.kinds: dict[type[Recording], EntryPoint] = {}
        for entry in entry_points(SOURCES):
            try:
                self._add(entry)
            except FAILURES as error:
                self.notes.append(failure(entry, error))

    def kind_of(self, path: Path) -> type[Recording] | None:
        """The kind of recording at a path; None if there is none."""
        for kind, entry in tuple(self.kinds.items()):
            try:
                if kind.fits(path):
                    return kind
            except (OSError, ValueError):
                # no file can have that name
                continue
            except FAILURES as error:
                del self.kinds[kind]
                self.notes.append(failure(entry, error))
        return None

    def with_notes(self, message: str) -> str:
        """A message, followed by the notes."""
        return " ".join((message, *self.notes))

    def _add(self, entry: EntryPoint) -> None:
        found = entry.load()
        if isinstance(found, Layout):
            self.layouts.append(found)
        elif isinstance(found, type) and issubclass(found, Recording):
            if missing := ", ".join(sorted(found.__abstractmethods__)):
                raise TypeError(f"{entry.value} is abstract: it has no {missing}")
            self.kinds[found] = entry
        else:
            raise TypeError(f"{entry.value} is neither a subclass of Recording nor a Layout")


@cache
def source_plugins() -> SourcePlugins:
    """The plugins, imported at the first call."""
    return SourcePlugins()
