"""Results of any bench as files: a table as CSV, and everything as JSON."""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Iterable, Mapping
from typing import Any

from .. import __version__
from ..io.atomic import write_bytes
from ..io.tables import write_csv
from ..run.machine import library_versions
from ..run.record import PROGRAM


def write_table(path: str | os.PathLike[str], kind: type[Any], lines: Iterable[Any]) -> None:
    """Write instances of a dataclass as CSV, atomically, its fields as columns; raises ExportError if that fails."""
    write_csv(path, [[field.name for field in dataclasses.fields(kind)], *map(dataclasses.astuple, lines)])


def write_content(path: str | os.PathLike[str], content: Mapping[str, Any]) -> None:
    """Write results as JSON, atomically, with the versions they come from; raises ExportError if that fails."""
    versions = {"program": PROGRAM, "version": __version__, "versions": library_versions()}
    write_bytes(path, (json.dumps(versions | dict(content), indent=1, allow_nan=False) + "\n").encode())


def records(items: Iterable[Any]) -> list[dict[str, Any]]:
    """Instances of dataclasses as JSON takes them."""
    return [dataclasses.asdict(item) for item in items]
