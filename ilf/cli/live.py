"""`ilf live`: play a recording at its rate in the window, completed as it plays."""

from __future__ import annotations

import argparse
import subprocess
import sys

from .._runtime.children import child_command
from .usage import Parser


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Play a recording or folder at its rate in a window, with colour, measured and completed depth, rate, latency "
        "and dropped frames; record it, or freeze a frame to correct it. The same as `ilf-gui --live`."
    )
    parser.set_defaults(command=run)
    parser.add_argument("source", metavar="SOURCE", help="recording, data set or folder with frames of one camera")
    parser.add_argument(
        "--rate", type=float, metavar="HZ", help="frames a second (default: by the timestamps, or 10 without any)"
    )


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    rate = [] if arguments.rate is None else ["--rate", str(arguments.rate)]
    sys.exit(subprocess.call([*child_command("gui.__main__"), "--live", arguments.source, *rate]))
