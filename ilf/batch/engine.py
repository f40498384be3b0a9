"""One engine for many frames: `complete_many` completes what a sink lacks, in processes here or on a Dask cluster.

    frames, settings --open_folder | open_shards--> Sink --complete_many--> outcomes
                                                      ^            |
                                 what is done --------+<-- put ----+  in a worker, frame by frame

A sink is a folder of results or a folder of shards. All that is known of an earlier or another process is in it.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import Any, Self

import cv2
import numpy as np

from .._runtime.children import run_in_processes
from .._runtime.long_work import available_cores, not_cancelled
from ..completion.confidence.expected_error import error_summary
from ..data.results import Completion
from ..errors import Cancelled, IlfError, InputError
from ..evaluation.evaluation import Evaluation, evaluate_completion
from ..evaluation.hold_out import evaluate_hold_out, untrusted_note
from ..run.run import Run
from .cluster import check_wanted, run_on_cluster, threads_of_worker
from .frame_record import FrameOutcome, LoadedFrame, read_frame
from .frames import BatchFrame
from .settings import BatchSettings

Outcomes = Generator[FrameOutcome, None, None]

Unit = Any
"""What a task on a cluster completes: a frame of a folder, or the index of a shard."""

CRASHED = "The process crashed twice, then alone. Memory may have run out, or the frame makes a library crash."
"""Message of a frame whose process has crashed repeatedly."""

OTHER_MACHINE = "This machine differs in program version, networks or files from the batch. Install the same on all."
"""Message of a worker whose settings have another hash."""

OTHER_BATCH = "Another batch has begun in {folder} with other settings. Choose another folder."
"""Message of a batch whose folder no longer has its settings."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Sink(ABC):
    """Where completed frames go, and what is left to complete. Workers have a copy.

    Attributes
    ----------
    settings : BatchSettings
    strict : bool
        Whether a frame with plausibility warnings fails.
    to_do : collection
        The units that are not finished.
    counts : Counter of str
        Numbers of frames that concern this batch: completed, failed, completed_before, failed_before, not_done. Brought
        up to date by `complete_many`.
    earlier : tuple of FrameOutcome
        Outcomes of the frames that were done before and are not done again, as far as the sink lists them.
    """

    settings: BatchSettings
    strict: bool = False
    to_do: Collection[Unit] = ()
    counts: Counter[str] = field(default_factory=Counter)
    earlier: tuple[FrameOutcome, ...] = ()

    # A frame, in any process.

    @abstractmethod
    def done(self, frame: BatchFrame) -> FrameOutcome | None:
        """Return the outcome of a frame that needs no more work; else None."""

    def tidy(self, frame: BatchFrame) -> None:  # noqa: B027 - not all sinks have anything to remove
        """Remove what a crashed worker has left of a frame."""

    def run_of(self, frame: BatchFrame, reading: LoadedFrame) -> tuple[Run, Sequence[str]]:
        """Return the run of what was read of a frame, and notes; raises IlfError before it is run if its files cannot
        be written."""
        return self.settings.run_of(reading.frame), ()

    @abstractmethod
    def write(self, frame: BatchFrame, reading: LoadedFrame, completion: Completion) -> tuple[Any, Sequence[str]]:
        """Write or encode the files of a completed frame; return what `put` needs of them, and notes on them."""

    @abstractmethod
    def put(self, frame: BatchFrame, outcome: FrameOutcome, written: Any = None) -> None:
        """Store a frame's outcome, which makes it done; `written` is None for a failed frame. Raises ExportError."""

    # A unit, which is stored as a whole: each frame alone, unless a sink says otherwise.

    @abstractmethod
    def bare(self) -> Self:
        """Return a copy for workers, without what is left to do."""

    @abstractmethod
    def check_here(self) -> None:
        """Raise InputError if this machine does not see the results, or would give others."""

    def unit_of(self, frame: BatchFrame) -> Unit:
        """Return the unit of a frame."""
        return frame

    def begin(self, unit: Unit) -> bool:
        """Return whether no other process has begun a unit, which has now been begun."""
        return True

    def frames_of(self, unit: Unit) -> list[BatchFrame]:
        """Return the frames of a unit that are left to complete; none if another process has finished it."""
        return [unit]

    def finish(self, unit: Unit) -> None:  # noqa: B027 - a folder is finished with its frame
        """Store a unit whose frames are all done; raises ExportError."""

    @abstractmethod
    def outcomes(self, unit: Unit) -> Iterator[FrameOutcome]:
        """Yield the outcomes of a unit that another process has finished, as far as they were left to complete here;
        raises InputError if they are not here."""

    @abstractmethod
    def close(self) -> None:
        """Conclude the work, however it has ended; raises ExportError."""


