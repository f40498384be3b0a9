"""The report of the experiments in a folder: one self-contained HTML page, and Markdown from the same numbers."""

from __future__ import annotations

import base64
import html
import io
import os
import re
from collections.abc import Sequence
from pathlib import Path

from ..._runtime.files import ensure_folder, read_file, write_bytes
from ..._runtime.installation import __version__
from ...errors import FormatError, InputError
from ...io.images import image_header, read_colour
from .experiment import Comparison
from .files import StoredFigure, StoredResult, stored_results
from .registry import EXPERIMENTS

REPORT_FILE = "report.html"
IMAGE_FOLDER = Path("images") / "experiments"
"""Folder of the figures, relative to the Markdown file."""

SMALL_BYTES, _COLOURS, _SHRINK_FACTOR = 90_000, 64, 0.9
"""Maximum size of a figure beside the Markdown file, and the colours and scale by which larger ones are reduced."""

_MARKDOWN_CHARACTERS = re.compile(r"[\\<>\[\]*]|(?<!\w)_|_(?!\w)")
"""Characters with a meaning in Markdown."""

_TITLE = "The paper's experiments, rerun"

_INTRODUCTION = (
    'Wang, Yu, Yang, Huang, Zhu, Lau, Sun, "Depth Image Completion through Iterative Low-Pass Filtering", compared '
    "with runs of this implementation. `paper` follows the paper's text, `released-code` the authors' MATLAB code; "
    "`best` is the default here, not the paper's method. All comparison texts are generated from the numbers beside "
    "them."
)

_COMMANDS = """    ilf experiments run all --data FOLDER_OF_FRAMES
    ilf experiments report --markdown FILE"""

_ABOUT_TABLE = (
    "Table 1 of the paper is not a fair mean. The authors' published evaluation adds a block to the sums only where "
    "ILF's error is below that of the peer, and its Rel for ILF lacks the pixel weight of the other sums, which is why "
    "173 mm and 0.008 appear in one row. The rows `all blocks` here are over all blocks, weighted by pixels. The rows "
    "`selective` apply the authors' selection to the same blocks."
)

_STYLE = """
:root { color-scheme: light dark; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 68rem; margin: 2rem auto; padding: 0 1.2rem; }
h1, h2 { line-height: 1.2; } h2 { margin-top: 3rem; border-top: 1px solid #8886; padding-top: 1.5rem; }
table { border-collapse: collapse; font-size: .88rem; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: .4rem .7rem .4rem 0; border-bottom: 1px solid #8883; }
th:first-child, td:first-child { min-width: 10rem; }
figure { margin: 1.6rem 0; } img { max-width: 100%; background: #fff; border-radius: 4px; }
figcaption, .facts { font-size: .88rem; opacity: .8; }
details { margin: 1rem 0; font-size: .88rem; } details div { overflow-x: auto; }
.warning { border-left: 4px solid #d1495b; padding-left: .8rem; }
nav a { margin-right: 1rem; }
"""


def write_report(
    folder: str | os.PathLike[str], html_file: str | os.PathLike[str] | None = None,
    markdown_file: str | os.PathLike[str] | None = None,
) -> list[Path]:  # fmt: skip
    """Write the report of the results in a folder.

    Parameters
    ----------
    folder : path-like
        Output of `write_result`.
    html_file : path-like, optional
        Self-contained page; report.html in the folder if left out.
    markdown_file : path-like, optional
        Also write Markdown there, and its figures into images/experiments beside it, except those that show the user's
        frames.

    Returns
    -------
    list of Path
        The files written, figures not counted.

    Raises
    ------
    InputError, FormatError
        If the folder has no results, or they cannot be read.
    ExportError
        If a file cannot be written.
    """
    root = Path(folder)
    results = stored_results(root, tuple(EXPERIMENTS))
    try:
        page, text = html_report(results, root), markdown_report(results)
    except (LookupError, TypeError, ValueError, ArithmeticError, AttributeError, StopIteration) as error:
        raise FormatError(f"{root} has results of another version ({error}). Run the experiments again.") from error
    written = [root / REPORT_FILE if html_file is None else Path(html_file)]
    write_bytes(written[0], page.encode())
    if markdown_file is not None:
        written.append(Path(markdown_file))
        _copy_figures(results, root, written[-1].parent / IMAGE_FOLDER)
        write_bytes(written[-1], text.encode())
    return written


