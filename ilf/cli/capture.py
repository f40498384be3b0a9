"""`ilf capture`: write a frame of the connected camera."""

from __future__ import annotations

import argparse

from ..sources.frame_folder import new_frame_files, write_frame
from ..sources.realsense import SETTLING, capture_frame
from .output import warn
from .usage import Parser, declare


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Register the depth of a frame of the connected RealSense camera to colour, and write it into a folder, which "
        "the other commands read. `ilf-gui --realsense` plays the camera in the window."
    )
    declared = """
        DIR         output folder, created if missing
        --settle N  frames to discard first, until the exposure has settled
    """
    declare(parser, declared, settle=SETTLING)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    new_frame_files(arguments.dir)
    frame = capture_frame(arguments.settle)
    warn(frame.notes)
    for path in write_frame(arguments.dir, frame):
        print(path)
