"""Completing one frame of a batch: the task of every worker, on this machine or another."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import file_sha256
from .._runtime.formatting import counted, grouped
from .._runtime.writing import ensure_folder, remove, remove_empty, restore_interrupted, write_bytes
from ..completion.confidence.expected_error import error_summary, expected_error
from ..data.frame import RGBDFrame
from ..data.neighbours import median_of_known
from ..data.results import Completion
from ..errors import Cancelled, ExportError, IlfError, InputError, cause
from ..evaluation.evaluation import Evaluation, evaluate_completion
from ..evaluation.hold_out import evaluate_hold_out, untrusted_note
from ..io.depth import write_depth
from ..io.labels import with_more_invalid
from ..run.options import RECORD_FILE, drop_impossible_cloud
from ..run.run import Run
from ..run.writing import check_write, write
from ..sources.reading import load_frame
from .frame_record import (
    FRAME_FILE,
    FrameOutcome,
    FrameRecord,
    FrameStatus,
    LoadedFrame,
    current_content,
    read_frame,
    read_frame_record,
    reading_sha256,
    source_files,
    write_frame_record,
)
from .frames import BatchFrame
from .pictures import write_preview
from .settings import BatchSettings, Levels, sha256_of

# Static camera: the temporal median of the depth of neighbouring frames where colour is unchanged.

DEPTH_FILE, COLOUR_FILE = "steady/depth.npy", "steady/rgb.png"
"""Files in a frame's folder that it is completed from; the colour only if the frame has no colour file."""

_BLUR_SIGMA = 2.0
"""Standard deviation [px] of the Gaussian blur of colours before they are compared; it removes noise."""

_MIN_DIFFERENCE, _NOISE_FACTOR, _MAX_DIFFERENCE = 2.5, 6.0, 8.0
"""Threshold of changed colours: at least `_MIN_DIFFERENCE` grey levels, `_NOISE_FACTOR` deviations of the noise, at
most `_MAX_DIFFERENCE`."""

_MARGIN = 6
"""Pixels around a change that count as changed: depth is less sharp than colour."""

_MAX_CHANGED_SHARE = 0.4
"""Neighbours with a larger changed share show another view and are left out."""


def with_temporal_median(reading: LoadedFrame, folder: Path) -> tuple[RGBDFrame, tuple[str, ...]]:
    """Return a frame with its `temporal_median`, written to and read from files in a folder, so that its run can be
    replayed.

    Returns
    -------
    (RGBDFrame, tuple of str)
        The frame, and the paths of these files in the folder.

    Raises
    ------
    ExportError
        If the files cannot be written.
    """
    frame = reading.frame
    layers = _layers(frame, reading.neighbours)
    depth = median_of_known(layers)
    ensure_folder((folder / DEPTH_FILE).parent)
    write_depth(folder / DEPTH_FILE, depth)
    inputs, files = frame.inputs, [DEPTH_FILE]
    if inputs is None or not inputs.has_colour_file:
        _, encoded = cv2.imencode(".png", frame.rgb[..., ::-1])
        write_bytes(folder / COLOUR_FILE, encoded.tobytes())
        files.append(COLOUR_FILE)
    ground_truth = None if inputs is None else inputs.ground_truth
    read = load_frame(
        folder / COLOUR_FILE if COLOUR_FILE in files or inputs is None else inputs.rgb.path,
        folder / DEPTH_FILE,
        intrinsics=frame.intrinsics,
        name=frame.name,
        ground_truth=None if ground_truth is None else ground_truth.path,
        ground_truth_units=None if ground_truth is None else ground_truth.units,
        beside=False,
        warn=False,
    )
    note = _median_note(frame, depth, len(layers), len(reading.neighbours))
    steady = replace(read, outside_view=frame.outside_view, pose=frame.pose, notes=(*frame.notes, note))
    return steady.with_guide(frame.guide), tuple(files)


def temporal_median(frame: RGBDFrame, others: Sequence[RGBDFrame]) -> NDArray[np.float32]:
    """Compute the temporal median of depth: per pixel, over a frame and its neighbours with unchanged colour.

    A pixel has depth if the frame or any neighbour with unchanged colour has depth there.

    Parameters
    ----------
    frame : RGBDFrame
    others : sequence of RGBDFrame
        Frames of the same static camera, taken shortly before and after. Frames of another size, and frames whose
        colour has changed nearly everywhere, are ignored.

    Returns
    -------
    ndarray of float32, shape (H, W)
        Depth [m], NaN = missing.

    Examples
    --------
    >>> rgb = np.zeros((20, 30, 3), np.uint8)
    >>> frames = [RGBDFrame(rgb, np.full((20, 30), depth)) for depth in (2.0, 2.03, 1.99)]
    >>> float(temporal_median(frames[1], [frames[0], frames[2]])[0, 0])
    2.0
    """
    return median_of_known(_layers(frame, others))