def complete_many(sink: Sink, *, jobs: int = 1, cluster: str | None = None) -> Outcomes:
    """Complete the frames that a sink lacks, and yield their outcomes in order of completion.

    A frame whose process crashes is tried once more at the end, alone; if it crashes again, it has failed. Units that a
    cluster gives up are completed here. When this generator is closed, the work stops and its processes have ended;
    frames in progress are discarded.

    Parameters
    ----------
    sink : Sink
    jobs : int
        Number of processes on this machine, which share its cores.
    cluster : str, optional
        Dask scheduler to use instead: its address, or its scheduler file.

    Raises
    ------
    IlfError
        For errors that affect all frames, such as a full disk or a lost scheduler. An error of a single frame becomes
        its outcome.
    """
    try:
        for outcome in _outcomes(sink, jobs, cluster):
            sink.counts.update({outcome.status: 1, "not_done": -1})
            yield outcome
    finally:
        with not_cancelled():
            sink.close()


def _outcomes(sink: Sink, jobs: int, cluster: str | None) -> Outcomes:
    units = list(sink.to_do)
    if cluster is not None and units:
        given_up = []
        for unit, done in run_on_cluster(partial(_on_worker, sink.bare()), units, cluster):
            if done is None:
                given_up.append(unit)
            else:
                yield from sink.outcomes(unit)
        units, jobs = given_up, 1
    yield from _in_processes(sink, units, jobs)


