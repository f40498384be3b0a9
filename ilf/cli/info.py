"""`ilf info`: show the contents of a frame's files, a source of frames or a run record."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import is_address, read_file
from .._runtime.folders import folder_at
from .._runtime.formatting import counted
from .._runtime.writing import interrupted
from ..batch.shard_files import check_shards
from ..data.camera import Camera, camera_doubt, camera_text
from ..data.declarations import Value
from ..data.frame import RGBDFrame, check_depth_scale, check_same_size
from ..data.parameters import BlockParameters, nearest_preset
from ..data.results import BlockOutcome
from ..errors import IlfError, InputError
from ..io.cameras import IntrinsicsSpec, frame_camera, intrinsics_from
from ..io.depth_reading import DepthReading, unique_warnings
from ..io.encodings import encoding_of_inputs
from ..io.frame_additions import (
    NO_CONFIDENCE_MAP,
    UNUSED_CONFIDENCE,
    confidence_doubt,
    load_guide,
    low_confidence,
    read_confidence,
    read_ground_truth,
    scale_misfit,
)
from ..io.images import read_colour_with_warning, turned
from ..io.orientation import pair_orientation
from ..project.file import SUFFIX
from ..run.options import RECORD_FILE
from ..run.record import RunRecord
from ..run.record_file import read_record
from ..run.replaying import file_problems
from ..sources.frame_folder import FrameFiles, frame_folder, is_frame_folder, two_files
from ..sources.frame_ref import FrameRef
from ..sources.image_pair import depth_of_files, unlike_companions
from ..sources.layouts import all_layouts, layouts_folder
from ..sources.naming import META_NAME
from ..sources.opening import is_recording
from ..sources.own_results import COMPLETED_DEPTH, is_result, is_shards
from ..sources.reading import files_of, read_frame
from ..sources.reading_options import ReadingOptions
from ..sources.recorded import read_recorded
from ..sources.remote import copied, restored
from ..sources.shards import read_shard_set
from ..sources.source import Source
from .output import print_json
from .parsing import (
    add_companions,
    add_frame,
    add_strict,
    check_plausibility,
    frame_of_source,
    reading_options,
    source_from,
)
from .run_output import outcome_lines, outcome_record
from .usage import Parser, UsageError, add_json


class Fact(NamedTuple):
    """One line of the output, and its entries in the JSON document."""

    name: str
    text: str
    entries: Mapping[str, Any] = {}


class Section(NamedTuple):
    """All facts about a source, a frame or a run; `kind` is its key in the JSON document."""

    kind: str
    facts: Sequence[Fact]
    outcomes: Sequence[BlockOutcome] = ()

    @property
    def plausibility_warnings(self) -> list[str]:
        """The plausibility warnings."""
        return [fact.text for fact in self.facts if fact.name == "warning"]

    def record(self) -> dict[str, Any]:
        """Return the section for the JSON document."""
        found: dict[str, Any] = {}
        for fact in self.facts:
            found |= fact.entries
        if self.kind == "run":
            found["blocks"] = [outcome_record(outcome) for outcome in self.outcomes]
        told = {name: [fact.text for fact in self.facts if fact.name == name] for name in ("note", "problem")}
        warnings = self.plausibility_warnings
        return {**found, "plausibility_warnings": warnings, "notes": told["note"], "problems": told["problem"]}


# Facts of a run record.


def record_facts(record: RunRecord) -> list[Fact]:
    """List the facts of a run record."""
    versions = ", ".join(f"{k} {v}" for k, v in record.versions.items())
    entries: dict[str, Any] = {"version": record.version, "versions": record.versions}
    facts = [Fact("made with", f"ILF Studio {record.version}, {versions}", entries)]
    if record.inputs is None:
        facts.append(Fact("frame", "not read from files; the run cannot be replayed"))
    else:
        colour, depth, ground_truth = record.inputs.rgb.path, record.inputs.depth.path, record.inputs.ground_truth
        encoding, camera = encoding_of_inputs(record.inputs).text, intrinsics_from(record.inputs.intrinsics)
        facts += [
            Fact("colour", colour, {"colour": colour}),
            Fact("depth", depth, {"depth": depth}),
            Fact("encoding", encoding, {"encoding": encoding}),
            Fact("intrinsics", camera_text(camera), {"intrinsics": _camera_record(camera)}),
        ]
        if record.inputs.frame is not None:
            facts.append(Fact("frame", record.inputs.frame, {"frame": record.inputs.frame}))
        if ground_truth is not None:
            entries = {"ground_truth": {"path": ground_truth.path, "units_per_m": ground_truth.units}}
            facts.append(Fact("ground truth", f"{ground_truth.path}, {ground_truth.units:g} units per metre", entries))
    height, width = record.blocks.shape
    origin = "given as a label map" if record.extraction is None else "edited" if record.blocks.edited else "extracted"
    entries = {"width": width, "height": height, "blocks_from": origin}
    facts.append(Fact("blocks", f"{len(record.blocks_outcome)} run, {width} x {height}, {origin}", entries))
    if record.extraction is not None:
        changes = record.extraction.differences_from(BlockParameters())
        facts.append(Fact("extraction", _text(changes) or "defaults", {"extraction": changes}))
    nearest = nearest_preset(record.parameters)
    text = f"preset {nearest.preset}" + (f" with {_text(nearest.differs)}" if nearest.differs else "")
    facts.append(Fact("parameters", text, {"preset": nearest.preset, "parameters": record.parameters.to_dict()}))
    own = record.block_parameters
    facts += [Fact(f"block {label}", _text(changes), {"block_parameters": own}) for label, changes in own.items()]
    uses = (record.networks.extraction, "blocks"), (record.networks.filter, "the filter")
    used = dict.fromkeys(item for networks, _ in uses for item in networks.items())
    for name, sha256 in used:
        use = " and ".join(text for networks, text in uses if networks.get(name) == sha256)
        facts.append(Fact("network", f"{name} ({sha256[:12]}) for {use}", {"networks": dict(used)}))
    if record.invalid_mask is not None:
        file = record.invalid_mask.file
        facts.append(Fact("invalid mask", file, {"invalid_mask": file}))
    if record.drawn is not None:
        facts.append(Fact("borders", record.drawn.file, {"borders": record.drawn.file}))
    if record.by_hand is not None:
        entries = {"depth_by_hand": {"file": record.by_hand.file, "weight": record.by_hand.weight}}
        facts.append(Fact("depth by hand", f"{record.by_hand.file}, weight {record.by_hand.weight:g}", entries))
    if record.guide is not None:
        origin = "" if record.guide.path is None else f", read from {record.guide.path}"
        entries = {"guide": {"file": record.guide.file, "path": record.guide.path}}
        facts.append(Fact("guide", f"in {record.guide.file}{origin}", entries))
    if record.neighbours:
        names = [neighbour.name for neighbour in record.neighbours]
        facts.append(Fact("neighbours", ", ".join(names), {"neighbours": names}))
    if record.extrapolate:
        facts.append(Fact("extrapolated", "depth that was still missing after the run", {"extrapolated": True}))
    files = list(record.outputs or record.export.filenames())
    return [*facts, Fact("files", ", ".join(files), {"files": files})]


def _camera_record(camera: Camera | None) -> dict[str, Any] | None:
    return None if camera is None else camera.to_json()


def _text(values: Mapping[str, Value]) -> str:
    return ", ".join(f"{name} {value}" for name, value in values.items())


# Facts of a source.

_SHOWN = 3
"""Number of keys shown at each end of a long list."""


def source_facts(source: Source) -> list[Fact]:
    """List the facts of a source."""
    count, keys = len(source), list(source.keys)
    facts = [
        Fact("source", f"{source.path}, {counted(count, 'frame')}", {"path": str(source.path), "frames": count}),
        Fact("layout", source.layout, {"layout": source.layout}),
        Fact("keys", _some(source.keys), {"keys": keys}),
    ]
    times = source.timestamps
    if times is not None:
        start, end = min(times), max(times)
        span = f"{start:.6f} to {end:.6f} s, {end - start:.3f} s in all" if len(times) > 1 else f"{start:.6f} s"
        facts.append(Fact("time", span, {"start_s": start, "end_s": end}))
    first, registered = source.calibration(keys[0]), source.is_registered
    one = source.ref(keys[0])
    is_on_reading = one.frame is not None or one.options.depth_intrinsics is not None
    way = "registered on reading" if is_on_reading else "not registered on reading"
    return [
        *facts,
        Fact("colour camera", camera_text(first.colour), {"colour_camera": _camera_record(first.colour)}),
        Fact("depth camera", camera_text(first.depth), {"depth_camera": _camera_record(first.depth)}),
        Fact("registered", "yes" if registered else f"no: {way}", {"registered": registered}),
    ]


def plausibility_facts(source: Source) -> list[Fact]:
    """List plausibility warnings, other notes and errors on reading the first, the middle and the last frame."""
    known: set[str] = set()
    facts = []
    for key in dict.fromkeys(source.keys[at] for at in (0, len(source) // 2, -1)):
        try:
            frame = read_frame(source.ref(key))
            found = [("warning" if text in frame.plausibility_warnings else "note", text) for text in frame.notes]
        except IlfError as error:
            found = [("problem", str(error))]
        facts += [Fact(name, f"{key}: {text}") for name, text in found if unique_warnings([text], known)]
    return facts


def _some(keys: tuple[str, ...]) -> str:
    if len(keys) <= 2 * _SHOWN:
        return ", ".join(keys)
    return f"{', '.join(keys[:_SHOWN])} ... {', '.join(keys[-_SHOWN:])}"


_WIDTH = 13
"""Minimum width of the names of facts [characters]."""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = "ilf info (RGB [DEPTH] | FOLDER | SOURCE [--frame KEY] | run.json) [options]"
    parser.description = (
        "Show size, depth range, missing share, encoding and intrinsics of a frame, the frames of a source, or a run "
        "record."
    )
    parser.epilog = (
        "The JSON document contains an object for the shards, the source, the frame and the run, if present. All have "
        "doubts (plausibility warnings), notes and problems (lists of sentences). shards: path, shards, finished, "
        "per_shard, frames, completed, failed, keep, settings (hash). source: path, frames, layout, keys, start_s, "
        "end_s, colour_camera, depth_camera, registered. frame: name, colour, depth (paths), width, height, "
        "depth_width, depth_height, depth_type, encoding, encoding_assumed, missing_share, min_m, max_m, median_m, "
        "intrinsics, colour_camera, ground_truth, guide, confidence, outside_view_share. run: version, versions, "
        "colour, depth, encoding, intrinsics, frame, ground_truth, width, height, blocks_from, extraction, preset, "
        "parameters, "
        "block_parameters, networks, invalid_mask, borders, depth_by_hand, guide, neighbours, extrapolated, files, "
        "blocks (as in `ilf complete --json`). Keys without a value are left out."
    )
    parser.set_defaults(command=run)
    add_frame(parser)
    add_strict(parser, "fail")
    add_companions(parser)
    parser.add_argument("--layouts", action="store_true", help="list the layouts of folders that are recognised")
    add_json(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    if arguments.layouts:
        _print_layouts(arguments.json)
        return
    inputs = [Path(path) for path in arguments.inputs]
    if any(map(is_address, arguments.inputs)) and len(inputs) < 3:
        sections = _sections_at_addresses(arguments)
    elif len(inputs) == 1 and inputs[0].suffix.lower() == SUFFIX:
        raise UsageError(f"{inputs[0]} is a project: use `ilf project info`.")
    elif len(inputs) == 1 and inputs[0].suffix.lower() == ".json":
        sections = [_record_section(inputs[0])]
    elif len(inputs) in {1, 2} or arguments.frame is not None:
        sections = _input_sections(inputs, arguments)
    else:
        raise UsageError("Give a colour and a depth file, one folder, or a run.json.")
    if arguments.json:
        print_json({section.kind: section.record() for section in sections})
    else:
        for number, section in enumerate(sections):
            _print_section(section, apart=number > 0)
    check_plausibility([doubt for section in sections for doubt in section.plausibility_warnings], arguments.strict)


def _print_layouts(as_json: bool) -> None:
    """Print the layouts, those of the user first."""
    layouts = all_layouts()
    if as_json:
        print_json({"layouts": [msgspec.to_builtins(layout) for layout in layouts], "folder": str(layouts_folder())})
        return
    width = max(len(layout.name) for layout in layouts) + 2
    for layout in layouts:
        print(f"{layout.name:{width}}{layout.title}")
    print(f"\nYour own: TOML files in {layouts_folder()}.")


def _sections_at_addresses(arguments: argparse.Namespace) -> list[Section]:
    """Make the sections of a frame or a source at an address; those of a frame's files from copies."""
    if len(arguments.inputs) > 1 and arguments.frame is None:
        given = reading_options(arguments)
        with copied(FrameRef(arguments.inputs[0], arguments.inputs[1], options=given)) as here:
            changed = argparse.Namespace(**{**vars(arguments), **here.options.paths})
            sections = _input_sections([Path(path) for path in (here.rgb, here.depth) if path is not None], changed)
    elif arguments.frame is not None:
        sections = [_source_frame(frame_of_source(arguments), arguments)]
    elif is_shards(arguments.inputs[0]):
        sections = _shards_sections(arguments.inputs[0], arguments)
    else:
        sections = _source_sections(source_from(arguments), arguments)
    return [
        section._replace(
            facts=[
                Fact(fact.name, restored(fact.text), json.loads(restored(json.dumps(fact.entries))))
                for fact in section.facts
            ]
        )
        for section in sections
    ]


