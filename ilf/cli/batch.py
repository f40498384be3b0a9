"""`ilf batch`: complete many frames, one folder each, in several processes or on several machines; resumable."""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections import Counter
from contextlib import closing
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from .._runtime.files import absolute
from .._runtime.folders import folder_at
from .._runtime.formatting import counted, millimetres
from .._runtime.termination import extended_time_limit
from ..batch.engine import Sink, complete_many
from ..batch.folder_sink import MANIFEST_FILE, FolderSink, open_folder
from ..batch.frame_record import FrameOutcome
from ..batch.frames import BatchFrame, ListFrames, frames_of_sources, shard_of, slice_frames, with_companion_files
from ..batch.pictures import write_contact_sheet, write_video
from ..batch.settings import BatchSettings
from ..batch.shard_files import check_shards, merge_tables
from ..batch.shard_sink import KEPT, ShardSink, open_shards
from ..completion.confidence.expected_error import MEDIAN_NAME
from ..errors import IlfError
from ..io.depth_doubts import unique_warnings
from ..io.frame_additions import guide_network
from ..io.guide_models import is_guide_name
from ..run.options import ExportOptions
from ..sources.shards import MERGED_FILE
from ..sources.source import Source
from . import parsing
from .output import Bar, print_json, shows_progress, warn
from .usage import VALUES, Parser, UsageError, declare, given_flags

_USAGE = """ilf batch SOURCE... --out DIR [options]
       ilf batch SOURCE... --out DIR [--jobs 4] [--shard 3/40]
       ilf batch SOURCE... --out DIR --dask ADDRESS
       ilf batch [SOURCE...] --shards DIR [--dask ADDRESS] [--verify] [--merge]"""

_STATIC_RADIUS = 3
"""Default number of frames before and after each for --static-camera."""

_SHUTDOWN_S = 30.0
"""Time to shut down [s]: end the processes and write the manifest of all completed frames."""


def add_arguments(parser: Parser) -> None:
    """Add the command's arguments to its parser."""
    parser.usage = _USAGE
    parser.description = (
        "Complete the frames of folders, data sets and recordings, each into its own folder, and write manifest.csv "
        "with the result of each. The same command resumes an interrupted batch."
    )
    declared = """
        [SOURCE ...]  folder of frames, data set or recording
        --out DIR     output folder, created if missing
    """
    declare(parser, declared)
    _add_shard_arguments(parser.add_argument_group("shards: many frames in a file"))
    frames = parser.add_argument_group("selection of frames")
    declared = """
        --every N     complete every N-th frame only
        --frames A:B  complete frames A to before B, counted from 0; A or B may be left out, negative numbers count from
            the end
    """
    declare(frames, declared, every=1)
    frames.set_defaults(frames=(None, None))
    parsing.add_pairing(frames)
    declared = """
        --jobs N        number of processes on this machine (default: 1)
        --shard K/N     complete only the K-th of N parts of the frames, while other machines complete the other parts
            into the same folder; with --shards, of the shards
        --dask ADDRESS  run on a Dask cluster, frame by frame, or shard by shard with --shards: address of the
            scheduler, or its scheduler file. A scheduler can run any code here and on its workers: use only one that
            you trust
    """
    declare(parser.add_argument_group("parallel and distributed work"), declared)
    declared = """
        --retry-failed   also retry failed frames
        --rerun-changed  also rerun frames whose settings or files have changed since
    """
    declare(parser.add_argument_group("resuming"), declared)
    parsing.add_reading(parser.add_argument_group("reading the frames"))
    parsing.add_shared(parser, "--strict", "--invalid-mask")
    parser.add_argument(
        "--static-camera",
        type=VALUES["N"],
        nargs="?",
        const=_STATIC_RADIUS,
        default=0,
        metavar="N",
        help="for a static camera: fuse the depth of N frames before and after each one where colour is unchanged "
        f"(default: {_STATIC_RADIUS} if N is left out)",
    )
    parsing.add_shared(parser, "--neighbours", "--neighbour-step")
    beside = parser.add_argument_group("guides and ground truth: folders with one file per frame, named as the frame")
    declared = """
        --guide DIR|FILE|NAME  depth or inverse depth from another source; or one network that predicts it, an ONNX file
            or a name of `ilf models list` (default: guide.* of a frame)
        --ground-truth DIR     depth to evaluate the results against (default: gt.* of a frame)
        --ground-truth-units UNITS  units per metre of the ground truth
    """
    declare(beside, declared)
    parsing.add_given_blocks(parser, "--blocks")
    parsing.add_shared(parser, "--drawn", "--hold-out", "--seeds")
    output = parser.add_argument_group("output")
    parsing.add_export_options(output)
    parsing.add_shared(output, "--extrapolate")
    declared = """
        --contact-sheet  write contact-sheet.png, all previews with their names
        --video          write video.mp4, all previews in sequence
    """
    declare(output, declared)
    parsing.add_shared(output, "--json", "--progress", "--quiet")
    parsing.add_settings(parser)


