"""A batch: many frames completed with the same settings, one folder per frame; completed frames are skipped."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from .._runtime.children import run_in_processes
from .._runtime.formatting import counted
from .._runtime.threads import available_cores
from .._runtime.writing import ensure_folder
from ..errors import InputError
from ..io.tables import write_csv
from .frame_record import COLUMNS_WITH_UNITS, FRAME_FILE, FrameOutcome, FrameRecord, current_content, read_frame_record
from .frames import BatchFrame
from .pictures import depth_levels
from .settings import BatchSettings, differences, read_settings, sha256_of, write_settings
from .task import Task
from .workers import Outcomes, complete_locally, complete_on_cluster

# The state of every frame before a batch starts, from the records in its folder.


class State(Enum):
    """State of a frame: not completed with these settings; completed; failed; completed, but its files have changed."""

    OPEN, FINISHED, FAILED, CHANGED = range(4)


@dataclass(frozen=True)
class BatchFrameState:
    """A frame with its state and outcome; the outcome is None if the frame is open."""

    frame: BatchFrame
    state: State
    outcome: FrameOutcome | None = None


def frame_states(task: Task, frames: Sequence[BatchFrame]) -> list[BatchFrameState]:
    """Determine the states of frames. Frames whose file stamps differ are read, in separate processes."""
    records = {frame: task.record_of(frame) for frame in frames}
    same = {frame: record is not None and record.is_of(frame) for frame, record in records.items()}
    doubtful = [frame for frame, record in records.items() if record and record.is_completed and same[frame] is None]
    for frame, content in run_in_processes(current_content, doubtful, jobs=available_cores()):
        record = records[frame]
        same[frame] = record is not None and content is not None and content == record.content
    return [_batch_frame_state(frame, record, bool(same[frame])) for frame, record in records.items()]


def _batch_frame_state(frame: BatchFrame, record: FrameRecord | None, same: bool) -> BatchFrameState:
    if record is None:
        return BatchFrameState(frame, State.OPEN)
    if record.is_completed:
        return BatchFrameState(frame, State.FINISHED if same else State.CHANGED, record.outcome)
    return BatchFrameState(frame, State.FAILED, record.outcome) if same else BatchFrameState(frame, State.OPEN)


# manifest.csv: the outcomes of all frames in a folder, from their records.

MANIFEST_FILE = "manifest.csv"

MANIFEST_COLUMNS = tuple(COLUMNS_WITH_UNITS.get(field.name, field.name) for field in dataclasses.fields(FrameOutcome))


def write_manifest(folder: Path, order: Sequence[BatchFrame]) -> list[FrameOutcome]:
    """Write the manifest, and return its outcomes.

    Several processes may share a folder: each checks after writing, and writes again if a record was added meanwhile.
    So the last writer includes all records.

    Parameters
    ----------
    folder : Path
    order : sequence of BatchFrame
        Order of the rows; other frames follow.

    Raises
    ------
    ExportError
        If it cannot be written.
    """
    before = None
    while (state := _recorded_state(folder)) != before:
        before = state
        outcomes = read_outcomes(folder, order)
        write_csv(folder / MANIFEST_FILE, [MANIFEST_COLUMNS, *map(dataclasses.astuple, outcomes)])
    return outcomes


def read_outcomes(folder: Path, order: Sequence[BatchFrame] = ()) -> list[FrameOutcome]:
    """Read the outcomes of the frames whose records are in a folder."""
    places = {frame.folder: place for place, frame in enumerate(order)}
    records = (read_frame_record(path.parent) for path in folder.glob(f"*/{FRAME_FILE}"))
    outcomes = [record.outcome for record in records if record is not None]
    return sorted(outcomes, key=lambda outcome: (places.get(outcome.folder, len(places)), outcome.frame))


def _recorded_state(folder: Path) -> dict[str, int]:
    """Return the folders with a record, and the records' modification times [ns]."""
    state = {}
    for path in folder.glob(f"*/{FRAME_FILE}"):
        try:
            state[path.parent.name] = path.stat().st_mtime_ns
        except OSError:  # deleted meanwhile
            continue
    return state


