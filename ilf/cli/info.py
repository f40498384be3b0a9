"""`ilf info`: show the contents of a frame's files, a source of frames or a run record; list presets and layouts."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Sequence
from operator import attrgetter, itemgetter
from pathlib import Path
from typing import Any

import msgspec

from .._runtime.files import is_address
from .._runtime.folders import folder_at
from .._runtime.formatting import counted
from .._runtime.schema import plain
from .._runtime.writing import interrupted
from ..batch.shard_files import check_shards
from ..data.parameters import PRESETS
from ..data.presets import list_presets, presets_folder
from ..errors import IlfError, InputError
from ..io.depth_doubts import unique_warnings
from ..project.file import SUFFIX
from ..sources.copies import restored
from ..sources.frame_folder import is_frame_folder
from ..sources.frame_ref import RECORD_FILE, FrameRef, is_shards
from ..sources.layouts import all_layouts, layouts_folder
from ..sources.opening import is_recording
from ..sources.reading import read_frame
from ..sources.shards import read_shard_set
from ..sources.source import Source
from .facts import Facts, facts_of_colour, facts_of_frame, facts_of_record
from .output import Column, print_json, table, values_text, warn
from .parsing import add_frame, add_shared, check_plausibility, frame_of_source, reading_options, source_from
from .usage import Parser, UsageError, declare

_SHOWN = 3
"""Number of keys shown at each end of a long list."""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = (
        "ilf info (RGB [DEPTH] | FOLDER | SOURCE [--frame KEY] | run.json) [options]\n"
        "       ilf info (--presets | --layouts) [--json]"
    )
    parser.description = (
        "Show size, depth range, missing share, encoding and intrinsics of a frame, the frames of a source, or a run "
        "record."
    )
    add_frame(parser)
    lists = parser.add_argument_group("lists")
    declared = """
        --presets  list the built-in presets, and your own
        --layouts  list the layouts of folders that are recognised
    """
    declare(lists, declared)
    output = parser.add_argument_group("output")
    add_shared(output, "--strict", "--json")


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    if arguments.presets:
        _print_presets(arguments.json)
        return
    if arguments.layouts:
        _print_layouts(arguments.json)
        return
    found = _facts(arguments)
    if arguments.json:
        document = plain({facts.kind: facts.record() for facts in found})
        print_json(json.loads(restored(json.dumps(document))))
    else:
        print(restored("\n\n".join("\n".join(facts.lines()) for facts in found)))
    check_plausibility([text for facts in found for text in facts.told("warning")], arguments.strict)


def _print_list(as_json: bool, document: object, columns: Sequence[Column], items: Sequence[Any], told: str) -> None:
    """Print a list as JSON, or as a table with a sentence below it."""
    if as_json:
        print_json(document)
    else:
        print("\n".join([*table(columns, items), "", told]))


def _print_presets(as_json: bool) -> None:
    """Print the presets, the built-in ones first."""
    own, problems = list_presets()
    found: list[dict[str, Any]] = [{"name": name, "base": None, "changes": {}} for name in PRESETS]
    for name, preset in own.items():
        extraction = {f"blocks-{key}": value for key, value in preset.extraction_changes.items()}
        found.append({"name": name, "base": preset.base, "changes": preset.changes | extraction})
    columns = (
        Column("name", itemgetter("name")),
        Column("origin", lambda one: f"your own, from {one['base']}" if one["base"] else "built-in"),
        Column("changes", lambda one: values_text(one["changes"])),
    )
    folder = presets_folder()
    document = {"presets": found, "folder": str(folder)}
    _print_list(as_json, document, columns, found, f"Your own presets are in {folder}")
    warn(problems)


def _print_layouts(as_json: bool) -> None:
    """Print the layouts, those of the user first."""
    layouts, folder = all_layouts(), layouts_folder()
    document = {"layouts": list(map(msgspec.to_builtins, layouts)), "folder": str(folder)}
    columns = Column("name", attrgetter("name")), Column("title", attrgetter("title"))
    _print_list(as_json, document, columns, layouts, f"Your own: TOML files in {folder}.")


def _facts(arguments: argparse.Namespace) -> list[Facts]:
    """Collect the facts about what the arguments name."""
    inputs, given = arguments.inputs, reading_options(arguments)
    if arguments.frame is not None:
        return [facts_of_frame(frame_of_source(arguments, source_from(arguments)), given)]
    if len(inputs) == 2:
        return [facts_of_frame(FrameRef(inputs[0], inputs[1]), given)]
    if len(inputs) != 1:
        raise UsageError("Give a colour and a depth file, one folder, or a run.json.")
    path = Path(inputs[0])
    if not is_address(inputs[0]) and path.suffix.lower() == SUFFIX and not path.is_dir():
        raise UsageError(f"{path} is a project: use `ilf project info`.")
    if not is_address(inputs[0]) and path.suffix.lower() == ".json":
        return [facts_of_record(path)]
    if is_shards(inputs[0]):
        return _of_shards(arguments)
    if is_address(inputs[0]) or arguments.layout is not None or is_recording(path) or _is_source(path):
        return _of_source(source_from(arguments), arguments)
    return _of_folder(path, arguments) if os.path.isdir(path) else [facts_of_colour(path)]


def _is_source(folder: Path) -> bool:
    """Return whether a path is a folder, but neither that of a frame nor of a run."""
    is_other = is_frame_folder(folder) or (folder / RECORD_FILE).is_file()
    return os.path.isdir(folder) and not is_other and not interrupted(folder)


def _of_folder(folder: Path, arguments: argparse.Namespace) -> list[Facts]:
    """Collect the facts about a folder with a frame, a run or both."""
    record = folder / RECORD_FILE
    if interrupted(folder) and not record.is_file():
        raise InputError(f"{folder} has an interrupted export. Export again, which first restores the earlier files.")
    found = []
    if is_frame_folder(folder) or not record.is_file():
        found.append(facts_of_frame(FrameRef(str(folder)), reading_options(arguments)))
    if record.is_file():
        found.append(facts_of_record(record))
    return found


def _of_shards(arguments: argparse.Namespace) -> list[Facts]:
    """Collect the facts about a folder of shards and of their completed frames."""
    path, facts = arguments.inputs[0], Facts("shards")
    folder = folder_at(path)
    state, shards = check_shards(folder, contents=False), read_shard_set(folder)
    counts = {"shards": state.shards, "finished": state.finished, "per_shard": shards.per_shard}
    text = f"{path}, {state.finished} of {state.shards} finished, {counted(shards.per_shard, 'frame')} each"
    facts.add("shards", text, path=path, **counts)
    left = state.frames - state.completed - state.failed
    text = f"{counted(state.frames, 'frame')}: {state.completed} completed, {state.failed} failed, {left} not done"
    facts.add("batch", text, frames=state.frames, completed=state.completed, failed=state.failed)
    facts.add("contents", ", ".join(shards.keep), keep=shards.keep)
    facts.add("settings", shards.sha256, settings=shards.sha256)
    facts.tell("problem", *state.problems)
    if state.problems or not state.completed:
        return [facts]
    return [facts, *_of_source(source_from(arguments), arguments)]


def _of_source(source: Source, arguments: argparse.Namespace) -> list[Facts]:
    """Collect the facts about a source, and about the frame of one that has a single one."""
    facts, count, keys = Facts("source"), len(source), list(source.keys)
    facts.add("source", f"{source.path}, {counted(count, 'frame')}", path=str(source.path), frames=count)
    facts.add("layout", source.layout, layout=source.layout)
    shown = keys if count <= 2 * _SHOWN else [f"{', '.join(keys[:_SHOWN])} ... {', '.join(keys[-_SHOWN:])}"]
    facts.add("keys", ", ".join(shown), keys=keys)
    times = source.timestamps
    if times is not None:
        start, end = min(times), max(times)
        span = f"{start:.6f} to {end:.6f} s, {end - start:.3f} s in all" if len(times) > 1 else f"{start:.6f} s"
        facts.add("time", span, start_s=start, end_s=end)
    first, one = source.calibration(keys[0]), source.ref(keys[0])
    facts.add_camera("colour camera", first.colour)
    facts.add_camera("depth camera", first.depth)
    is_on_reading = one.frame is not None or one.options.depth_intrinsics is not None
    way = "registered on reading" if is_on_reading else "not registered on reading"
    registered = source.is_registered
    facts.add("registered", "yes" if registered else f"no: {way}", registered=registered)
    if count == 1:
        return [facts, facts_of_frame(one, reading_options(arguments))]
    _tell_of_frames(facts, source)
    return [facts]


def _tell_of_frames(facts: Facts, source: Source) -> None:
    """Tell plausibility warnings, other notes and errors on reading the first, the middle and the last frame."""
    known: set[str] = set()
    for key in dict.fromkeys(source.keys[at] for at in (0, len(source) // 2, -1)):
        try:
            frame = read_frame(source.ref(key))
            found = [("warning" if text in frame.plausibility_warnings else "note", text) for text in frame.notes]
        except IlfError as error:
            found = [("problem", str(error))]
        for kind, text in found:
            if unique_warnings([text], known):
                facts.tell(kind, f"{key}: {text}")