def _in_processes(sink: Sink, units: Iterable[Unit], jobs: int) -> Outcomes:
    """Complete units frame by frame in processes of this machine; finish each after its last frame."""
    left: dict[Unit, int] = {}
    elsewhere: list[Unit] = []
    work = partial(complete_frame, sink.bare(), threads=max(available_cores() // jobs, 1))
    for frame, outcome in run_in_processes(work, _frames(sink, units, left, elsewhere), jobs=jobs, tidy=sink.tidy):
        if outcome is None:
            outcome = failed_outcome(frame, CRASHED)
            sink.put(frame, outcome)
        yield outcome
        unit = sink.unit_of(frame)
        left[unit] -= 1
        if not left[unit]:
            del left[unit]
            sink.finish(unit)
    for unit in elsewhere:
        yield from sink.outcomes(unit)


def _frames(sink: Sink, units: Iterable[Unit], left: dict[Unit, int], elsewhere: list[Unit]) -> Iterator[BatchFrame]:
    """Yield the frames of units, and count them. Units that no process has begun come first; in the others, which
    another one may be at, the last frame does. Units without frames are finished, and added to `elsewhere`."""

    def opened(unit: Unit) -> list[BatchFrame]:
        frames = sink.frames_of(unit)
        if frames:
            left[unit] = len(frames)
        else:
            sink.finish(unit)
            elsewhere.append(unit)
        return frames

    begun = []
    for unit in units:
        if sink.begin(unit):
            yield from opened(unit)
        else:
            begun.append(unit)
    for unit in begun:
        yield from reversed(opened(unit))


def _on_worker(sink: Sink, unit: Unit) -> bool:
    complete_unit(sink, unit, threads_of_worker(), check_wanted)
    return True


def complete_unit(
    sink: Sink, unit: Unit, threads: int | None = None, before_each: Callable[[], object] = lambda: None
) -> None:
    """Complete a unit in this process, which is a worker of a cluster. It may be repeated after a crash: the frame in
    progress then is completed last, so that the others are done if it crashes again.

    Raises
    ------
    InputError
        As `Sink.check_here`.
    ExportError
        If a file cannot be written.
    """
    sink.check_here()
    begun = not sink.begin(unit)
    frames = sink.frames_of(unit)
    for frame in frames[1:] + frames[:1] if begun else frames:
        before_each()
        complete_frame(sink, frame, threads)
    sink.finish(unit)


def complete_frame(sink: Sink, frame: BatchFrame, threads: int | None = None) -> FrameOutcome:
    """Complete a frame and put it into a sink, unless it is done. Errors of the frame itself become its outcome.

    Parameters
    ----------
    sink : Sink
    frame : BatchFrame
    threads : int, optional
        As for `Run.steps`.

    Raises
    ------
    ExportError
        If the outcome cannot be written.
    """
    if (done := sink.done(frame)) is not None:
        return done
    if threads is not None:
        cv2.setNumThreads(threads)
    sink.tidy(frame)
    started = time.perf_counter()
    written = None
    try:
        outcome, written = _completed(sink, frame, threads)
    except Cancelled:
        raise
    except Exception as error:
        if (done := sink.done(frame)) is not None:  # another process has completed it meanwhile
            return done
        text = str(error) if isinstance(error, IlfError) else f"{type(error).__name__}: {error}"
        outcome = failed_outcome(frame, text)
    outcome = replace(outcome, seconds=round(time.perf_counter() - started, 3))
    sink.put(frame, outcome, written)
    return outcome


def failed_outcome(frame: BatchFrame, message: str) -> FrameOutcome:
    """Return the outcome of a failed frame; the message becomes one line."""
    return FrameOutcome(frame.key, frame.folder, frame.time, "failed", " ".join(message.split()))


@lru_cache(1)
def facts_here(settings: BatchSettings) -> dict[str, Any]:
    """Return the facts of settings on this machine; computed once per worker."""
    return settings.facts()


def _completed(sink: Sink, frame: BatchFrame, threads: int | None) -> tuple[FrameOutcome, Any]:
    """Complete a frame; return its outcome and what was written."""
    reading = read_frame(frame)
    plausibility_warnings = " ".join(reading.frame.plausibility_warnings)
    if plausibility_warnings and sink.strict:
        raise InputError(plausibility_warnings)
    run, notes = sink.run_of(frame, reading)
    notes = [*run.frame.notes, *run.blocks.notes, *notes]
    completion = run.complete(threads=threads)
    outcome = _measured(sink.settings, frame, completion, threads)
    written, more = sink.write(frame, reading, completion)
    notes += [outcome.message, *completion.notes, *more]
    message = " ".join(dict.fromkeys(filter(None, notes)))
    return replace(outcome, message=message, plausibility_warnings=plausibility_warnings), written


def _measured(settings: BatchSettings, frame: BatchFrame, completion: Completion, threads: int | None) -> FrameOutcome:
    """Return the figures of a completed frame; its message tells of known depth that the hold-out leaves out."""
    run, hidden, expected = completion.run, settings.hidden, error_summary(completion)
    missing, outside = run.frame.missing, run.frame.outside_view
    whole = Evaluation() if hidden is None else evaluate_hold_out(run, hidden, threads=threads).whole
    ground_truth = Evaluation() if run.frame.ground_truth is None else evaluate_completion(run.frame, completion)
    return FrameOutcome(
        frame=frame.key,
        folder=frame.folder,
        time_s=frame.time,
        status="completed",
        message="" if hidden is None else untrusted_note(run.frame),
        blocks=len(np.unique(run.blocks.labels[run.blocks.labels > 0])),
        pixels=missing.size,
        missing_before=int(np.count_nonzero(missing)),
        missing_after=int(np.count_nonzero(missing & np.isnan(completion.depth))),
        outside_view=0 if outside is None else int(np.count_nonzero(outside)),
        expected_error_median_m=_rounded(expected.median),
        expected_error_p90_m=_rounded(expected.p90),
        hold_out_mae_m=_rounded(whole.mae),
        hold_out_rmse_m=_rounded(whole.rmse),
        truth_mae_m=_rounded(ground_truth.mae),
        truth_rmse_m=_rounded(ground_truth.rmse),
    )


def _rounded(metres: float | np.floating) -> float | None:
    """Round to a micrometre; None for NaN."""
    return None if np.isnan(metres) else round(float(metres), 6)
