"""A report as one HTML page that needs no other file, no network and no script."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape

from ..version import __version__
from .colours import hex_of
from .content import (
    Cell,
    Chapter,
    Facts,
    Gallery,
    Image,
    Legend,
    Paragraph,
    Part,
    Picture,
    Plot,
    Report,
    Section,
    Table,
)
from .style import STYLE


def page(report: Report, made: str) -> str:
    """The page; `made` says when."""
    title = escape(report.title)
    several = len(report.chapters) > 1
    return "\n".join([
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        '<meta name="color-scheme" content="light dark">',
        f'<meta name="generator" content="ILF Studio {__version__}"><title>{title}</title>',
        f"<style>{STYLE}</style></head><body><main>",
        *(_chapter(chapter, several and number > 0, report) for number, chapter in enumerate(report.chapters)),
        f"</main><footer>Made with ILF Studio {__version__}, {escape(made)}.</footer></body></html>\n",
    ])  # fmt: skip


def _chapter(chapter: Chapter, leads_back: bool, report: Report) -> str:
    first = report.chapters[0]
    back = f'<p class="back"><a href="#{first.id}">All frames</a></p>' if leads_back else ""
    lead = f'<p class="lead">{escape(chapter.lead)}</p>' if chapter.lead else ""
    head = f"<h1>{escape(chapter.title)}</h1>"
    sections = "\n".join(_section(section) for section in chapter.sections)
    return f'<article id="{chapter.id}"><header>{back}{head}{lead}</header>\n{sections}</article>'


def _section(section: Section) -> str:
    title = f"<h2>{escape(section.title)}</h2>" if section.title else ""
    return f"<section>{title}{''.join(_part(part) for part in section.parts)}</section>"


def _part(part: Part) -> str:
    if isinstance(part, Paragraph):
        if part.code:
            return f"<pre><code>{escape(part.text)}</code></pre>"
        return f"<p{' class=warning' * part.warns}>{escape(part.text)}</p>"
    if isinstance(part, Facts):
        rows = (
            f"<dt>{escape(fact.name)}</dt><dd{' class=hash' * fact.is_hash}>{escape(fact.text)}</dd>"
            for fact in part.rows
        )
        return f"<dl>{''.join(rows)}</dl>"
    if isinstance(part, Table):
        return _table(part)
    return _gallery(part)


def _table(table: Table) -> str:
    # the first column with words stays in sight when a table is scrolled
    key = next((column for column in table.columns if not column.number and column.text), None)
    classes = [" class=n" if column.number else " class=key" if column is key else "" for column in table.columns]
    head = "".join(
        f"<th{kind}{_title(column.about)}>{escape(column.text)}</th>"
        for column, kind in zip(table.columns, classes, strict=True)
    )
    rows = "".join(f"<tr>{_row(classes, row)}</tr>" for row in table.rows)
    # a table that is too wide is scrolled, by keys, too
    return f'<div class="wide" tabindex="0"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'


def _row(classes: Sequence[str], row: Sequence[Cell]) -> str:
    return "".join(f"<td{kind}{_title(cell.about)}>{_cell(cell)}</td>" for kind, cell in zip(classes, row, strict=True))


def _cell(cell: Cell) -> str:
    if cell.image is not None:
        return _image(cell.image, cell.text)
    plate = "" if cell.colour is None else f'<i class="plate" style="background:{hex_of(cell.colour)}"></i>'
    text = escape(cell.text)
    return plate + (f'<a href="#{cell.target}">{text}</a>' if cell.target else text)


def _gallery(gallery: Gallery) -> str:
    shown = (_picture(item) if isinstance(item, Picture) else _plot(item) for item in gallery.items)
    kind = "plots" if any(isinstance(item, Plot) for item in gallery.items) else "pictures"
    return f'<div class="{kind}">{"".join(shown)}</div>'


def _picture(picture: Picture) -> str:
    marks = "".join(
        f'<b style="left:{100 * mark.x:.2f}%;top:{100 * mark.y:.2f}%">{escape(mark.text)}</b>' for mark in picture.marks
    )
    below = []
    if picture.bar is not None:
        ticks = "".join(f"<span>{escape(tick)}</span>" for tick in picture.bar.ticks)
        below.append(f'<div class="bar">{_image(picture.bar.image, "colour scale")}<div>{ticks}</div></div>')
    if picture.scale is not None:
        width = f"{100 * picture.scale.share:.3f}%"
        below.append(f'<div class="scale"><i style="width:{width}"></i><span>{escape(picture.scale.text)}</span></div>')
    below.append(_legend(picture.legend))
    caption = f"<p>{escape(picture.caption)}</p>" if picture.caption else ""
    return (
        f"<figure><h3>{escape(picture.title)}</h3>"
        f'<div class="picture">{_image(picture.image, picture.title)}{marks}</div>'
        f"{''.join(below)}<figcaption>{caption}</figcaption></figure>"
    )


def _plot(plot: Plot) -> str:
    return f"<figure><h3>{escape(plot.title)}</h3>{plot.svg}{_legend(plot.legend)}</figure>"


def _legend(items: Sequence[Legend]) -> str:
    def sign(item: Legend) -> str:
        if not item.is_line:
            return f'<i class="plate" style="background:{hex_of(item.colour)}"></i>'
        dashes = f' stroke-dasharray="{item.dashes}"' if item.dashes else ""
        return (
            '<svg viewBox="0 0 26 8" width="26" height="8" aria-hidden="true"><line x1="0" y1="4" x2="26" y2="4" '
            f'stroke="{hex_of(item.colour)}" stroke-width="2.5"{dashes}/></svg>'
        )

    if not items:
        return ""
    return f'<ul class="legend">{"".join(f"<li>{sign(item)}{escape(item.text)}</li>" for item in items)}</ul>'


def _image(image: Image, text: str) -> str:
    data = base64.b64encode(image.data).decode()
    size = f'width="{image.width}" height="{image.height}"'
    return f'<img alt="{escape(text)}" {size} src="data:image/{image.format};base64,{data}">'


def _title(text: str) -> str:
    return f' title="{escape(text)}"' if text else ""
