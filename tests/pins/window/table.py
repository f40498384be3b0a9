"""The table of what sessions of the window end in: `python -m tests.pins.window.table [--values] [SESSION ...]`.

With `--values`, it prints what is hashed, to see in what two programs differ.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from ..hashes import LEFT_OUT, of_array, of_bytes, of_text, portable_json
from .hand import Hand, isolated
from .sessions import SESSIONS

_LEFT_OUT = LEFT_OUT | {"when", "path", "sha256", "outputs", "program"}
"""What of a record names the moment, the machine, or another file."""


def make(names: Iterable[str] = ()) -> dict[str, dict[str, str]]:
    """Run sessions, all if none is named: session -> what -> SHA-256 of it."""
    return {name: run(name) for name in names or SESSIONS}


def run(name: str, read: Callable[[object], str] | None = None) -> dict[str, str]:
    """Run a session in a folder of its own, and read what it has kept; as SHA-256 if nothing is said."""
    with tempfile.TemporaryDirectory(prefix="ilf-pins-") as place, isolated(Path(place)):
        user = Hand(Path(place))
        try:
            SESSIONS[name](user)
            if user.window.isVisible():
                user.keep_undo()
                user.keep_project()
            return {what: (read or digest)(value) for what, value in user.kept.items()}
        except Exception as error:
            error.add_note(f"in the session {name}")
            raise
        finally:
            user.close()


def digest(value: object) -> str:
    """SHA-256 of a value: a file, an array, or what JSON can say of both."""
    if isinstance(value, Path):
        return of_text(_record(value)) if value.suffix == ".json" else of_bytes(value.read_bytes())
    return of_array(value) if isinstance(value, np.ndarray) else of_text(_as_text(value))


def _record(path: Path) -> str:
    return portable_json(path, _LEFT_OUT)


def _as_text(value: object) -> str:
    return json.dumps(value, sort_keys=True, default=_as_json)


def _as_json(value: object) -> object:
    if isinstance(value, np.ndarray):
        return digest(value)
    return value.item() if isinstance(value, np.generic) else str(value)


def shown(value: object) -> str:
    """A value as text: arrays and files by their digest."""
    if isinstance(value, Path):
        return _record(value) if value.suffix == ".json" else f"{value.stat().st_size} bytes {digest(value)}"
    return digest(value) if isinstance(value, np.ndarray) else _as_text(value)


def main() -> None:
    """Print the table as JSON, and how long it took."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("sessions", nargs="*", default=list(SESSIONS))
    parser.add_argument("--values", action="store_true", help="print what is hashed")
    options = parser.parse_args()
    begun = time.monotonic()
    table = {name: run(name, shown if options.values else None) for name in options.sessions}
    print(json.dumps(table, indent=1))
    count = sum(map(len, table.values()))
    print(f"{len(table)} sessions, {count} hashes, {time.monotonic() - begun:.0f} s", file=sys.stderr)


if __name__ == "__main__":
    main()
