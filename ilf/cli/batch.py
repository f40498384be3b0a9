"""`ilf batch`: complete many frames, one folder each, in several processes or on several machines; resumable."""

from __future__ import annotations

import argparse
import os
import re
import sys
import time
from collections.abc import Iterable, Sequence
from contextlib import closing
from dataclasses import astuple, replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from .._runtime.formatting import counted, millimetres
from .._runtime.termination import extended_time_limit
from ..batch.batch import MANIFEST_COLUMNS, Batch, open_batch
from ..batch.frame_record import FrameOutcome, FrameStatus
from ..batch.frames import BatchFrame, frames_of_sources, shard_of, slice_frames, with_companion_files
from ..batch.pictures import write_contact_sheet, write_video
from ..batch.settings import BatchSettings
from ..batch.shards import ShardCounts
from ..completion.confidence.expected_error import MEDIAN_NAME
from ..errors import IlfError
from ..io.depth_reading import unique_warnings
from ..io.frame_additions import guide_network
from ..sources.source import Source
from .options import add_export_options, export_options
from .output import FramesBar, print_json, shows_progress, warn
from .parsing import (
    add_flags,
    add_given_blocks,
    add_pairing,
    add_reading,
    add_settings,
    checked_neighbours,
    hold_out_from,
    preset_from,
    reading_options,
    settings_from,
)
from .shards import add_shard_arguments, check_or_merge, check_shard_arguments, run_shards, summary
from .usage import Parser, UsageError, add_json, add_progress, count

_USAGE = """ilf batch SOURCE... --out DIR [options]
       ilf batch SOURCE... --out DIR [--jobs 4] [--shard 3/40]
       ilf batch SOURCE... --out DIR --dask ADDRESS
       ilf batch [SOURCE...] --shards DIR [--dask ADDRESS] [--verify] [--merge]"""

_STATIC_RADIUS = 3
"""Default number of frames before and after each for --static-camera."""

_SHUTDOWN_S = 30.0
"""Time to shut down [s]: end the processes and write the manifest of all completed frames."""

