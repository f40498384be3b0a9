"""`ilf stream`: complete a recording frame after frame, as `ilf.Stream` does, into one MCAP file or a folder."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from .._runtime.cancellation import cancellable_items
from .._runtime.formatting import counted
from ..data.frame import RGBDFrame
from ..errors import Cancelled, IlfError, InputError
from ..io.rosbags import ENCODINGS_OF_ROS
from ..sources.source import Source
from ..sources.stamps import stamp_of
from ..stream.recording import MCAP, StreamRecorder
from ..stream.stream import Stream
from .output import Bar, shows_progress, warn
from .parsing import add_pairing, add_preset, add_reading, preset_from, source_from
from .usage import Parser, add_progress, count


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Complete a recording or folder frame after frame: blocks, edges and correction are found every few frames and "
        "carried along, so that it is fast and filled depth does not flicker. The output is written frame by frame: if "
        "the program ends early, it contains the frames up to then."
    )
    parser.set_defaults(command=run)
    parser.add_argument(
        "inputs", nargs=1, metavar="SOURCE", help="recording, data set or folder with frames of one moving camera"
    )
    parser.add_argument(
        "--out",
        required=True,
        metavar="PATH",
        help=f"a ROS 2 recording in one file (*{MCAP}) with colour, completed depth, expected error, camera_info and, "
        "where poses are known, tf; or a folder with a folder for each frame",
    )
    add_preset(parser)
    parser.add_argument("--threads", type=count, default=2, metavar="N", help="number of threads (default: 2)")
    parser.add_argument(
        "--rate", type=float, metavar="HZ", help="frame rate, for frames without timestamps in a recording"
    )
    parser.add_argument(
        "--ros-encoding",
        choices=ENCODINGS_OF_ROS,
        default=ENCODINGS_OF_ROS[0],
        help="encoding of depth in a recording: 32FC1 for metres (default), 16UC1 for millimetres",
    )
    parser.add_argument(
        "--frame-id", default="camera", metavar="ID", help="coordinate frame of the camera (default: camera)"
    )
    add_progress(parser)
    add_pairing(parser)
    add_reading(parser.add_argument_group("reading the frames"))


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    if arguments.rate is not None and not arguments.rate > 0:
        raise InputError(f"--rate must be more than 0 frames a second, not {arguments.rate:g}.")
    source, chosen, out = source_from(arguments), preset_from(arguments.preset), Path(arguments.out)
    stamp = _stamps(source, arguments.rate, out.suffix.lower() == MCAP)
    noted: set[str] = set()
    with ExitStack() as stack:
        recorder = stack.enter_context(
            StreamRecorder(out, encoding=arguments.ros_encoding, frame_id=arguments.frame_id)
        )
        stream = stack.enter_context(Stream(chosen.parameters, extraction=chosen.extraction, threads=arguments.threads))
        bar = stack.enter_context(Bar(len(source), "frames", shown=shows_progress(arguments)))
        for number, key in enumerate(cancellable_items(source.keys)):
            try:
                completion = stream.complete(source.read(key))
            except Cancelled:
                raise
            except IlfError as error:
                warn([f"{key} is left out: {error}"])
            else:
                warn(note for note in completion.notes if note not in noted)
                noted.update(completion.notes)
                recorder.write(completion, stamp(number, completion.frame))
            bar.advance(key)
    found = stream.statistics
    if not found.frames:
        raise InputError(f"None of the {counted(len(source), 'frame')} could be completed.")
    print(
        f"{counted(found.frames, 'frame')}, {counted(found.scenes, 'scene')}, "
        f"{found.median * 1000:.0f} ms a frame (median), {found.worst * 1000:.0f} ms (95 %), written to {out}"
    )


def _stamps(source: Source, rate: float | None, needed: bool) -> Callable[[int, RGBDFrame], int]:
    """What gives the timestamp of a frame [ns], from its number and the frame."""
    times = source.timestamps
    if needed and times is None and rate is None:
        raise InputError("The frames have no timestamps. Give the frame rate (--rate).")

    def stamp(number: int, frame: RGBDFrame) -> int:
        if times is None:
            return round(number / (rate or 1.0) * 1e9)
        exact = None if frame.inputs is None else stamp_of(frame.inputs)  # times are rounded
        return round(times[number] * 1e9) if exact is None else exact

    return stamp
