"""One frame of a batch, from its files to its folder: what every worker does, here and on other machines."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np

from ..confidence import error_summary, expected_error
from ..errors import Cancelled, ExportError, IlfError, InputError, cause
from ..io.files import file_sha256
from ..io.label_files import also_distrusting
from ..judgement import Judgement, judge_completion, judge_hidden
from ..outcomes import Completion
from ..run import Run, check_write, write
from ..run.options import RECORD_FILE
from ..run.staging import clear_interrupted
from ..unfinished import remove, remove_empty
from .frame_record import (
    FRAME_FILE,
    FrameOutcome,
    FrameRecord,
    FrameStatus,
    read_frame_record,
    write_frame_record,
)
from .frames import BatchFrame
from .pictures import write_preview
from .reading import content_now, named_files, read_frame, reading_of
from .settings import BatchSettings, Levels, sha256_of
from .steady import steadied


@dataclass(frozen=True)
class Task:
    """What workers need to know of a batch.

    Attributes
    ----------
    folder : str
        Absolute path of the results; the same on all machines.
    settings : BatchSettings
    sha256 : str
        Of the settings where the batch was started.
    levels : tuple of float
        Depth [m] of the two ends of the previews' colours.
    strict : bool
        Whether a frame fails that speaks against the way that it is read.
    """

    folder: str
    settings: BatchSettings
    sha256: str
    levels: Levels
    strict: bool = False

    def folder_of(self, frame: BatchFrame) -> Path:
        """Where a frame's results go."""
        return Path(self.folder, frame.folder)

    def record_of(self, frame: BatchFrame) -> FrameRecord | None:
        """Of a frame that failed, or whose set is whole, with these settings."""
        folder = self.folder_of(frame)
        record = read_frame_record(folder)
        if record is None or record.settings != self.sha256:
            return None
        return record if not record.is_completed or record.is_whole(folder) else None

    def finished(self, frame: BatchFrame) -> FrameOutcome | None:
        """What came of a frame that is there already, completed with these settings; None if it is not."""
        record = self.record_of(frame)
        if record is None or not record.is_completed:
            return None
        same = record.is_of(frame)
        if same is None:
            same = record.content == content_now(frame)
        return record.outcome if same else None


def complete_frame(task: Task, frame: BatchFrame, threads: int | None = None) -> FrameOutcome:
    """Complete a frame and write its folder, its record last; what is there already is not done again.

    Whatever is wrong with the frame is its outcome.

    Parameters
    ----------
    task : Task
    frame : BatchFrame
    threads : int, optional
        As for `Run.steps`.

    Raises
    ------
    InputError
        If the settings come to others on this machine.
    ExportError
        If not even the record can be written.
    """
    done = task.finished(frame)
    if done is not None:
        return done
    if _sha256_here(task.settings) != task.sha256:
        raise InputError(
            "This machine would complete frames otherwise than the one that started the batch: version of the program, "
            "networks or files differ. Install the same on all of them."
        )
    if threads is not None:
        cv2.setNumThreads(threads)
    tidy(task, frame)
    started = time.perf_counter()
    try:
        record = _completed(task, frame, threads)
    except Cancelled:
        raise
    except Exception as error:
        if (done := task.finished(frame)) is not None:  # another process was quicker
            return done
        message = str(error) if isinstance(error, IlfError) else f"{type(error).__name__}: {error}"
        record = failure(task, frame, message)
    record = replace(record, outcome=replace(record.outcome, seconds=round(time.perf_counter() - started, 3)))
    write_record(task, frame, record)
    return record.outcome


def write_record(task: Task, frame: BatchFrame, record: FrameRecord) -> None:
    """Write a frame's record into its folder; raises ExportError."""
    folder = task.folder_of(frame)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(f"{folder} cannot be made ({cause(error)}). Choose another folder.") from error
    write_frame_record(folder, record)


def failure(task: Task, frame: BatchFrame, message: str) -> FrameRecord:
    """The record of a frame that failed."""
    outcome = FrameOutcome(frame.key, frame.folder, frame.time, FrameStatus.FAILED, " ".join(message.split()))
    return FrameRecord(outcome, task.sha256, reading_of(frame), files=named_files(frame))


def tidy(task: Task, frame: BatchFrame) -> None:
    """Take away what a worker that died, here or on another machine, has left half written in a frame's folder."""
    folder = task.folder_of(frame)
    if folder.is_dir():
        clear_interrupted(folder)
        for left in folder.glob(".ilf-*"):
            remove(left)
        remove_empty((folder,))


@lru_cache(1)
def _sha256_here(settings: BatchSettings) -> str:
    """What the settings come to on this machine; found once, for as long as a worker lives."""
    return sha256_of(settings.facts())


def _completed(task: Task, frame: BatchFrame, threads: int | None) -> FrameRecord:
    """The record of a frame that is completed."""
    settings = task.settings
    reading = read_frame(frame)
    doubts = " ".join(reading.frame.doubts)
    if doubts and task.strict:
        raise InputError(doubts)
    loaded, inputs = steadied(reading, task.folder_of(frame)) if settings.steady else (reading.frame, ())
    if settings.distrust is not None:
        loaded = also_distrusting(loaded, settings.distrust)
    run = settings.recipe.run_of(loaded)
    options = settings.options
    notes = [*loaded.notes, *run.notes]
    if loaded.intrinsics is None and options.cloud is not None:
        options = replace(options, cloud=None)
        notes.append("No point cloud is written, because the camera's intrinsics are not known.")
    folder = task.folder_of(frame)
    check_write(folder, run, options)
    completion = run.complete(threads=threads)
    outcome = _measured(task, frame, run, completion, threads)
    (folder / FRAME_FILE).unlink(missing_ok=True)  # it does not speak of what comes now
    written = write(folder, run, completion, options)
    preview = write_preview(folder, loaded, completion.depth, task.levels)
    notes += [*completion.notes, *written.notes, *written.remarks]
    return FrameRecord(
        replace(outcome, message=" ".join(dict.fromkeys(notes)), doubts=doubts),
        task.sha256,
        reading_of(frame),
        reading.content,
        reading.files,
        file_sha256(folder / RECORD_FILE) if options.run_record else None,
        (*(path.name for path in written.files), preview, *inputs),
    )


def _measured(task: Task, frame: BatchFrame, run: Run, completion: Completion, threads: int | None) -> FrameOutcome:
    missing, outside = run.frame.missing, run.frame.outside_view
    expected = error_summary(expected_error(run.frame, completion), completion)
    hidden = task.settings.hidden
    whole = Judgement() if hidden is None else judge_hidden(run, hidden, threads=threads).whole
    truth = Judgement() if run.frame.truth is None else judge_completion(run.frame, completion)
    return FrameOutcome(
        frame=frame.key,
        folder=frame.folder,
        time=frame.time,
        status=FrameStatus.COMPLETED,
        blocks=len(np.unique(run.blocks[run.blocks > 0])),
        pixels=missing.size,
        missing_before=int(np.count_nonzero(missing)),
        missing_after=int(np.count_nonzero(missing & np.isnan(completion.depth))),
        outside_view=0 if outside is None else int(np.count_nonzero(outside)),
        expected_error_median=_rounded(expected.median),
        expected_error_p90=_rounded(expected.p90),
        hidden_mae=_rounded(whole.mae),
        hidden_rmse=_rounded(whole.rmse),
        truth_mae=_rounded(truth.mae),
        truth_rmse=_rounded(truth.rmse),
    )


def _rounded(metres: float | np.floating) -> float | None:
    """To a micrometre; None for NaN."""
    return None if np.isnan(metres) else round(float(metres), 6)
