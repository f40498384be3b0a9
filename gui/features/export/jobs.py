"""What is exported, step by step, in any thread: a step is the `ExportedFrame` of a frame, or `Progress`."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from pathlib import Path

from ilf._runtime.formatting import millimetres
from ilf._runtime.writing import ensure_folder, write_bytes
from ilf.batch.engine import complete_many
from ilf.batch.folder_sink import open_folder
from ilf.batch.frame_record import FrameOutcome
from ilf.batch.frames import BatchFrame, frames_of_files
from ilf.batch.settings import BatchSettings
from ilf.completion.confidence.expected_error import MEDIAN_NAME
from ilf.data.frame import RGBDFrame
from ilf.data.parameters import Parameters
from ilf.data.results import Completion, compose
from ilf.errors import IlfError, InputError
from ilf.evaluation.evaluation import Progress
from ilf.evaluation.hold_out import HoldOutTest
from ilf.project.exporting import ExportedFrame, ExportStatus, FrameToExport, Read, in_folders, run_and_completion
from ilf.project.recorded_frames import recorded_run
from ilf.project.state_codec import Decoded
from ilf.report.report import report_steps, write_report
from ilf.report.subject import Subject, Unreadable
from ilf.run.options import ExportOptions
from ilf.run.run import BlockChoice, Run
from ilf.sources.reading import read_frame

from ...project.loading import state_reader
from ...project.store import WorkStore
from ...state.document import Document
from ...state.parameters import DocumentParameters
from ...state.workspace import Entry
from ...work.jobs import spare_cores
from .pdf import pdf_of

Step = ExportedFrame | Progress


class Scope(StrEnum):
    """Choices of frames, as they are offered."""

    THIS = "This frame"
    DONE = "Frames marked as done"
    WORKED_ON = "Frames that have been worked on"
    SELECTED = "Selected rows of the list"
    ALL = "All frames of the list"


@dataclass(frozen=True)
class Export:
    """What the user wants to be written.

    Attributes
    ----------
    folder : Path
    options : ExportOptions
    scope : Scope
    from_files : bool
        Whether frames are completed anew, as a batch.
    jobs : int
        Number of processes of a batch.
    pictures : sequence of callable
        What writes the pictures of a batch.
    retry, anew : bool
        Whether a batch completes frames again that have failed, or whose settings or files have changed.
    report : Path or None
        The file of the report, HTML or PDF; None for no report.
    test : HoldOutTest or None
        Of the frames of the report.
    """

    folder: Path
    options: ExportOptions
    scope: Scope = Scope.THIS
    from_files: bool = False
    jobs: int = 1
    pictures: Sequence[Callable[[Path, Sequence[FrameOutcome]], Path]] = ()
    retry: bool = False
    anew: bool = False
    report: Path | None = None
    test: HoldOutTest | None = None


# Frames as they are in the window.


def present_frame(document: Document) -> tuple[Run, Completion | None]:
    """The run of an open frame as it is shown, and its completion; None if no block has a result."""
    return document.run(document.state.common, extrapolate=document.extrapolated), document.completion()


def behind(document: Document) -> str:
    """Describe which blocks of a frame lack up-to-date results; "" for none."""
    counts = document.counts()
    without = len(counts.keys() - document.valid_results().keys())
    otherwise = len(document.changed_blocks()) - without
    lacks = {
        "Not run in their current state, so that their missing depth stays missing": without,
        "Run with other parameters than the current ones": otherwise,
    }
    sentences = [f"{what}: {count} of {len(counts)} blocks." for what, count in lacks.items() if count]
    return " ".join([*sentences, "Run them first (F5)."] if sentences else [])


def frame_as_shown(document: Document) -> FrameToExport:
    """An open frame with the results that it has: depth of blocks without one stays missing."""
    run, completion = present_frame(document)
    found = compose(run, {}) if completion is None else completion
    return FrameToExport(document.name, "", lambda: (run, found))


def settings_of(parameters: DocumentParameters, options: ExportOptions) -> BatchSettings:
    """What frames without blocks are completed with, as those of a batch."""
    return BatchSettings(parameters.current, BlockChoice(parameters.extraction), options=options)


def frames_to_export(entries: Sequence[Entry], store: WorkStore, parameters: DocumentParameters) -> list[FrameToExport]:
    """Snapshot of frames, open or not; closed frames are read when they are reached, in any thread, from `store`."""
    make_run = settings_of(parameters, ExportOptions()).run_of

    def reader(entry: Entry) -> Read:
        read = _state_reader(entry, store, parameters.for_all)
        if read is None or (entry.document is not None and not entry.document.counts()):
            return partial(_of_files, entry, store, make_run)
        return lambda: run_and_completion(read().state)

    return in_folders((entry.name, entry.id, reader(entry)) for entry in entries)


def _state_reader(entry: Entry, store: WorkStore, for_all: Parameters | None) -> Callable[[], Decoded] | None:
    """As `state_reader`; a stored state gets the settings that were made since."""
    read, note = state_reader(entry, store), entry.note
    if read is None or entry.document is not None:
        return read

    def read_stored() -> Decoded:
        decoded = read()
        return replace(decoded, state=decoded.state.with_current_settings(note, for_all))

    return read_stored


def _of_files(entry: Entry, store: WorkStore, make_run: Callable[[RGBDFrame], Run]) -> tuple[Run, Completion | None]:
    if entry.source is None:
        raise InputError("It has not been read, and where from is not known. Open it first.")
    again = recorded_run(entry.source, store.places)
    return (make_run(read_frame(entry.source)), None) if again is None else (again.run, again.completion)


# Frames completed anew from their files, as a batch.


def batch_frames(entries: Iterable[Entry]) -> dict[str, BatchFrame]:
    """Return the frames of the list that have files, by their ids."""
    sources = {entry.id: entry.source for entry in entries if entry.source is not None}
    return dict(zip(sources, frames_of_files(list(sources.values())), strict=True))


def batch_steps(
    export: Export, frames: Sequence[BatchFrame], only: Sequence[BatchFrame], settings: BatchSettings
) -> Iterator[Step]:
    """Open a batch of frames and complete some, after those that were completed before; then write the pictures.

    Raises
    ------
    IlfError
        As from `open_folder` and `complete_many`, or if a picture cannot be written.
    """
    sink = open_folder(frames, export.folder, settings, only=only, anew=export.anew, retry_failed=export.retry)
    yield from (_exported(outcome, sink.folder, before=True) for outcome in sink.earlier)
    with closing(complete_many(sink, jobs=export.jobs)) as outcomes:
        for outcome in outcomes:
            yield _exported(outcome, sink.folder)
    for write in export.pictures:
        write(sink.folder, sink.recorded())


def _exported(outcome: FrameOutcome, folder: Path, before: bool = False) -> ExportedFrame:
    place = folder / outcome.folder
    if not outcome.is_completed:
        return ExportedFrame(outcome.frame, place, ExportStatus.FAILED, (outcome.message,))
    status = ExportStatus.UNCHANGED if before else ExportStatus.WRITTEN
    return ExportedFrame(outcome.frame, place, status, tuple(filter(None, (_figures(outcome), outcome.message))))


def _figures(outcome: FrameOutcome) -> str:
    figures = []
    if outcome.missing_before is not None and outcome.missing_after is not None and outcome.pixels:
        before, after = outcome.missing_before / outcome.pixels, outcome.missing_after / outcome.pixels
        figures.append(f"missing {before:.1%} → {after:.1%}")
    if outcome.expected_error_median_m is not None:
        figures.append(f"{MEDIAN_NAME.lower()} {millimetres(outcome.expected_error_median_m)} mm")
    if outcome.seconds is not None:
        figures.append(f"{outcome.seconds:.1f} s")
    return f"{', '.join(figures)}.".capitalize() if figures else ""


# A page on frames.


def subjects_of(
    entries: Sequence[Entry], store: WorkStore, for_all: Parameters | None
) -> list[Callable[[], Subject | Unreadable]]:
    """Return functions that read the subjects of frames in any thread, of those that are open or stored: open ones as
    they are now.

    `for_all`: the parameters shared by all frames, if any.
    """
    readers = ((entry.name, _state_reader(entry, store, for_all)) for entry in entries)
    return [partial(_subject, name, read) for name, read in readers if read is not None]


def _subject(name: str, read: Callable[[], Decoded]) -> Subject | Unreadable:
    try:
        decoded = read()
    except IlfError as error:
        return Unreadable(name, str(error))
    return Subject.of_state(decoded.state, problems=decoded.problems)


def report_file_steps(
    path: Path, subjects: Sequence[Callable[[], Subject | Unreadable]], hidden: HoldOutTest | None
) -> Generator[Progress, None, None]:
    """Write a report, as PDF if that is the suffix, otherwise as HTML; a subject is read when it is reached.

    Raises
    ------
    InputError
        As from `ilf.report.report.report_steps`.
    ExportError
        If the file cannot be written; an existing file stays unchanged.
    """
    read = (subject() for subject in subjects)
    report = yield from report_steps(read, len(subjects), hidden=hidden, threads=spare_cores())
    yield Progress(1.0, "writing")
    ensure_folder(path.parent)
    if path.suffix.lower() == ".pdf":
        write_bytes(path, pdf_of(report))
    else:
        write_report(path, report)
