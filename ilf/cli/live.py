"""`ilf live`: play a recording at its rate, or a camera, in the window, completed as it plays; or capture a frame."""

from __future__ import annotations

import argparse
import subprocess
import sys

from .._runtime.installation import child_command
from .._runtime.plugins import entry_points
from ..errors import InputError
from ..sources.frame_folder import new_frame_files, write_frame
from ..sources.realsense import SETTLING, capture_frame, connected_realsense
from .output import warn
from .usage import Parser, UsageError, declare


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Play a recording or folder at its rate, or the connected RealSense camera, in a window, with colour, measured "
        "and completed depth, rate, latency and dropped frames; record it, or freeze a frame to correct it. The same "
        "as `ilf-gui --live` and `ilf-gui --realsense`. With --capture, a frame of the camera is written, without a "
        "window."
    )
    played = parser.add_mutually_exclusive_group(required=True)
    declared = """
        [SOURCE]     recording, data set or folder with frames of one camera
        --realsense  the connected RealSense camera
    """
    declare(played, declared)
    declare(parser, "--rate HZ  frames a second (default: by the timestamps; 10 without any, or of a camera)")
    declared = f"""
        --capture DIR  register the depth of a frame of the camera to colour, and write it into this folder, created if
            missing, which the other commands read
        --settle N     with --capture: frames to discard first, until the exposure has settled (default: {SETTLING})
    """
    declare(parser.add_argument_group("capturing a frame"), declared)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    if arguments.capture is not None:
        _capture(arguments)
        return
    if arguments.realsense:
        connected_realsense()
    played = ["--realsense"] if arguments.realsense else ["--live", arguments.source]
    rate = [] if arguments.rate is None else ["--rate", str(arguments.rate)]
    # the package of the window has another name once it is installed
    window = next((entry for entry in entry_points("gui_scripts") if entry.name == "ilf-gui"), None)
    if window is None:
        raise InputError("The window's command ilf-gui is not installed. Reinstall ilf-studio.")
    sys.exit(subprocess.call([*child_command(window.module), *played, *rate]))


def _capture(arguments: argparse.Namespace) -> None:
    if not arguments.realsense:
        raise UsageError("--capture takes a frame of the camera: give --realsense in place of a source.")
    new_frame_files(arguments.capture)
    frame = capture_frame(SETTLING if arguments.settle is None else arguments.settle)
    warn(frame.notes)
    for path in write_frame(arguments.capture, frame):
        print(path)
