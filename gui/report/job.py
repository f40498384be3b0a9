"""Writing a report, step by step, in any thread."""

from __future__ import annotations

from collections.abc import Generator, Iterable
from pathlib import Path

from gui.report.pdf import write_pdf
from ilf.judgement import Step
from ilf.judgement.step import part_of
from ilf.report import ReportOptions, Subject, Unreadable, made_text, report_steps, write_report

_OF_CONTENT = 0.8
"""Share of the work that is done when the pages begin to be written."""


def write_steps(
    path: Path, subjects: Iterable[Subject | Unreadable], count: int, options: ReportOptions
) -> Generator[Step, None, Path]:
    """Write a report of so many subjects, as PDF if the file is called so, otherwise as HTML.

    Raises
    ------
    InputError
        As `ilf.report.report_steps` does.
    ExportError
        If the file cannot be written; what was there is as it was.
    """
    content = yield from part_of(report_steps(subjects, options, count), 0.0, _OF_CONTENT)
    if path.suffix.lower() == ".pdf":
        yield from part_of(write_pdf(path, content, made_text(options)), _OF_CONTENT, 1 - _OF_CONTENT, "writing ")
    else:
        yield Step(_OF_CONTENT, "writing")
        write_report(path, content, options)
    return path