def _input_sections(inputs: list[Path], arguments: argparse.Namespace) -> list[Section]:
    """Make the sections of a frame or a source."""
    if arguments.frame is not None:
        return [_source_frame(frame_of_source(arguments), arguments)]
    if len(inputs) == 1 and is_shards(inputs[0]):
        return _shards_sections(str(inputs[0]), arguments)
    is_source = arguments.layout is not None or (os.path.isdir(inputs[0]) and _is_source(inputs[0]))
    if len(inputs) == 1 and (is_recording(inputs[0]) or is_source):
        return _source_sections(source_from(arguments), arguments)
    if len(inputs) == 1 and os.path.isdir(inputs[0]):
        return _folder_sections(inputs[0], arguments)
    if len(inputs) == 1:
        return [Section("frame", _colour_facts(inputs[0], *read_colour_with_warning(inputs[0])))]
    files, given = two_files(*inputs), reading_options(arguments)
    if files.has_meta:
        return [_frame_section(files, given)]
    return [Section("frame", _frame_facts(replace(files, rgb=inputs[0], depth=inputs[1]), given))]


def _is_source(folder: Path) -> bool:
    """Return whether a folder is neither that of a frame nor of a run."""
    return not (is_frame_folder(folder) or (folder / RECORD_FILE).is_file() or interrupted(folder))


