"""A batch in a folder: one folder per frame, whose record is written last, and the manifest of all records."""

from __future__ import annotations

import dataclasses
import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from .._runtime.children import run_in_processes
from .._runtime.files import file_sha256
from .._runtime.formatting import counted
from .._runtime.long_work import available_cores
from .._runtime.writing import ensure_folder, remove, remove_empty, restore_interrupted
from ..data.results import Completion
from ..errors import InputError
from ..io.tables import write_csv
from ..run.run import Run
from ..run.writing import check_write, drop_impossible, write
from ..sources.frame_ref import RECORD_FILE
from .cluster import SHARED_FOLDER
from .engine import OTHER_BATCH, OTHER_MACHINE, Sink, facts_here
from .frame_record import (
    FRAME_FILE,
    FrameOutcome,
    FrameRecord,
    LoadedFrame,
    current_content,
    read_frame_record,
    reading_sha256,
    source_files,
    write_frame_record,
)
from .frames import BatchFrame
from .pictures import depth_levels, write_preview
from .settings import BatchSettings, Levels, differences, read_settings, sha256_of, some, write_settings
from .static_camera import files_of, with_temporal_median

MANIFEST_FILE = "manifest.csv"

MANIFEST_COLUMNS = tuple(field.name for field in dataclasses.fields(FrameOutcome))

_REDO_HINT = "Choose another folder, or complete them again (--rerun-changed), in the window by Redo."


@dataclass(frozen=True, eq=False, kw_only=True)
class FolderSink(Sink):
    """A folder with a folder for each frame; opened by `open_folder`.

    Attributes
    ----------
    folder : Path
        The same on all machines.
    sha256 : str
        Hash of the settings on the machine that started the batch.
    levels : tuple of float
        Colour range of the previews: depth [m] of its two ends.
    frames : tuple of BatchFrame
        All frames of the batch.
    """

    folder: Path
    sha256: str
    levels: Levels
    frames: tuple[BatchFrame, ...] = ()

    def folder_of(self, frame: BatchFrame) -> Path:
        """Return the folder of a frame's results."""
        return self.folder / frame.folder

    def record_of(self, frame: BatchFrame) -> FrameRecord | None:
        """Return the record of a frame that failed, or whose results are complete, with these settings; else None."""
        folder = self.folder_of(frame)
        record = read_frame_record(folder)
        if record is None or record.settings != self.sha256:
            return None
        return record if not record.outcome.is_completed or record.has_all_files(folder) else None

    def _check_settings(self) -> None:
        """Raise InputError if another batch has begun in the folder with other settings, at the same time or since."""
        found = read_settings(self.folder)
        if found is None or sha256_of(found[0]) != self.sha256:
            raise InputError(OTHER_BATCH.format(folder=self.folder))

    def done(self, frame: BatchFrame) -> FrameOutcome | None:
        """Return the outcome of a frame that is already completed with these settings; else None. Raises InputError as
        `_check_settings`, which ends the batch."""
        self._check_settings()
        record = self.record_of(frame)
        if record is None or not record.outcome.is_completed:
            return None
        same = record.is_of(frame)
        if same is None:
            same = record.content == current_content(frame)
        return record.outcome if same else None

    def tidy(self, frame: BatchFrame) -> None:
        folder = self.folder_of(frame)
        if folder.is_dir():
            restore_interrupted(folder)
            for left in folder.glob(".ilf-*"):
                remove(left)
            remove_empty((folder,))

    def run_of(self, frame: BatchFrame, reading: LoadedFrame) -> tuple[Run, Sequence[str]]:
        folder = self.folder_of(frame)
        run = self.settings.run_of(with_temporal_median(reading, folder) if self.settings.steady else reading.frame)
        options, without = drop_impossible(self.settings.options, run)
        check_write(folder, run, options)
        return run, without

    def write(
        self, frame: BatchFrame, reading: LoadedFrame, completion: Completion
    ) -> tuple[dict[str, Any], Sequence[str]]:
        self._check_settings()
        folder = self.folder_of(frame)
        options, _ = drop_impossible(self.settings.options, completion.run)
        (folder / FRAME_FILE).unlink(missing_ok=True)  # the old record does not describe the new results
        written = write(folder, completion, options)
        preview = write_preview(folder, completion, self.levels)
        steady = files_of(reading.frame) if self.settings.steady else ()
        facts = {
            "content": reading.content,
            "files": reading.files,
            "run": file_sha256(folder / RECORD_FILE) if options.run_record else None,
            "outputs": (*(path.name for path in written.files), preview, *steady),
        }
        return facts, written.notes

    def put(self, frame: BatchFrame, outcome: FrameOutcome, written: dict[str, Any] | None = None) -> None:
        facts = {"files": source_files(frame)} if written is None else written
        record = FrameRecord(outcome, self.sha256, reading_sha256(frame), **facts)
        write_frame_record(ensure_folder(self.folder_of(frame)), record)

    def bare(self) -> Self:
        return replace(self, frames=(), to_do=(), earlier=())

    def check_here(self) -> None:
        if sha256_of(facts_here(self.settings)) != self.sha256:
            raise InputError(OTHER_MACHINE)

    def outcomes(self, unit: BatchFrame) -> Iterator[FrameOutcome]:
        record = read_frame_record(self.folder_of(unit))
        if record is None:
            path = self.folder_of(unit) / FRAME_FILE
            raise InputError(f"A worker has completed {unit.key}, but {path} is missing here. {SHARED_FOLDER}")
        yield record.outcome

    def close(self) -> None:
        """Write the manifest, the outcomes of all frames in the folder.

        Several processes may share a folder: each checks after writing, and writes again if a record was added
        meanwhile. So the last writer includes all records.
        """
        before = None
        while (state := self._record_times()) != before:
            before = state
            write_csv(self.folder / MANIFEST_FILE, [MANIFEST_COLUMNS, *map(dataclasses.astuple, self.recorded())])

    def recorded(self) -> list[FrameOutcome]:
        """Read the outcomes of all frames in the folder, those of this batch first."""
        places = {frame.folder: place for place, frame in enumerate(self.frames)}
        records = (read_frame_record(path.parent) for path in self.folder.glob(f"*/{FRAME_FILE}"))
        outcomes = [record.outcome for record in records if record is not None]
        return sorted(outcomes, key=lambda outcome: (places.get(outcome.folder, len(places)), outcome.frame))

    def _record_times(self) -> dict[str, int]:
        """Return the folders with a record, and the records' modification times [ns]."""
        state = {}
        for path in self.folder.glob(f"*/{FRAME_FILE}"):
            try:
                state[path.parent.name] = path.stat().st_mtime_ns
            except OSError:  # deleted meanwhile
                continue
        return state


