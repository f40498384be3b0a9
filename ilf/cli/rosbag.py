"""`ilf rosbag`: write completed depth of runs, with colour and expected error, as a ROS 2 recording."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from .._runtime.formatting import counted
from ..errors import InputError
from ..io.rosbags import (
    CAMERA_TOPIC,
    COLOUR_TOPIC,
    DEPTH_TOPIC,
    ENCODINGS_OF_ROS,
    ERROR_TOPIC,
    STORAGES,
    StampedDepth,
    write_rosbag,
)
from ..run.options import RECORD_FILE
from ..run.record_file import read_record
from ..run.stored_results import StoredResults, result_folders
from ..sources.stamps import stamp_of
from .parsing import add_flags
from .usage import Parser


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        f"Write the completed depth of runs as a ROS 2 recording with the topics {DEPTH_TOPIC}, {CAMERA_TOPIC}, "
        f"{COLOUR_TOPIC} and, where runs have an expected error, {ERROR_TOPIC}, with the timestamps of the frames."
    )
    parser.set_defaults(command=run)
    parser.add_argument(
        "folders",
        nargs="+",
        metavar="DIR",
        help="output folder of `ilf complete`, or a folder of such folders, as written by `ilf batch`",
    )
    parser.add_argument("--out", required=True, metavar="BAG", help="output folder, which must not exist")
    add_flags(parser, "--allow-address")
    parser.add_argument(
        "--encoding",
        choices=ENCODINGS_OF_ROS,
        default=ENCODINGS_OF_ROS[0],
        help="encoding of depth: 32FC1 for metres (default), 16UC1 for millimetres",
    )
    parser.add_argument(
        "--storage", choices=STORAGES, default=STORAGES[0], help=f"storage format (default: {STORAGES[0]})"
    )
    parser.add_argument(
        "--frame-id", default="camera", metavar="ID", help="coordinate frame of the camera (default: camera)"
    )
    parser.add_argument(
        "--rate",
        type=float,
        metavar="HZ",
        help="frame rate for frames without timestamps, in the order of their names",
    )


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    if arguments.rate is not None and not arguments.rate > 0:
        raise InputError(f"--rate must be more than 0 frames a second, not {arguments.rate:g}.")
    if Path(arguments.out).suffix.lower() == ".bag":
        raise InputError(f"{arguments.out}: a ROS 2 recording is a folder; .bag is the file type of ROS 1. Omit .bag.")
    folders = [folder for named in arguments.folders for folder in result_folders(named)]
    stamped = sorted(_stamped(folders, arguments.rate))
    count = write_rosbag(
        arguments.out,
        (_frame(folder, stamp) for stamp, folder in stamped),
        encoding=arguments.encoding,
        storage=arguments.storage,
        frame_id=arguments.frame_id,
    )
    print(f"{counted(count, 'frame')}, written to {arguments.out}")


def _stamped(folders: list[Path], rate: float | None) -> Iterator[tuple[int, Path]]:
    """Yield folders with the timestamps of their frames [ns]."""
    for number, folder in enumerate(folders):
        inputs = read_record(folder / RECORD_FILE).inputs
        stamp = None if inputs is None else stamp_of(inputs, folder)
        if stamp is None and rate is not None:
            stamp = round(number / rate * 1e9)
        if stamp is None:
            raise InputError(f"{folder}: its frame has no timestamp. Give the frame rate (--rate).")
        yield stamp, folder


def _frame(folder: Path, stamp: int) -> StampedDepth:
    result = StoredResults(folder)[0]
    return StampedDepth(result.depth, result.intrinsics, stamp, result.rgb, result.expected_error)
