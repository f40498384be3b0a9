"""`ilf project`: make, show, export and replay project files without the window."""

from __future__ import annotations

import argparse
import dataclasses
import os
import secrets
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from operator import itemgetter
from pathlib import Path
from typing import Any

from .._runtime.formatting import counted
from ..completion.confidence.expected_error import RMS_NAME
from ..data.frame import InputFile
from ..data.results import Completion
from ..errors import InputError, one_line
from ..project.archive import Parts
from ..project.codec import UNREADABLE, check_content, from_plain, stored_fields
from ..project.exporting import ExportStatus, export_frames, in_folders, run_and_completion
from ..project.file import SUFFIX, OpenedProject, open_project, save_project
from ..project.frame_state import FrameState
from ..project.project import Project, ProjectFrame, Stage
from ..project.run_history import StoredRun
from ..project.sources import embedded, located
from ..project.state_codec import UnreadableFrame, frame_part, read_head
from ..run.data_sets import DATA_SETS, write_data_set
from ..run.record import array_sha256
from ..run.replaying import depth_difference_text
from ..run.run import BlockChoice, Run
from ..sources.frame_ref import FrameRef
from ..sources.listing import list_frames
from ..sources.opening import is_recording
from ..sources.reading import read_frame
from .output import Column, completed, fact_lines, parameters_text, print_json, shows_progress, table, warn
from .parsing import add_export_options, add_reading, add_shared, export_options, geometry_flags, reading_options
from .usage import Parser, UsageError, add_action, check_there, declare

# Facts about the frames of a project, without opening them.

_OF_RUN = (
    "number", "name", "how", "done", "seconds", "note", "ground_truth_error", "hold_out_error", "expected_error",
)  # fmt: skip


FrameFacts = dict[str, Any]
"""Facts about a frame, as `ilf project info --json` prints them."""


def frame_facts(opened: OpenedProject, frame: ProjectFrame) -> FrameFacts:
    """Collect the facts about a frame; reads all its parts and files, and checks their hashes.

    Returns
    -------
    dict
        Id, name, the fields of its summary, and has_state; bytes of its own part and of the arrays that it refers to;
        sources: path of each of its files -> "embedded", "present", "changed", "missing", or "not allowed" if it may
        lie where nothing is opened unasked; runs: number, name, how, done, seconds, note and errors of each run of the
        history, as in `StoredRun`; problems: why the work on it cannot be read.
    """
    facts: FrameFacts = {
        "id": frame.id,
        "name": frame.name,
        **dataclasses.asdict(frame.summary),
        "has_state": frame.has_state,
        "bytes": 0,
        "sources": {file.path: _how_found(file, opened) for file in _wanted_files(frame, opened.parts)},
        "runs": (),
        "problems": (),
    }
    if not frame.has_state:
        return facts
    try:
        content = opened.parts.read(frame_part(frame.id))
        head = read_head(content)
        kinds = stored_fields(StoredRun)
        runs = tuple({name: from_plain(run[name], kinds[name], {}) for name in _OF_RUN} for run in head.state["runs"])
        size = len(content)
        for name in head.parts:
            part = opened.parts.read(name)
            check_content(name, part)
            size += len(part)
    except UNREADABLE as error:
        return facts | {"problems": (f"The work on this frame cannot be read: {error}",)}
    return facts | {"bytes": size, "runs": runs}


def _how_found(wanted: InputFile, opened: OpenedProject) -> str:
    """Return how a file is there, as in the sources of `frame_facts`."""
    if embedded(wanted, opened.parts) is not None:
        return "embedded"
    same, other = located(wanted, opened.places)
    if same is not None or other is not None:
        return "changed" if same is None else "present"
    try:
        opened.places.check(wanted)
    except InputError:
        return "not allowed"
    return "missing"


def _wanted_files(frame: ProjectFrame, parts: Parts) -> list[InputFile]:
    """List the files of a frame from its state, or else from its source, without their SHA-256."""
    if frame.has_state:
        with suppress(*UNREADABLE):  # else from the source
            return list(read_head(parts.read(frame_part(frame.id))).files)
    return [] if frame.source is None else [InputFile(path, "") for path in frame.source.paths]


