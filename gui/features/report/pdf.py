"""A report as PDF: the same content as the HTML page, laid out for paper."""

from __future__ import annotations

import os
from collections.abc import Generator, Sequence
from html import escape
from pathlib import Path

from PySide6.QtCore import QByteArray, QMarginsF, QPointF, QRectF, Qt
from PySide6.QtGui import (
    QAbstractTextDocumentLayout,
    QColor,
    QFont,
    QImage,
    QPageSize,
    QPainter,
    QPalette,
    QPdfWriter,
    QPen,
    QTextDocument,
)
from PySide6.QtSvg import QSvgRenderer

from ilf._runtime.files import atomic_path
from ilf._runtime.installation import __version__
from ilf.drawing.colours import Colour
from ilf.errors import ExportError
from ilf.evaluation.evaluation import Step
from ilf.report.content import (
    Cell,
    Chapter,
    ColourBar,
    Facts,
    Gallery,
    Image,
    Legend,
    Paragraph,
    Picture,
    Plot,
    Report,
    ScaleBar,
    Section,
    Table,
)

# Pieces of a document, one below the other, on the numbered pages of a PDF.

DPI = 300
_MARGIN_MM = 15.0
_FOOT_MM = 9.0
_TEXT_PT, _FOOT_PT = 9.0, 7.5
_STYLE = "body {{ color: #1c2126; }} th {{ color: #5c6670; }} .soft {{ color: #5c6670; font-size: {small}px; }}"


def millimetres(length: float) -> float:
    """Convert millimetres to dots of the page."""
    return length * DPI / 25.4


def points(size: float) -> float:
    """Convert points to dots of the page."""
    return size * DPI / 72


class Pages:
    """Pages of a PDF, written from top to bottom; call `close` at the end.

    The layout is in dots of the page, independent of the screen. May be used in any thread, by one thread at a time.

    Parameters
    ----------
    path : Path
    title : str
        Title of the document, also in the footers.
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
            raise ExportError(f"Could not write {path}. Choose another folder, or free disk space.")

    @property
    def width(self) -> float:
        """Width of all pieces, in dots."""
        return self._area.width()

    @property
    def height(self) -> float:
        """Height of an empty page, in dots."""
        return self._area.height()

    @property
    def left(self) -> float:
        """Free height on the current page, in dots."""
        return self._area.height() - self._y

    def piece(self, html: str, images: dict[str, QImage] | None = None) -> QTextDocument:
        """Create a piece: rich text as wide as the page, with its named images."""
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
        """Add a piece below the last one, or on a new page if the rest of this page is too small.

        Parameters
        ----------
        piece : QTextDocument
            At most as high as a page; the rest is cut off.
        before : float
            Space above it, unless it is the first of its page [dots].
        together : float
            Height below it to keep on the same page, for the next pieces [dots].
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
        """Start a new page, unless this one is empty."""
        if self._y:
            self._write_foot()
            self._writer.newPage()
            self.number += 1
            self._y = 0.0

    def close(self) -> None:
        """Write the last footer and finish the file."""
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


# The images of a report on paper.

_MARK_PT = 6.5
_INK = QColor("#1c2126")


def image_of(image: Image) -> QImage:
    """Decode an image."""
    found = QImage()
    found.loadFromData(image.data)
    return found.convertToFormat(QImage.Format.Format_RGB32)


def picture_image(picture: Picture, width: int) -> QImage:
    """Image of a picture; with marks, it is scaled to `width` dots and the marks are drawn on it."""
    image = image_of(picture.image)
    if not picture.marks:
        return image
    image = image.scaledToWidth(width, Qt.TransformationMode.SmoothTransformation)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    font = QFont()
    font.setPixelSize(round(points(_MARK_PT)))
    font.setBold(True)
    painter.setFont(font)
    metrics = painter.fontMetrics()
    for mark in picture.marks:
        plate = QRectF(0, 0, metrics.horizontalAdvance(mark.text) + 8, metrics.height() - 4)
        plate.moveCenter(QPointF(mark.x * image.width(), mark.y * image.height()))
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(QColor(0, 0, 0, 150))
        painter.drawRoundedRect(plate, 6, 6)
        painter.setPen(QColor("white"))
        painter.drawText(plate, Qt.AlignmentFlag.AlignCenter, mark.text)
    painter.end()
    return image


