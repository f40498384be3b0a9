"""A batch in shards: a tar of many frames and its table, instead of a folder for each frame.

The list of frames is frozen first. A shard is a slice of it; its name follows from the settings, the list and its
index. It is finished if its table exists, which is written last, from the parts of its frames.
"""

from __future__ import annotations

import os
import shutil
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Self

from .._runtime.children import run_in_processes
from .._runtime.folders import Folder, folder_at
from .._runtime.installation import optional
from .._runtime.writing import ensure_folder, remove_empty
from ..data.frame import RGBDFrame
from ..data.results import Completion
from ..errors import FormatError, InputError
from ..run.formats import FORMATS
from ..run.writing import colour, contents, drop_impossible
from ..sources.frame_ref import SHARDS_FILE
from ..sources.shards import COLOUR, DEPTH, LIST_FILE, ShardSet, ShardTable, read_shard_set, table_ends
from .cluster import SHARED_FOLDER
from .engine import OTHER_BATCH, OTHER_MACHINE, Sink, facts_here
from .frame_record import FrameOutcome, LoadedFrame
from .frames import BatchFrame, ListFrames, freeze, listed_frames
from .settings import SETTINGS_FILE, BatchSettings, differences, some
from .shard_files import completed_part, failed_part, outcome_of, read_row, sample_of, write_part, write_shard

KEPT = ("depth", "expected_error", "blocks", "unsupported", "rgb")
"""What a shard can contain of a frame, besides its frame.json."""

_PARTS = "parts"
"""Folder on this machine of the parts of unfinished shards."""


