"""Reports of frames: one self-contained HTML page each, or one of many; `content.py` says what stands in it."""

from .content import Report
from .report import ReportOptions, html_of, made_text, report, report_steps, write_report
from .subject import Subject, Unreadable

__all__ = [
    "Report",
    "ReportOptions",
    "Subject",
    "Unreadable",
    "html_of",
    "made_text",
    "report",
    "report_steps",
    "write_report",
]
