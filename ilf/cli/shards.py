"""`ilf batch --shards`: the arguments of shards; checking and merging a folder of them."""

from __future__ import annotations

import argparse
from dataclasses import asdict, replace
from typing import Any

from .._runtime.files import absolute
from .._runtime.folders import folder_at
from .._runtime.formatting import counted
from ..batch.frames import ListFrames
from ..batch.settings import BatchSettings
from ..batch.shard_files import check_shards, merge_tables
from ..batch.shard_sink import KEPT, ShardSink, open_shards
from ..errors import IlfError
from ..sources.shards import MERGED_FILE
from .options import geometry_flags
from .output import print_json, warn
from .parsing import reading_options
from .usage import UsageError, declare, given_flags

_PER_SHARD, _KEEP = 1000, "depth,expected_error,blocks"

_MAX_LISTED = 5
"""Maximum number of damaged files listed on the terminal."""

_ONLY_SHARDS = "per_shard", "keep", "verify", "merge"
_ONLY_FOLDERS = "static_camera", "neighbours", "rerun_changed", "no_expected_error", "contact_sheet", "video"
"""Flags of batches in shards, and of those with a folder for each frame."""


def add_shard_arguments(group: argparse._ArgumentGroup) -> None:
    """Add the arguments of shards."""
    declared = f"""
        --shards DIR   write WebDataset tars, each with a table, instead of a folder per frame. DIR is a folder or an
            address (s3://bucket/folder). The tables are Parquet, depth has one format: png (default) or npy
        --per-shard N  frames in a shard (default: {_PER_SHARD})
        --keep LIST    what a shard contains: depth, and any of {",".join(KEPT[1:])} (default: {_KEEP})
        --verify       only check all shards of a folder
        --merge        only merge the tables of a folder's shards into {MERGED_FILE}
    """
    declare(group, declared)


def check_shard_arguments(arguments: argparse.Namespace) -> None:
    """Raise UsageError for arguments that contradict --shards, or need it."""
    if arguments.shards is None:
        if given := given_flags(arguments, _ONLY_SHARDS):
            raise UsageError(f"{given[0]} applies to shards only: add --shards.")
        return
    if arguments.out is not None:
        raise UsageError("--shards replaces --out: leave one of them out.")
    alone = given_flags(arguments, ("verify", "merge"))
    if alone and arguments.sources:
        raise UsageError(f"{alone[0]} needs no SOURCE: give only --shards.")
    given = given_flags(arguments, _ONLY_FOLDERS) + geometry_flags(arguments)
    if given:
        raise UsageError(f"{', '.join(given)} cannot be combined with --shards. Leave it out, or use --out.")


def open_given_shards(arguments: argparse.Namespace, settings: BatchSettings, list_frames: ListFrames) -> ShardSink:
    """Open the shards that the arguments name; raises as `open_shards`, and UsageError."""
    keep = tuple(filter(None, (arguments.keep or _KEEP).split(",")))
    if "depth" not in keep or not set(keep) <= set(KEPT):
        raise UsageError(f"--keep takes depth, and any of {', '.join(KEPT[1:])}, not {arguments.keep!r:.60}.")
    depth_format = arguments.depth_formats or "png"
    if depth_format not in ("png", "npy"):
        raise UsageError(f"Depth in shards has one format, png or npy, not {depth_format!r:.40}.")
    return open_shards(
        list_frames,
        arguments.shards,
        replace(settings, options=replace(settings.options, depth_formats=(depth_format,), cloud=None)),
        tuple(name for name in KEPT if name in keep),
        arguments.per_shard or _PER_SHARD,
        _request(arguments),
        part=arguments.shard or (1, 1),
        retry_failed=arguments.retry_failed,
        strict=arguments.strict,
    )


def check_or_merge(arguments: argparse.Namespace) -> None:
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
    options = reading_options(arguments)
    topics = None if options.topics is None else list(options.topics)
    return {
        "sources": [absolute(path) for path in arguments.sources],
        "frames": list(arguments.frames),
        "every": arguments.every,
        "pairing": {"max_gap": options.time_gap, "topics": topics, "layout": options.layout},
        "reading": options.to_json(),
    }