def bar_image(bar: ColourBar, width: int) -> QImage:
    """Colour bar for a picture of `width` dots."""
    gap, height = round(points(3)), round(points(6))
    image = QImage(width, gap + height, QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    painter.drawImage(QRectF(0, gap, width, height), image_of(bar.image))
    painter.end()
    return image


def scale_image(scale: ScaleBar, width: int) -> QImage:
    """Scale bar for a picture of `width` dots."""
    gap, height = points(3), round(points(7))
    image = QImage(max(round(scale.share * width), 4), height, QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    painter.setPen(QPen(_INK, points(0.9)))
    right, low = image.width() - 2.0, height - 2.0
    painter.drawPolyline([QPointF(2, gap), QPointF(2, low), QPointF(right, low), QPointF(right, gap)])
    painter.end()
    return image


def swatch_image(colour: tuple[int, int, int]) -> QImage:
    """Small colour swatch."""
    side = round(points(6))
    image = QImage(side, side, QImage.Format.Format_RGB32)
    image.fill(QColor(*colour))
    return image


def line_image(item: Legend) -> QImage:
    """Short line for the legend of a curve."""
    width, height = round(points(20)), round(points(6))
    image = QImage(width, height, QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    pen = QPen(QColor(*item.colour), points(1.6))
    if item.dashes:
        pen.setDashPattern([float(length) / 2 for length in item.dashes.split()])
        pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    painter.setPen(pen)
    painter.drawLine(QPointF(0, height / 2), QPointF(width, height / 2))
    painter.end()
    return image


def plot_image(plot: Plot, width: int) -> QImage:
    """Image of a plot, `width` dots wide."""
    image = QImage(width, round(width * plot.size[1] / plot.size[0]), QImage.Format.Format_RGB32)
    image.fill(QColor("white"))
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    QSvgRenderer(QByteArray(plot.svg.encode())).render(painter, QRectF(image.rect()))
    painter.end()
    return image


_GAP_MM, _SECTION_MM, _FIGURE_MM = 2.0, 7.0, 5.0
_COLUMNS = 2
_GUTTER_MM = 6.0
_HEAD_PT, _SECTION_PT, _TABLE_PT, _SMALL_PT = 18.0, 12.0, 7.5, 7.5
_LETTERS = 4, 30
"""Minimum and maximum number of letters assumed for a column of a table."""
_THUMBNAIL_MM = 22.0
_CELL = f"padding:{round(points(1.4))}px {round(points(3))}px; border-bottom:2px solid #d9dde2"


def write_pdf(path: str | os.PathLike[str], report: Report, made: str) -> Generator[Step, None, None]:
    """Write a report as PDF, step by step and atomically.

    Parameters
    ----------
    path : path-like
    report : Report
    made : str
        Date and time of creation, as text.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    with atomic_path(path) as temporary:
        pages = Pages(temporary, report.title)
        try:
            for number, chapter in enumerate(report.chapters):
                pages.turn()
                for part, section in enumerate(_sections(chapter)):
                    yield Step((number + part / (len(chapter.sections) + 1)) / len(report.chapters), chapter.title)
                    _Writer(pages).add(section)
            _Writer(pages).add_text(f'<span class="soft">Made with ILF Studio, {escape(made)}.</span>', _SECTION_MM)
        finally:
            pages.close()


def _sections(chapter: Chapter) -> Sequence[Section | Chapter]:
    return [chapter, *chapter.sections]


class _Writer:
    """Lays out the parts of a section."""

    def __init__(self, pages: Pages) -> None:
        self._pages = pages
        self._images: dict[str, QImage] = {}

    def add(self, section: Section | Chapter) -> None:
        """Add a section, or the head of a chapter."""
        if isinstance(section, Chapter):
            self.add_text(_sized(f"<b>{escape(section.title)}</b>", _HEAD_PT))
            if section.lead:
                self.add_text(escape(section.lead).replace("\n", "<br>"))
            return
        if section.title:
            # keep the title with the next piece: at least a row of a table or of figures
            first = section.parts[0] if section.parts else None
            figures = next((part for part in section.parts[:2] if isinstance(part, Gallery)), None)
            below = millimetres(15) if figures is None else self._figures(figures.items[:_COLUMNS]).size().height()
            below += millimetres(8) if isinstance(first, Paragraph) and figures is not None else 0
            self.add_text(_sized(f"<b>{escape(section.title)}</b>", _SECTION_PT), _SECTION_MM, below)
        for part in section.parts:
            if isinstance(part, Paragraph):
                text = escape(part.text)
                self.add_text(f"<code>{text}</code>" if part.code else f"<i>{text}</i>" if part.warns else text)
            elif isinstance(part, Facts):
                self._add_facts(part)
            elif isinstance(part, Table):
                self._add_table(part)
            else:
                for start in range(0, len(part.items), _COLUMNS):
                    self._pages.add(self._figures(part.items[start : start + _COLUMNS]), millimetres(_FIGURE_MM))

    def add_text(self, html: str, before_mm: float = _GAP_MM, together: float = 0.0) -> None:
        """Add a piece of rich text."""
        self._pages.add(self._piece(html), millimetres(before_mm), together)

    def _piece(self, html: str) -> QTextDocument:
        images, self._images = self._images, {}
        return self._pages.piece(html, images)

    def _image(self, image: QImage, width: float) -> str:
        """HTML tag of an image of this width."""
        name = f"image-{len(self._images)}"
        self._images[name] = image
        height = width * image.height() / image.width()
        return f'<img src="{name}" width="{round(width)}" height="{round(height)}">'

    def _swatch(self, colour: Colour) -> str:
        return self._image(swatch_image(colour), points(6)) + "&nbsp;"

    def _add_facts(self, facts: Facts) -> None:
        for fact in facts.rows:
            text = _sized(f"<code>{escape(fact.text)}</code>", _SMALL_PT) if fact.is_hash else escape(fact.text)
            name = f'<td width="24%"><span style="color:#5c6670">{escape(fact.name)}</span></td>'
            self.add_text(f'<table width="100%" cellspacing="0"><tr>{name}<td>{text}</td></tr></table>', 0.6)

    # figures

    def _figures(self, items: Sequence[Picture | Plot]) -> QTextDocument:
        """Some figures side by side."""
        gutter = millimetres(_GUTTER_MM)
        width = (self._pages.width - (_COLUMNS - 1) * gutter) / _COLUMNS
        cells = [self._picture(item, width) if isinstance(item, Picture) else self._plot(item, width) for item in items]
        cells += [""] * (_COLUMNS - len(cells))
        between = f'<td width="{round(gutter)}"></td>'
        row = between.join(f'<td width="{round(width)}">{cell}</td>' for cell in cells)
        return self._piece(f'<table cellspacing="0" cellpadding="0"><tr>{row}</tr></table>')

    def _picture(self, picture: Picture, width: float) -> str:
        parts = [f"<b>{escape(picture.title)}</b>", self._image(picture_image(picture, round(width)), width)]
        if picture.bar is not None:
            low, middle, high = (f'<span class="soft">{escape(tick)}</span>' for tick in picture.bar.ticks)
            third = f'width="{round(width / 3)}"'
            cells = (
                f'<td {third}>{low}</td><td {third} align="center">{middle}</td><td {third} align="right">{high}</td>'
            )
            bar = self._image(bar_image(picture.bar, round(width)), width)
            parts.append(
                f'<table width="{round(width)}" cellspacing="0" cellpadding="0"><tr><td colspan="3">{bar}</td></tr>'
                f"<tr>{cells}</tr></table>"
            )
        if picture.scale is not None:
            parts.append(self._image(scale_image(picture.scale, round(width)), picture.scale.share * width))
            parts.append(f'<span class="soft">{escape(picture.scale.text)}</span>')
        parts.append(self._legend(picture.legend))
        if picture.caption:
            parts.append(f'<span class="soft">{escape(picture.caption)}</span>')
        return "".join(part if part.startswith("<table") else f"<div>{part}</div>" for part in parts if part)

    def _plot(self, plot: Plot, width: float) -> str:
        image = self._image(plot_image(plot, round(width)), width)
        return f"<div><b>{escape(plot.title)}</b></div><div>{image}</div><div>{self._legend(plot.legend)}</div>"

    def _legend(self, items: Sequence[Legend]) -> str:
        def sign(item: Legend) -> str:
            return f"{self._image(line_image(item), points(20))}&nbsp;" if item.is_line else self._swatch(item.colour)

        between = "<br>" if any(item.is_line for item in items) else "&nbsp;&nbsp; "
        return between.join(f'{sign(item)}<span class="soft">{escape(item.text)}</span>' for item in items)

    # tables

    def _add_table(self, table: Table) -> None:
        """Add a table, split at page ends, with headings on each page."""
        rows = list(table.rows)
        while rows:
            count = len(rows)
            room = self._pages.left - millimetres(_GAP_MM)
            while True:
                piece = self._table(table, rows[:count])
                height = piece.size().height()
                if height <= room or count == 1:
                    break
                count = max(1, min(count - 1, int(count * room / height)))
            if height > room and self._pages.left < self._pages.height:
                self._pages.turn()
                continue
            self._pages.add(piece, millimetres(_GAP_MM))
            rows = rows[count:]

    def _table(self, table: Table, rows: Sequence[Sequence[Cell]]) -> QTextDocument:
        widths = _column_widths(table)
        sides = [f'align="{"right" if column.number else "left"}" style="{_CELL}"' for column in table.columns]
        head = "".join(
            f'<th width="{width}%" {side}>{escape(column.text)}</th>'
            for column, width, side in zip(table.columns, widths, sides, strict=True)
        )
        body = "".join(
            f"<tr>{''.join(f'<td {side}>{self._cell(cell)}</td>' for cell, side in zip(row, sides, strict=True))}</tr>"
            for row in rows
        )
        style = f"font-size:{round(points(_TABLE_PT))}px; border-collapse:collapse; border-style:none"
        return self._piece(f'<table width="100%" cellspacing="0" style="{style}"><tr>{head}</tr>{body}</table>')

    def _cell(self, cell: Cell) -> str:
        if cell.image is not None:
            return self._image(image_of(cell.image), millimetres(_THUMBNAIL_MM))
        return ("" if cell.colour is None else self._swatch(cell.colour)) + escape(cell.text)


def _column_widths(table: Table) -> list[int]:
    """Column widths in per cent, from the lengths of their texts."""
    min_letters, max_letters = _LETTERS
    letters = []
    for number, column in enumerate(table.columns):
        longest = max([len(row[number].text) for row in table.rows], default=0)
        pictures = any(row[number].image is not None for row in table.rows)
        word = round(1.3 * max(map(len, column.text.split()), default=0))  # headings are bold
        letters.append(min(max(longest, word, min_letters, 16 if pictures else 0), max_letters) + 3)
    return [round(100 * count / sum(letters)) for count in letters]


def _sized(html: str, size: float) -> str:
    return f'<span style="font-size:{round(points(size))}px">{html}</span>'