def run(arguments: argparse.Namespace) -> None:
    """Run the command."""
    if arguments.dask is not None and (arguments.jobs is not None or arguments.shard is not None):
        raise UsageError("--dask distributes the work itself: leave out --jobs and --shard.")
    _check_shard_arguments(arguments)
    if arguments.verify or arguments.merge:
        _check_or_merge(arguments)
        return
    if not arguments.sources or (arguments.out is None and arguments.shards is None):
        raise UsageError("Give a SOURCE, and an output folder by --out or --shards.")
    settings = _settings(arguments)
    warn(parsing.missing_networks(settings.parameters, settings.blocks))  # as the message of every frame will say
    if arguments.shards is not None:
        shards = _open_given_shards(arguments, settings, partial(_frames, arguments))
        summary = BatchSummary(shards, "the tables")
        numbers = _complete(shards, arguments, summary)
        if arguments.json:
            print_json({"folder": arguments.shards, "shards": shards.shards.count} | numbers)
        elif not arguments.quiet:
            print(f"Written to {arguments.shards}: {counted(len(shards.to_do), 'shard')}.")
    else:
        folder = _opened_folder(arguments, settings)
        summary = BatchSummary(folder, MANIFEST_FILE)
        numbers = _complete(folder, arguments, summary)
        wanted = [write_contact_sheet] * arguments.contact_sheet + [write_video] * arguments.video
        files = [MANIFEST_FILE, *(write(folder.folder, folder.recorded()).name for write in wanted)]
        if arguments.json:
            rows = list(map(asdict, folder.recorded()))
            print_json({"folder": str(folder.folder)} | numbers | {"frames": rows, "files": files})
        elif not arguments.quiet:
            print(f"Written to {arguments.out}: {', '.join(files)}, and a folder for each frame.")
    summary.check_failures()


def _opened_folder(arguments: argparse.Namespace, settings: BatchSettings) -> FolderSink:
    frames = _frames(arguments)
    return open_folder(
        frames,
        arguments.out,
        settings,
        only=frames if arguments.shard is None else shard_of(frames, *arguments.shard),
        anew=arguments.rerun_changed,
        retry_failed=arguments.retry_failed,
        strict=arguments.strict,
    )


def _settings(arguments: argparse.Namespace) -> BatchSettings:
    hidden = parsing.hold_out_from(arguments)
    parameters, blocks = parsing.settings_from(arguments, parsing.preset_from(arguments.preset))
    if arguments.neighbours and arguments.static_camera:
        raise UsageError("--static-camera already fuses the depth of frames around each one: leave out --neighbours.")
    return BatchSettings(
        parameters,
        blocks,
        arguments.extrapolate,
        parsing.export_options(arguments),
        hidden,
        # absolute, since workers may have another working directory
        None if arguments.invalid_mask is None else str(Path(arguments.invalid_mask).absolute()),
        steady=arguments.static_camera,
        neighbours=arguments.neighbours,
        neighbour_step=arguments.neighbour_step,
    )


def _frames(arguments: argparse.Namespace) -> list[BatchFrame]:
    sources = [Source(path, parsing.reading_options(arguments)) for path in arguments.sources]
    warn(note for source in sources for note in source.notes)
    first, end = arguments.frames
    step = arguments.neighbour_step
    frames = slice_frames(
        frames_of_sources(
            sources,
            arguments.out or arguments.shards,
            reach=arguments.neighbours * step or arguments.static_camera,
            neighbour_step=step if arguments.neighbours else 0,
        ),
        first=first,
        end=end,
        every=arguments.every,
    )
    guide, of_all = arguments.guide, {"ground_truth_units": arguments.ground_truth_units}
    if guide is not None and not os.path.isdir(guide) and guide_network(guide, arguments.guide_gives):
        of_all["guide"] = guide if is_guide_name(guide) else str(Path(guide).absolute())
    elif guide is not None:
        frames = with_companion_files(frames, "guide", guide)
    if arguments.ground_truth is not None:
        frames = with_companion_files(frames, "ground_truth", arguments.ground_truth)
    given = {name: value for name, value in of_all.items() if value is not None}
    return [replace(frame, source=frame.source.with_options(**given)) for frame in frames] if given else frames