Encoded = tuple[RGBDFrame, dict[str, bytes]]
"""A frame as it was completed, and its files by the endings of their names."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ShardSink(Sink):
    """A folder or an address of shards; opened by `open_shards`. The export options of its settings have one depth
    format.

    Attributes
    ----------
    folder : Folder
    shards : ShardSet
    to_do : mapping of int to collection of int
        Unfinished shards, with the places in the list of their frames that are to be completed.
    retry_failed : bool
        Whether failed frames of these shards are completed again.
    """

    folder: Folder
    shards: ShardSet
    to_do: Mapping[int, Collection[int]] = field(default_factory=dict)
    retry_failed: bool = False

    def part(self, number: int) -> Path:
        """Return the file of a frame's part, by its place in the frozen list."""
        return self._part_folder(number // self.shards.per_shard) / f"{number:09}"

    def parts(self, index: int) -> frozenset[int]:
        """Return the places in the list of the frames of a shard that have a part."""
        try:
            return frozenset(int(entry) for entry in os.listdir(self._part_folder(index)) if entry.isdecimal())
        except FileNotFoundError:
            return frozenset()

    def remove_parts(self, index: int) -> None:
        """Remove the parts of a shard."""
        shutil.rmtree(self._part_folder(index), ignore_errors=True)

    def done(self, frame: BatchFrame) -> FrameOutcome | None:
        """Return the outcome of a frame that has a part; raises FormatError if that is damaged."""
        row = read_row(self.part(frame.number))
        return None if row is None else outcome_of(row)

    def write(self, frame: BatchFrame, reading: LoadedFrame, completion: Completion) -> tuple[Encoded, Sequence[str]]:
        keep, (options, without) = self.shards.keep, drop_impossible(self.settings.options, completion.run)
        image = f"{frame.folder}.{COLOUR}" if "rgb" in keep else ""
        made = contents(completion.run, options.replace(expected_error=True, labels=True)) | {COLOUR: colour}
        (depth_format,) = options.depth_formats
        of_kept = (f"{DEPTH}.{depth_format}", f"expected_error.{depth_format}", "blocks.png", "unsupported.png", COLOUR)
        files: dict[str, bytes] = {}
        notes: list[str] = []
        wanted = [name for kept, name in zip(KEPT, of_kept, strict=True) if kept == "depth" or kept in keep]
        for name in [*wanted, *(FORMATS[export].file for export in options.exports)]:
            if (make := made[name]) is not None:
                files[name], found = make(completion, image)
                notes += found if name in wanted else [f"{name}: {note}" for note in found]
        return (completion.frame, files), [*notes, *without]

    def put(self, frame: BatchFrame, outcome: FrameOutcome, written: Encoded | None = None) -> None:
        if written is None:
            write_part(self.part(frame.number), failed_part(outcome))
        else:
            part = completed_part(outcome, *written, self.shards.sha256, self.settings.options)
            write_part(self.part(frame.number), *part)

    def bare(self) -> Self:
        return replace(self, to_do={}, counts=Counter())

    def check_here(self) -> None:
        there = read_shard_set(self.folder) if self.folder.exists(SHARDS_FILE) else None
        if there is None or there.sha256 != self.shards.sha256:
            raise InputError(f"A worker of the cluster does not see the shards in {self.folder}. {SHARED_FOLDER}")
        if there.settings != facts_here(self.settings) | _form(there.keep, there.per_shard):
            raise InputError(OTHER_MACHINE)

    def unit_of(self, frame: BatchFrame) -> int:
        return frame.number // self.shards.per_shard

    def begin(self, unit: int) -> bool:
        try:
            ensure_folder(self._part_folder(unit).parent)
            self._part_folder(unit).mkdir()
        except FileExistsError:
            return False
        return True

    def frames_of(self, unit: int) -> list[BatchFrame]:
        if self._is_finished(unit):
            if not self.retry_failed or not self._part_folder(unit).exists():
                return []
            self._reopen(unit)
        if self.retry_failed:
            self._forget_failed(unit)
        ensure_folder(self._part_folder(unit))
        there, to_do = self.parts(unit), self.to_do.get(unit, ())
        left = [number for number in self.shards.numbers(unit) if number not in there or number in to_do]
        frames = listed_frames(self.folder, self.shards, unit) if left else {}
        return [frames[number] for number in left]

    def finish(self, unit: int) -> None:
        """Write a shard from its parts, unless another process has, and remove them; raises InputError, which ends the
        batch, if another one has begun in the folder with other settings."""
        if not self._is_finished(unit):
            if read_shard_set(self.folder).sha256 != self.shards.sha256:
                raise InputError(OTHER_BATCH.format(folder=self.folder))
            files = [self.part(number) for number in self.shards.numbers(unit)]
            try:
                write_shard(self.folder, self.shards.name(unit), self.shards.sha256, files)
            except InputError:  # a part is missing: another process has just written the shard, and removed them
                if not self._is_finished(unit):
                    raise
        self.remove_parts(unit)

    def outcomes(self, unit: int) -> Iterator[FrameOutcome]:
        table, to_do = self.shards.table(unit), self.to_do[unit]
        if not self.folder.exists(table):
            raise InputError(f"A worker has written {table}, but it is missing in {self.folder} here. {SHARED_FOLDER}")
        rows = ShardTable.of(self.folder, table).read().to_pylist()
        for number, row in zip(self.shards.numbers(unit), rows, strict=True):
            if number in to_do:
                yield outcome_of(row)

    def close(self) -> None:
        """Remove the folders of parts, if no shard is left."""
        if not self.counts["not_done"]:
            parts = self.folder.working / _PARTS
            remove_empty((parts, parts.parent))

    def _part_folder(self, index: int) -> Path:
        return self.folder.working / _PARTS / self.shards.name(index)

    def _is_finished(self, index: int) -> bool:
        return self.folder.exists(self.shards.table(index))

    def _reopen(self, index: int) -> None:
        """Turn a finished shard into the parts of its completed frames."""
        samples = sample_of(self.folder, self.shards.name(index))
        for number, (row, data) in zip(self.shards.numbers(index), samples, strict=True):
            if row["status"] == "completed":
                write_part(self.part(number), row, data)
        self.folder.remove(self.shards.table(index))

    def _forget_failed(self, index: int) -> None:
        """Remove the parts of failed frames."""
        for number in self.parts(index):
            row = read_row(self.part(number))
            if row is not None and row["status"] != "completed":
                self.part(number).unlink(missing_ok=True)


def open_shards(
    list_frames: ListFrames,
    folder: str | os.PathLike[str],
    settings: BatchSettings,
    keep: Sequence[str],
    per_shard: int,
    request: Mapping[str, Any],
    *,
    part: tuple[int, int] = (1, 1),
    retry_failed: bool = False,
    strict: bool = False,
) -> ShardSink:
    """Open a batch that writes shards, and determine which are left to write. The first time, its frames are listed.

    Parameters
    ----------
    list_frames : callable
        Called in a process of its own, whose memory is free afterwards.
    folder : path-like
        Created if missing; or an address.
    settings : BatchSettings
        Their export options have one depth format.
    keep : sequence of str
        What the shards contain: any of `KEPT`.
    per_shard : int
        Number of frames in a shard.
    request : mapping
        JSON values that determine which frames `list_frames` lists.
    part : tuple of int
        (k, n): only every n-th shard from the k-th on.
    retry_failed : bool
        Also retry failed frames.
    strict : bool
        Frames with plausibility warnings fail.

    Raises
    ------
    InputError
        If the folder contains results of other settings, of other frames, or not of shards; it is left unchanged.
    ExportError
        If the folder cannot be written.
    """
    # a missing package is reported before any work
    optional("pyarrow.parquet", "ilf-studio[cluster]", "Writing shards")
    target = folder_at(folder)
    facts = settings.facts() | _form(keep, per_shard)
    shards = _shard_set(target, facts, request, list_frames)
    sink = ShardSink(settings=settings, strict=strict, folder=target, shards=shards, retry_failed=retry_failed)
    counts, to_do = Counter[str](), dict[int, Collection[int]]()
    own = range(part[0] - 1, shards.count, part[1])
    failures = _failures(sink, own)
    for index in own:
        numbers, failed = shards.numbers(index), failures.get(index)
        if failed is not None and not (failed and retry_failed):
            counts.update(completed_before=len(numbers) - failed, failed_before=failed)
            sink.remove_parts(index)  # left by a process that was killed
            continue
        there = _statuses(sink, index, finished=failed is not None)
        done = {number for number, status in there.items() if not (retry_failed and status == "failed")}
        counts.update(f"{there[number]}_before" for number in done)
        counts["not_done"] += len(numbers) - len(done)
        to_do[index] = frozenset(numbers) - done if done else numbers
    return replace(sink, to_do=to_do, counts=counts)


def _form(keep: Sequence[str], per_shard: int) -> dict[str, Any]:
    """Return what shards contain, as a part of the facts that determine them."""
    return {"shards": {"keep": list(keep), "per_shard": per_shard}}


def _shard_set(folder: Folder, facts: dict[str, Any], request: Mapping[str, Any], list_frames: ListFrames) -> ShardSet:
    """Return what a folder states of its shards, written if there is none; raises InputError if that is of another
    batch."""
    if folder.exists(SETTINGS_FILE):
        raise InputError(f"{folder} contains a batch with a folder for each frame. Choose another folder for shards.")
    if not folder.exists(SHARDS_FILE):
        folder.forget_working()
        for _, _ in run_in_processes(partial(freeze, str(folder), facts, dict(request)), [list_frames]):
            pass
        if not folder.exists(SHARDS_FILE):
            raise InputError("The process that lists the frames ended. Memory may have run out: close other programs.")
    shards = read_shard_set(folder)
    for what, before, now in (("settings", shards.settings, facts), ("frames", shards.request, request)):
        if before != now:
            raise InputError(
                f"{folder} has shards of other {what} ({some(differences(before, now))}). Choose another folder."
            )
    size = folder.size(LIST_FILE)
    if size != shards.list_bytes:
        raise FormatError(f"{folder}/{LIST_FILE} has {size}, not {shards.list_bytes} bytes. Choose another folder.")
    return shards


def _failures(sink: ShardSink, indices: Sequence[int]) -> dict[int, int]:
    """Return the numbers of failed frames of those of some shards that are finished."""
    folder, tables = sink.folder, {sink.shards.table(index): index for index in indices}
    sizes, found = folder.sizes(), {}
    for name, table in table_ends(folder, {name: sizes[name] for name in tables if name in sizes}):
        if isinstance(table, FormatError):
            raise table
        if table.sha256 != sink.shards.sha256:
            raise FormatError(f"{folder}/{name} is not of the settings in its name. Delete it and run the batch again.")
        found[tables[name]] = table.failed
    return found


def _statuses(sink: ShardSink, index: int, finished: bool) -> dict[int, str]:
    """Return the statuses of the frames of a shard that are done, by their places in the list: from its table if it is
    finished, else from its parts."""
    if finished:
        statuses = ShardTable.of(sink.folder, sink.shards.table(index)).read("status")["status"].to_pylist()
        return dict(zip(sink.shards.numbers(index), statuses, strict=True))
    rows = {number: read_row(sink.part(number)) for number in sink.parts(index)}
    return {number: row["status"] for number, row in rows.items() if row is not None}
