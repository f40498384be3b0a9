"""Making a report of subjects, step by step."""

from __future__ import annotations

import datetime
import os
from collections.abc import Generator, Iterable
from dataclasses import dataclass, field

from .._runtime.writing import write_bytes
from ..completion.confidence.expected_error import RMS_MEANING, RMS_NAME
from ..errors import InputError
from ..evaluation.evaluation import Progress, scaled_progress
from ..evaluation.hold_out import HoldOutTest, RunEvaluation, hold_out_steps
from .frame_page import frame_page
from .subject import Subject, Unreadable
from .templates import render

_MAX_PIXELS, _MAX_PIXELS_WITH_INDEX = 1024, 640

_INDEX = {
    "size [px]": "",
    "missing in": "Share of the pixels without depth, in the depth camera's view",
    "missing out": "The same after completion",
    "blocks": "",
    "with result": "Number of blocks that were run",
    f"{RMS_NAME} [mm]": RMS_MEANING,
    "ground truth [mm]": "Root mean square error of filled pixels against ground truth",
    "hold-out [mm]": "Root mean square error on hold-out",
    "note": "",
}
"""Headings of the index, and what they mean."""


@dataclass(frozen=True)
class Report:
    """The content of a report as HTML, without the head of the page.

    Attributes
    ----------
    title : str
    parts : tuple of str
        The index, if there are several frames, and the frames.
    """

    title: str
    parts: tuple[str, ...] = field(repr=False)

    def html(self) -> str:
        """Return the page; it needs no other file, no network and no script."""
        return render("page.html", title=self.title, parts=self.parts)


def write_report(path: str | os.PathLike[str], content: Report) -> None:
    """Write a report's page; raises ExportError if that fails, and then leaves an existing file unchanged."""
    # file names may contain bytes that cannot be encoded
    write_bytes(path, content.html().encode(errors="replace"))


def report_steps(
    subjects: Iterable[Subject | Unreadable],
    count: int,
    *,
    title: str = "Report",
    hidden: HoldOutTest | None = None,
    threads: int | None = None,
) -> Generator[Progress, None, Report]:
    """Make one self-contained HTML page about frames: pictures, blocks, parameters, curves, errors, versions, hashes;
    step by step, so that the caller can show progress and cancel.

    Parameters
    ----------
    subjects : iterable of Subject or Unreadable
        One gives a report of one frame, several a report with an index. Iterated once and not kept, so that frames can
        be loaded one after the other.
    count : int
        Number of subjects.
    title : str
        Title of a report of several frames; a report of one frame has the frame's name.
    hidden : HoldOutTest, optional
        Also evaluate every frame with results on hold-out; repeats its run once per seed.
    threads : int, optional
        As for `Run.steps`.

    Yields
    ------
    Progress

    Returns
    -------
    Report

    Raises
    ------
    InputError
        If there is no subject, or too little known depth for a hold-out.

    Examples
    --------
    >>> import numpy as np, ilf
    >>> from ilf._runtime.long_work import run_to_end
    >>> depth = np.full((40, 50), 2.0)
    >>> depth[10:20, 10:20] = np.nan
    >>> run = ilf.Run(ilf.RGBDFrame(np.zeros((40, 50, 3), np.uint8), depth, name="plain"), np.ones((40, 50), np.int32))
    >>> text = run_to_end(report_steps([Subject(run.complete())], 1)).html()
    >>> text.startswith("<!doctype html>"), "<h1>plain</h1>" in text
    (True, True)
    """
    most = _MAX_PIXELS if count == 1 else _MAX_PIXELS_WITH_INDEX
    parts: list[str] = []
    rows: list[dict[str, str]] = []
    for number, subject in enumerate(subjects):
        id, done = f"frame-{number + 1}", number / count
        if isinstance(subject, Unreadable):
            parts.append(render("unreadable.html", id=id, frame=subject))
            rows.append({"id": id, "name": subject.name, "image": "", "note": subject.why})
            continue
        name = subject.run.frame.name
        yield Progress(done, name)
        test = _hold_out_result(subject, hidden, threads)
        hidden_error = yield from scaled_progress(test, done, 1 / count, f"{name}, hold-out: ")
        html, row = frame_page(subject, id, most, hidden_error)
        parts.append(html)
        rows.append(row)
    if not parts:
        raise InputError("There is no frame to report on. Give at least one.")
    if count == 1:
        title = rows[0]["name"]
    else:
        columns = {heading: about for heading, about in _INDEX.items() if any(row.get(heading) for row in rows)}
        parts.insert(0, render("index.html", title=title, columns=columns, rows=rows))
    parts[-1] += render("foot.html", made=f"{datetime.datetime.now():%d %B %Y, %H:%M}")
    return Report(title, tuple(parts))


def _hold_out_result(
    subject: Subject, hidden: HoldOutTest | None, threads: int | None
) -> Generator[Progress, None, RunEvaluation | None]:
    """Evaluate the blocks with results on hold-out, with the parameters of these results; None if not requested, or
    if there are no results."""
    results = subject.completion.results
    if hidden is None or not results:
        return None
    run = subject.run.with_parameters(subject.run.parameters, {label: one.parameters for label, one in results.items()})
    return (yield from hold_out_steps(run, hidden, list(results), threads=threads))
