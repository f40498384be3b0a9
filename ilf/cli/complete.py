"""`ilf complete`: complete the depth of a frame; write depth, blocks, curves, point cloud and run record."""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ..run.formats import Export
from ..run.options import ExportOptions, output_folder_name
from ..run.replaying import Replay, replay
from ..run.run import Run
from ..run.writing import check_not_an_input, check_write, drop_impossible_cloud, write
from ..sources.frame_folder import frame_folder
from ..sources.opening import is_recording
from . import parsing
from .output import completed, completion_record, completion_report, errors_of, print_json, shows_progress, warn
from .usage import Parser, UsageError, declare

_USAGE = """ilf complete RGB DEPTH [options]
       ilf complete FOLDER|RECORDING [--frame KEY] [options]
       ilf complete --replay run.json [RGB DEPTH] [options]"""

_WITH_REPLAY = {
    *("--replay", "--out", "--no-cloud", "--export", "--json", "--progress", "--no-progress", "--quiet"),
    *("--device", "--allow-address"),
}
"""The flags that a replay takes; all other settings are in the record."""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = _USAGE
    parser.description = "Extract the blocks of a frame, complete their depth, and write the results."
    declare(parser, "--replay run.json  replay a recorded run with the record's settings")
    parsing.add_frame(parser)
    measured = parser.add_argument_group("measured depth")
    parsing.add_shared(measured, "--strict", "--invalid-mask", "--neighbours", "--neighbour-step")
    blocks = parser.add_argument_group("blocks and depth by hand")
    parsing.add_given_blocks(blocks, "--blocks")
    parsing.add_shared(blocks, "--drawn", "--by-hand", "--by-hand-weight")
    output = parser.add_argument_group("output")
    out = "output folder (default: NAME-ilf). It is created if missing; existing files are overwritten"
    declare(output, f"--out DIR  {out}")
    parsing.add_shared(output, "--extrapolate")
    parsing.add_export_options(output)
    parsing.add_shared(output, "--json", "--progress", "--quiet")
    parsing.add_settings(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    again = None if arguments.replay is None else _recorded(arguments)
    if again is None:
        run, options, told = _new(arguments)
    else:
        run, told = again.run, again.differences
        options = replace(again.options, exports=(*again.options.exports, *parsing.given_exports(arguments)[0]))
        options = replace(options, **parsing.given_parameters(arguments, ExportOptions))
    folder = Path(arguments.out or output_folder_name(run.frame.name))
    names = "blocks", "drawn", "invalid_mask", "by_hand", "intrinsics", "preset"
    given = [path for name in names if (path := getattr(arguments, name)) is not None]
    check_write(folder, run, options, given=given)
    exports = [Export(path) for path in parsing.given_exports(arguments)[1]]
    for export in exports:
        export.check(run)
    check_not_an_input(run.frame, [export.path for export in exports], given)
    started = time.perf_counter()
    completion = completed(run, shown=shows_progress(arguments))
    seconds = time.perf_counter() - started
    verdict = () if again is None else again.verdict(completion)
    written = write(folder, completion, options)
    notes = [*told, *run.blocks.notes, *completion.notes, *verdict, *written.notes]
    warn(notes)
    for export in exports:
        warn(export.write(completion))
    if arguments.quiet and not arguments.json:
        return
    errors = errors_of(completion)
    record = completion_record(
        completion,
        errors,
        seconds,
        folder=str(folder),
        files=[path.name for path in written.files],
        exports=[str(export.path) for export in exports],
        warnings=list(dict.fromkeys(notes)),
    )
    if arguments.json:
        print_json(record)
    else:
        print(completion_report(completion, errors, record))
        if again is not None and not verdict:
            print("The result is identical to the recorded one.")


def _new(arguments: argparse.Namespace) -> tuple[Run, ExportOptions, Sequence[str]]:
    """Return the run of the arguments, what is written of it, and a note of a cloud that is not."""
    options = parsing.export_options(arguments, with_files=True)
    parameters, choice = parsing.settings_from(arguments, parsing.preset_from(arguments.preset))
    frame = parsing.frame_from(arguments)
    run = choice.run_of(frame, parameters, arguments.extrapolate)
    if parsing.geometry_flags(arguments):
        return run, options, ()
    return run, *drop_impossible_cloud(options, frame, ": give --intrinsics for one")


def _recorded(arguments: argparse.Namespace) -> Replay:
    """Return the recorded run that is replayed, with the files that are given or recorded."""
    if also := [flag for flag in arguments.given.values() if flag not in _WITH_REPLAY]:
        raise UsageError(f"With --replay, settings but --no-cloud are the record's: leave out {', '.join(also)}.")
    inputs = arguments.inputs
    if len(inputs) == 1 and not is_recording(inputs[0]):
        files = frame_folder(inputs[0])
        return replay(arguments.replay, files.rgb, files.depth)
    if len(inputs) > 2:
        raise UsageError(f"Give the colour and the depth file of the recorded run, not {len(inputs)} paths.")
    return replay(arguments.replay, *inputs)