def _layers(frame: RGBDFrame, others: Sequence[RGBDFrame]) -> NDArray[np.float32]:
    """Stack the depth [m] of a frame and of the others that show the same view, (N, H, W); NaN where they have
    changed."""
    smooth = _smooth(frame.rgb)
    depths = [frame.depth]
    for other in others:
        if other.shape != frame.shape:
            continue
        changed = _changed(smooth, _smooth(other.rgb))
        if changed.mean() <= _MAX_CHANGED_SHARE:
            depths.append(np.where(changed, np.float32(np.nan), other.depth))
    return np.stack(depths)


def _median_note(frame: RGBDFrame, depth: NDArray[np.float32], used: int, neighbours: int) -> str:
    """Return a note on how the temporal median has changed a frame's depth [m], (H, W)."""
    changed = np.count_nonzero(np.isfinite(depth) & (depth != frame.depth))
    if used == 1:
        return f"Depth is unchanged: none of {counted(neighbours, 'neighbouring frame')} shows the same view."
    return (
        f"Depth is the median of up to {used} frames where colour is unchanged: it differs from the measured depth at "
        f"{grouped(changed)} of {counted(depth.size, 'pixel')} ({changed / depth.size:.0%})."
    )


def _smooth(rgb: NDArray[np.uint8]) -> NDArray[np.float32]:
    return np.asarray(cv2.GaussianBlur(rgb.astype(np.float32), (0, 0), _BLUR_SIGMA))


