"""`ilf info`: what there is in a frame's files or in a run record."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import read_file
from .._runtime.formatting import counted
from .._runtime.staging import interrupted
from ..data.camera import CameraIntrinsics, camera_text
from ..data.declarations import ParameterSet, Value
from ..data.frame import RGBDFrame, check_depth_scale, check_same_size
from ..data.parameters import BlockParameters, likeness
from ..errors import IlfError, InputError
from ..io.cameras import intrinsics_from
from ..io.companions import UNUSED, below, load_guide, read_confidence, read_truth, scale_misfit
from ..io.depth_reading import DepthReading, first_of_each, read_depth
from ..io.encodings import encoding_of_inputs, one_encoding
from ..io.images import read_doubted_colour
from ..project.file import SUFFIX
from ..run.options import RECORD_FILE
from ..run.record import RunRecord
from ..run.record_file import read_record
from ..run.replaying import missing_or_changed
from ..sources.frame_source import FrameSource
from ..sources.frames import META_NAME, FrameFiles, frame_beside, frame_folder
from ..sources.opening import is_recording
from ..sources.source import Source
from .parsing import add_frame, add_guide, add_strict, add_truth, check_doubts, frame_of_source, source_from
from .run_output import outcome_lines
from .usage import Parser, UsageError

# A run record in words, for `ilf info`.


def record_facts(record: RunRecord) -> list[tuple[str, str]]:
    """What a run was made of, as pairs of name and fact."""
    facts = [
        ("made with", f"ILF Studio {record.version}, " + ", ".join(f"{k} {v}" for k, v in record.versions.items()))
    ]
    if record.inputs is None:
        facts.append(("frame", "not read from files, so the run cannot be replayed"))
    else:
        facts += [
            ("colour", record.inputs.rgb.path),
            ("depth", record.inputs.depth.path),
            ("encoding", encoding_of_inputs(record.inputs).text),
            ("intrinsics", camera_text(intrinsics_from(record.inputs.intrinsics))),
        ]
        if record.inputs.frame is not None:
            facts.append(("frame", record.inputs.frame))
        if record.inputs.truth is not None:
            facts.append(("truth", f"{record.inputs.truth.path}, {record.inputs.truth.units:g} units per metre"))
    origin = "given as a label map" if record.extraction is None else "edited" if record.edited else "extracted"
    facts.append(("blocks", f"{len(record.outcomes)} run, {record.shape[1]} x {record.shape[0]}, {origin}"))
    if record.extraction is not None:
        facts.append(("extraction", _changes(record.extraction, BlockParameters()) or "defaults"))
    nearest = likeness(record.common)
    changes = _text(nearest.differs)
    facts.append(("parameters", f"preset {nearest.preset}" + (f" with {changes}" if changes else "")))
    facts += [
        (f"block {label}", _changes(own, record.common))
        for label, own in record.parameters.items()
        if own != record.common
    ]
    uses = (record.extraction_networks, "blocks"), (record.networks, "the filter")
    for name, sha256 in dict.fromkeys(item for networks, _ in uses for item in networks.items()):
        use = " and ".join(text for networks, text in uses if networks.get(name) == sha256)
        facts.append(("network", f"{name} ({sha256[:12]}) for {use}"))
    if record.distrusted is not None:
        facts.append(("distrusted", f"depth in {record.distrusted.file}"))
    if record.drawn is not None:
        facts.append(("drawn", f"borders in {record.drawn.file}"))
    if record.guide is not None:
        origin = "" if record.guide.path is None else f", read from {record.guide.path}"
        facts.append(("guide", f"in {record.guide.file}{origin}"))
    if record.dense:
        facts.append(("dense", "the rest was guessed"))
    return [*facts, ("files", ", ".join(record.outputs or record.options.filenames()))]


def _changes(values: ParameterSet, base: ParameterSet) -> str:
    return _text(values.unlike(base))


def _text(values: Mapping[str, Value]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())


# A source in words, for `ilf info`.

_SHOWN = 3
"""Keys that are shown at either end of many."""


def source_facts(source: Source) -> list[tuple[str, str]]:
    """What frames a source has, as pairs of name and fact."""
    facts = [("source", f"{source.path}, {counted(len(source), 'frame')}"), ("keys", _some(source.keys))]
    times = source.timestamps
    if times is not None:
        start, end = min(times), max(times)
        span = f"{start:.6f} to {end:.6f} s, {end - start:.3f} s in all" if len(times) > 1 else f"{start:.6f} s"
        facts.append(("time", span))
    first = source.calibration(source.keys[0])
    facts += [("colour camera", camera_text(first.colour)), ("depth camera", camera_text(first.depth))]
    way = "done as it is read" if source.frame_source(source.keys[0]).frame is not None else "read as it is"
    facts.append(("registered", "yes" if source.is_registered else f"no: {way}"))
    return facts


def doubt_facts(source: Source) -> list[tuple[str, str]]:
    """What speaks against the way that the first, the middle and the last frame are read, and what keeps them from it,
    as pairs of name and fact."""
    known: set[str] = set()
    facts = []
    for key in dict.fromkeys(source.keys[at] for at in (0, len(source) // 2, -1)):
        try:
            found = [("doubt", text) for text in source.frame_source(key).load().doubts]
        except IlfError as error:
            found = [("problem", str(error))]
        facts += [(name, f"{key}: {text}") for name, text in found if first_of_each([text], known)]
    return facts


def _some(keys: tuple[str, ...]) -> str:
    if len(keys) <= 2 * _SHOWN:
        return ", ".join(keys)
    return f"{', '.join(keys[:_SHOWN])} ... {', '.join(keys[-_SHOWN:])}"


_WIDTH = 13
"""Characters that names of facts take, at least."""


def add_arguments(parser: Parser) -> None:
    """Give the command's parser its arguments."""
    parser.usage = "ilf info (RGB [DEPTH] | FOLDER | SOURCE [--frame KEY] | run.json) [options]"
    parser.description = (
        "Show sizes, depth range, missing share, encoding and intrinsics of a frame, the frames of a "
        "source, or a run record."
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
