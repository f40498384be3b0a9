"""A report as PDF: the same content as the page, laid out for paper."""

from __future__ import annotations

import os
from collections.abc import Generator, Sequence
from html import escape

from PySide6.QtGui import QImage, QTextDocument

from gui.report.pages import Pages, millimetres, points
from gui.report.pictures import bar_image, image_of, line_image, picture_image, plate_image, plot_image, scale_image
from ilf.drawing.colour_tables import Colour
from ilf.io.atomic import atomic_path
from ilf.judgement import Step
from ilf.report.content import Cell, Chapter, Facts, Gallery, Legend, Paragraph, Picture, Plot, Report, Section, Table

_GAP_MM, _SECTION_MM, _FIGURE_MM = 2.0, 7.0, 5.0
_COLUMNS = 2
_GUTTER_MM = 6.0
_HEAD_PT, _SECTION_PT, _TABLE_PT, _SMALL_PT = 18.0, 12.0, 7.5, 7.5
_LETTERS = 4, 30
"""That a column of a table is taken to have at least and at most."""
_THUMBNAIL_MM = 22.0
_CELL = f"padding:{round(points(1.4))}px {round(points(3))}px; border-bottom:2px solid #d9dde2"


def write_pdf(path: str | os.PathLike[str], report: Report, made: str) -> Generator[Step, None, None]:
    """Write a report as PDF, step by step; all of it or nothing.

    Parameters
    ----------
    path : path-like
    report : Report
    made : str
        When it was made, in words.

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
    """Lays the parts of a section out."""

    def __init__(self, pages: Pages) -> None:
        self._pages = pages
        self._images: dict[str, QImage] = {}

    def add(self, section: Section | Chapter) -> None:
        """A section, or the head of a chapter."""
        if isinstance(section, Chapter):
            self.add_text(_sized(f"<b>{escape(section.title)}</b>", _HEAD_PT))
            if section.lead:
                self.add_text(escape(section.lead).replace("\n", "<br>"))
            return
        if section.title:
            # with what stands below it: at least a row of a table, or a row of figures
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
        """A piece of rich text."""
        self._pages.add(self._piece(html), millimetres(before_mm), together)

    def _piece(self, html: str) -> QTextDocument:
        images, self._images = self._images, {}
        return self._pages.piece(html, images)

    def _image(self, image: QImage, width: float) -> str:
        """The tag of an image of such a width."""
        name = f"image-{len(self._images)}"
        self._images[name] = image
        height = width * image.height() / image.width()
        return f'<img src="{name}" width="{round(width)}" height="{round(height)}">'

    def _plate(self, colour: Colour) -> str:
        return self._image(plate_image(colour), points(6)) + "&nbsp;"

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
            return f"{self._image(line_image(item), points(20))}&nbsp;" if item.is_line else self._plate(item.colour)

        between = "<br>" if any(item.is_line for item in items) else "&nbsp;&nbsp; "
        return between.join(f'{sign(item)}<span class="soft">{escape(item.text)}</span>' for item in items)

    # tables

    def _add_table(self, table: Table) -> None:
        """A table, in as many pieces as there are pages, each with the headings."""
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
        return ("" if cell.colour is None else self._plate(cell.colour)) + escape(cell.text)


def _column_widths(table: Table) -> list[int]:
    """In per cent, by what stands in them."""
    least, most = _LETTERS
    letters = []
    for number, column in enumerate(table.columns):
        longest = max([len(row[number].text) for row in table.rows], default=0)
        pictures = any(row[number].image is not None for row in table.rows)
        word = round(1.3 * max(map(len, column.text.split()), default=0))  # headings are bold
        letters.append(min(max(longest, word, least, 16 if pictures else 0), most) + 3)
    return [round(100 * count / sum(letters)) for count in letters]


def _sized(html: str, size: float) -> str:
    return f'<span style="font-size:{round(points(size))}px">{html}</span>'