def html_report(results: Sequence[StoredResult], folder: Path) -> str:
    """Return the HTML page with embedded figures from the folder."""
    parts = [
        '<!doctype html><html lang="en"><head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{_TITLE}</title><style>{_STYLE}</style></head><body>",
        f"<h1>{_TITLE}</h1><p>{inline(_INTRODUCTION)}</p><p class=facts>{html.escape(_facts(results))}</p>",
        "<nav>" + "".join(f'<a href="#{result.experiment}">{html.escape(result.experiment)}</a>' for result in results),
        "</nav>",
        *(_html_section(result, folder) for result in results),
        "</body></html>\n",
    ]
    return "\n".join(parts)


def markdown_report(results: Sequence[StoredResult]) -> str:
    """Return the report as Markdown, without the rows and with links to the figures."""
    lines = [f"# {_TITLE}", "", _INTRODUCTION, "", _COMMANDS, "", _facts(results)]
    for result in results:
        lines += [
            "",
            f"## {escape_markdown(result.title)} (`{result.experiment}`, {escape_markdown(result.source)})",
            "",
        ]
        lines += [escape_markdown(paragraphs(result)[0]), ""]
        lines += [f"- {escape_markdown(note)}" for note in paragraphs(result)[1:]]
        lines += ["", "| | paper | here | |", "|---|---|---|---|"]
        lines += [
            "| " + " | ".join(escape_markdown(cell).replace("|", "\\|") for cell in _cells(item)) + " |"
            for item in _compared(result)
        ]
        for figure in result.figures:
            caption = escape_markdown(figure.caption)
            if figure.shows_data:
                lines += ["", f"{caption} (Not shown: the frames may not be distributed. See {REPORT_FILE}.)"]
                continue
            lines += ["", f"![{caption}]({(IMAGE_FOLDER / figure.stem).as_posix()}.png)", "", caption]
    return "\n".join(lines) + "\n"


def _facts(results: Sequence[StoredResult]) -> str:
    seconds = sum(result.seconds for result in results)
    facts = f"ilf {__version__}; {len(results)} of {len(EXPERIMENTS)} experiments, {seconds:.0f} s of computing time."
    missing = [name for name in EXPERIMENTS if name not in {result.experiment for result in results}]
    if missing:
        facts += f" Not run: {', '.join(missing)}."
    quick = [result.experiment for result in results if result.quick]
    if quick:
        facts += f" Quick runs, with unreliable numbers: {', '.join(quick)}."
    return facts


def paragraphs(result: StoredResult) -> list[str]:
    """Description, choices and notes of a result."""
    found = [
        f"{result.about} Seed {result.seed}, {result.seconds:.0f} s.",
        f"{result.parameters['chosen']}",
        *result.notes,
    ]
    if result.quick:
        found.append("A quick run: fewer points, smaller grids, few frames.")
    if result.experiment == "table":
        found.insert(1, _ABOUT_TABLE)
    return found


def _compared(result: StoredResult) -> list[Comparison]:
    return EXPERIMENTS[result.experiment].compare(result.rows)


def _cells(item: Comparison) -> tuple[str, str, str, str]:
    return item.label, item.paper, item.ours, item.text