_MAX_LISTED = 5
"""Maximum number of failed frames listed on the terminal; the manifest lists all."""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = _USAGE
    parser.description = (
        "Complete the frames of folders, data sets and recordings, each into its own folder, and write manifest.csv "
        "with the result of each. The same command resumes an interrupted batch."
    )
    parser.set_defaults(command=run)
    parser.add_argument("sources", nargs="*", metavar="SOURCE", help="folder of frames, data set or recording")
    parser.add_argument("--out", metavar="DIR", help="output folder, created if missing")
    add_shard_arguments(parser.add_argument_group("shards: many frames in a file"))
    frames = parser.add_argument_group("selection of frames")
    frames.add_argument("--every", type=count, default=1, metavar="N", help="complete every N-th frame only")
    frames.add_argument(
        "--frames",
        type=_range,
        default=(None, None),
        metavar="A:B",
        help="complete frames A to before B, counted from 0; A or B may be left out, negative numbers count from the "
        "end",
    )
    add_pairing(frames)
    _add_sharing(parser.add_argument_group("parallel and distributed work"))
    again = parser.add_argument_group("resuming")
    again.add_argument("--retry-failed", action="store_true", help="also retry failed frames")
    again.add_argument(
        "--rerun-changed",
        action="store_true",
        help="also rerun frames whose settings or files have changed since",
    )
    add_reading(parser.add_argument_group("reading the frames"))
    add_flags(parser, "--strict", "--invalid-mask")
    parser.add_argument(
        "--static-camera",
        type=count,
        nargs="?",
        const=_STATIC_RADIUS,
        default=0,
        metavar="N",
        help="for a static camera: fuse the depth of N frames before and after each one where colour is unchanged "
        f"(default: {_STATIC_RADIUS} if N is left out)",
    )
    add_flags(parser, "--neighbours", "--neighbour-step")
    beside = parser.add_argument_group("guides and ground truth: folders with one file per frame, named as the frame")
    beside.add_argument(
        "--guide",
        metavar="DIR",
        help="depth or inverse depth from another source, or an ONNX network that predicts it (default: guide.* of a "
        "frame)",
    )
    beside.add_argument(
        "--ground-truth", metavar="DIR", help="depth to evaluate the results against (default: gt.* of a frame)"
    )
    beside.add_argument("--ground-truth-units", type=float, metavar="N", help="units per metre of the ground truth")
    add_given_blocks(parser, "--blocks")
    add_flags(parser, "--drawn", "--hold-out", "--seeds")
    output = parser.add_argument_group("output")
    add_export_options(output)
    add_flags(output, "--extrapolate")
    output.add_argument(
        "--contact-sheet", action="store_true", help="write contact-sheet.png, all previews with their names"
    )
    output.add_argument("--video", action="store_true", help="write video.mp4, all previews in sequence")
    add_json(
        output,
        "folder, files, completed, failed, completed_before, failed_before, not_done (frames), seconds and frames. "
        f"frames: {', '.join(MANIFEST_COLUMNS)}, as in manifest.csv. With --shards: folder, shards, before, "
        "failed_before, completed, failed, total, left (frames) and seconds; with --verify or --merge: folder, shards, "
        "finished, frames, completed, failed, problems",
    )
    add_progress(output)
    add_flags(output, "--quiet")
    add_settings(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    if arguments.dask is not None and (arguments.jobs is not None or arguments.shard is not None):
        raise UsageError("--dask distributes the work itself: leave out --jobs and --shard.")
    check_shard_arguments(arguments)
    if arguments.verify or arguments.merge:
        check_or_merge(arguments)
        return
    if not arguments.sources or (arguments.out is None and arguments.shards is None):
        raise UsageError("Give a SOURCE, and an output folder by --out or --shards.")
    settings = _settings(arguments)
    if arguments.shards is not None:
        run_shards(arguments, settings, partial(_frames, arguments))
        return
    frames = _frames(arguments)
    only = frames if arguments.shard is None else shard_of(frames, *arguments.shard)
    batch = open_batch(
        frames,
        arguments.out,
        settings,
        only=only,
        anew=arguments.rerun_changed,
        retry_failed=arguments.retry_failed,
        strict=arguments.strict,
    )
    started = time.perf_counter()
    done: list[FrameOutcome] = []
    text = not (arguments.quiet or arguments.json)
    with extended_time_limit(_SHUTDOWN_S):
        try:
            _complete(batch, arguments, done)
        finally:
            all_of_them = batch.write_manifest()
            if text:
                print("\n".join(_summary(batch, done, time.perf_counter() - started)), flush=True)
    shown = [path.name for path in _pictures(arguments, batch, all_of_them)]
    if arguments.json:
        seconds = time.perf_counter() - started
        print_json(_record(batch, all_of_them, done, seconds) | {"files": ["manifest.csv", *shown]})
    elif text:
        print(f"Written to {arguments.out}: {', '.join(['manifest.csv', *shown])}, and a folder for each frame.")
    failed = [*batch.failed, *(outcome for outcome in done if outcome.status is FrameStatus.FAILED)]
    if arguments.strict:  # including frames completed before
        failed += [
            replace(outcome, message=outcome.plausibility_warnings)
            for outcome in batch.finished
            if outcome.plausibility_warnings
        ]
    if failed:
        raise IlfError(_failures(failed, len(only)))


def _add_sharing(group: argparse._ArgumentGroup) -> None:
    group.add_argument("--jobs", type=count, metavar="N", help="number of processes on this machine (default: 1)")
    group.add_argument(
        "--shard",
        type=_shard,
        metavar="K/N",
        help="complete only the K-th of N parts of the frames, while other machines complete the other parts into the "
        "same folder; with --shards, of the shards",
    )
    group.add_argument(
        "--dask",
        metavar="ADDRESS",
        help="run on a Dask cluster, frame by frame, or shard by shard with --shards: address of the scheduler, or its "
        "scheduler file. A scheduler can run any code here and on its workers: use only one that you trust",
    )


def _settings(arguments: argparse.Namespace) -> BatchSettings:
    hidden = hold_out_from(arguments)
    parameters, blocks = settings_from(arguments, preset_from(arguments.preset))
    neighbours, step = checked_neighbours(arguments)
    if neighbours and arguments.static_camera:
        raise UsageError("--static-camera already fuses the depth of frames around each one: leave out --neighbours.")
    return BatchSettings(
        parameters,
        blocks,
        arguments.extrapolate,
        export_options(arguments),
        hidden,
        _absolute(arguments.invalid_mask),
        steady=arguments.static_camera,
        neighbours=neighbours,
        neighbour_step=step,
    )


def _frames(arguments: argparse.Namespace) -> list[BatchFrame]:
    sources = [Source(path, reading_options(arguments)) for path in arguments.sources]
    warn(note for source in sources for note in source.notes)
    first, end = arguments.frames
    neighbours, step = checked_neighbours(arguments)
    frames = slice_frames(
        frames_of_sources(
            sources,
            arguments.out or arguments.shards,
            reach=neighbours * step or arguments.static_camera,
            neighbour_step=step if neighbours else 0,
        ),
        first=first,
        end=end,
        every=arguments.every,
    )
    for kind, folder in (("guide", arguments.guide), ("ground_truth", arguments.ground_truth)):
        if kind == "guide" and folder is not None and not os.path.isdir(folder) and guide_network(folder):
            path = str(Path(folder).absolute())
            frames = [replace(frame, source=frame.source.with_options(**{kind: path})) for frame in frames]
        elif folder is not None:
            frames = with_companion_files(frames, kind, folder)
    if arguments.ground_truth_units is None:
        return frames
    return [
        replace(frame, source=frame.source.with_options(ground_truth_units=arguments.ground_truth_units))
        for frame in frames
    ]


def _complete(batch: Batch, arguments: argparse.Namespace, done: list[FrameOutcome]) -> None:
    """Complete the frames, with a progress bar, and add their outcomes to `done`."""
    shown = shows_progress(arguments)
    there = len(batch.finished) + len(batch.failed)
    plausibility_warnings = set[str]()
    _report_plausibility(batch.finished, plausibility_warnings)
    with (
        FramesBar(there + len(batch.to_do), there, len(batch.failed), shown=shown) as bar,
        closing(batch.outcomes(jobs=arguments.jobs or 1, cluster=arguments.dask)) as outcomes,
    ):
        for outcome in outcomes:
            done.append(outcome)
            with FramesBar.external_write_mode(sys.stderr):
                _report_plausibility([outcome], plausibility_warnings)
            bar.add(completed=outcome.status is FrameStatus.COMPLETED)


def _report_plausibility(outcomes: Iterable[FrameOutcome], known: set[str]) -> None:
    """Print plausibility warnings, each once with the first frame that it concerns."""
    for outcome in outcomes:
        if outcome.plausibility_warnings:
            warn(f"{outcome.frame}: {text}" for text in unique_warnings([outcome.plausibility_warnings], known))


def _summary(batch: Batch, done: Sequence[FrameOutcome], seconds: float) -> list[str]:
    completed = [outcome for outcome in done if outcome.status is FrameStatus.COMPLETED]
    before, failed_before = len(batch.finished), len(batch.failed)
    total = len(batch.to_do) + before + failed_before
    lines = summary(ShardCounts(before, failed_before, len(completed), len(done) - len(completed), total), seconds)
    pixels = sum(outcome.pixels or 0 for outcome in completed)
    if pixels:
        missing, after, outside = (
            sum(getattr(outcome, name) or 0 for outcome in completed) / pixels
            for name in ("missing_before", "missing_after", "outside_view")
        )
        lines.append(f"Missing depth: {missing:.1%} of the pixels before, {after:.1%} after.")
        if outside:
            lines.append(f"Another {outside:.1%} lie outside the depth camera's view.")
    if implausible := [outcome for outcome in (*batch.finished, *completed) if outcome.plausibility_warnings]:
        lines.append(
            f"{counted(len(implausible), 'frame')} with plausibility warnings, listed in manifest.csv (column doubts). "
            "With --strict such frames fail."
        )
    if errors := [error for outcome in completed if (error := outcome.expected_error_median) is not None]:
        lines.append(f"{MEDIAN_NAME}: {millimetres(median(errors))} mm in the median frame.")
    return lines


def _record(
    batch: Batch, frames: Sequence[FrameOutcome], done: Sequence[FrameOutcome], seconds: float
) -> dict[str, Any]:
    """Describe the batch for JSON, with all frames of the manifest."""
    completed = sum(outcome.status is FrameStatus.COMPLETED for outcome in done)
    return {
        "folder": str(batch.folder),
        "completed": completed,
        "failed": len(done) - completed,
        "completed_before": len(batch.finished),
        "failed_before": len(batch.failed),
        "not_done": len(batch.to_do) - len(done),
        "seconds": seconds,
        "frames": [dict(zip(MANIFEST_COLUMNS, astuple(outcome), strict=True)) for outcome in frames],
    }


def _pictures(arguments: argparse.Namespace, batch: Batch, outcomes: Sequence[FrameOutcome]) -> list[Path]:
    wanted = [write_contact_sheet] * arguments.contact_sheet + [write_video] * arguments.video
    return [write(batch.folder, outcomes) for write in wanted]


def _failures(failed: Sequence[FrameOutcome], of: int) -> str:
    named = "; ".join(f"{outcome.frame}: {outcome.message}" for outcome in failed[:_MAX_LISTED])
    more = f" And {len(failed) - _MAX_LISTED} more, listed in manifest.csv." if len(failed) > _MAX_LISTED else ""
    return f"{len(failed)} of {counted(of, 'frame')} failed. {named}{more} Retry them with --retry-failed."


def _range(text: str) -> tuple[int | None, int | None]:
    match = re.fullmatch(r"(-?\d+)?:(-?\d+)?", text)
    if match is None:
        raise argparse.ArgumentTypeError(f"{text!r} is not a range of frames, such as 100:200, :50 or -10:")
    first, end = (None if number is None else int(number) for number in match.groups())
    return first, end


def _shard(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)/(\d+)", text)
    if match is None or not 1 <= int(match[1]) <= int(match[2]):
        raise argparse.ArgumentTypeError(f"{text!r} is not a part K/N, such as 3/40")
    return int(match[1]), int(match[2])


def _absolute(path: str | None) -> str | None:
    """Make a path absolute, since workers may have another working directory."""
    return None if path is None else str(Path(path).absolute())