def differences(state: FrameState, completion: Completion) -> tuple[str, ...]:
    """Compare a new completion with the stored results; empty if they are identical bit for bit.

    Parameters
    ----------
    state : FrameState
    completion : Completion
        Of `state.present_run()`.

    Returns
    -------
    tuple of str
        The differences, one sentence each.

    Examples
    --------
    >>> import ilf
    >>> import numpy as np
    >>> depth = np.full((20, 30), 2.0)
    >>> depth[8:12, 10:20] = np.nan
    >>> completion = ilf.complete(ilf.RGBDFrame(np.zeros((20, 30, 3), np.uint8), depth))
    >>> from ilf.data.blocks import Blocks
    >>> state = FrameState("a1", completion.frame, Blocks(completion.blocks), results=completion.results)
    >>> differences(state, completion)
    ()
    """
    stored = state.present_completion()
    sentences = []
    if array_sha256(stored.depth) != array_sha256(completion.depth):
        sentences.append(f"{depth_difference_text(completion.depth, stored.depth)}.")
    others = [label for label, outcome in stored.outcomes.items() if completion.outcomes.get(label) != outcome]
    if others:
        blocks = ", ".join(map(str, others[:10])) + (", ..." if len(others) > 10 else "")
        sentences.append(f"Iterations or status differ from the stored ones: block{'s' * (len(others) > 1)} {blocks}.")
    return tuple(sentences)


# Output of `ilf project info`: as text, and as JSON.

_PROBLEMS = {
    "missing": "is missing",
    "changed": "has changed",
    "not allowed": "lies outside the project's folder and was never opened here; allow it by --allow-address",
}
"""State of a frame's file -> what is told about it."""


def print_facts(opened: OpenedProject, facts: Sequence[FrameFacts]) -> None:
    """Print the facts about a project and its frames."""
    project, path = opened.project, opened.path
    stages = Counter(frame.summary.stage for frame in project.frames)
    to_text = ", ".join(f"{stages[stage]} {stage}" for stage in Stage if stages[stage])
    scope = "for all frames:" if project.for_all else "per frame; defaults of the next frame:"
    lines = [
        ("project", f"{path}, {path.stat().st_size / 1e6:.1f} MB in {counted(len(opened.parts.names()), 'part')}"),
        ("frames", f"{len(facts)}" + (f": {to_text}" if to_text else "")),
        ("parameters", f"{scope} {parameters_text(project.common)}"),
        ("files", "embedded" if opened.embedded else "not embedded"),
    ]
    problems = [*opened.problems]
    for fact in facts:
        problems += [f"{fact['name']}: {problem}" for problem in fact["problems"]]
        found = fact["sources"].items()
        problems += [f"{fact['name']}: {file} {_PROBLEMS[how]}." for file, how in found if how in _PROBLEMS]
    print(*fact_lines([*lines, *(("problem", problem) for problem in problems)]), sep="\n")
    if facts:
        print("", *table(_FRAMES, facts), sep="\n")
    for fact in facts:
        if fact["runs"]:
            print(f"\nRuns of {fact['name']}:")
            print(*table(_RUNS, fact["runs"]), sep="\n")


def _size(fact: FrameFacts) -> str | None:
    shape = fact["shape"]
    return None if shape is None else f"{shape[1]} x {shape[0]}"


def _files(fact: FrameFacts) -> str:
    how = Counter(fact["sources"].values())
    return ", ".join(f"{count} {state}" for state, count in how.items()) or "in the project"


def _mm(metres: float | None) -> float | None:
    return None if metres is None else 1000 * metres


_FRAMES = (
    Column("frame", itemgetter("name")),
    Column("id", itemgetter("id")),
    Column("stage", itemgetter("stage")),
    Column("size", _size),
    Column("missing", itemgetter("missing"), ".1%"),
    Column("blocks", itemgetter("blocks")),
    Column("completed", itemgetter("completed")),
    Column("runs", lambda fact: len(fact["runs"])),
    Column("kB", lambda fact: fact["bytes"] / 1000, ".0f"),
    Column("files", _files),
)

_RUNS = (
    Column("run", itemgetter("number")),
    Column("name", lambda run: one_line(run["name"])),
    Column("end", itemgetter("how")),
    Column("blocks", lambda run: len(run["done"])),
    Column("time [s]", itemgetter("seconds"), ".1f"),
    Column("ground truth [mm]", lambda run: _mm(run["ground_truth_error"]), ".2f"),
    Column("hold-out [mm]", lambda run: _mm(run["hold_out_error"]), ".2f"),
    Column(f"{RMS_NAME} [mm]", lambda run: _mm(run["expected_error"]), ".2f"),
    Column("note", lambda run: one_line(run["note"]) or None),
)


