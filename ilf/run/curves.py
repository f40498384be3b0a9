"""Convergence curves as CSV: the record of every iteration of a run."""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Mapping, Sequence
from itertools import groupby

from .._runtime.files import read_file
from ..data.results import EdgeAwareRecord, History, IterationRecord, PassBandRecord
from ..errors import FormatError

CURVE_COLUMNS = (
    "label", "i", "stage", "r_y", "r_x", "sigma_i_m", "l1_m", "residual_m", "held_out_m", "weighted",
    "cell_px", "round", "error_m",
)  # fmt: skip
"""r_y, r_x and weighted belong to the filter "ideal", cell_px and round to "edge-aware"; empty for the other filter."""


def encode_curves(history: Mapping[int, Sequence[IterationRecord]]) -> bytes:
    """Return the record of every iteration, block after block, as CSV.

    Floats are written with all digits, and seconds are left out: the same run gives the same file. An error without any
    pixels is an empty cell.

    Parameters
    ----------
    history : mapping
        Label -> records, as in `Completion.history`.
    """
    text = io.StringIO()
    table = csv.DictWriter(text, CURVE_COLUMNS, lineterminator="\n")
    table.writeheader()
    table.writerows({"label": label, **_cells(record)} for label in sorted(history) for record in history[label])
    return text.getvalue().encode()


def _cells(record: IterationRecord) -> dict[str, object]:
    """Column -> its value."""
    cells: dict[str, object] = {
        "i": record.i,
        "stage": record.stage,
        "sigma_i_m": _digits(record.sigma_i),
        "l1_m": _digits(record.l1),
    }
    errors = {"residual_m": record.residual, "held_out_m": record.held_out, "error_m": record.error}
    cells |= {name: _digits(error) for name, error in errors.items() if not math.isnan(error)}
    if isinstance(record, PassBandRecord):
        r_y, r_x = record.radii
        cells |= {"r_y": _digits(r_y), "r_x": _digits(r_x), "weighted": int(record.weighted)}
    elif isinstance(record, EdgeAwareRecord):
        cells |= {"cell_px": record.cell, "round": record.round}
    return cells


def _digits(value: float) -> str:
    return repr(float(value))


def read_curves(path: str | os.PathLike[str]) -> dict[int, History]:
    """Read what `encode_curves` has made: label -> records, whose seconds are NaN.

    Raises
    ------
    InputError
        If the file cannot be read.
    FormatError
        If it was not made by `encode_curves`.
    """
    try:
        rows = csv.DictReader(io.StringIO(bytes(read_file(path).data).decode()))
        return {
            int(label): tuple(_record(row) for row in own) for label, own in groupby(rows, lambda row: row["label"])
        }
    except (KeyError, TypeError, ValueError) as error:
        raise FormatError(f"{os.fspath(path)} has no curves of a run. Restore it, or run the frame again.") from error


def _record(row: Mapping[str, str]) -> IterationRecord:
    sigma_i, l1, residual, held_out, error = (
        float(row[name] or "nan") for name in ("sigma_i_m", "l1_m", "residual_m", "held_out_m", "error_m")
    )
    common = int(row["i"]), int(row["stage"]), sigma_i, l1, residual, held_out, math.nan
    if row["cell_px"]:
        return EdgeAwareRecord(*common, int(row["cell_px"]), int(row["round"]), error=error)
    return PassBandRecord(*common, (float(row["r_y"]), float(row["r_x"])), row["weighted"] == "1", error=error)