def _changed(here: NDArray[np.float32], there: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return the pixels, bool (H, W), whose smoothed colours differ by more than noise and exposure."""
    exposure = np.median((here + 1) / (there + 1), axis=(0, 1))
    difference = np.abs(here - (there + 1) * exposure + 1).max(axis=2)
    limit = np.clip(_NOISE_FACTOR * 1.4826 * np.median(difference), _MIN_DIFFERENCE, _MAX_DIFFERENCE)
    disk = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * _MARGIN + 1, 2 * _MARGIN + 1))
    return cv2.dilate((difference > limit).astype(np.uint8), disk).astype(bool)


@dataclass(frozen=True)
class Task:
    """The data of a batch that its workers need.

    Attributes
    ----------
    folder : str
        Absolute path of the results; the same on all machines.
    settings : BatchSettings
    sha256 : str
        Hash of the settings on the machine that started the batch.
    levels : tuple of float
        Colour range of the previews: depth [m] of its two ends.
    strict : bool
        Whether a frame with plausibility warnings fails.
    """

    folder: str
    settings: BatchSettings
    sha256: str
    levels: Levels
    strict: bool = False

    def folder_of(self, frame: BatchFrame) -> Path:
        """Return the folder of a frame's results."""
        return Path(self.folder, frame.folder)

    def record_of(self, frame: BatchFrame) -> FrameRecord | None:
        """Return the record of a frame that failed, or whose results are complete, with these settings; else None."""
        folder = self.folder_of(frame)
        record = read_frame_record(folder)
        if record is None or record.settings != self.sha256:
            return None
        return record if not record.is_completed or record.has_all_files(folder) else None

    def finished(self, frame: BatchFrame) -> FrameOutcome | None:
        """Return the outcome of a frame that is already completed with these settings; else None."""
        record = self.record_of(frame)
        if record is None or not record.is_completed:
            return None
        same = record.is_of(frame)
        if same is None:
            same = record.content == current_content(frame)
        return record.outcome if same else None


OTHER_MACHINE = (
    "This machine differs from the one that started the batch in its program version, networks or files, so its "
    "results would differ. Install the same on all machines."
)
"""Message of a worker whose settings have another hash."""


def complete_frame(task: Task, frame: BatchFrame, threads: int | None = None) -> FrameOutcome:
    """Complete a frame and write its folder, its record last; a completed frame is not completed again.

    Errors of the frame itself become its outcome.

    Parameters
    ----------
    task : Task
    frame : BatchFrame
    threads : int, optional
        As for `Run.steps`.

    Raises
    ------
    InputError
        If the settings have another hash on this machine.
    ExportError
        If the record cannot be written.
    """
    done = task.finished(frame)
    if done is not None:
        return done
    if _sha256_here(task.settings) != task.sha256:
        raise InputError(OTHER_MACHINE)
    if threads is not None:
        cv2.setNumThreads(threads)
    tidy(task, frame)
    started = time.perf_counter()
    try:
        record = _completed(task, frame, threads)
    except Cancelled:
        raise
    except Exception as error:
        if (done := task.finished(frame)) is not None:  # another process has completed it meanwhile
            return done
        record = failure(task, frame, failure_text(error))
    record = replace(record, outcome=replace(record.outcome, seconds=round(time.perf_counter() - started, 3)))
    write_record(task, frame, record)
    return record.outcome


def write_record(task: Task, frame: BatchFrame, record: FrameRecord) -> None:
    """Write a frame's record into its folder; raises ExportError."""
    folder = task.folder_of(frame)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ExportError(f"{folder} cannot be created ({cause(error)}). Choose another folder.") from error
    write_frame_record(folder, record)


def failure_text(error: Exception) -> str:
    """Describe in one line why a frame has failed."""
    text = str(error) if isinstance(error, IlfError) else f"{type(error).__name__}: {error}"
    return " ".join(text.split())


def failure(task: Task, frame: BatchFrame, message: str) -> FrameRecord:
    """Return the record of a failed frame."""
    outcome = FrameOutcome(frame.key, frame.folder, frame.time, FrameStatus.FAILED, " ".join(message.split()))
    return FrameRecord(outcome, task.sha256, reading_sha256(frame), files=source_files(frame))


def tidy(task: Task, frame: BatchFrame) -> None:
    """Remove incomplete files that a crashed worker has left in a frame's folder."""
    folder = task.folder_of(frame)
    if folder.is_dir():
        restore_interrupted(folder)
        for left in folder.glob(".ilf-*"):
            remove(left)
        remove_empty((folder,))


@lru_cache(1)
def _sha256_here(settings: BatchSettings) -> str:
    """Return the hash of the settings on this machine; computed once per worker."""
    return sha256_of(settings.facts())


def _completed(task: Task, frame: BatchFrame, threads: int | None) -> FrameRecord:
    """Complete a frame, write its results and return its record."""
    settings = task.settings
    reading = read_frame(frame)
    plausibility_warnings = " ".join(reading.frame.plausibility_warnings)
    if plausibility_warnings and task.strict:
        raise InputError(plausibility_warnings)
    loaded, inputs = with_temporal_median(reading, task.folder_of(frame)) if settings.steady else (reading.frame, ())
    if settings.invalid_mask is not None:
        loaded = with_more_invalid(loaded, settings.invalid_mask)
    run = settings.run_of(loaded)
    options, without = drop_impossible_cloud(settings.options, loaded)
    notes = [*loaded.notes, *run.blocks.notes, *without]
    folder = task.folder_of(frame)
    check_write(folder, run, options)
    completion = run.complete(threads=threads)
    outcome = measured(task.settings, frame, run, completion, expected_error(completion), threads)
    (folder / FRAME_FILE).unlink(missing_ok=True)  # the old record does not describe the new results
    written = write(folder, run, completion, options)
    preview = write_preview(folder, loaded, completion.depth, task.levels)
    notes += [outcome.message, *completion.notes, *written.notes, *written.remarks]
    message = " ".join(dict.fromkeys(filter(None, notes)))
    return FrameRecord(
        replace(outcome, message=message, plausibility_warnings=plausibility_warnings),
        task.sha256,
        reading_sha256(frame),
        reading.content,
        reading.files,
        file_sha256(folder / RECORD_FILE) if options.run_record else None,
        (*(path.name for path in written.files), preview, *inputs),
    )


def measured(
    settings: BatchSettings,
    frame: BatchFrame,
    run: Run,
    completion: Completion,
    error: NDArray[np.float32],
    threads: int | None,
) -> FrameOutcome:
    """Return the outcome of a completed frame, without plausibility warnings; its message tells of known depth that the
    hold-out leaves out.

    Parameters
    ----------
    settings : BatchSettings
    frame : BatchFrame
    run : Run
    completion : Completion
    error : ndarray of float32, shape (H, W)
        `expected_error` of the completion [m].
    threads : int, optional
        As for `Run.steps`.
    """
    missing, outside = run.frame.missing, run.frame.outside_view
    expected = error_summary(error, completion)
    hidden = settings.hidden
    whole = Evaluation() if hidden is None else evaluate_hold_out(run, hidden, threads=threads).whole
    ground_truth = Evaluation() if run.frame.ground_truth is None else evaluate_completion(run.frame, completion)
    return FrameOutcome(
        frame=frame.key,
        folder=frame.folder,
        time=frame.time,
        status=FrameStatus.COMPLETED,
        message="" if hidden is None else untrusted_note(run.frame),
        blocks=len(np.unique(run.blocks.labels[run.blocks.labels > 0])),
        pixels=missing.size,
        missing_before=int(np.count_nonzero(missing)),
        missing_after=int(np.count_nonzero(missing & np.isnan(completion.depth))),
        outside_view=0 if outside is None else int(np.count_nonzero(outside)),
        expected_error_median=_rounded(expected.median),
        expected_error_p90=_rounded(expected.p90),
        hold_out_mae=_rounded(whole.mae),
        hold_out_rmse=_rounded(whole.rmse),
        truth_mae=_rounded(ground_truth.mae),
        truth_rmse=_rounded(ground_truth.rmse),
    )


def _rounded(metres: float | np.floating) -> float | None:
    """Round to a micrometre; None for NaN."""
    return None if np.isnan(metres) else round(float(metres), 6)
