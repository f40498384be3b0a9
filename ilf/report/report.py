"""Making a report of subjects, step by step."""

from __future__ import annotations

import datetime
import os
from collections.abc import Generator, Iterable, Sequence
from dataclasses import dataclass, field, replace

from .._runtime.files import write_bytes
from ..errors import InputError
from ..evaluation.evaluation import Step, run_to_end, scaled_progress
from ..evaluation.hold_out import HoldOutResult, HoldOutTest, hold_out_steps
from .chapters import Entry, frame_chapter, index_chapter, index_entry, unreadable_chapter
from .content import Chapter, Report, Subject, Unreadable
from .frame_statistics import FrameStatistics
from .page import page

_MAX_PIXELS, _MAX_PIXELS_WITH_INDEX = 1024, 640


@dataclass(frozen=True)
class ReportOptions:
    """Options of a report.

    Parameters
    ----------
    title : str
        Title of a report of several frames; a report of one frame has the frame's name.
    hidden : HoldOutTest, optional
        Also evaluate every frame with results on hold-out; repeats its run once per seed.
    made : datetime
        Date of the report.
    threads : int, optional
        As for `Run.steps`.
    """

    title: str = "Report"
    hidden: HoldOutTest | None = None
    made: datetime.datetime = field(default_factory=datetime.datetime.now)
    threads: int | None = None


def report(subjects: Iterable[Subject | Unreadable], options: ReportOptions | None = None) -> str:
    """Make one self-contained HTML page about frames: pictures, blocks, parameters, curves, errors, versions, hashes.

    It needs no other file, no network and no script.

    Parameters
    ----------
    subjects : iterable of Subject or Unreadable
        One subject gives a report of one frame, several a report with an index. Iterated once.
    options : ReportOptions, optional

    Raises
    ------
    InputError
        If there is no subject, or too little known depth for a hold-out.

    Examples
    --------
    >>> import numpy as np, ilf
    >>> depth = np.full((40, 50), 2.0)
    >>> depth[10:20, 10:20] = np.nan
    >>> run = ilf.Run(ilf.RGBDFrame(np.zeros((40, 50, 3), np.uint8), depth, name="plain"), np.ones((40, 50), np.int32))
    >>> text = report([Subject(run, run.complete())])
    >>> text.startswith("<!doctype html>"), "<h1>plain</h1>" in text
    (True, True)
    """
    chosen = options or ReportOptions()
    return html_of(run_to_end(report_steps(list(subjects), chosen)), chosen)


def html_of(content: Report, options: ReportOptions) -> str:
    """Return the HTML page of a report."""
    return page(content, date_text(options))


def date_text(options: ReportOptions) -> str:
    """Return the date of a report as text."""
    return f"{options.made:%d %B %Y, %H:%M}"


def write_report(path: str | os.PathLike[str], content: Report, options: ReportOptions) -> None:
    """Write a report's page; raises ExportError if that fails, and then leaves an existing file unchanged."""
    # file names may contain bytes that cannot be encoded
    write_bytes(path, html_of(content, options).encode(errors="replace"))


def report_steps(
    subjects: Iterable[Subject | Unreadable], options: ReportOptions, count: int | None = None
) -> Generator[Step, None, Report]:
    """Make the content of a report step by step, so that the caller can show progress and cancel.

    Parameters
    ----------
    subjects : iterable of Subject or Unreadable
        Iterated once and not kept, so that frames can be loaded one after the other.
    options : ReportOptions
    count : int, optional
        Number of subjects, if `subjects` has no length.

    Yields
    ------
    Step

    Returns
    -------
    Report

    Raises
    ------
    InputError
        As for `report`.
    """
    total = count if count is not None else len(subjects) if isinstance(subjects, Sequence) else 1
    most = _MAX_PIXELS if total == 1 else _MAX_PIXELS_WITH_INDEX
    chapters: list[Chapter] = []
    entries: list[Entry] = []
    for number, subject in enumerate(subjects):
        id, done = f"frame-{number + 1}", min(number / total, 1.0)
        if isinstance(subject, Unreadable):
            chapters.append(unreadable_chapter(id, subject))
            entries.append(Entry(id, subject.name, None, note=subject.why))
            continue
        name = subject.run.frame.name
        yield Step(done, name)
        hidden = yield from scaled_progress(_hold_out_result(subject, options), done, 1 / total, f"{name}, hold-out: ")
        figures = FrameStatistics(subject, hidden)
        chapters.append(frame_chapter(id, figures, most))
        if total > 1:
            entries.append(index_entry(id, figures))
    if not chapters:
        raise InputError("There is no frame to report on. Give at least one.")
    if total > 1:
        return Report(options.title, (index_chapter(options.title, entries), *chapters))
    return Report(chapters[0].title, tuple(chapters))


def _hold_out_result(subject: Subject, options: ReportOptions) -> Generator[Step, None, HoldOutResult | None]:
    """Evaluate the blocks with results on hold-out, with the parameters of these results; None if not requested, or
    if there are no results."""
    results = subject.completion.results
    if options.hidden is None or not results:
        return None
    run = replace(subject.run, own={label: result.parameters for label, result in results.items()})
    return (yield from hold_out_steps(run, options.hidden, list(results), threads=options.threads))
