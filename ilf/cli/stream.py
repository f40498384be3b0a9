"""`ilf stream`: complete a recording frame after frame, as `ilf.Stream` does, or write results, as a recording."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path

from .._runtime.formatting import counted
from .._runtime.long_work import cancellable_items
from ..data.frame import RGBDFrame
from ..errors import Cancelled, IlfError, InputError
from ..io.ros_output import ENCODINGS_OF_ROS, StampedDepth
from ..run.record import read_record
from ..run.stored_results import StoredResults, result_folders
from ..sources.frame_ref import RECORD_FILE
from ..sources.reading import stamp_of
from ..sources.source import Source
from ..stream.recording import MCAP, StreamRecorder, stamped
from ..stream.stream import Stream
from .output import Bar, shows_progress, warn
from .parsing import add_pairing, add_preset, add_reading, add_shared, preset_from, source_from
from .usage import Parser, declare


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Complete a recording or folder frame after frame: blocks, edges and correction are found every few frames and "
        "carried along, so that it is fast and filled depth does not flicker. The output is written frame by frame: if "
        "the program ends early, it contains the frames up to then. With --results, the completed depth of runs is "
        "written as it is."
    )
    declared = """
        INPUT ...  recording, data set or folder with frames of one moving camera; with --results output folders of
            `ilf complete`, or folders of such folders, as written by `ilf batch`
        --results  write the completed depth of runs, in order of time
    """
    declare(parser, declared)
    output = parser.add_argument_group("output")
    declared = f"""
        --out PATH     required: a ROS 2 recording in one file (*{MCAP}) with colour, completed depth, expected error,
            camera_info and, where poses are known, tf; or a folder with a folder for each frame
        --rate HZ      frame rate, for frames without timestamps in a recording
        --ros-encoding {"|".join(ENCODINGS_OF_ROS)}  encoding of depth in a recording: 32FC1 for metres, 16UC1 for
            millimetres
        --frame-id ID  coordinate frame of the camera
    """
    declare(output, declared, ros_encoding=ENCODINGS_OF_ROS[0], frame_id="camera")
    add_preset(parser)
    declare(parser, "--threads N  number of threads", threads=2)
    add_shared(parser, "--progress")
    add_pairing(parser)
    add_reading(parser.add_argument_group("reading the frames"))


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    out = Path(arguments.out)
    if arguments.rate is not None and not arguments.rate > 0:
        raise InputError(f"--rate must be more than 0 frames a second, not {arguments.rate:g}.")
    if out.suffix.lower() == ".bag":
        raise InputError(f"{out}: .bag is the file type of ROS 1. Give a name that ends in {MCAP}, or a folder.")
    if arguments.results:
        done = _write(arguments, out, _results(arguments))
        print(f"{counted(done, 'frame')}, written to {out}")
        return
    source, chosen = source_from(arguments), preset_from(arguments.preset)
    with Stream(chosen.parameters, extraction=chosen.extraction, threads=arguments.threads) as stream:
        done = _write(arguments, out, _completed(arguments, source, stream))
        found = stream.statistics
    print(
        f"{counted(done, 'frame')}, {counted(found.scenes, 'scene')}, {found.median * 1000:.0f} ms a frame (median), "
        f"{found.worst * 1000:.0f} ms (95 %), written to {out}"
    )


def _write(arguments: argparse.Namespace, out: Path, frames: Iterator[StampedDepth]) -> int:
    """Write frames as they come; return how many."""
    with StreamRecorder(out, encoding=arguments.ros_encoding, frame_id=arguments.frame_id) as recorder:
        for frame in frames:
            recorder.write(frame)
        return recorder.count


def _completed(arguments: argparse.Namespace, source: Source, stream: Stream) -> Iterator[StampedDepth]:
    """Complete the frames of a source; those that cannot be completed are left out, with a warning."""
    stamp = _stamps(source, arguments.rate, Path(arguments.out).suffix.lower() == MCAP)
    noted: set[str] = set()
    with Bar(len(source), "frames", shown=shows_progress(arguments)) as bar:
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
                yield stamped(completion, stamp(number, completion.frame))
            bar.advance(key)
    if not stream.statistics.frames:
        raise InputError(f"None of the {counted(len(source), 'frame')} could be completed.")


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


def _results(arguments: argparse.Namespace) -> Iterator[StampedDepth]:
    """The results of runs, in the order of the times of their frames."""
    folders = [folder for named in arguments.inputs for folder in result_folders(named)]
    stamps = [_stamp_of_result(folder, number, arguments.rate) for number, folder in enumerate(folders)]
    for stamp, folder in sorted(zip(stamps, folders, strict=True)):
        result = StoredResults(folder)[0]
        yield StampedDepth(
            result.depth, result.intrinsics, stamp, result.rgb, result.expected_error, result.pose, result.name
        )


def _stamp_of_result(folder: Path, number: int, rate: float | None) -> int:
    inputs = read_record(folder / RECORD_FILE).inputs
    stamp = None if inputs is None else stamp_of(inputs, folder)
    if stamp is None and rate is not None:
        stamp = round(number / rate * 1e9)
    if stamp is None:
        raise InputError(f"{folder}: its frame has no timestamp. Give the frame rate (--rate).")
    return stamp
