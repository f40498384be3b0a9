"""An experiment's result as files: rows as JSON and CSV, longer tables as CSV, figures as PNG and SVG."""

from __future__ import annotations

import io
import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec

from ..._runtime.files import read_json, write_bytes
from ..._runtime.schema import converted
from ...errors import FormatError, InputError
from ...evaluation.bench.results import write_content
from ...io.tables import write_csv
from .experiment import Drawing, Experiment, Result, Row

PNG_DPI = 110

_Stem = Annotated[str, msgspec.Meta(pattern=r"\A[A-Za-z0-9_-]{1,100}\Z")]
"""Stem of a figure: no path separators, so a figure can only lie beside its result."""
_LARGEST = 10**15
"""Limit of numbers that are printed in full."""


@dataclass(frozen=True)
class StoredFigure:
    """A figure stored in files: their stem, and fields of `Drawing`."""

    stem: _Stem
    caption: str
    shows_data: bool


@dataclass(frozen=True)
class StoredResult:
    """Content of NAME.json: see `Result`; figures refer to their files."""

    experiment: str
    title: str
    source: str
    about: str
    parameters: dict[str, Any]
    seed: Annotated[int, msgspec.Meta(ge=-_LARGEST, le=_LARGEST)]
    quick: bool
    seconds: Annotated[float, msgspec.Meta(ge=-_LARGEST, le=_LARGEST)]
    notes: list[str]
    figures: list[StoredFigure]
    rows: Annotated[list[Row], msgspec.Meta(min_length=1)]


def write_result(result: Result, experiment: Experiment, folder: str | os.PathLike[str]) -> list[Path]:
    """Write a result into a folder, every file atomically and NAME.json last, so all files that it lists exist.

    Parameters
    ----------
    result : Result
        As `run_experiment` gives it.
    experiment : Experiment
        The experiment of this result.
    folder : path-like
        Must exist.

    Returns
    -------
    list of Path
        NAME.json, NAME.csv, NAME-TABLE.csv and NAME-FIGURE.png and .svg, in this order.

    Raises
    ------
    ExportError
        If a file cannot be written.
    """
    root, name = Path(folder), result.experiment
    written = []
    for stem, rows in ((name, result.rows), *((f"{name}-{key}", table) for key, table in result.tables.items())):
        written.append(root / f"{stem}.csv")
        names = list(dict.fromkeys(name for row in rows for name in row))
        write_csv(written[-1], [names, *([row.get(name) for name in names] for row in rows)])
    drawings = experiment.draw(result)
    for drawing in drawings:
        for suffix in ("png", "svg"):
            written.append(root / f"{name}-{drawing.key}.{suffix}")
            write_bytes(written[-1], rendered(drawing, suffix))
    content = {
        "experiment": name,
        "title": experiment.title,
        "source": experiment.source,
        "about": experiment.about,
        "parameters": result.parameters,
        "seed": result.seed,
        "quick": result.quick,
        "seconds": result.seconds,
        "notes": result.notes,
        "figures": [
            {"stem": f"{name}-{drawing.key}", "caption": drawing.caption, "shows_data": drawing.shows_data}
            for drawing in drawings
        ],
        "rows": result.rows,
    }
    write_content(root / f"{name}.json", _without_nan(content))
    return [root / f"{name}.json", *written]


def rendered(drawing: Drawing, form: str) -> bytes:
    """Render a figure as the content of a "png" or "svg" file, always the same for the same figure."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    buffer = io.BytesIO()
    FigureCanvasAgg(drawing.figure)
    # without these, an SVG has random ids and the current date
    with matplotlib.rc_context({"svg.hashsalt": drawing.key}):
        drawing.figure.savefig(buffer, format=form, dpi=PNG_DPI, metadata={"Date": None} if form == "svg" else None)
    return buffer.getvalue()


def read_result(path: str | os.PathLike[str]) -> StoredResult:
    """Read NAME.json.

    Raises
    ------
    InputError
        If the file does not exist.
    FormatError
        If `write_result` did not write it.
    """
    content = read_json(path)
    try:
        stored = converted(content, StoredResult, "result")
    except FormatError as error:
        raise FormatError(f"{path} is not the result of an experiment ({error}) Run the experiment again.") from error
    if stored.experiment != Path(path).stem:
        raise FormatError(f"{path} is the result of {stored.experiment!r:.60}. Restore its original file name.")
    return stored


def stored_results(folder: str | os.PathLike[str], names: Sequence[str]) -> list[StoredResult]:
    """Read the results in a folder, in the order of the names.

    Raises
    ------
    InputError
        If the folder has no results.
    FormatError
        If a result cannot be read.
    """
    root = Path(folder)
    found = [root / f"{name}.json" for name in names if (root / f"{name}.json").is_file()]
    if not found:
        raise InputError(f"{root} has no results of experiments. Run them first: ilf experiments run all --out {root}.")
    return [read_result(path) for path in found]


def _without_nan(value: Any) -> Any:
    """Replace NaN by None, because JSON has no NaN."""
    if isinstance(value, dict):
        return {name: _without_nan(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