def _shards_sections(path: str, arguments: argparse.Namespace) -> list[Section]:
    """Make the sections of a folder of shards and of their completed frames."""
    folder = folder_at(path)
    state, shards = check_shards(folder, contents=False), read_shard_set(folder)
    left = state.frames - state.completed - state.failed
    facts = [
        Fact(
            "shards",
            f"{path}, {state.finished} of {state.shards} finished, {counted(shards.per_shard, 'frame')} each",
            {"path": path, "shards": state.shards, "finished": state.finished, "per_shard": shards.per_shard},
        ),
        Fact(
            "batch",
            f"{counted(state.frames, 'frame')}: {state.completed} completed, {state.failed} failed, {left} not done",
            {"frames": state.frames, "completed": state.completed, "failed": state.failed},
        ),
        Fact("contents", ", ".join(shards.keep), {"keep": shards.keep}),
        Fact("settings", shards.sha256, {"settings": shards.sha256}),
        *(Fact("problem", text) for text in state.problems),
    ]
    section = Section("shards", facts)
    if state.problems or not state.completed:
        return [section]
    return [section, *_source_sections(source_from(arguments), arguments)]


def _source_sections(source: Source, arguments: argparse.Namespace) -> list[Section]:
    """Make the section of a source, with plausibility warnings; for a single frame, also its section."""
    if len(source) > 1:
        return [Section("source", [*source_facts(source), *plausibility_facts(source)])]
    frame = _source_frame(source.ref(source.keys[0]), arguments)
    return [Section("source", source_facts(source)), frame]


