"""Pieces of a document, one below the other, on the numbered pages of a PDF."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QMarginsF, QRectF, Qt
from PySide6.QtGui import (
    QAbstractTextDocumentLayout,
    QColor,
    QFont,
    QImage,
    QPageSize,
    QPainter,
    QPalette,
    QPdfWriter,
    QTextDocument,
)

from ilf.errors import ExportError
from ilf.version import __version__

DPI = 300
_MARGIN_MM = 15.0
_FOOT_MM = 9.0
_TEXT_PT, _FOOT_PT = 9.0, 7.5
_STYLE = "body {{ color: #1c2126; }} th {{ color: #5c6670; }} .soft {{ color: #5c6670; font-size: {small}px; }}"


def millimetres(length: float) -> float:
    """Millimetres in the units of the pages."""
    return length * DPI / 25.4


def points(size: float) -> float:
    """Points in the units of the pages."""
    return size * DPI / 72


class Pages:
    """Pages that are written from top to bottom; to be closed at the end.

    Everything is laid out in dots of the page, so that nothing depends on any screen. May be used in any thread, from
    one at a time.

    Parameters
    ----------
    path : Path
    title : str
        Of the document, and in its pages' feet.
    """

    def __init__(self, path: Path, title: str) -> None:
        writer = self._writer = QPdfWriter(str(path))
        writer.setResolution(DPI)
        writer.setPageSize(QPageSize(QPageSize.PageSizeId.A4))
        writer.setPageMargins(QMarginsF(0, 0, 0, 0))
        writer.setTitle(title)
        writer.setCreator(f"ILF Studio {__version__}")
        self._title = title
        size = QPageSize(QPageSize.PageSizeId.A4).sizePixels(DPI)
        margin = millimetres(_MARGIN_MM)
        self._area = QRectF(margin, margin, size.width() - 2 * margin, size.height() - 2 * margin - _foot())
        self._y = 0.0
        self.number = 1
        self._painter = QPainter()
        if not self._painter.begin(writer):
            raise ExportError(f"Could not write {path}. Choose another folder, or make space.")

    @property
    def width(self) -> float:
        """Of all pieces, in dots."""
        return self._area.width()

    @property
    def height(self) -> float:
        """Of an empty page, in dots."""
        return self._area.height()

    @property
    def left(self) -> float:
        """What is left of the present page, in dots."""
        return self._area.height() - self._y

    def piece(self, html: str, images: dict[str, QImage] | None = None) -> QTextDocument:
        """A piece to be added: rich text as wide as the page, with the images that it names."""
        document = QTextDocument()
        font = QFont()
        font.setPixelSize(round(points(_TEXT_PT)))
        document.setDefaultFont(font)
        document.setDocumentMargin(0)
        document.setUseDesignMetrics(True)
        document.setDefaultStyleSheet(_STYLE.format(small=round(points(_FOOT_PT))))
        for name, image in (images or {}).items():
            document.addResource(QTextDocument.ResourceType.ImageResource, name, image)
        document.setHtml(f"<body>{html}</body>")
        document.setTextWidth(self.width)
        return document

    def add(self, piece: QTextDocument, before: float = 0.0, together: float = 0.0) -> None:
        """Put a piece below the last one, or on a new page if the rest of this one is too small.

        Parameters
        ----------
        piece : QTextDocument
            No higher than a page; what is beyond that is cut off.
        before : float
            Room above it, where it is not the first of its page [dots].
        together : float
            Room below it that what follows needs on the same page [dots].
        """
        height = piece.size().height()
        above = before if self._y else 0.0
        if self._y and above + height + together > self.left:
            self.turn()
            above = 0.0
        painter = self._painter
        painter.save()
        painter.translate(self._area.left(), self._area.top() + self._y + above)
        context = QAbstractTextDocumentLayout.PaintContext()
        context.palette.setColor(QPalette.ColorRole.Text, QColor("#1c2126"))
        context.clip = QRectF(0, 0, self.width, self.height)
        piece.documentLayout().draw(painter, context)
        painter.restore()
        self._y += above + height

    def turn(self) -> None:
        """Go on on a new page, unless this one is empty."""
        if self._y:
            self._write_foot()
            self._writer.newPage()
            self.number += 1
            self._y = 0.0

    def close(self) -> None:
        """Write the last foot; the file is whole afterwards."""
        self._write_foot()
        self._painter.end()

    def _write_foot(self) -> None:
        painter = self._painter
        font = QFont()
        font.setPixelSize(round(points(_FOOT_PT)))
        painter.setFont(font)
        painter.setPen(QColor("#5c6670"))
        place = QRectF(self._area.left(), self._area.bottom(), self.width, _foot())
        bottom = Qt.AlignmentFlag.AlignBottom
        title = painter.fontMetrics().elidedText(self._title, Qt.TextElideMode.ElideRight, round(0.8 * self.width))
        painter.drawText(place, bottom | Qt.AlignmentFlag.AlignLeft, title)
        painter.drawText(place, bottom | Qt.AlignmentFlag.AlignRight, str(self.number))


def _foot() -> float:
    return millimetres(_FOOT_MM)
