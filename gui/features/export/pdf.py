"""A report as PDF: its HTML, printed on A4 pages."""

from __future__ import annotations

from collections.abc import Generator

from PySide6.QtCore import QBuffer, QEventLoop, QIODevice, QMarginsF, QRectF, QSizeF, Qt
from PySide6.QtGui import (
    QFont,
    QPageSize,
    QPainter,
    QPdfWriter,
    QTextBlock,
    QTextCursor,
    QTextDocument,
    QTextFormat,
    QTextFrame,
    QTextTable,
)

from ilf._runtime.installation import __version__
from ilf.evaluation.evaluation import Progress
from ilf.report.report import Report
from ilf.report.templates import render

_DPI = 300
_MARGIN_MM, _FOOT_MM = 15.0, 7.0
_TEXT_PT, _FOOT_PT = 8, 7
_NEW_PAGE = QTextFormat.PageBreakFlag.PageBreak_AlwaysBefore


def pdf_steps(report: Report) -> Generator[Progress, None, bytes]:
    """Print a report, a step per page; returns the content of the file. May be used in any thread."""
    _events = QEventLoop()  # without one, a document complains in threads that Qt has not started
    buffer = QBuffer()
    buffer.open(QIODevice.OpenModeFlag.WriteOnly)
    writer = QPdfWriter(buffer)
    writer.setResolution(_DPI)
    writer.setPageSize(QPageSize(QPageSize.PageSizeId.A4))
    writer.setPageMargins(QMarginsF(0, 0, 0, 0))
    writer.setTitle(report.title)
    writer.setCreator(f"ILF Studio {__version__}")
    dot = _DPI / 25.4
    area = QRectF(0, 0, writer.width() - 2 * _MARGIN_MM * dot, writer.height() - (2 * _MARGIN_MM + _FOOT_MM) * dot)
    foot = QRectF(0, area.height(), area.width(), _FOOT_MM * dot)
    painter = QPainter(writer)
    try:
        number = 0
        for place, part in enumerate(report.parts):
            document = _document(part, writer, area.size())
            for page in range(document.pageCount()):
                yield Progress((place + page / document.pageCount()) / len(report.parts), f"page {number + 1}")
                if number:
                    writer.newPage()
                number += 1
                painter.resetTransform()
                painter.translate(_MARGIN_MM * dot, _MARGIN_MM * dot)
                _draw_foot(painter, foot, report.title, number)
                painter.translate(0, -page * area.height())
                document.drawContents(painter, area.translated(0, page * area.height()))
    finally:
        painter.end()
    return bytes(buffer.data().data())


def _document(html: str, writer: QPdfWriter, size: QSizeF) -> QTextDocument:
    document = QTextDocument()
    document.documentLayout().setPaintDevice(writer)
    document.setDefaultFont(QFont("sans-serif", _TEXT_PT))
    document.setDocumentMargin(0)
    document.setDefaultStyleSheet(render("style.css"))
    document.setHtml(f"<body>{html}</body>")
    document.setPageSize(size)
    _keep_together(document)
    return document


def _keep_together(document: QTextDocument) -> None:
    """Begin a new page before figures that the end of a page would cut, and before headings that it would leave."""
    height = document.pageSize().height()
    parts: list[QTextFrame | QTextBlock] = []
    place = document.rootFrame().begin()
    while not place.atEnd():
        frame = place.currentFrame()
        parts.append(place.currentBlock() if frame is None else frame)
        place += 1
    for part, after in zip(parts, [*parts[1:], parts[-1]], strict=True):
        top, bottom = _extent(document, part)
        if isinstance(part, QTextBlock) and part.blockFormat().headingLevel():
            bottom = _extent(document, after)[1]
        if top // height != (bottom - 1) // height:
            if isinstance(part, QTextBlock):
                format = part.blockFormat()
                format.setPageBreakPolicy(_NEW_PAGE)
                QTextCursor(part).setBlockFormat(format)
            else:
                frame_format = part.frameFormat()
                frame_format.setPageBreakPolicy(_NEW_PAGE)
                part.setFrameFormat(frame_format)


def _extent(document: QTextDocument, part: QTextBlock | QTextFrame) -> tuple[float, float]:
    """Return top and bottom of a paragraph or a table; of a table with a head, only those of head and first row."""
    layout = document.documentLayout()
    if isinstance(part, QTextBlock):
        rect = layout.blockBoundingRect(part)
        return rect.top(), rect.bottom()
    rect = layout.frameBoundingRect(part)
    if isinstance(part, QTextTable) and (head := part.format().toTableFormat().headerRowCount()):
        return rect.top(), layout.blockBoundingRect(part.cellAt(head, 0).lastCursorPosition().block()).bottom()
    return rect.top(), rect.bottom()


def _draw_foot(painter: QPainter, place: QRectF, title: str, number: int) -> None:
    painter.setFont(QFont("sans-serif", _FOOT_PT))
    text = painter.fontMetrics().elidedText(title, Qt.TextElideMode.ElideRight, round(0.8 * place.width()))
    painter.drawText(place, Qt.AlignmentFlag.AlignBottom | Qt.AlignmentFlag.AlignLeft, text)
    painter.drawText(place, Qt.AlignmentFlag.AlignBottom | Qt.AlignmentFlag.AlignRight, str(number))