def _source_frame(source: FrameRef, arguments: argparse.Namespace) -> Section:
    """Make the section of a frame of a source."""
    if source.frame is None:
        with copied(source) as here:
            files = files_of(here)
            files = replace(files, options=here.options.or_else(files.options))
            return _frame_section(files, reading_options(arguments))
    frame, images = read_frame(source), read_recorded(source.allowed())
    depth, levels = images.reading, images.confidence
    height, width = frame.shape
    sure = [] if levels is None else _confidence_value_facts(None, levels, source.options.min_confidence, depth.metres)
    entries = {"colour": source.rgb, "width": width, "height": height}
    shares = {"missing_share": frame.missing_share, "outside_view_share": frame.outside_share}
    facts = [
        Fact("name", frame.name, {"name": frame.name}),
        Fact("colour", f"{source.rgb}, {width} x {height}", entries),
        *_depth_facts(source.rgb, depth, frame.intrinsics),
        Fact("registered", _registered_text(frame), shares),
        *sure,
        *(Fact("note", text) for text in frame.notes if text not in depth.notes),
    ]
    return Section("frame", facts)


def _registered_text(frame: RGBDFrame) -> str:
    outside = f", {frame.outside_share:.1%} outside the depth camera's view" if frame.outside_share else ""
    return f"{frame.missing_share:.1%} missing{outside}"


