"""The HTML page of a report; self-contained: it needs no other file, no network and no script."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape

from .._runtime.installation import __version__
from .content import (
    Cell,
    Chapter,
    Element,
    Facts,
    Gallery,
    Image,
    Legend,
    Paragraph,
    Picture,
    Plot,
    Report,
    Section,
    Table,
)
from .curves import hex_of

# Style sheet: light and dark mode, screens from 360 pixels wide, and print.

STYLE = """
:root { color-scheme: light dark; --ground: #fff; --ink: #1c2126; --soft: #5c6670; --line: #d9dde2; --card: #f5f6f8;
  --accent: #1b5fa8; --warn: #b3541e; }
@media screen and (prefers-color-scheme: dark) { :root { --ground: #14171b; --ink: #e4e7ea; --soft: #9aa4ae;
  --line: #323840; --card: #1c2127; --accent: #7ab4f0; --warn: #f0a060; } }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body { margin: 0; background: var(--ground); color: var(--ink);
  font: 15px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
main, footer { max-width: 88rem; margin: 0 auto; padding: 0 clamp(.9rem, 3vw, 2.5rem); }
article { padding-top: 1.2rem; }
article + article { margin-top: 3rem; border-top: 3px solid var(--line); }
h1 { font-size: clamp(1.4rem, 4vw, 2rem); line-height: 1.2; margin: .6rem 0 .4rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; line-height: 1.25; margin: 2.2rem 0 .8rem; }
h3 { font-size: .95rem; margin: 0 0 .4rem; }
p { margin: .5rem 0; max-width: 50rem; overflow-wrap: anywhere; }
a { color: var(--accent); }
.back { margin: 0; font-size: .87rem; }
.lead { white-space: pre-line; border-left: 3px solid var(--accent); padding-left: .8rem; }
.warning { border-left: 3px solid var(--warn); padding-left: .8rem; }
dl { display: grid; grid-template-columns: fit-content(38%) minmax(0, 1fr); gap: .25rem 1.2rem;
  margin: .6rem 0; }
dt { color: var(--soft); } dd { margin: 0; overflow-wrap: anywhere; }
.hash { font: .8rem/1.6 ui-monospace, "Cascadia Mono", Menlo, Consolas, monospace; color: var(--soft); }
pre { background: var(--card); border: 1px solid var(--line); border-radius: 6px; padding: .7rem .9rem; margin: .6rem 0;
  white-space: pre-wrap; overflow-wrap: anywhere; font-size: .85rem; }
.wide { overflow-x: auto; margin: .6rem 0 1rem; }
table { border-collapse: collapse; font-size: .87rem; line-height: 1.35; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .35rem .9rem .35rem 0; border-bottom: 1px solid var(--line); }
th { color: var(--soft); font-weight: 600; vertical-align: bottom; border-bottom-width: 2px; }
th:last-child, td:last-child { padding-right: 0; }
td { overflow-wrap: anywhere; max-width: 22rem; }
td:not(.n) { min-width: 7rem; }
.key { position: sticky; left: 0; background: var(--ground); }
@media (max-width: 40rem) { .key { max-width: 9.5rem; } }
.n { text-align: right; white-space: nowrap; overflow-wrap: normal; }
th.n { white-space: normal; }
td img { display: block; width: 7.5rem; height: auto; border-radius: 3px; }
.plate { display: inline-block; width: .8em; height: .8em; border-radius: 2px; margin-right: .45em;
  vertical-align: -.05em; border: 1px solid #0003; }
.pictures, .plots { display: grid; gap: 1.6rem 1.4rem; margin: .6rem 0;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 24rem), 1fr)); }
.plots { grid-template-columns: repeat(auto-fill, minmax(min(100%, 30rem), 1fr)); }
figure { margin: 0; min-width: 0; }
figcaption { font-size: .85rem; color: var(--soft); } figcaption p { margin: .25rem 0 0; }
.picture { position: relative; line-height: 0; border-radius: 4px; overflow: hidden; }
.picture img { width: 100%; height: auto; }
.picture b { position: absolute; transform: translate(-50%, -50%); font: 700 10.5px/1 system-ui, sans-serif;
  color: #fff; text-shadow: 0 0 2px #000, 0 0 2px #000, 0 0 3px #000; }
.bar { margin-top: .4rem; }
.bar img { display: block; width: 100%; height: 9px; border-radius: 2px; }
.bar div { display: flex; justify-content: space-between; font-size: .8rem; color: var(--soft); line-height: 1.4; }
.scale { margin-top: .3rem; font-size: .8rem; color: var(--soft); line-height: 1.3; }
.scale i { display: block; height: 6px; border: 2px solid var(--ink); border-top: 0; }
.legend { list-style: none; display: flex; flex-wrap: wrap; gap: .1rem 1.1rem; margin: .35rem 0 0; padding: 0;
  font-size: .82rem; color: var(--soft); }
.legend li { overflow-wrap: anywhere; } .legend svg { margin-right: .45em; vertical-align: .1em; }
.plots > figure > svg { display: block; width: 100%; height: auto; }
svg text.ink { fill: var(--soft); } svg line.ink { stroke: var(--soft); } svg .grid { stroke: var(--line); }
footer { margin-top: 3rem; padding-top: 1rem; padding-bottom: 2rem; font-size: .85rem; color: var(--soft); }
@page { size: A4; margin: 15mm 13mm; }
@media print {
  body { font-size: 10pt; }
  main, footer { max-width: none; padding: 0; }
  .plate, .scale i, .bar img { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  article { padding-top: 0; }
  article + article { break-before: page; border-top: 0; margin-top: 0; }
  h1, h2, h3, p:has(+ .plots), p:has(+ .wide) { break-after: avoid; }
  h2 { margin-top: 1.4rem; }
  figure, tr, dl > *, pre { break-inside: avoid; }
  .pictures, .plots { grid-template-columns: repeat(2, 1fr); gap: 1rem; }
  .wide { overflow: visible; }
  table { font-size: 7.8pt; } th, td { padding: .18rem .45rem .18rem 0; } td { min-width: 0; }
  td img { width: 22mm; }
  pre { font-size: 8pt; } .hash { font-size: 7.5pt; }
  .back { display: none; } footer { margin-top: 1rem; padding: 0; }
}
"""


def page(report: Report, made: str) -> str:
    """Return the HTML page of a report; `made` is its date as text."""
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


def _chapter(chapter: Chapter, links_to_index: bool, report: Report) -> str:
    first = report.chapters[0]
    back = f'<p class="back"><a href="#{first.id}">All frames</a></p>' if links_to_index else ""
    lead = f'<p class="lead">{escape(chapter.lead)}</p>' if chapter.lead else ""
    head = f"<h1>{escape(chapter.title)}</h1>"
    sections = "\n".join(_section(section) for section in chapter.sections)
    return f'<article id="{chapter.id}"><header>{back}{head}{lead}</header>\n{sections}</article>'


def _section(section: Section) -> str:
    title = f"<h2>{escape(section.title)}</h2>" if section.title else ""
    return f"<section>{title}{''.join(_part(part) for part in section.parts)}</section>"


def _part(part: Element) -> str:
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
    # the first column with text stays visible when the table is scrolled
    key = next((column for column in table.columns if not column.number and column.text), None)
    classes = [" class=n" if column.number else " class=key" if column is key else "" for column in table.columns]
    head = "".join(
        f"<th{kind}{_title(column.about)}>{escape(column.text)}</th>"
        for column, kind in zip(table.columns, classes, strict=True)
    )
    rows = "".join(f"<tr>{_row(classes, row)}</tr>" for row in table.rows)
    # a wide table can be scrolled, also by keyboard
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
