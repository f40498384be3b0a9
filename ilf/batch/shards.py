"""A batch that writes shards: a tar of many frames and its table, instead of a folder for each frame.

The list of frames is frozen first. A shard is a slice of it; its name follows from the settings, the list and its
index. It is finished if its table exists, which is written last.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import shutil
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from .._runtime.children import run_in_processes
from .._runtime.files import is_address, parse_json
from .._runtime.folders import Folder, folder_at
from .._runtime.installation import optional
from .._runtime.schema import Section
from .._runtime.threads import available_cores
from .._runtime.writing import ensure_folder, remove_empty
from ..errors import FormatError, InputError
from ..run.record import PROGRAM
from ..sources.frame_ref import FrameRef
from ..sources.own_results import SHARDS_FILE
from ..sources.shards import LIST_FILE, SCHEMA, ShardSet, ShardTable, read_shard_set, table_ends
from .batch import some
from .frame_record import FrameOutcome, FrameStatus
from .frames import BatchFrame
from .settings import SETTINGS_FILE, BatchSettings, differences, sha256_of
from .shard_files import sample_of, write_shard
from .shard_task import (
    Part,
    ShardFrame,
    ShardTask,
    complete_part,
    failed_part,
    outcome_of,
    read_row,
    sample_name,
    write_part,
)
from .task import OTHER_MACHINE
from .workers import CRASHED, SHARED_FOLDER, Outcomes, check_wanted, run_on_cluster, threads_of_worker

_PARTS = "parts"
"""Folder of the parts of unfinished shards."""

ListFrames = Callable[[], Sequence[BatchFrame]]
"""A function at the top level of a module that lists all frames of a batch."""


@dataclass
class ShardCounts:
    """Numbers of frames: completed and failed before, completed and failed now, and all that concern this batch."""

    before: int = 0
    failed_before: int = 0
    completed: int = 0
    failed: int = 0
    total: int = 0

    @property
    def left(self) -> int:
        """Number of frames that are not done."""
        return self.total - self.before - self.failed_before - self.completed - self.failed


@dataclass(frozen=True)
class ShardBatch:
    """Shards to write; created by `open_shards`.

    Attributes
    ----------
    folder : Folder
    shards : ShardSet
    task : ShardTask
    to_do : dict of int to collection of int
        Unfinished shards, with the places in the list of their frames that are to be completed.
    retry_failed : bool
        Whether failed frames of these shards are completed again.
    counts : ShardCounts
        Brought up to date by `outcomes`.
    """

    folder: Folder
    shards: ShardSet
    task: ShardTask
    to_do: dict[int, Collection[int]]
    retry_failed: bool = False
    counts: ShardCounts = field(default_factory=ShardCounts)

    def outcomes(self, jobs: int = 1, *, cluster: str | None = None) -> Outcomes:
        """Complete the frames of the unfinished shards, write every shard once its last frame is done, and yield the
        outcomes in order of completion.

        When this generator is closed, the work stops. Frames that are done are kept in their parts; those in progress
        are discarded.

        Parameters
        ----------
        jobs : int
            Number of processes on this machine.
        cluster : str, optional
            Dask scheduler to use instead: its address, or its scheduler file. A worker completes a whole shard, whose
            outcomes are then yielded.

        Raises
        ------
        InputError
            As `run_on_cluster`, or if its workers do not see the folder.
        ExportError
            If a file cannot be written. An error of a single frame becomes its outcome.
        IlfError
            If the connection to the scheduler is lost.
        """
        local = cluster is None or not self.to_do
        for outcome in self._by_frame(self.to_do, jobs) if local else self._by_shard(str(cluster)):
            if outcome.is_completed:
                self.counts.completed += 1
            else:
                self.counts.failed += 1
            yield outcome
        if not self.counts.left:
            parts = Path(self.task.folder)
            remove_empty((parts, parts.parent))

    def _by_frame(self, indices: Iterable[int], jobs: int = 1) -> Outcomes:
        """Complete shards in processes of this machine, frame by frame."""
        open_frames: dict[int, int] = {}
        elsewhere: list[int] = []
        work = partial(complete_part, self.task, threads=max(available_cores() // jobs, 1))
        for item, done in run_in_processes(work, self._frames(indices, open_frames, elsewhere), jobs=jobs):
            yield self._record_crash(item) if done is None else done
            index = item.number // self.shards.per_shard
            open_frames[index] -= 1
            if not open_frames[index]:
                del open_frames[index]
                self._write(index)
        for index in elsewhere:
            yield from self._written(index)

    def _by_shard(self, cluster: str) -> Outcomes:
        """Complete shards on a cluster; those that it gives up, in processes of this machine."""
        given_up = []
        work = partial(complete_shard, str(self.folder), self.task, self.retry_failed)
        for index, done in run_on_cluster(work, list(self.to_do), cluster):
            if done is None:
                given_up.append(index)
            else:
                yield from self._written(index)
        for index in given_up:
            for _ in self._by_frame([index]):
                pass  # workers have completed some of the frames
            yield from self._written(index)

    def _written(self, index: int) -> Outcomes:
        """Yield the outcomes of the frames to be completed of a shard that is finished."""
        table, to_do = self.shards.table(index), self.to_do[index]
        if not self.folder.exists(table):
            raise InputError(f"A worker has written {table}, but it is missing in {self.folder} here. {SHARED_FOLDER}")
        rows = ShardTable.of(self.folder, table).read().to_pylist()
        for number, row in zip(self.shards.numbers(index), rows, strict=True):
            if number in to_do:
                yield outcome_of(row)

    def complete_here(self, index: int, threads: int) -> None:
        """Complete a shard in this process, which is a worker of a cluster. It may be repeated after a crash: the frame
        in progress then is completed last, so that the others are done if it crashes again."""
        if self.retry_failed or not self.folder.exists(self.shards.table(index)):
            begun = self._part_folder(index).exists()
            frames = sorted(self._frames([index], {}, []), key=lambda item: item.number)
            for item in frames[1:] + frames[:1] if begun else frames:
                check_wanted()
                complete_part(self.task, item, threads)
        self._write(index)

    def _frames(
        self, indices: Iterable[int], open_frames: dict[int, int], elsewhere: list[int]
    ) -> Iterator[ShardFrame]:
        """Yield the frames that have no part yet, and count them by shard. Shards that no process has begun come first;
        in the others, which another one may be at, the last frame does. Shards that have all parts are written; those
        that another process has finished are added to `elsewhere`."""
        begun = []
        ensure_folder(Path(self.task.folder))
        for index in indices:
            try:
                self._part_folder(index).mkdir(parents=True)
            except FileExistsError:
                begun.append(index)
            else:
                yield from self._frames_of(index, open_frames, elsewhere)
        for index in begun:
            if not self._part_folder(index).exists() and self.folder.exists(self.shards.table(index)):
                elsewhere.append(index)
            else:
                yield from reversed([*self._frames_of(index, open_frames, elsewhere)])

    def _frames_of(self, index: int, open_frames: dict[int, int], elsewhere: list[int]) -> Iterator[ShardFrame]:
        numbers, name = self.shards.numbers(index), self.shards.name(index)
        if self.retry_failed:
            self._reopen(index)
        elif self.folder.exists(self.shards.table(index)):
            self._remove_parts(index)
            elsewhere.append(index)
            return
        ensure_folder(self._part_folder(index))
        there = _parts(self.task, name)
        left = [number for number in numbers if number not in there or number in self.to_do.get(index, ())]
        if not left:
            self._write(index)
            return
        open_frames[index] = len(left)
        lines = self.shards.lines(self.folder, index)
        for number in left:
            yield ShardFrame(name, number, frame_of_line(lines[number - numbers.start], self.shards.request))

    def _part_folder(self, index: int) -> Path:
        return self.task.part(self.shards.name(index), 0).parent

    def _record_crash(self, item: ShardFrame) -> FrameOutcome:
        path = self.task.part(item.shard, item.number)
        if (row := read_row(path)) is not None:
            return outcome_of(row)
        outcome, part = failed_part(item.frame, CRASHED)
        write_part(path, part)
        return outcome

    def _reopen(self, index: int) -> None:
        """Turn a finished shard into the parts of its completed frames, or remove the parts of failed ones."""
        name, table = self.shards.name(index), self.shards.table(index)
        if self.folder.exists(table):
            for number, (row, data) in zip(self.shards.numbers(index), sample_of(self.folder, name), strict=True):
                if row["status"] == FrameStatus.COMPLETED:
                    write_part(self.task.part(name, number), Part(row, data))
            self.folder.remove(table)
        for number in _parts(self.task, name):
            path = self.task.part(name, number)
            if (before := read_row(path)) is not None and before["status"] != FrameStatus.COMPLETED:
                path.unlink(missing_ok=True)

    def _write(self, index: int) -> None:
        """Write a shard from its parts, unless another process has, and remove them."""
        name = self.shards.name(index)
        if not self.folder.exists(self.shards.table(index)):
            files = [self.task.part(name, number) for number in self.shards.numbers(index)]
            try:
                write_shard(self.folder, name, self.task.sha256, files)
            except InputError:  # a part is missing: another process has just written the shard, and removed them
                if not self.folder.exists(self.shards.table(index)):
                    raise
        self._remove_parts(index)

    def _remove_parts(self, index: int) -> None:
        shutil.rmtree(self._part_folder(index), ignore_errors=True)


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
) -> ShardBatch:
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
    facts = _facts(settings, keep, per_shard)
    if target.exists(SETTINGS_FILE):
        raise InputError(f"{target} contains a batch with a folder for each frame. Choose another folder for shards.")
    if not target.exists(SHARDS_FILE):
        target.forget_working()
        for _, _ in run_in_processes(partial(_freeze, str(target), facts, dict(request)), [list_frames]):
            pass
        if not target.exists(SHARDS_FILE):
            raise InputError("The process that lists the frames ended. Memory may have run out: close other programs.")
    shards = read_shard_set(target)
    for what, before, now in (("settings", shards.settings, facts), ("frames", shards.request, request)):
        if before != now:
            raise InputError(
                f"{target} has shards of other {what} ({some(differences(before, now))}). Choose another folder."
            )
    _check_list(target, shards)
    task = ShardTask(_part_folder(target), settings, tuple(keep), shards.sha256, strict)
    counts, to_do = ShardCounts(), dict[int, Collection[int]]()
    own = range(part[0] - 1, shards.count, part[1])
    failures = _failures(target, task, [shards.table(index) for index in own])
    for index in own:
        name, table, numbers = shards.name(index), shards.table(index), shards.numbers(index)
        counts.total += len(numbers)
        failed = failures.get(table)
        if failed is not None and not (failed and retry_failed):
            counts.before += len(numbers) - failed
            counts.failed_before += failed
            shutil.rmtree(task.part(name, 0).parent, ignore_errors=True)  # left by a process that was killed
            continue
        if failed:
            there = dict(zip(numbers, ShardTable.of(target, table).read("status")["status"].to_pylist(), strict=True))
        else:
            rows = {number: read_row(task.part(name, number)) for number in _parts(task, name)}
            there = {number: row["status"] for number, row in rows.items() if row is not None}
        done = {number for number, status in there.items() if not (retry_failed and status == FrameStatus.FAILED)}
        completed = sum(there[number] == FrameStatus.COMPLETED for number in done)
        counts.before += completed
        counts.failed_before += len(done) - completed
        to_do[index] = frozenset(numbers) - done if done else numbers
    return ShardBatch(target, shards, task, to_do, retry_failed, counts)


def _facts(settings: BatchSettings, keep: Sequence[str], per_shard: int) -> dict[str, Any]:
    """Return what determines the results, as JSON values."""
    return settings.facts() | {"shards": {"keep": list(keep), "per_shard": per_shard}}


def _part_folder(folder: Folder) -> str:
    """Return the folder of this machine for the parts of unfinished shards."""
    return str(folder.working / _PARTS)


def complete_shard(address: str, task: ShardTask, retry_failed: bool, index: int) -> bool:
    """Complete a shard on a worker of a cluster; a finished one is not completed again.

    Parameters
    ----------
    address : str
        Folder of the shards, or its address.
    task : ShardTask
    retry_failed : bool
        Also complete failed frames again.
    index : int

    Returns
    -------
    bool
        True.

    Raises
    ------
    InputError
        If the worker does not see the folder, or would give other results.
    ExportError
        If a file cannot be written.
    """
    folder = folder_at(address)
    shards = _shards_on_worker(address, task)
    batch = ShardBatch(folder, shards, replace(task, folder=_part_folder(folder)), {}, retry_failed)
    batch.complete_here(index, threads_of_worker())
    return True


@lru_cache(1)
def _shards_on_worker(address: str, task: ShardTask) -> ShardSet:
    """Read shards.json and compare it with what a worker is asked for; done once per worker."""
    folder = folder_at(address)
    shards = read_shard_set(folder) if folder.exists(SHARDS_FILE) else None
    if shards is None or shards.sha256 != task.sha256:
        raise InputError(f"A worker of the cluster does not see the shards in {folder}. {SHARED_FOLDER}")
    if shards.settings != _facts(task.settings, task.keep, shards.per_shard):
        raise InputError(OTHER_MACHINE)
    return shards


def _failures(folder: Folder, task: ShardTask, names: Sequence[str]) -> dict[str, int]:
    """Return the numbers of failed frames of those of some tables that exist."""
    sizes, found = folder.sizes(), {}
    for name, table in table_ends(folder, {name: sizes[name] for name in names if name in sizes}):
        if isinstance(table, FormatError):
            raise table
        if table.sha256 != task.sha256:
            raise FormatError(
                f"{folder}/{name} does not match the settings in its name. Delete it and run the batch again."
            )
        found[name] = table.failed
    return found


def _parts(task: ShardTask, name: str) -> frozenset[int]:
    """Return the places in the list of the frames of a shard whose parts exist."""
    folder = task.part(name, 0).parent
    try:
        return frozenset(int(entry) for entry in os.listdir(folder) if entry.isdecimal())
    except FileNotFoundError:
        return frozenset()


# The frozen list: a line of JSON for each frame.


def _freeze(target: str, facts: dict[str, Any], request: dict[str, Any], list_frames: ListFrames) -> None:
    """Write the frozen list, and shards.json last."""
    frames, folder = list_frames(), folder_at(target)
    keys, whole, size = hashlib.sha256(), hashlib.sha256(), 0
    per_shard, keep = facts["shards"]["per_shard"], tuple(facts["shards"]["keep"])
    offsets: list[int] = []

    def lines() -> Iterator[bytes]:
        nonlocal size
        for number, frame in enumerate(frames):
            if number % per_shard == 0:
                offsets.append(size)
            line = f"{json.dumps({'key': frame.key, 'time': frame.time, **frame.source.to_json()})}\n".encode()
            keys.update(f"{json.dumps(frame.key)}\n".encode())
            whole.update(line)
            size += len(line)
            yield line

    folder.put(LIST_FILE, lines())
    sha256 = sha256_of(facts | {"keys": keys.hexdigest()})
    shards = ShardSet(facts, request, sha256, len(frames), per_shard, keep, size, whole.hexdigest(), tuple(offsets))
    data = {"program": PROGRAM, "schema": SCHEMA, **dataclasses.asdict(shards)}
    folder.put(SHARDS_FILE, [f"{json.dumps(data, indent=2)}\n".encode()])


def frame_of_line(line: bytes, request: Mapping[str, Any]) -> BatchFrame:
    """Return the frame in a line of the frozen list.

    Parameters
    ----------
    line : bytes
    request : mapping
        That of the user, whose sources and other files the frame may use.

    Raises
    ------
    NotAllowed
        If it names others, and they are not allowed.
    FormatError
        If it is damaged.
    """
    data = parse_json(line, LIST_FILE)
    stated = Section(LIST_FILE, data if isinstance(data, dict) else {})
    key, source = stated.get("key", str), FrameRef.from_json(stated, "")
    given = tuple(map(_as_folder, (*request.get("sources", ()), *map(str, request.get("reading", {}).values()))))
    paths = *source.paths, *source.options.camera_paths.values()
    if any("/../" in path or not _as_folder(path).startswith(given) for path in paths):
        source = source.allowed()
    return BatchFrame(key, replace(source, stated_in=None), stated.get("time", float, None), sample_name(key))


def _as_folder(path: str) -> str:
    return path.rstrip("/") + "/" if is_address(path) else os.path.join(os.path.normpath(path), "")


def _check_list(folder: Folder, shards: ShardSet) -> None:
    """Raise if the frozen list does not have the size that shards.json states."""
    size = folder.size(LIST_FILE)
    if size != shards.list_bytes:
        raise FormatError(
            f"{folder}/{LIST_FILE} has {size} bytes instead of {shards.list_bytes}. Choose another folder."
        )
