"""`ilf info`: what there is in a frame's files or in a run record."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..camera import CameraIntrinsics, camera_text
from ..errors import InputError
from ..frame import RGBDFrame, check_depth_scale, check_same_size
from ..io import (
    META_NAME,
    FrameFiles,
    frame_beside,
    frame_folder,
    load_guide,
)
from ..io.camera_files import intrinsics_from
from ..io.confidence_files import UNUSED, below, read_confidence
from ..io.depth_reading import DepthReading, read_depth
from ..io.encodings import one_encoding
from ..io.files import read_file
from ..io.frame_source import FrameSource
from ..io.images import read_doubted_colour
from ..io.recordings import is_recording
from ..io.truth_files import read_truth, scale_misfit
from ..project.file import SUFFIX
from ..run import missing_or_changed, read_record
from ..run.options import RECORD_FILE
from ..run.staging import interrupted
from ..sources import Source
from .parsing import (
    Commands,
    UsageError,
    add_frame,
    add_guide,
    add_strict,
    add_truth,
    check_doubts,
    frame_of_source,
    source_from,
)
from .record_facts import record_facts
from .report import outcome_lines
from .source_facts import doubt_facts, source_facts

_WIDTH = 13
"""Characters that names of facts take, at least."""


def add_command(commands: Commands) -> None:
    """Add the command to the parser."""
    parser = commands.add_parser(
        "info",
        help="show what is in a frame or in a run record",
        usage="ilf info (RGB [DEPTH] | FOLDER | SOURCE [--frame KEY] | run.json) [options]",
        description="Show sizes, depth range, missing share, encoding and intrinsics of a frame, the frames of a "
        "source, or a run record.",
        allow_abbrev=False,
    )
    parser.set_defaults(command=run)
    add_frame(parser)
    add_strict(parser, "end with an error")
    add_guide(parser)
    add_truth(parser)


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out."""
    inputs = [Path(path) for path in arguments.inputs]
    if len(inputs) == 1 and inputs[0].suffix.lower() == SUFFIX:
        raise UsageError(f"{inputs[0]} is a project: `ilf project info` tells of it.")
    if len(inputs) == 1 and inputs[0].suffix.lower() == ".json":
        _print_record(inputs[0])
    elif len(inputs) in {1, 2} or arguments.frame is not None:
        check_doubts(_print_inputs(inputs, arguments), arguments.strict)
    else:
        raise UsageError("Give a colour and a depth file, one folder, or a run.json.")


def _print_inputs(inputs: list[Path], arguments: argparse.Namespace) -> list[str]:
    """What there is in a frame or a source; returns what is doubted."""
    if arguments.frame is not None:
        return _print_frame_of(frame_of_source(arguments), arguments)
    if len(inputs) == 1 and (is_recording(inputs[0]) or (os.path.isdir(inputs[0]) and _is_source(inputs[0]))):
        return _print_source(source_from(arguments), arguments)
    if len(inputs) == 1 and os.path.isdir(inputs[0]):
        return _print_folder(inputs[0], arguments)
    if len(inputs) == 1:
        return _print_facts(_colour_facts(inputs[0], *read_doubted_colour(inputs[0])))
    beside = frame_beside(*inputs)
    if beside is not None:
        return _print_frame(beside, arguments)
    given = one_encoding(arguments.depth_encoding, arguments.depth_units)
    depth = read_depth(read_file(inputs[1]), given, None, arguments.invalid)
    return _print_facts(
        [
            *_pair_facts(inputs[0], inputs[1], depth, arguments.intrinsics),
            *_truth_facts(arguments.truth, arguments.truth_units, depth),
            *_guide_facts(arguments.guide, depth.metres),
        ]
    )


def _is_source(folder: Path) -> bool:
    """Whether it is neither a frame's folder nor a run's."""
    return not ((folder / META_NAME).is_file() or (folder / RECORD_FILE).is_file() or interrupted(folder))