def open_folder(
    frames: Sequence[BatchFrame],
    folder: str | os.PathLike[str],
    settings: BatchSettings | None = None,
    *,
    only: Sequence[BatchFrame] | None = None,
    anew: bool = False,
    retry_failed: bool = False,
    strict: bool = False,
) -> FolderSink:
    """Open a batch in a folder, and determine which frames are left to complete.

    Parameters
    ----------
    frames : sequence of BatchFrame
        As `frames_of_sources` returns them.
    folder : path-like
        Folder of the results, created if missing; it contains one folder per frame.
    settings : BatchSettings, optional
        Default settings if left out.
    only : sequence of BatchFrame, optional
        Frames to complete here; default: all.
    anew : bool
        Complete frames again that were completed with other settings, or whose files have changed since.
    retry_failed : bool
        Also retry failed frames. Failed frames whose files have changed since are always retried.
    strict : bool
        Frames with plausibility warnings fail (`RGBDFrame.plausibility_warnings`).

    Raises
    ------
    InputError
        If there are results of other settings, or of files that have changed since, and `anew` is False. The folder
        is then left unchanged.
    ExportError
        If the folder cannot be written.
    """
    chosen, target = settings or BatchSettings(), Path(folder).absolute()
    before = read_settings(target)
    facts = chosen.facts()
    same_settings = before is not None and before[0] == facts
    if before is not None and not same_settings and not anew:
        changes = some(differences(before[0], facts))
        raise InputError(f"{target} has frames completed with other settings ({changes}). {_REDO_HINT}")
    # other settings may come with other frames and another depth range
    levels = before[1] if before is not None and same_settings else depth_levels(frames)
    sink = FolderSink(settings=chosen, strict=strict, folder=target, sha256=sha256_of(facts), levels=levels)
    records = {frame: sink.record_of(frame) for frame in (frames if only is None else only)}
    same = unchanged(records)
    changed = [
        frame.key for frame, record in records.items() if record and record.outcome.is_completed and not same[frame]
    ]
    if changed and not anew:
        told = f"The files of {counted(len(changed), 'frame')} have changed since they were completed"
        raise InputError(f"{told} into {target}: {some(changed)}. {_REDO_HINT}")
    if not same_settings:
        write_settings(ensure_folder(target), facts, levels)
    kept = {
        frame: record.outcome
        for frame, record in records.items()
        if record and same[frame] and (record.outcome.is_completed or not retry_failed)
    }
    earlier = tuple(_doubted(outcome) if strict else outcome for outcome in kept.values())
    to_do = tuple(frame for frame in records if frame not in kept)
    counts = Counter([f"{outcome.status}_before" for outcome in earlier] + ["not_done"] * len(to_do))
    return replace(sink, frames=tuple(frames), to_do=to_do, earlier=earlier, counts=counts)


def _doubted(outcome: FrameOutcome) -> FrameOutcome:
    """The outcome of a strict batch: one with plausibility warnings has failed."""
    doubts = outcome.plausibility_warnings
    return replace(outcome, status="failed", message=doubts) if doubts else outcome


def unchanged(records: dict[BatchFrame, FrameRecord | None]) -> dict[BatchFrame, bool]:
    """Return which frames have a record of the files that they have now. Frames whose file stamps differ are read, in
    separate processes."""
    same = {frame: record is not None and record.is_of(frame) for frame, record in records.items()}
    doubtful = [
        frame for frame, record in records.items() if record and record.outcome.is_completed and same[frame] is None
    ]
    for frame, content in run_in_processes(current_content, doubtful, jobs=available_cores()):
        record = records[frame]
        same[frame] = record is not None and content is not None and content == record.content
    return {frame: bool(found) for frame, found in same.items()}