def _folder_sections(folder: Path, arguments: argparse.Namespace) -> list[Section]:
    """Make the sections of a folder with a frame, a run or both."""
    record, left = folder / RECORD_FILE, interrupted(folder)
    if left and not record.is_file():
        raise InputError(
            f"{folder} contains an interrupted export: its files do not belong together. Export again; that first "
            "restores the earlier files."
        )
    sections = []
    if is_frame_folder(folder) or not record.is_file():
        sections.append(_frame_section(frame_folder(folder), reading_options(arguments)))
    if record.is_file():
        sections.append(_record_section(record))
    return sections


def _frame_section(files: FrameFiles, given: ReadingOptions) -> Section:
    """Make the section of a frame of files, with its name."""
    return Section("frame", [Fact("name", files.name, {"name": files.name}), *_frame_facts(files, given)])


def _frame_facts(files: FrameFiles, given: ReadingOptions) -> list[Fact]:
    """List the facts of a frame of files, without its name."""
    options, depth = given.or_else(files.options), depth_of_files(files, given)
    ground_truth = _ground_truth_facts(options, depth)
    if files.has_meta and not ground_truth and (filled := sorted(files.rgb.parent.glob("gt.*"))):
        ground_truth = [
            Fact("ground truth", f"none: according to {META_NAME}, {filled[0].name} is not measured or exact depth")
        ]
    return [
        *_pair_facts(files.rgb, files.depth, depth, options),
        *ground_truth,
        *_guide_facts(options.guide, depth.metres),
        *_confidence_facts(options, depth.metres),
    ]


