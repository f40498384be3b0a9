"""Convergence curves as CSV."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence

from ..filter.convergence import IterationRecord
from ..filter.edge_aware.record import EdgeAwareRecord
from ..filter.pass_band.record import PassBandRecord
from ..io.tables import write_csv

CURVE_COLUMNS = (
    "label", "i", "stage", "r_y", "r_x", "sigma_i_m", "l1_m", "residual_m", "held_out_m", "weighted",
    "cell_px", "round", "error_m",
)  # fmt: skip
"""r_y, r_x and weighted are of the filter "ideal", cell_px and round of "edge-aware"; the other's cells are empty."""


def write_curves(path: str | os.PathLike[str], history: Mapping[int, Sequence[IterationRecord]]) -> None:
    """Write the record of every iteration, block after block, atomically.

    Floats keep every digit, and seconds are left out: the same run gives the same file. The cell of an error that there
    are no pixels for is empty.

    Parameters
    ----------
    path : path-like
    history : mapping
        Label -> records, as in `Completion.history`.

    Raises
    ------
    ExportError
        If the file cannot be written.
    """
    lines = ({"label": label, **_cells(record)} for label in sorted(history) for record in history[label])
    write_csv(path, [CURVE_COLUMNS, *([line.get(name) for name in CURVE_COLUMNS] for line in lines)])


def _cells(record: IterationRecord) -> dict[str, object]:
    """Column -> what stands in it."""
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
