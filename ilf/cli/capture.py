"""`ilf capture`: capture a frame with the connected camera."""

from __future__ import annotations

import argparse

from ..sources.frame_writing import new_frame_files, write_frame
from ..sources.realsense import SETTLING, capture_frame
from .output import warn
from .usage import Parser, count


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Capture a frame with the connected RealSense camera, register its depth to colour, and write it into a "
        "folder that the other commands read."
    )
    parser.set_defaults(command=run)
    parser.add_argument("--out", required=True, metavar="DIR", help="output folder, created if missing")
    parser.add_argument(
        "--settle",
        type=count,
        default=SETTLING,
        metavar="N",
        help=f"frames to discard first, until the exposure has settled (default: {SETTLING})",
    )


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    new_frame_files(arguments.out)
    frame = capture_frame(arguments.settle)
    warn(frame.notes)
    for path in write_frame(arguments.out, frame):
        print(path)