def _html_section(result: StoredResult, folder: Path) -> str:
    first, *others = paragraphs(result)
    name = result.experiment
    compared = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in _cells(item)) + "</tr>"
        for item in _compared(result)
    )
    place = f"{name}, {result.source}"
    return "\n".join([
        f'<section id="{name}"><h2>{html.escape(result.title)} <small>({html.escape(place)})</small></h2>',
        f"<p>{inline(first)}</p>",
        *(["<p class=warning>A quick run: its numbers are not reliable.</p>"] if result.quick else []),
        "<ul>" + "".join(f"<li>{inline(note)}</li>" for note in others) + "</ul>",
        f"<table><thead><tr><th></th><th>paper</th><th>here</th><th></th></tr></thead><tbody>{compared}</tbody></table>",
        *(_html_figure(figure, folder) for figure in result.figures),
        f"<details><summary>All rows</summary><div>{_html_rows(result)}</div></details>",
        "</section>",
    ])  # fmt: skip


def _html_figure(figure: StoredFigure, folder: Path) -> str:
    path = _figure_file(folder, figure)
    content = read_file(path).data.tobytes()
    if image_header(path, content).kind != "PNG":
        raise FormatError(f"{path} is not a PNG file. Run the experiment again.")
    data = base64.b64encode(content).decode()
    caption = html.escape(figure.caption)
    return (
        f'<figure><img alt="{caption}" src="data:image/png;base64,{data}"><figcaption>{caption}</figcaption></figure>'
    )


def _html_rows(result: StoredResult) -> str:
    names = list(dict.fromkeys(name for row in result.rows for name in row))
    head = "".join(f"<th>{html.escape(name)}</th>" for name in names)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(shown(row.get(name)))}</td>" for name in names) + "</tr>"
        for row in result.rows
    )
    return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def shown(value: object) -> str:
    """Format a value of a row."""
    if value is None:
        return ""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def inline(text: str) -> str:
    """Escape text for HTML; text in backquotes becomes code."""
    pieces = html.escape(text, quote=False).split("`")
    return "".join(f"<code>{piece}</code>" if place % 2 else piece for place, piece in enumerate(pieces))


def escape_markdown(text: str) -> str:
    """Escape text for Markdown, on one line; text in backquotes stays code.

    Examples
    --------
    >>> escape_markdown("`a<b` of [1, 2] <b> 3*4")
    '`a<b` of \\\\[1, 2\\\\] \\\\<b\\\\> 3\\\\*4'
    """
    pieces = " ".join(text.split()).split("`")
    pieces[::2] = [_MARKDOWN_CHARACTERS.sub(r"\\\g<0>", piece) for piece in pieces[::2]]
    if len(pieces) % 2 == 0:  # the last backquote has no partner
        last = _MARKDOWN_CHARACTERS.sub(r"\\\g<0>", pieces.pop())
        pieces[-1] += rf"\`{last}"
    return "`".join(pieces)


def _figure_file(folder: Path, figure: StoredFigure) -> Path:
    path = folder / f"{figure.stem}.png"
    if not path.is_file():
        raise InputError(f"{path} is missing. Run the experiment again.")
    return path


def _copy_figures(results: Sequence[StoredResult], source: Path, target: Path) -> None:
    ensure_folder(target)
    for result in results:
        for figure in (figure for figure in result.figures if not figure.shows_data):
            write_bytes(target / f"{figure.stem}.png", _small_png(_figure_file(source, figure)))


def _small_png(path: Path) -> bytes:
    """Reduce a picture to few colours and, if needed, fewer pixels, because it is kept in version control."""
    from PIL import Image

    picture = Image.fromarray(read_colour(path))
    size = picture.size
    while True:
        buffer = io.BytesIO()
        picture.resize(size, Image.Resampling.LANCZOS).quantize(_COLOURS).save(buffer, "PNG", optimize=True)
        if buffer.tell() <= SMALL_BYTES:
            return buffer.getvalue()
        size = round(_SHRINK_FACTOR * size[0]), round(_SHRINK_FACTOR * size[1])
