"""`ilf complete`: a frame in; completed depth, blocks, curves, point cloud and run record out."""

from __future__ import annotations

import argparse
import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..completion import CompletionRun, ParameterChoice, compose
from ..ebs import extract
from ..errors import InputError
from ..frame import RGBDFrame, doubtful_scale
from ..io import frame_folder, read_labels
from ..parameters import DEFAULT_PRESET, PRESETS, BlockParameters, Parameters
from ..run.export import (
    CLOUD_AXES,
    CLOUD_FILES,
    CLOUD_UNITS,
    DEPTH_FILES,
    ExportOptions,
    check_export,
    export,
    output_folder_name,
)
from ..run.record import RecordedInputs, RunRecord, make_run_record, outcome_to_dict, read_run_record
from ..run.replay import replay, version_differences
from .parsing import (
    BLOCK_PREFIX,
    Commands,
    UsageError,
    add_block_parameters,
    add_frame,
    add_parameters,
    frame_from,
    given_parameters,
    with_given,
)
from .progress import RunProgress
from .report import completion_report

_USAGE = """ilf complete RGB DEPTH [options]
       ilf complete FOLDER [options]
       ilf complete --replay run.json [RGB DEPTH] [options]"""


@dataclass(frozen=True, eq=False)
class _Job:
    """All that decides what is run and written."""

    frame: RGBDFrame
    labels: NDArray[np.int32]
    parameters: ParameterChoice
    only: set[int] | None
    extraction: BlockParameters | None
    edited: bool
    options: ExportOptions
    warnings: tuple[str, ...] = ()
    inputs: RecordedInputs | None = None
    record: RunRecord | None = None


def add_command(commands: Commands) -> None:
    """Add the command to the parser."""
    parser = commands.add_parser(
        "complete",
        help="complete the depth of a frame and write all results",
        usage=_USAGE,
        description="Extract the operation blocks of a frame, complete their depth, and write the results.",
        allow_abbrev=False,
    )
    parser.set_defaults(command=run)
    add_frame(parser)
    parser.add_argument(
        "--preset", choices=tuple(PRESETS), help=f"parameters to start from (default: {DEFAULT_PRESET})"
    )
    parser.add_argument("--labels", metavar="FILE.png", help="take the blocks from a label map, do not extract them")
    parser.add_argument("--replay", metavar="run.json", help="make a recorded run again; all else is in the record")
    output = parser.add_argument_group("output")
    output.add_argument(
        "--out",
        metavar="DIR",
        help="folder for the results, made if missing; files in it are overwritten (default: NAME-ilf here)",
    )
    output.add_argument(
        "--depth-formats", metavar="LIST", help=f"depth files, any of {','.join(DEPTH_FILES)} (default: png,npy)"
    )
    output.add_argument("--png-units", type=float, metavar="N", help="units per metre of depth.png (default: 1000)")
    output.add_argument(
        "--no-expected-error",
        action="store_true",
        help="write no expected_error files beside the depth files, in the same formats and units",
    )
    output.add_argument(
        "--dense",
        action="store_true",
        help="guess the depth that is still missing after the run, and write guessed.png, which shows where",
    )
    output.add_argument("--cloud-format", choices=tuple(CLOUD_FILES), help="format of the point cloud (default: ply)")
    output.add_argument("--axes", choices=CLOUD_AXES, help="axes of the point cloud (default: camera: x right, y down)")
    output.add_argument("--cloud-unit", choices=CLOUD_UNITS, help="unit of the point cloud (default: m)")
    output.add_argument("--no-cloud", action="store_true", help="write no point cloud")
    output.add_argument(
        "--progress",
        action=argparse.BooleanOptionalAction,
        help="progress bar on stderr (default: if that is a terminal)",
    )
    output.add_argument("--quiet", action="store_true", help="print nothing but warnings and errors")
    add_parameters(parser, Parameters, "filter", presets=PRESETS, default=DEFAULT_PRESET)
    add_block_parameters(parser)


def run(arguments: argparse.Namespace) -> None:
    """Carry the command out."""
    job = _recorded_job(arguments) if arguments.replay is not None else _new_job(arguments)
    frame, options = job.frame, job.options
    folder = Path(arguments.out or output_folder_name(frame.name))
    check_export(folder, frame, options)
    started = time.perf_counter()
    wanted = not arguments.quiet and (sys.stderr.isatty() if arguments.progress is None else arguments.progress)
    with (
        CompletionRun(frame, job.labels, job.parameters, job.only, extraction=job.extraction) as steps,
        RunProgress(steps, shown=wanted) as progress,
    ):
        for step in steps:
            progress.update(step)
    completion = compose(frame, steps.results)
    seconds = time.perf_counter() - started
    record = make_run_record(frame, job.labels, job.extraction, job.edited, completion, options, inputs=job.inputs)
    report = export(folder, frame, job.labels, completion, options, run_record=record)
    warnings = [*job.warnings, *completion.notes, *_outcome_warning(job.record, record), *report.warnings]
    for warning in dict.fromkeys(warnings):
        print("ilf: warning:", warning, file=sys.stderr)
    if not arguments.quiet:
        print(completion_report(frame, job.labels, completion, seconds, folder, report.files))


