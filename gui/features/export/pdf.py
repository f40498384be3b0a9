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

from ilf._runtime.cancellation import check_cancelled
from ilf._runtime.installation import __version__
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
    """Begin a page before each heading and title that a page's end would part from what follows, and before each row of
    a table that it would tear."""
    printed = document.clone()  # as `print_` lays it out
    layout = printed.documentLayout()
    layout.setPaintDevice(writer)
    margins = printed.rootFrame().frameFormat()
    margins.setMargin(_MARGIN)
    printed.rootFrame().setFrameFormat(margins)
    printed.setPageSize(QSizeF(writer.width(), writer.height()))
    pixel, height = writer.logicalDpiY() / 96, writer.height()
    block, twin = printed.begin(), document.begin()
    while block.next().isValid():
        top, bottom = _row_at(block, layout)
        end = (top // height + 1) * height - _MARGIN * pixel  # of the page
        if top < end < bottom:
            for start in (block, twin):
                _lower_row(QTextCursor(start), (end - top) / pixel)
        ends = (layout.blockBoundingRect(each).bottom() + _MARGIN * pixel for each in (block, block.next()))
        page, next_page = (int((end - 1) // height) for end in ends)  # of its last line
        if block.blockFormat().headingLevel() and page != next_page:
            _begin_page(QTextCursor(block))
            _begin_page(QTextCursor(twin))
        block, twin = block.next(), twin.next()


def _row_at(block: QTextBlock, layout: QAbstractTextDocumentLayout) -> tuple[float, float]:
    """Top and bottom of the row of a table of several that begins with a block; zeros where none does."""
    cursor = QTextCursor(block)
    table = cursor.currentTable()
    if not table or table.rows() == 1 or (first := table.cellAt(cursor)).column() > 0:
        return 0.0, 0.0
    if first.firstCursorPosition() != cursor:
        return 0.0, 0.0
    cells = [table.cellAt(first.row(), column) for column in range(table.columns())]
    ends = (layout.blockBoundingRect(cell.lastCursorPosition().block()).bottom() for cell in cells)
    return layout.blockBoundingRect(block).top(), max(ends)


def _lower_row(cursor: QTextCursor, by: float) -> None:
    """Lower the content of a table's row [px]."""
    table = cursor.currentTable()
    row = table.cellAt(cursor).row()
    for column in range(table.columns()):
        cell = table.cellAt(row, column)
        form = cell.format().toTableCellFormat()
        form.setTopPadding(form.topPadding() + by)
        cell.setFormat(form)


def _begin_page(cursor: QTextCursor) -> None:
    """Begin a page at a heading; in a table, before the table and its own heading."""
    breaks = QTextFormat.PageBreakFlag.PageBreak_AlwaysBefore
    if table := cursor.currentTable():
        cursor.setPosition(table.firstPosition() - 1)
        cursor.movePosition(QTextCursor.MoveOperation.PreviousCharacter)
    if table and not cursor.blockFormat().headingLevel():
        form = table.format()
        form.setPageBreakPolicy(breaks)
        table.setFormat(form)
    else:
        heading = cursor.blockFormat()
        heading.setPageBreakPolicy(breaks)
        cursor.setBlockFormat(heading)
