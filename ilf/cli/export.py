"""`ilf export`: write completed frames with poses as a data set of another program."""

from __future__ import annotations

import argparse

from .._runtime.formatting import counted
from ..run.data_sets import DATA_SETS, write_data_set
from .output import warn
from .parsing import add_allowed
from .usage import Parser


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Write results of `ilf complete` or `ilf batch` as a data set of another program. Poses come from the source "
        "of the frames."
    )
    parser.set_defaults(command=run)
    parser.add_argument(
        "results",
        nargs="+",
        metavar="RESULT",
        help="output folder of `ilf complete`, a folder of such folders, or one of shards",
    )
    parser.add_argument(
        "--to",
        choices=tuple(DATA_SETS),
        required=True,
        help="; ".join(f"{name}: {one.contents}" for name, one in DATA_SETS.items()),
    )
    parser.add_argument("--out", required=True, metavar="DIR", help="output folder, new or empty")
    add_allowed(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    written = write_data_set(arguments.out, arguments.results, arguments.to)
    warn(written.notes)
    print(f"Written to {arguments.out}: {counted(len(written.files), 'file')}.")
