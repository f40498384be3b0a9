"""`ilf nerfstudio`: write completed frames with poses as a nerfstudio data set."""

from __future__ import annotations

import argparse

from ..run.nerfstudio import write_nerfstudio
from .output import warn
from .usage import Parser


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Write results of `ilf complete` as a nerfstudio data set: colour, completed depth, a weight of the depth per "
        "pixel, and transforms.json. Poses come from the source of the frames."
    )
    parser.set_defaults(command=run)
    parser.add_argument(
        "results", nargs="+", metavar="RESULT", help="output folder of `ilf complete`, or a folder of such folders"
    )
    parser.add_argument("--out", required=True, metavar="DIR", help="output folder, new or empty")


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    written = write_nerfstudio(arguments.out, arguments.results)
    warn(written.notes)
    print(f"Written to {arguments.out}: {written.files[-1].name} and the {len(written.files) - 1} files listed in it.")
