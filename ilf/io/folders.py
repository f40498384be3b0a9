"""Folders to write into."""

from __future__ import annotations

from pathlib import Path

from ..errors import ExportError, cause


def made_folder(folder: str | Path) -> Path:
    """The folder, made if it was not there; raises ExportError if it cannot be."""
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(f"{path} cannot be made a folder: {cause(error)}. Choose another one.") from error
    return path