def _record_section(path: Path) -> Section:
    record = read_record(path)
    wrong = file_problems(record, path.absolute().parent)
    return Section("run", [*record_facts(record), *(Fact("problem", text) for text in wrong)], record.blocks_outcome)


def _colour_facts(path: Path, rgb: NDArray[np.uint8], doubt: str) -> list[Fact]:
    """List the facts of a colour image."""
    height, width = rgb.shape[:2]
    entries = {"colour": str(path), "width": width, "height": height}
    return [Fact("colour", f"{path}, {width} x {height}", entries), *([Fact("warning", doubt)] if doubt else [])]


def _pair_facts(colour: Path, path: Path, depth: DepthReading, options: ReadingOptions) -> list[Fact]:
    """List the facts of colour and depth, and whether they match."""
    rgb, doubt = read_colour_with_warning(colour)
    depth_camera = options.depth_intrinsics
    camera = options.intrinsics if depth_camera is None else depth_camera
    facts = [*_colour_facts(colour, rgb, doubt), *_depth_facts(path, depth, camera)]
    orientation = pair_orientation(read_file(colour), rgb, read_file(path), depth.metres)
    if orientation.note:
        facts.append(Fact("warning" if orientation.is_doubt else "orientation", orientation.note))
    if is_result(FrameRef(str(colour), str(path))):
        facts.append(Fact("note", f"{path.name}: {COMPLETED_DEPTH}"))
    rgb, metres = turned(rgb, orientation.tags[0]), turned(depth.metres, orientation.tags[1])
    if depth_camera is not None and rgb.shape[:2] != metres.shape:
        of_colour = _camera_facts("colour camera", options.intrinsics, (rgb.shape[0], rgb.shape[1]))
        return [*facts, *of_colour, Fact("registered", "on reading, by the intrinsics of both images")]
    try:
        facts += [Fact("warning", text) for text in unlike_companions(options, read_file(path), orientation)]
        check_same_size(rgb, metres)
    except InputError as error:
        facts.append(Fact("problem", str(error)))
    return facts


def _depth_facts(path: Path | str, depth: DepthReading, camera: IntrinsicsSpec | None) -> list[Fact]:
    """List the facts of a depth file."""
    values, metres = depth.values, depth.metres
    known = metres[np.isfinite(metres)]
    height, width = values.shape
    size = {"depth_width": width, "depth_height": height, "depth_type": str(values.dtype)}
    encoding, assumed = depth.encoding.text, depth.is_assumed
    missing = 1 - known.size / metres.size
    facts = [
        Fact("depth", f"{path}, {width} x {height}, {values.dtype}", {"depth": str(path), **size}),
        Fact(
            "encoding",
            encoding + (" (assumed; set it with --depth-encoding)" if assumed else ""),
            {"encoding": encoding, "encoding_assumed": assumed},
        ),
        Fact("missing", f"{missing:.1%}", {"missing_share": missing}),
    ]
    if known.size:
        low, high, median = float(known.min()), float(known.max()), float(np.median(known))
        text = f"{low:.3f} to {high:.3f} m, median {median:.3f} m"
        facts.append(Fact("range", text, {"min_m": low, "max_m": high, "median_m": median}))
    facts += _camera_facts("intrinsics", camera, (height, width))
    try:
        check_depth_scale(metres)
    except InputError as error:
        facts.append(Fact("problem", str(error)))
    facts += [Fact("left out", depth.left_out)] if depth.left_out else []
    return [*facts, *(Fact("warning", doubt.text) for doubt in depth.plausibility_warnings)]


def _camera_facts(name: str, given: IntrinsicsSpec | None, shape: tuple[int, int]) -> list[Fact]:
    """List the facts of the camera of an image (H, W)."""
    camera, notes = frame_camera(given, shape)
    doubt = "" if camera is None else camera_doubt(camera, shape)
    return [
        Fact(name, camera_text(camera), {name.replace(" ", "_"): _camera_record(camera)}),
        *(Fact("note", text) for text in notes),
        *([Fact("warning", doubt)] if doubt else []),
    ]


