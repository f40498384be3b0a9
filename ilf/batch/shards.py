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
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from .._runtime.files import ensure_folder, write_bytes
from .._runtime.folders import Folder, folder_at
from .._runtime.installation import optional
from .._runtime.processes import run_in_processes
from .._runtime.schema import Section
from .._runtime.temporary_files import remove_empty
from .._runtime.threads import available_cores
from ..errors import FormatError, InputError, cause
from ..run.record import PROGRAM
from ..sources.frame_source import FrameSource
from ..sources.shards import LIST_FILE, SCHEMA, SHARDS_FILE, ShardSet, read_shard_set, table_ends
from .batch import some
from .frame_record import FrameOutcome, FrameStatus
from .frames import BatchFrame
from .settings import SETTINGS_FILE, BatchSettings, differences, sha256_of
from .shard_files import sample_of, write_shard
from .shard_task import Part, ShardFrame, ShardTask, complete_part, failed_part, sample_name
from .workers import CRASHED

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
    to_do : tuple of int
        Unfinished shards.
    counts : ShardCounts
        Brought up to date by `outcomes`.
    """

    folder: Folder
    shards: ShardSet
    task: ShardTask
    to_do: tuple[int, ...]
    counts: ShardCounts = field(default_factory=ShardCounts)

    def outcomes(self, jobs: int = 1) -> Generator[FrameOutcome, None, None]:
        """Complete the frames of the unfinished shards, write every shard once its last frame is done, and yield the
        outcomes in order of completion.

        When this generator is closed, the work stops. Frames that are done are kept in their parts; those in progress
        are discarded.

        Parameters
        ----------
        jobs : int
            Number of processes on this machine.

        Raises
        ------
        ExportError
            If a file cannot be written. An error of a single frame becomes its outcome.
        """
        open_frames: dict[int, int] = {}
        work = partial(complete_part, self.task, threads=max(available_cores() // jobs, 1))
        for item, done in run_in_processes(work, self._frames(open_frames), jobs=jobs):
            outcome = self._record_crash(item) if done is None else done
            self._count(outcome)
            yield outcome
            index = item.number // self.shards.per_shard
            open_frames[index] -= 1
            if not open_frames[index]:
                del open_frames[index]
                self._write(index)
        if not self.counts.left:
            parts = Path(self.task.folder)
            remove_empty((parts, parts.parent))

    def _frames(self, open_frames: dict[int, int]) -> Iterator[ShardFrame]:
        """Yield the frames that have no part yet, and count them by shard; shards that have all parts are written."""
        for index in self.to_do:
            numbers, name = self.shards.numbers(index), self.shards.name(index)
            ensure_folder(self.task.part(name, 0).parent)
            there = self._parts(index)
            left = [number for number in numbers if number not in there]
            if not left:
                self._write(index)
                continue
            open_frames[index] = len(left)
            lines = self.shards.lines(self.folder, index)
            for number in left:
                yield ShardFrame(name, number, frame_of_line(lines[number - numbers.start]))

    def _parts(self, index: int) -> frozenset[int]:
        return _parts(self.task, self.shards.name(index))

    def _count(self, outcome: FrameOutcome) -> None:
        if outcome.is_completed:
            self.counts.completed += 1
        else:
            self.counts.failed += 1

    def _record_crash(self, item: ShardFrame) -> FrameOutcome:
        outcome, part = failed_part(item.frame, CRASHED)
        write_bytes(self.task.part(item.shard, item.number), part.content())
        return outcome

    def _write(self, index: int) -> None:
        """Write a shard from its parts, unless another process has, and remove them."""
        name = self.shards.name(index)
        if not self.folder.exists(self.shards.table(index)):
            files = [self.task.part(name, number) for number in self.shards.numbers(index)]
            write_shard(self.folder, name, self.task.sha256, files)
        shutil.rmtree(self.task.part(name, 0).parent, ignore_errors=True)


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
    optional("pyarrow.parquet", "shards", "Writing shards")  # missing packages are reported before any work
    target = folder_at(folder)
    facts = settings.facts() | {"shards": {"keep": list(keep), "per_shard": per_shard}}
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
    task = ShardTask(str(target.working / _PARTS), settings, tuple(keep), shards.sha256, strict)
    counts, to_do = ShardCounts(), []
    own = range(part[0] - 1, shards.count, part[1])
    failures = _failures(target, task, [shards.table(index) for index in own])
    for index in own:
        counts.total += len(shards.numbers(index))
        name, failed = shards.name(index), failures.get(shards.table(index))
        if failed is not None and not (failed and retry_failed):
            counts.before += len(shards.numbers(index)) - failed
            counts.failed_before += failed
            shutil.rmtree(task.part(name, 0).parent, ignore_errors=True)  # left by a process that was killed
            continue
        if failed:
            _reopen(target, task, name, shards.numbers(index))
        to_do.append(index)
        for number in _parts(task, name):
            if _status(task.part(name, number)) == FrameStatus.COMPLETED:
                counts.before += 1
            elif retry_failed:
                task.part(name, number).unlink()
            else:
                counts.failed_before += 1
    return ShardBatch(target, shards, task, tuple(to_do), counts)


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


def _status(path: Path) -> str:
    """Return the status of the frame in a part, whose files are not read."""
    try:
        with open(path, "rb") as file:
            return str(Part.of(file.readline()).row["status"])
    except (OSError, ValueError, KeyError) as error:
        raise FormatError(f"{path} is damaged ({cause(error)}). Delete it and run the batch again.") from error


def _reopen(folder: Folder, task: ShardTask, name: str, numbers: range) -> None:
    """Turn a finished shard into the parts of its completed frames, so that the failed ones can be completed."""
    ensure_folder(task.part(name, 0).parent)
    for number, (row, data) in zip(numbers, sample_of(folder, name), strict=True):
        if row["status"] == "completed":
            write_bytes(task.part(name, number), Part(row, data).content())
    folder.remove(f"{name}.parquet")


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


def frame_of_line(line: bytes) -> BatchFrame:
    """Return the frame in a line of the frozen list."""
    data = json.loads(line)
    key = data["key"]
    return BatchFrame(key, FrameSource.from_json(Section(LIST_FILE, data)), data["time"], sample_name(key))


def _check_list(folder: Folder, shards: ShardSet) -> None:
    """Raise if the frozen list does not have the size that shards.json states."""
    size = folder.size(LIST_FILE)
    if size != shards.list_bytes:
        raise FormatError(
            f"{folder}/{LIST_FILE} has {size} bytes instead of {shards.list_bytes}. Choose another folder."
        )