def _complete(sink: Sink, arguments: argparse.Namespace, summary: BatchSummary) -> dict[str, Any]:
    """Complete the frames, with a progress bar, and print the summary however that ends; return its numbers."""
    started, counts, total = time.perf_counter(), sink.counts, sink.counts.total()
    with extended_time_limit(_SHUTDOWN_S):
        try:
            with (
                Bar(total, "frames", shown=shows_progress(arguments), done=total - counts["not_done"]) as bar,
                closing(complete_many(sink, jobs=arguments.jobs or 1, cluster=arguments.dask)) as outcomes,
            ):
                for outcome in outcomes:
                    summary.add(outcome)
                    failed = counts["failed"] + counts["failed_before"]
                    bar.advance(f"{failed} failed" if failed else "")
        finally:
            seconds = time.perf_counter() - started
            if not (arguments.quiet or arguments.json):
                print("\n".join(summary.lines(seconds)), flush=True)
    return {**summary.numbers(), "seconds": seconds}


# Shards: their arguments; checking and merging a folder of them.

_MAX_LISTED = 5
"""Maximum number of damaged files, and of failed frames, listed on the terminal."""

_ONLY_FOLDERS = "static_camera", "neighbours", "rerun_changed", "ExportOptions.expected_error", "contact_sheet", "video"
"""Flags of batches with a folder for each frame."""


def _add_shard_arguments(group: argparse._ArgumentGroup) -> None:
    """Add the arguments of shards."""
    declared = f"""
        --shards DIR   write WebDataset tars, each with a table, instead of a folder per frame. DIR is a folder or an
            address (s3://bucket/folder). The tables are Parquet, depth has one format: png (default) or npy
        --per-shard N  with --shards: frames in a shard
        --keep LIST    with --shards: what a shard contains: depth, and any of {",".join(KEPT[1:])}
        --verify       with --shards: only check all shards of a folder
        --merge        with --shards: only merge the tables of a folder's shards into {MERGED_FILE}
    """
    declare(group, declared, per_shard=1000, keep="depth,expected_error,blocks")


def _check_shard_arguments(arguments: argparse.Namespace) -> None:
    """Raise UsageError for arguments that contradict --shards."""
    if arguments.shards is None:
        return
    if arguments.out is not None:
        raise UsageError("--shards replaces --out: leave one of them out.")
    alone = given_flags(arguments, ("verify", "merge"))
    if alone and arguments.sources:
        raise UsageError(f"{alone[0]} needs no SOURCE: give only --shards.")
    given = given_flags(arguments, _ONLY_FOLDERS) + parsing.geometry_flags(arguments)
    if given:
        raise UsageError(f"{', '.join(given)} cannot be combined with --shards. Leave it out, or use --out.")


def _open_given_shards(arguments: argparse.Namespace, settings: BatchSettings, list_frames: ListFrames) -> ShardSink:
    """Open the shards that the arguments name; raises as `open_shards`, and UsageError."""
    keep = tuple(filter(None, arguments.keep.split(",")))
    if "depth" not in keep or not set(keep) <= set(KEPT):
        raise UsageError(f"--keep takes depth, and any of {', '.join(KEPT[1:])}, not {arguments.keep!r:.60}.")
    depth_formats = parsing.given_parameters(arguments, ExportOptions).get("depth_formats", ("png",))
    if depth_formats not in (("png",), ("npy",)):
        raise UsageError(f"Depth in shards has one format, png or npy, not {','.join(depth_formats)!r:.40}.")
    return open_shards(
        list_frames,
        arguments.shards,
        replace(settings, options=replace(settings.options, depth_formats=depth_formats, cloud=None)),
        tuple(name for name in KEPT if name in keep),
        arguments.per_shard,
        _request(arguments),
        part=arguments.shard or (1, 1),
        retry_failed=arguments.retry_failed,
        strict=arguments.strict,
    )


def _check_or_merge(arguments: argparse.Namespace) -> None:
    """Check the shards of a folder, merge their tables, or both."""
    folder = folder_at(arguments.shards)
    state = check_shards(folder, contents=arguments.verify)
    if arguments.merge and not state.problems:
        merge_tables(folder)
        if not state.is_complete:
            warn([f"The batch is unfinished: {MERGED_FILE} has {state.finished} of {state.shards} shards."])
    if arguments.json:
        print_json({"folder": str(folder), **asdict(state)})
    elif not arguments.quiet:
        print(
            f"{state.finished} of {counted(state.shards, 'shard')} finished: {state.completed} of "
            f"{counted(state.frames, 'frame')} completed, {state.failed} failed."
        )
        if arguments.merge and not state.problems:
            print(f"Written: {folder}/{MERGED_FILE}.")
    if state.problems:
        more = f" And {len(state.problems) - _MAX_LISTED} more." if len(state.problems) > _MAX_LISTED else ""
        raise IlfError(" ".join(state.problems[:_MAX_LISTED]) + more)
    if arguments.verify and not state.is_complete:
        left = state.shards - state.finished
        raise IlfError(f"{left} of {counted(state.shards, 'shard')} not finished. Run the batch again.")


