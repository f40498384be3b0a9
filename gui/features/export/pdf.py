"""A report as PDF: its HTML, printed on A4 pages."""

from __future__ import annotations

from collections.abc import Generator

from PySide6.QtCore import QBuffer, QEventLoop, QIODevice
from PySide6.QtGui import QFont, QPageSize, QPdfWriter, QTextBlockFormat, QTextCursor, QTextDocument, QTextFormat

from ilf._runtime.installation import __version__
from ilf.evaluation.evaluation import Progress
from ilf.report.report import Report
from ilf.report.templates import render

_TEXT_PT = 8


def pdf_steps(report: Report) -> Generator[Progress, None, bytes]:
    """Print a report, a step per part, each of which begins a page; returns the content of the file. May be used in any
    thread."""
    _events = QEventLoop()  # without one, a document complains in threads that Qt has not started
    document = QTextDocument()
    document.setDefaultFont(QFont("sans-serif", _TEXT_PT))
    document.setDefaultStyleSheet(render("style.css"))
    cursor, begins_page = QTextCursor(document), QTextBlockFormat()
    begins_page.setPageBreakPolicy(QTextFormat.PageBreakFlag.PageBreak_AlwaysBefore)
    for number, part in enumerate(report.parts):
        yield Progress(number / len(report.parts), f"part {number + 1}")
        if number:
            cursor.insertBlock(begins_page)
        cursor.insertHtml(f"<body>{part}</body>")
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    writer = QPdfWriter(buffer)
    writer.setPageSize(QPageSize(QPageSize.PageSizeId.A4))
    writer.setTitle(report.title)
    writer.setCreator(f"ILF Studio {__version__}")
    document.print_(writer)
    return bytes(buffer.data().data())