_MAX_LISTED = 3
_REDO_HINT = (
    "Choose another folder, or complete them again (--rerun-changed; in the window, Redo: Frames with changed settings "
    "or files)."
)
"""Number of differences and frames listed in a message; what the user can do."""


@dataclass(frozen=True)
class Batch:
    """Frames to complete, and the outcomes of earlier frames; created by `open_batch`.

    Attributes
    ----------
    task : Task
    frames : tuple of BatchFrame
        All frames of the batch.
    to_do : tuple of BatchFrame
        Frames to complete.
    finished : tuple of FrameOutcome
        Outcomes of the frames that are already completed.
    failed : tuple of FrameOutcome
        Outcomes of the frames that failed before and are not retried.
    """

    task: Task
    frames: tuple[BatchFrame, ...]
    to_do: tuple[BatchFrame, ...]
    finished: tuple[FrameOutcome, ...] = ()
    failed: tuple[FrameOutcome, ...] = ()

    @property
    def folder(self) -> Path:
        """Folder of the results."""
        return Path(self.task.folder)

    def outcomes(self, *, jobs: int = 1, cluster: str | None = None) -> Outcomes:
        """Complete the frames, and yield their outcomes in order of completion.

        When this generator is closed, the work stops; frames in progress are discarded, and completed when the batch is
        opened again.

        Parameters
        ----------
        jobs : int
            Number of processes on this machine.
        cluster : str, optional
            Dask scheduler to use instead: its address, or its scheduler file.

        Raises
        ------
        IlfError
            For errors that affect all frames. An error of a single frame becomes its outcome.
        """
        if cluster is not None and self.to_do:
            return complete_on_cluster(self.task, self.to_do, cluster)
        return complete_locally(self.task, self.to_do, jobs)

    def write_manifest(self) -> list[FrameOutcome]:
        """Write manifest.csv of all results in the folder, including those of other processes; return its outcomes."""
        return write_manifest(self.folder, self.frames)


def open_batch(
    frames: Sequence[BatchFrame],
    folder: str | os.PathLike[str],
    settings: BatchSettings | None = None,
    *,
    only: Sequence[BatchFrame] | None = None,
    anew: bool = False,
    retry_failed: bool = False,
    strict: bool = False,
) -> Batch:
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
    same = before is not None and before[0] == facts
    if before is not None and not same and not anew:
        raise InputError(
            f"{target} has frames that were completed with other settings "
            f"({some(differences(before[0], facts))}). {_REDO_HINT}"
        )
    # other settings may come with other frames and another depth range
    levels = before[1] if before is not None and same else depth_levels(frames)
    task = Task(str(target), chosen, sha256_of(facts), levels, strict)
    found = frame_states(task, frames if only is None else only)
    changed = [there.frame.key for there in found if there.state is State.CHANGED]
    if changed and not anew:
        raise InputError(
            f"The files of {counted(len(changed), 'frame')} have changed since they were completed into {target}: "
            f"{some(changed)}. {_REDO_HINT}"
        )
    if not same:
        write_settings(ensure_folder(target), facts, levels)
    kept = {State.FINISHED} if retry_failed else {State.FINISHED, State.FAILED}
    to_do = tuple(there.frame for there in found if there.state not in kept)
    finished, failed = (
        tuple(there.outcome for there in found if there.outcome is not None and there.state is state)
        for state in (State.FINISHED, State.FAILED)
    )
    return Batch(task, tuple(frames), to_do, finished, () if retry_failed else failed)


def some(things: Sequence[str]) -> str:
    """Return the first few of several texts, and the number of the others."""
    more = len(things) - _MAX_LISTED
    return "; ".join(things[:_MAX_LISTED]) + (f"; and {more} more" if more > 0 else "")