def facts_as_json(opened: OpenedProject, facts: Sequence[FrameFacts]) -> Any:
    """Return the facts about a project and its frames for JSON."""
    return {
        "path": str(opened.path),
        "bytes": opened.path.stat().st_size,
        "parts": len(opened.parts.names()),
        "embedded": opened.embedded,
        "problems": opened.problems,
        "present": opened.project.present,
        "for_all": opened.project.for_all,
        "parameters": opened.project.common.to_dict(),
        "frames": facts,
    }


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.description = (
        "Make, show, export and replay project files (.ilf), which contain frames with all edits and results."
    )
    actions = parser.add_subparsers(title="actions", metavar="ACTION", required=True)

    making = add_action(
        actions,
        "new",
        run_new,
        "make a project from frames, without edits and results",
        usage="ilf project new FILE.ilf (FOLDER... | RGB DEPTH) [options]",
    )
    declared = """
        FILE.ilf   output file, which must not exist
        FRAME ...  folder of a frame or of frames, or a colour file and a depth file
        --embed    embed the frames' files in the project
    """
    declare(making, declared)
    add_reading(making.add_argument_group("reading the frames"))

    telling = add_action(actions, "info", run_info, "show the contents of a project and its problems")
    _add_project(telling)
    add_shared(telling, "--json")

    text = "write the stored results of frames, as `ilf complete` writes them, or a data set of another program"
    usage = "ilf project export (FILE.ilf | RESULT... --to FORMAT) --out DIR [options]"
    exporting = add_action(actions, "export", run_export, text, usage=usage)
    _add_project(exporting)
    contents = "; ".join(f"{name}: {what}" for name, (_, what) in DATA_SETS.items())
    declared = f"""
        [RESULT ...]  with --to: output folders of `ilf complete`, folders of such folders, or of shards
        --out DIR     required: output folder with one folder per frame; existing files are overwritten, unchanged
            frames skipped. With --to, a new or empty folder
        --to {"|".join(DATA_SETS)}  write a data set of the results of `ilf complete` or `ilf batch`, with the poses of
            the frames' source. {contents}
        --complete  export all frames: those with blocks without a result are completed first, untouched ones with
            their extracted blocks
    """
    declare(exporting, declared)
    _add_selection(exporting)
    add_export_options(exporting.add_argument_group("files"))

    again = add_action(actions, "replay", run_replay, "replay runs and compare them with the stored results")
    _add_project(again)
    _add_selection(again)
    add_shared(again, "--progress")


def _add_project(parser: argparse.ArgumentParser) -> None:
    declare(parser, "FILE.ilf  the project")
    add_shared(parser, "--look-in", "--allow-address")


def _add_selection(parser: argparse.ArgumentParser) -> None:
    declare(parser, "--frame NAME_OR_ID ...  only this frame; can be repeated (default: all with results)")


def run_new(arguments: argparse.Namespace) -> None:
    """Make a project."""
    check_there(arguments.frames)
    path = Path(arguments.file)
    if path.suffix.lower() != SUFFIX:
        raise UsageError(f"The name of a project file must end in {SUFFIX}, not {path.name!r}.")
    if os.path.exists(path):
        raise InputError(f"{path} already exists. Choose another name, or delete it first.")
    sources = list(_sources(arguments))
    frames = tuple(ProjectFrame(secrets.token_hex(8), source.name, source) for source in sources)
    warn(save_project(path, Project(frames), embed=True if arguments.embed else None))
    print(f"Written to {path}: {counted(len(frames), 'frame')}.")


def run_info(arguments: argparse.Namespace) -> None:
    """Show the contents of a project."""
    with _opened(arguments) as opened:
        facts = [frame_facts(opened, frame) for frame in opened.project.frames]
        if arguments.json:
            print_json(facts_as_json(opened, facts))
        else:
            print_facts(opened, facts)


def run_export(arguments: argparse.Namespace) -> None:
    """Write the results of a project's frames; with --complete, of all frames, whose missing results are computed
    first. With --to, write a data set of results."""
    if arguments.to is not None:
        _export_data_set(arguments)
        return
    if arguments.results:
        raise UsageError("Give one project, or the format of a data set by --to.")
    options, counts = export_options(arguments), Counter[ExportStatus]()
    with _opened(arguments) as opened:
        if arguments.complete:
            warn(opened.problems)
            frames = _wanted(opened, arguments.frame)
        else:
            frames = [frame for frame, _ in _with_results(opened, arguments.frame)]
        found = in_folders((one.name, one.id, partial(_run_of, opened, one, arguments.complete)) for one in frames)
        strict = bool(geometry_flags(arguments))
        for done in export_frames(found, Path(arguments.out), options, strict=strict):
            counts[done.status] += 1
            warn(f"{done.name}: {note}" for note in done.notes)
            print(f"{done.name}: {done.status}, {done.folder}")
    if failed := counts[ExportStatus.FAILED]:
        raise InputError(f"{failed} of {counted(counts.total(), 'frame')} could not be exported.")


