"""A report as PDF: its HTML, printed on A4 pages."""

from __future__ import annotations

from PySide6.QtCore import QBuffer, QEventLoop, QIODevice, QSizeF
from PySide6.QtGui import (
    QAbstractTextDocumentLayout,
    QFont,
    QPageSize,
    QPdfWriter,
    QTextBlock,
    QTextBlockFormat,
    QTextCursor,
    QTextDocument,
    QTextFormat,
)

from ilf._runtime.installation import __version__
from ilf._runtime.long_work import check_cancelled
from ilf.report.report import Report
from ilf.report.templates import render

_TEXT_PT = 8
_MARGIN = 2 / 2.54 * 96
"""Margin that Qt prints with, 2 cm [px of 1/96 inch]."""


def pdf_of(report: Report) -> bytes:
    """Print a report, of which each part begins a page; returns the content of the file. May be used in any thread."""
    _events = QEventLoop()  # without one, a document complains in threads that Qt has not started
    document = QTextDocument()
    document.setDefaultFont(QFont("sans-serif", _TEXT_PT))
    document.setDefaultStyleSheet(render("style.css"))
    cursor, begins_page = QTextCursor(document), QTextBlockFormat()
    begins_page.setPageBreakPolicy(QTextFormat.PageBreakFlag.PageBreak_AlwaysBefore)
    for number, part in enumerate(report.parts):
        check_cancelled()
        if number:
            cursor.insertBlock(begins_page)
        cursor.insertHtml(f"<body>{part}</body>")
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    writer = QPdfWriter(buffer)
    writer.setPageSize(QPageSize(QPageSize.PageSizeId.A4))
    writer.setTitle(report.title)
    writer.setCreator(f"ILF Studio {__version__}")
    _keep_together(document, writer)
    document.print_(writer)
    return bytes(buffer.data().data())


def _keep_together(document: QTextDocument, writer: QPdfWriter) -> None:
    """Lower each heading that a page's end would part from what follows, and each row of a table that it would tear, to
    the next page."""
    printed = document.clone()  # as `print_` lays it out
    layout = printed.documentLayout()
    layout.setPaintDevice(writer)
    margins = printed.rootFrame().frameFormat()
    margins.setMargin(_MARGIN)
    printed.rootFrame().setFrameFormat(margins)
    printed.setPageSize(QSizeF(writer.width(), writer.height()))
    pixel, height = writer.logicalDpiY() / 96, writer.height()
    block, twin = printed.begin(), document.begin()
    while block.isValid():
        top = layout.blockBoundingRect(block).top()
        end = (top // height + 1) * height - _MARGIN * pixel  # of the page
        if top < end < _bottom(block, layout) < end + height:
            for start in (block, twin):
                _lower(QTextCursor(start), (end - top) / pixel)
        block, twin = block.next(), twin.next()


def _bottom(block: QTextBlock, layout: QAbstractTextDocumentLayout) -> float:
    """Bottom of what must be on one page with a block: the row of a table that it begins, what follows a heading."""
    cursor = QTextCursor(block)
    table = cursor.currentTable()
    last = [block]
    if table and table.cellAt(cursor).firstCursorPosition() == cursor and table.cellAt(cursor).column() == 0:
        row = table.cellAt(cursor).row()
        last = [table.cellAt(row, column).lastCursorPosition().block() for column in range(table.columns())]
    bottom = max(layout.blockBoundingRect(each).bottom() for each in last)
    if block.blockFormat().headingLevel() and block.next().isValid():
        bottom = max(bottom, _bottom(block.next(), layout))
    return bottom


def _lower(cursor: QTextCursor, by: float) -> None:
    """Begin a page at a block, which is so much lower [px]; in a table, lower the content of its row."""
    table = cursor.currentTable()
    if not table:
        heading = cursor.blockFormat()
        heading.setPageBreakPolicy(QTextFormat.PageBreakFlag.PageBreak_AlwaysBefore)
        cursor.setBlockFormat(heading)
        return
    row = table.cellAt(cursor).row()
    for column in range(table.columns()):
        cell = table.cellAt(row, column)
        form = cell.format().toTableCellFormat()
        form.setTopPadding(form.topPadding() + by)
        cell.setFormat(form)
