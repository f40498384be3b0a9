"""`ilf live`: play a recording at its rate, or a camera, in the window, completed as it plays."""

from __future__ import annotations

import argparse
import subprocess
import sys

from .._runtime.installation import child_command
from .._runtime.plugins import entry_points
from ..errors import InputError
from ..sources.realsense import connected_realsense
from .usage import Parser


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Play a recording or folder at its rate, or the connected RealSense camera, in a window, with colour, measured "
        "and completed depth, rate, latency and dropped frames; record it, or freeze a frame to correct it. The same "
        "as `ilf-gui --live` and `ilf-gui --realsense`."
    )
    parser.set_defaults(command=run)
    played = parser.add_mutually_exclusive_group(required=True)
    played.add_argument(
        "source", nargs="?", metavar="SOURCE", help="recording, data set or folder with frames of one camera"
    )
    played.add_argument("--realsense", action="store_true", help="the connected RealSense camera")
    parser.add_argument(
        "--rate",
        type=float,
        metavar="HZ",
        help="frames a second (default: by the timestamps; 10 without any, or of a camera)",
    )


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    if arguments.realsense:
        connected_realsense()
    played = ["--realsense"] if arguments.realsense else ["--live", arguments.source]
    rate = [] if arguments.rate is None else ["--rate", str(arguments.rate)]
    # the package of the window has another name once it is installed
    window = next((entry for entry in entry_points("gui_scripts") if entry.name == "ilf-gui"), None)
    if window is None:
        raise InputError("The window's command ilf-gui is not installed. Reinstall ilf-studio.")
    sys.exit(subprocess.call([*child_command(window.module), *played, *rate]))