def _print_source(source: Source, arguments: argparse.Namespace) -> list[str]:
    """What frames there are, and what is doubted of some; of a single one, what is in it."""
    if len(source) > 1:
        return _print_facts([*source_facts(source), *doubt_facts(source)])
    _print_facts(source_facts(source))
    print()
    return _print_frame_of(source.frame_source(source.keys[0]), arguments)


def _print_frame_of(source: FrameSource, arguments: argparse.Namespace) -> list[str]:
    """A frame of a source."""
    if source.frame is None:
        return _print_frame(source.files(), arguments)
    frame, recorded = source.load(), source.recorded()
    depth, levels = recorded.reading, recorded.stored.confidence
    height, width = frame.shape
    sure = [] if levels is None else _levels_facts("", levels, source.min_confidence, depth.metres)
    return _print_facts(
        [
            ("name", frame.name),
            ("colour", f"{source.rgb}, {width} x {height}"),
            *_depth_facts(Path(source.rgb), depth, frame.intrinsics),
            ("registered", _registered_text(frame)),
            *sure,
        ]
    )


def _registered_text(frame: RGBDFrame) -> str:
    outside = f", {frame.outside_share:.1%} outside the depth camera's view" if frame.outside_share else ""
    return f"{frame.missing_share:.1%} missing{outside}"


def _print_folder(folder: Path, arguments: argparse.Namespace) -> list[str]:
    """A frame's folder, a run's, or both."""
    record, left = folder / RECORD_FILE, interrupted(folder)
    is_frame = (folder / META_NAME).is_file()
    if left and not record.is_file():
        raise InputError(
            f"{folder} holds an export that was interrupted: its files do not belong together. Export again: that puts "
            "back what was there before, first."
        )
    doubts = []
    if is_frame or not record.is_file():
        doubts = _print_frame(frame_folder(folder), arguments)
        print()
    if record.is_file():
        _print_record(record)
    return doubts


def _print_frame(files: FrameFiles, arguments: argparse.Namespace) -> list[str]:
    """What a meta.json says of a frame, and what there is in its files."""
    given = one_encoding(arguments.depth_encoding, arguments.depth_units)
    invalid = files.invalid if arguments.invalid is None else arguments.invalid
    depth = read_depth(read_file(files.depth), given, files.stated_encoding, invalid)
    stated = files.truth_units if arguments.truth is None else None
    truth = _truth_facts(arguments.truth or files.truth, arguments.truth_units or stated, depth)
    if not truth and (filled := sorted(files.rgb.parent.glob("gt.*"))):
        truth = [("truth", f"none: {META_NAME} says of {filled[0].name} that it is no measured or exact depth")]
    return _print_facts(
        [
            ("name", files.name),
            *_pair_facts(files.rgb, files.depth, depth, arguments.intrinsics or files.intrinsics),
            *truth,
            *_guide_facts(arguments.guide or files.guide, depth.metres),
            *_confidence_facts(files, arguments.min_confidence, depth.metres),
        ]
    )


def _print_record(path: Path) -> None:
    record = read_record(path)
    wrong = missing_or_changed(record, path.absolute().parent)
    _print_facts([*record_facts(record), *(("problem", sentence) for sentence in wrong)])
    print("", *outcome_lines(record.outcomes), sep="\n")


def _colour_facts(path: Path, rgb: NDArray[np.uint8], doubt: str) -> list[tuple[str, str]]:
    """What there is to say about colour."""
    return [("colour", f"{path}, {rgb.shape[1]} x {rgb.shape[0]}"), *([("doubt", doubt)] if doubt else [])]


def _pair_facts(
    colour: Path, path: Path, depth: DepthReading, camera: str | CameraIntrinsics | None
) -> list[tuple[str, str]]:
    """What there is to say about colour and depth, and whether they fit each other."""
    rgb, doubt = read_doubted_colour(colour)
    facts = [*_colour_facts(colour, rgb, doubt), *_depth_facts(path, depth, camera)]
    try:
        check_same_size(rgb, depth.metres)
    except InputError as error:
        facts.append(("problem", str(error)))
    return facts


