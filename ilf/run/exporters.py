"""Export of a completed frame into one file of another program: the table of formats, Rerun, and plugins."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from importlib.metadata import EntryPoint
from pathlib import Path

from .._runtime.plugins import EXPORTERS, call, entry_of_file, entry_points, load, package_of
from .._runtime.writing import atomic_path, ensure_folder, write_bytes
from ..data.results import Completion
from ..errors import ExportError, ParameterError
from .formats import FORMATS, check_format, colour_seen_from
from .run import Run

_BUILT_IN = (EntryPoint("rrd", "ilf.run.rerun_file:RerunFile", EXPORTERS),)


class Export:
    """An export into one file, in the format of its extension.

    Parameters
    ----------
    path : path-like
        A file of that name is replaced; the folder is created if missing.

    Raises
    ------
    ParameterError
        If no format has this extension.
    InputError
        If the format needs a package that is not installed, or its plugin fails.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        of_table = tuple(EntryPoint(name, "ilf.run.formats:FORMATS", EXPORTERS) for name in FORMATS)
        entries = (*of_table, *_BUILT_IN, *entry_points(EXPORTERS))
        entry = entry_of_file(path, entries)
        if entry is None:
            known = ", ".join(f".{each.name}" for each in entries)
            raise ParameterError(f"{path}: there is no export with this extension. Known: {known}.")
        self.path = Path(path)
        self._entry = entry
        self._write: Callable[[Path, Completion], None] | None = (
            None if entry in of_table else call(entry, lambda: load(entry)().write)
        )
        """Of what is not in the table: of an object that the class of the entry point makes, before the run, so that a
        missing package is reported then. It writes into the existing, empty file at the path."""

    def check(self, run: Run) -> None:
        """Raise InputError if the file cannot be made of a run."""
        if self._write is None:
            check_format(self._entry.name, run)

    def write(self, completion: Completion) -> Sequence[str]:
        """Write the file; returns notes on what it does not preserve.

        Raises
        ------
        ExportError
            If it cannot be written. An existing file is unchanged then.
        InputError
            If it cannot be made of this run, or the plugin fails; likewise.
        """
        self.check(completion.run)
        ensure_folder(self.path.parent)
        if self._write is None:
            image = colour_seen_from(self.path.parent, completion.frame)
            content, notes = FORMATS[self._entry.name].content(completion, image)
            write_bytes(self.path, content)
            return [f"{self.path.name}: {note}" for note in notes]
        with atomic_path(self.path) as temporary:
            call(self._entry, self._write, temporary, completion)
            if not (temporary.exists() and temporary.stat().st_size):
                raise ExportError(f"{self.path}: {package_of(self._entry)} has written nothing. Update that package.")
        return ()
