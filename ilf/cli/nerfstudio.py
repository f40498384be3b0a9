"""`ilf nerfstudio`: completed frames with poses as a data set of nerfstudio."""

from __future__ import annotations

import argparse

from ..run.nerfstudio import write_nerfstudio
from .output import warn
from .usage import Parser


def add_arguments(parser: Parser) -> None:
    """Give the command's parser its arguments."""
    parser.description = (
        "Write colour, completed depth, a weight for the depth of every pixel, and transforms.json, which "
        "nerfstudio opens, of results of `ilf complete`. Poses come from the source that the frames were read from."
    )
    parser.set_defaults(command=run)
    parser.add_argument("results", nargs="+", metavar="RESULT", help="folder of a result, or one that holds several")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder for the data set, new or empty")


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out."""
    written = write_nerfstudio(arguments.out, arguments.results)
    warn(written.notes)
    print(f"Written to {arguments.out}: {written.files[-1].name}, and {len(written.files) - 1} files that it names.")