def _new_job(arguments: argparse.Namespace) -> _Job:
    parameters = with_given(PRESETS[arguments.preset or DEFAULT_PRESET], arguments)
    block_changes = given_parameters(arguments, BlockParameters)
    if arguments.labels is not None and block_changes:
        raise UsageError(f"With --labels nothing is extracted: leave out the --{BLOCK_PREFIX}* flags.")
    options = _options(arguments)
    frame = frame_from(arguments)
    extraction = None if arguments.labels is not None else with_given(BlockParameters(), arguments)
    if extraction is None:
        labels = read_labels(arguments.labels, frame.shape)
        notes: tuple[str, ...] = ()
        way_out = "It holds 0 only: give a label map with blocks."
    else:
        extracted = extract(frame, extraction)
        labels, notes = extracted.blocks, extracted.notes
        way_out = (
            f"Lower --{BLOCK_PREFIX}min-size or --{BLOCK_PREFIX}min-known-share, or draw blocks and give --labels."
        )
    if not labels.any():
        raise InputError(f"There are no blocks, so there is nothing to complete. {way_out}")
    doubt = doubtful_scale(frame.depth, float(str(frame.sources["depth_units"])))
    warnings = tuple(filter(None, (*notes, doubt)))
    if frame.intrinsics is None and options.cloud is not None and not _cloud_flags(arguments):
        options = replace(options, cloud=None)
        warnings += (
            "No point cloud is written, because the camera's intrinsics are not known: give --intrinsics for one.",
        )
    return _Job(frame, labels, parameters, None, extraction, extraction is None, options, warnings)


def _recorded_job(arguments: argparse.Namespace) -> _Job:
    also = [
        f"--{name.replace('_', '-')}"
        for name in ("preset", "labels", "depth_units", "intrinsics", "depth_formats", "png_units")
        if getattr(arguments, name) is not None
    ]
    also += _cloud_flags(arguments) + ["--no-cloud"] * arguments.no_cloud
    also += ["--no-expected-error"] * arguments.no_expected_error + ["--dense"] * arguments.dense
    for kind, prefix in ((Parameters, ""), (BlockParameters, BLOCK_PREFIX)):
        also += [f"--{prefix}{name.replace('_', '-')}" for name in given_parameters(arguments, kind)]
    if also:
        raise UsageError(f"--replay takes all from the record: leave out {', '.join(also)}.")
    record = read_run_record(arguments.replay)
    again = replay(record, Path(arguments.replay).absolute().parent, *_present_files(arguments.inputs))
    return _Job(
        again.frame, again.labels, again.parameters, set(again.parameters), again.extraction, again.edited,
        again.options, again.warnings, again.inputs, record,
    )  # fmt: skip


def _present_files(inputs: list[str]) -> tuple[str | Path, ...]:
    """Where a recorded run's colour and depth are now, if that is said."""
    if len(inputs) == 1:
        files = frame_folder(inputs[0])
        return files.rgb, files.depth
    if len(inputs) not in {0, 2}:
        raise UsageError(f"Give the colour and the depth file of the recorded run; these are {len(inputs)} paths.")
    return tuple(inputs)


def _options(arguments: argparse.Namespace) -> ExportOptions:
    if arguments.no_cloud and (flags := _cloud_flags(arguments)):
        raise UsageError(f"--no-cloud does not go together with {', '.join(flags)}.")
    defaults = ExportOptions()
    formats = arguments.depth_formats
    return ExportOptions(
        depth_formats=defaults.depth_formats if formats is None else tuple(filter(None, formats.split(","))),
        depth_units=defaults.depth_units if arguments.png_units is None else arguments.png_units,
        expected_error=not arguments.no_expected_error,
        dense=arguments.dense,
        cloud=None if arguments.no_cloud else arguments.cloud_format or defaults.cloud,
        axes=arguments.axes or defaults.axes,
        cloud_unit=arguments.cloud_unit or defaults.cloud_unit,
    )


def _cloud_flags(arguments: argparse.Namespace) -> list[str]:
    """The flags that ask for a point cloud."""
    names = ("cloud_format", "axes", "cloud_unit")
    return [f"--{name.replace('_', '-')}" for name in names if getattr(arguments, name) is not None]


def _outcome_warning(old: RunRecord | None, new: dict[str, object]) -> list[str]:
    """Say so where a replay did not come out as recorded."""
    if old is None or [outcome_to_dict(outcome) for outcome in old.outcomes] == new["blocks_outcome"]:
        return []
    versions = version_differences(old)
    return ["The blocks did not come out as recorded" + (f" by {versions}." if versions else ".")]