def _ground_truth_facts(options: ReadingOptions, reading: DepthReading) -> list[Fact]:
    """List the facts of the ground truth; empty if there is none."""
    if options.ground_truth is None:
        return []
    depth = reading.metres
    shape, units = (depth.shape[0], depth.shape[1]), options.ground_truth_units
    try:
        ground_truth, file, note = read_ground_truth(
            options.ground_truth, shape, units, reading.encoding.units, reading.encoding.invalid
        )
    except InputError as error:
        return [Fact("problem", str(error))]
    known = np.isfinite(ground_truth)
    missing = np.isnan(depth)
    share, of_missing = _shares(known, missing)
    entries = {
        "path": str(file.path),
        "known_share": share,
        "known_share_of_missing": of_missing,
        "units_per_m": file.units,
    }
    text = f"{file.path}, {file.units:g} units per metre, {_known_text(share, of_missing)}"
    problem = scale_misfit(ground_truth, depth, file.units)
    doubts = [Fact(kind, text) for kind, text in (("note", note), ("problem", problem)) if text]
    return [Fact("ground truth", text, {"ground_truth": entries}), *doubts]


def _shares(known: NDArray[np.bool_], missing: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the known share of all pixels, and of the pixels with missing depth, 0-1."""
    return float(known.mean()), np.count_nonzero(known & missing) / max(int(np.count_nonzero(missing)), 1)


def _known_text(share: float, of_missing: float) -> str:
    return f"known at {share:.1%} of all pixels and {of_missing:.1%} of the missing ones"


def _confidence_facts(options: ReadingOptions, depth: NDArray[np.float32]) -> list[Fact]:
    """List the facts of a confidence map; empty if there is none."""
    if options.confidence is None:
        return [] if options.min_confidence is None else [Fact("warning", NO_CONFIDENCE_MAP)]
    try:
        levels = read_confidence(options.confidence, (depth.shape[0], depth.shape[1]))
    except InputError as error:
        return [Fact("problem", str(error))]
    return _confidence_value_facts(options.confidence, levels, options.min_confidence, depth)


def _confidence_value_facts(
    path: str | None, levels: NDArray[Any], minimum: float | None, depth: NDArray[np.float32]
) -> list[Fact]:
    """List the facts of confidence values, and of depth below the minimum confidence."""
    try:
        effect = UNUSED_CONFIDENCE if minimum is None else low_confidence(levels, minimum, depth)[1]
    except InputError as error:
        return [Fact("problem", str(error))]
    low, high = float(levels.min()), float(levels.max())
    entries = {"path": path, "min": low, "max": high, "min_confidence": minimum}
    where = "" if path is None else f"{path}, "
    doubt = "" if minimum is None else confidence_doubt(levels, minimum)
    fact = Fact("confidence", f"{where}from {low:g} to {high:g}. {effect}", {"confidence": entries})
    return [fact, Fact("warning", doubt)] if doubt else [fact]


def _guide_facts(path: str | None, depth: NDArray[np.float32]) -> list[Fact]:
    """List the facts of a guide; empty if there is none."""
    if path is None:
        return []
    try:
        guide = load_guide(path, (depth.shape[0], depth.shape[1]))
    except InputError as error:
        return [Fact("problem", str(error))]
    share, of_missing = _shares(np.isfinite(guide.values), np.isnan(depth))
    entries = {"path": str(guide.path), "known_share": share, "known_share_of_missing": of_missing}
    text = f"{guide.path}, {_known_text(share, of_missing)}"
    return [Fact("guide", text, {"guide": entries})]


def _print_section(section: Section, *, apart: bool) -> None:
    if apart:
        print()
    width = max([_WIDTH, *(len(fact.name) + 1 for fact in section.facts)])
    for fact in section.facts:
        print(f"{fact.name + ':':{width}} {fact.text}")
    if section.kind == "run":
        print("", *outcome_lines(section.outcomes), sep="\n")
