"""Where results lie, in a folder that a user names."""

from __future__ import annotations

import os
from pathlib import Path

from ..errors import InputError, cause
from ..io.pairing import natural
from .options import RECORD_FILE


def result_folders(path: str | os.PathLike[str]) -> list[Path]:
    """A folder of a result, or those in it, by name; InputError if there are none."""
    root = Path(path).absolute()
    if (root / RECORD_FILE).is_file():
        return [root]
    try:
        inside = (inner for inner in root.iterdir() if (inner / RECORD_FILE).is_file())
        found = sorted(inside, key=lambda inner: natural(inner.name))
    except OSError as error:
        raise InputError(f"{root}: cannot be read ({cause(error)}). Name a folder of results.") from error
    if not found:
        raise InputError(f"{root} holds no results: neither it nor a folder in it has a {RECORD_FILE}.")
    return found