def _request(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what determines the frames, as JSON values."""
    options = parsing.reading_options(arguments)
    topics = None if options.topics is None else list(options.topics)
    return {
        "sources": [absolute(path) for path in arguments.sources],
        "frames": list(arguments.frames),
        "every": arguments.every,
        "pairing": {"max_gap": options.time_gap, "topics": topics, "layout": options.layout},
        "reading": options.to_json(),
    }


# What is told of the frames: progress and warnings as they are completed, a summary, and what has failed.

_ENDS = "completed", "failed", "completed_before", "failed_before", "not_done"


class BatchSummary:
    """Sums over the frames of a batch, which may be a million.

    Parameters
    ----------
    sink : Sink
        What the frames go to.
    listed_in : str
        Where all frames are listed.
    """

    def __init__(self, sink: Sink, listed_in: str) -> None:
        self._counts, self._listed_in = sink.counts, listed_in
        self._sums: Counter[str] = Counter()
        self._errors: list[float] = []
        self._warnings: set[str] = set()
        self._failures: list[str] = []
        for outcome in sink.earlier:
            self._note(outcome)

    def add(self, outcome: FrameOutcome) -> None:
        """Add the outcome of a frame."""
        with Bar.external_write_mode(sys.stderr):
            self._note(outcome)
        if outcome.is_completed:
            names = "pixels", "missing_before", "missing_after", "outside_view"
            self._sums.update({name: getattr(outcome, name) or 0 for name in names})
            if outcome.expected_error_median_m is not None:
                self._errors.append(outcome.expected_error_median_m)

    def _note(self, outcome: FrameOutcome) -> None:
        """Print plausibility warnings, each once with the first frame that it concerns, and note a failure."""
        if outcome.plausibility_warnings:
            self._sums["implausible"] += outcome.is_completed
            new = unique_warnings([outcome.plausibility_warnings], self._warnings)
            warn(f"{outcome.frame}: {text}" for text in new)
        if not outcome.is_completed and len(self._failures) < _MAX_LISTED:
            self._failures.append(f"{outcome.frame}: {outcome.message}")

    def numbers(self) -> dict[str, int]:
        """Return the numbers of frames, by how they have ended."""
        return {name: self._counts[name] for name in _ENDS}

    def lines(self, seconds: float) -> list[str]:
        """Describe the frames of a batch that took so many seconds."""
        counts, sums = self._counts, self._sums
        parts = [
            f"{number} {what.replace('_', ' ')}"
            for what, number in self.numbers().items()
            if number or what in _ENDS[:2]
        ]
        rate = f" ({counts['completed'] / seconds:.2g} frames per second)" if counts["completed"] else ""
        lines = [f"{counted(counts.total(), 'frame')}: {', '.join(parts)}, in {seconds:.0f} s{rate}."]
        if counts["not_done"]:
            lines.append("Run the same command again to resume.")
        if sums["pixels"]:
            before, after, outside = (
                sums[name] / sums["pixels"] for name in ("missing_before", "missing_after", "outside_view")
            )
            lines.append(f"Missing depth: {before:.1%} of the pixels before, {after:.1%} after.")
            if outside:
                lines.append(f"Another {outside:.1%} lie outside the depth camera's view.")
        if sums["implausible"]:
            implausible = f"{counted(sums['implausible'], 'frame')} with plausibility warnings"
            lines.append(f"{implausible}, listed in {self._listed_in}. With --strict such frames fail.")
        if self._errors:
            lines.append(f"{MEDIAN_NAME}: {millimetres(median(self._errors))} mm in the median frame.")
        return lines

    def check_failures(self) -> None:
        """Raise IlfError if frames have failed."""
        number = self._counts["failed"] + self._counts["failed_before"]
        if not number:
            return
        told = [f"{number} of {counted(self._counts.total(), 'frame')} failed.", *self._failures]
        if hidden := number - len(self._failures):
            what = f"And {hidden} more are" if self._failures else "They are"
            told.append(f"{what} listed in {self._listed_in} (column message).")
        raise IlfError(" ".join(filter(None, [*told, "Retry them with --retry-failed."])))