def _export_data_set(arguments: argparse.Namespace) -> None:
    """Write results of `ilf complete` or `ilf batch` as a data set of another program."""
    if also := [flag for name, flag in arguments.given.items() if name not in ("out", "to", "allow_address")]:
        raise UsageError(f"With --to, results are written as they are: leave out {', '.join(also)}.")
    results = [arguments.file, *arguments.results]
    if any(Path(path).suffix.lower() == SUFFIX for path in results):
        raise UsageError("--to takes results, not a project: export it without --to first, then its output folder.")
    written = write_data_set(arguments.out, results, arguments.to)
    warn(written.notes)
    print(f"Written to {arguments.out}: {counted(len(written.files), 'file')}.")


def _run_of(opened: OpenedProject, frame: ProjectFrame, complete: bool) -> tuple[Run, Completion | None]:
    """A frame's run and its completion, None if it has to be completed first; otherwise its present results."""
    if not frame.has_state and frame.source is not None:
        loaded = read_frame(frame.source)
        return BlockChoice(opened.project.extraction).run_of(loaded, opened.project.common), None
    state = opened.state(frame.id).state
    return run_and_completion(state) if complete else (state.present_run(), state.present_completion())


def run_replay(arguments: argparse.Namespace) -> None:
    """Replay frames and compare the results."""
    other, count = [], 0
    shown = shows_progress(arguments)
    with _opened(arguments) as opened:
        for frame, state in _with_results(opened, arguments.frame):
            sentences = differences(state, completed(state.present_run(), shown=shown))
            count += 1
            if sentences:
                other.append(frame.name)
            print(f"{frame.name}: {' '.join(sentences) or 'identical to the stored result, bit for bit.'}")
    if other:
        raise InputError(f"{len(other)} of {counted(count, 'frame')} differ from what is stored: {', '.join(other)}.")


def _sources(arguments: argparse.Namespace) -> Iterator[FrameRef]:
    """Yield the frames that the arguments name."""
    inputs, how = arguments.frames, reading_options(arguments)
    if all(os.path.isdir(path) or is_recording(path) for path in inputs):
        for path in inputs:
            listing = list_frames(path, how)
            warn(listing.notes)
            yield from listing.sources
        return
    if len(inputs) != 2 or any(os.path.isdir(path) for path in inputs):
        raise UsageError("Give folders and recordings, or the colour and the depth file of one frame.")
    rgb, depth = (str(Path(path).absolute()) for path in inputs)
    source = FrameRef(rgb, depth, options=how)
    warn(read_frame(source).notes)  # reports a wrong file now
    yield source


def _opened(arguments: argparse.Namespace) -> OpenedProject:
    opened = open_project(arguments.file)
    return replace(opened, places=replace(opened.places, folders=tuple(map(Path, arguments.look_in))))


def _with_results(opened: OpenedProject, chosen: Sequence[str]) -> Iterator[tuple[ProjectFrame, FrameState]]:
    """Yield the selected frames, or all, with their states; print a warning for each frame without results."""
    warn(opened.problems)
    wanted = _wanted(opened, chosen)
    found = False
    for frame in wanted:
        if not (frame.has_state or chosen):
            continue
        try:
            decoded = opened.state(frame.id)
        except UnreadableFrame as error:
            warn([f"{frame.name}: {error}"])
            continue
        warn(f"{frame.name}: {problem}" for problem in decoded.problems)
        if decoded.state.results:
            found = True
            yield frame, decoded.state
        else:
            warn([f"{frame.name} has no results."])
    if not found:
        raise InputError("No frame has results. Run the blocks of a frame and save the project first.")


def _wanted(opened: OpenedProject, chosen: Sequence[str]) -> list[ProjectFrame]:
    """The selected frames, or all."""
    frames = opened.project.frames
    for name in chosen:
        if not any(name in (frame.id, frame.name) for frame in frames):
            raise InputError(f"The project has no frame {name!r:.60}. `ilf project info` lists its frames.")
    return [frame for frame in frames if not chosen or frame.id in chosen or frame.name in chosen]
