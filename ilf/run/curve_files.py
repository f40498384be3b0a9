"""Convergence curves as CSV."""

from __future__ import annotations

import csv
import io
import math
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from ..io.atomic import write_bytes

if TYPE_CHECKING:
    from ..filter.convergence import IterationRecord

CURVE_COLUMNS = ("label", "i", "stage", "r_y", "r_x", "sigma_i_m", "l1_m", "residual_m", "held_out_m", "weighted")


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
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(CURVE_COLUMNS)
    for label in sorted(history):
        for record in history[label]:
            numbers = (repr(float(x)) for x in (*record.radii, record.sigma_i, record.l1))
            errors = ("" if math.isnan(x) else repr(float(x)) for x in (record.residual, record.held_out))
            writer.writerow((label, record.i, record.stage, *numbers, *errors, int(record.weighted)))
    write_bytes(path, text.getvalue().encode())
