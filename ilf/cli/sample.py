"""`ilf sample`: the bundled sample frame."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from .._runtime.installation import asset_path
from .._runtime.writing import move_into_place, staging, write_bytes
from ..errors import ExportError
from .usage import Parser, declare

SAMPLE = "samples/room"


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Write the bundled sample, a generated room with the depth defects of a real sensor, into a folder."
    )
    declared = """
        DIR      output folder, created if missing
        --force  overwrite files of the same names
    """
    declare(parser, declared)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    folder = Path(arguments.dir)
    contents = {
        folder / path.name: path.read_bytes() for path in sorted(asset_path(SAMPLE).iterdir()) if path.is_file()
    }
    if not arguments.force:
        for path, content in contents.items():
            if os.path.exists(path) and (path.is_dir() or path.read_bytes() != content):
                raise ExportError(f"{path} exists and differs. Choose another folder, or overwrite it with --force.")
    with staging(folder) as staged:
        for path, content in contents.items():
            write_bytes(staged / path.name, content)
        move_into_place(staged, folder, [path.name for path in contents])
    print(f"Written to {folder}: {', '.join(path.name for path in contents)}")
    print(f"Complete it: ilf complete {folder}")