def _depth_facts(path: Path, depth: DepthReading, camera: str | CameraIntrinsics | None) -> list[tuple[str, str]]:
    """What there is to say about depth."""
    values, metres = depth.values, depth.metres
    known = metres[np.isfinite(metres)]
    facts = [
        ("depth", f"{path}, {values.shape[1]} x {values.shape[0]}, {values.dtype}"),
        ("encoding", depth.encoding.text + (" (assumed; --depth-encoding sets it)" if depth.is_assumed else "")),
        ("missing", f"{1 - known.size / metres.size:.1%}"),
    ]
    if known.size:
        low, high = float(known.min()), float(known.max())
        facts.append(("range", f"{low:.3f} to {high:.3f} m, median {float(np.median(known)):.3f} m"))
    intrinsics = intrinsics_from(camera, metres.shape)
    facts.append(("intrinsics", camera_text(intrinsics)))
    try:
        check_depth_scale(metres)
    except InputError as error:
        facts.append(("problem", str(error)))
    facts += [("left out", depth.left_out)] if depth.left_out else []
    return [*facts, *(("doubt", doubt.text) for doubt in depth.doubts)]


def _truth_facts(path: str | Path | None, units: float | None, reading: DepthReading) -> list[tuple[str, str]]:
    """What there is to say about the truth of depth; nothing if there is none."""
    if path is None:
        return []
    depth = reading.metres
    try:
        truth, file = read_truth(path, (depth.shape[0], depth.shape[1]), units, reading.encoding.units)
    except InputError as error:
        return [("problem", str(error))]
    known = np.isfinite(truth)
    missing = np.isnan(depth)
    share = np.count_nonzero(known & missing) / max(int(np.count_nonzero(missing)), 1)
    facts = [
        ("truth", f"{file.path}, known at {np.count_nonzero(known) / known.size:.1%}, {share:.1%} of what is missing"),
        ("truth units", f"{file.units:g} per metre"),
    ]
    problem = scale_misfit(truth, depth, file.units)
    return [*facts, ("problem", problem)] if problem else facts


def _confidence_facts(files: FrameFiles, given: float | None, depth: NDArray[np.float32]) -> list[tuple[str, str]]:
    """What there is to say about a confidence map; nothing if there is none."""
    if files.confidence is None:
        return []
    least = files.min_confidence if given is None else given
    try:
        levels = read_confidence(files.confidence, (depth.shape[0], depth.shape[1]))
    except InputError as error:
        return [("problem", str(error))]
    return _levels_facts(f"{files.confidence}, ", levels, least, depth)


def _levels_facts(
    where: str, levels: NDArray[Any], least: float | None, depth: NDArray[np.float32]
) -> list[tuple[str, str]]:
    """What there is to say about confidence that has been read, and of depth that is below the least."""
    try:
        told = UNUSED if least is None else below(levels, least, depth)[1]
    except InputError as error:
        return [("problem", str(error))]
    return [("confidence", f"{where}from {levels.min():g} to {levels.max():g}. {told}")]


def _guide_facts(path: str | Path | None, depth: NDArray[np.float32]) -> list[tuple[str, str]]:
    """What there is to say about a guide; nothing if there is none."""
    if path is None:
        return []
    try:
        guide = load_guide(path, (depth.shape[0], depth.shape[1]))
    except InputError as error:
        return [("problem", str(error))]
    said = np.isfinite(guide.values)
    share = np.count_nonzero(said & np.isnan(depth)) / max(int(np.count_nonzero(np.isnan(depth))), 1)
    return [("guide", f"{guide.path}, says something of {said.mean():.1%}, {share:.1%} of what is missing")]


def _print_facts(facts: Sequence[tuple[str, str]]) -> list[str]:
    """Print them, and return what is doubted."""
    width = max([_WIDTH, *(len(name) + 1 for name, _ in facts)])
    for name, fact in facts:
        print(f"{name + ':':{width}} {fact}")
    return [fact for name, fact in facts if name == "doubt"]
