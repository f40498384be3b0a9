"""`ilf complete`: complete the depth of a frame; write depth, blocks, curves, point cloud and run record."""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, replace
from pathlib import Path

from ..data.by_hand import USUAL_WEIGHT
from ..data.parameters import DEFAULT_PRESET, PRESETS, Parameters
from ..run.block_choice import BlockChoice
from ..run.exporters import Export
from ..run.options import ExportOptions, output_folder_name
from ..run.replaying import Replay, replay
from ..run.run import Run
from ..run.writing import check_not_an_input, check_write, write
from ..sources.frame_folder import frame_folder
from ..sources.opening import is_recording
from .options import (
    add_export_options,
    add_given_blocks,
    check_given_blocks,
    export_options,
    feasible_options,
    geometry_flags,
)
from .output import print_json, shows_progress, warn
from .parsing import (
    add_block_parameters,
    add_borders,
    add_by_hand,
    add_companions,
    add_frame,
    add_invalid_mask,
    add_neighbours,
    add_parameters,
    add_preset,
    add_strict,
    frame_from,
    parameter_flags,
    preset_from,
    reading_flags,
    with_given,
)
from .run_output import COMPLETION_KEYS, FinishedRun, completed, completion_record, completion_report
from .usage import Parser, UsageError, add_json, add_progress

_USAGE = """ilf complete RGB DEPTH [options]
       ilf complete FOLDER [options]
       ilf complete --replay run.json [RGB DEPTH] [options]"""


@dataclass(frozen=True, eq=False)
class _Job:
    """The job of the arguments: a new run or a replay."""

    run: Run
    options: ExportOptions
    notes: tuple[str, ...]
    again: Replay | None = None


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = _USAGE
    parser.description = "Extract the blocks of a frame, complete their depth, and write the results."
    parser.epilog = f"The JSON document contains {COMPLETION_KEYS}. Unknown numbers are null."
    parser.set_defaults(command=run)
    add_frame(parser)
    add_strict(parser, "complete nothing")
    add_invalid_mask(parser)
    add_companions(parser)
    add_neighbours(parser)
    add_preset(parser)
    add_given_blocks(parser, "--blocks")
    add_borders(parser)
    add_by_hand(parser)
    parser.add_argument("--replay", metavar="run.json", help="replay a recorded run with the record's settings")
    output = parser.add_argument_group("output")
    output.add_argument(
        "--out",
        metavar="DIR",
        help="output folder (default: NAME-ilf). It is created if missing; existing files are overwritten",
    )
    add_export_options(output)
    output.add_argument(
        "--export",
        metavar="FILE",
        action="append",
        default=[],
        help="also write a file of another program, in the format of its extension: .rrd, and those of plugins",
    )
    output.add_argument(
        "--rerun",
        metavar="FILE.rrd",
        dest="export",
        action="append",
        help="as --export: a file of the viewer Rerun with images, blocks and curves; needs the package rerun-sdk",
    )
    output.add_argument(
        "--extrapolate",
        action="store_true",
        help="extrapolate the depth that is still missing after the run, and write its mask extrapolated.png",
    )
    add_json(output)
    add_progress(output)
    output.add_argument("--quiet", action="store_true", help="print only warnings and errors")
    add_parameters(parser, Parameters, "filter", presets=PRESETS, default=DEFAULT_PRESET)
    add_block_parameters(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    job = _new_job(arguments) if arguments.replay is None else _recorded_job(arguments)
    folder = Path(arguments.out or output_folder_name(job.run.frame.name))
    names = "blocks", "borders", "invalid_mask", "depth_by_hand", "intrinsics", "preset"
    given = [path for name in names if (path := getattr(arguments, name)) is not None]
    check_write(folder, job.run, job.options, given=given)
    exports = [Export(path) for path in arguments.export]
    check_not_an_input(job.run.frame, [export.path for export in exports], given)
    started = time.perf_counter()
    completion = completed(job.run, shown=shows_progress(arguments))
    seconds = time.perf_counter() - started
    verdict = () if job.again is None else job.again.verdict(completion)
    written = write(folder, job.run, completion, job.options)
    notes = [*job.notes, *job.run.blocks.notes, *completion.notes, *verdict, *written.notes, *written.remarks]
    warn(notes)
    for export in exports:
        export.write(completion)
    finished = FinishedRun(job.run, completion, seconds, folder, written.files, [export.path for export in exports])
    if arguments.json:
        print_json(completion_record(finished, notes))
    elif not arguments.quiet:
        print(completion_report(finished))
        if job.again is not None and not verdict:
            print("The result is identical to the recorded one.")


def _new_job(arguments: argparse.Namespace) -> _Job:
    if arguments.by_hand_weight is not None and arguments.depth_by_hand is None:
        raise UsageError("--by-hand-weight is the weight of --depth-by-hand: give that, too.")
    chosen = preset_from(arguments.preset)
    options = export_options(arguments)
    parameters = with_given(chosen.parameters, arguments)
    blocks = BlockChoice(
        check_given_blocks(arguments, "--blocks", chosen.extraction),
        arguments.blocks,
        arguments.fill_gaps,
        arguments.borders,
        arguments.depth_by_hand,
        USUAL_WEIGHT if arguments.by_hand_weight is None else arguments.by_hand_weight,
    )
    frame = frame_from(arguments)
    run = Run(frame, blocks.blocks_of(frame), parameters, extrapolate=arguments.extrapolate)
    options, missing = feasible_options(options, frame, arguments, ": give --intrinsics for one")
    return _Job(run, options, tuple(missing))


def _recorded_job(arguments: argparse.Namespace) -> _Job:
    also = [
        f"--{name.replace('_', '-')}"
        for name in (
            *(
                "frame",
                "neighbours",
                "neighbour_step",
                "preset",
                "blocks",
                "borders",
                "invalid_mask",
                "depth_by_hand",
                "by_hand_weight",
                "depth_formats",
                "png_units",
            ),
        )
        if getattr(arguments, name) is not None
    ]
    also += [*reading_flags(arguments), *geometry_flags(arguments)]
    also += ["--strict"] * arguments.strict
    also += ["--no-expected-error"] * arguments.no_expected_error + ["--extrapolate"] * arguments.extrapolate
    also += ["--fill-gaps"] * arguments.fill_gaps
    also += parameter_flags(arguments)
    if also:
        raise UsageError(
            f"With --replay, all settings but --no-cloud come from the record: leave out {', '.join(also)}."
        )
    again = replay(arguments.replay, *_present_files(arguments.inputs))
    options = replace(again.options, cloud=None) if arguments.no_cloud else again.options
    return _Job(again.run, options, again.differences, again)


def _present_files(inputs: list[str]) -> tuple[str | Path, ...]:
    """Return the given paths of a recorded run's colour and depth, or of its recording, if any."""
    if len(inputs) == 1 and is_recording(inputs[0]):
        return tuple(inputs)
    if len(inputs) == 1:
        files = frame_folder(inputs[0])
        return files.rgb, files.depth
    if len(inputs) not in {0, 2}:
        raise UsageError(f"Give the colour and the depth file of the recorded run, not {len(inputs)} paths.")
    return tuple(inputs)
