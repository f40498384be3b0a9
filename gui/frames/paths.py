"""Which of the paths that are named or dropped are what. Without Qt: the command line takes over where it fails."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path


def sorted_out(paths: Iterable[Path]) -> tuple[list[Path], list[Path], list[Path]]:
    """Frame folders, run records and image files among paths, each in the order given."""
    chosen = list(paths)
    folders = [path for path in chosen if path.is_dir()]
    records = [path for path in chosen if path.suffix == ".json" and path not in folders]
    return folders, records, [path for path in chosen if path not in folders and path not in records]
