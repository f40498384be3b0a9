"""The list of kept runs as a file."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence

from gui.kept.run_rows import RunRow
from ilf.io.tables import write_csv
from ilf.parameters import Parameters
from ilf.preset_words import likeness

_ERRORS = ("rmse_truth [mm]", "rmse_hidden [mm]", "expected_error_rms [mm]")


def write_runs(path: str | os.PathLike[str], rows: Sequence[RunRow]) -> None:
    """Write runs as CSV, one per line: what the list shows, and all common parameters that have an effect.

    Parameters
    ----------
    path : path
    rows : sequence of RunRow
        One at least.

    Raises
    ------
    ExportError
        If the file cannot be written; what was there before is as it was.
    """
    lines = [_line(row) for row in rows]
    write_csv(path, [lines[0], *(line.values() for line in lines)])


def _line(row: RunRow) -> dict[str, object]:
    kept, parameters = row.kept, row.kept.run.parameters
    values = parameters.to_dict()
    return {
        "number": kept.number,
        "name": row.name,
        "note": row.note,
        "when": row.when.isoformat(timespec="seconds"),
        "how": kept.how,
        "time [s]": f"{row.seconds:.3f}",
        "iterations": row.iterations,
        "blocks_run": len(kept.done),
        "blocks_with_result": len(kept.results),
        "blocks": kept.block_count,
        "filled [px]": kept.recovered,
        **{name: _millimetres(error) for name, error in zip(_ERRORS, row.errors, strict=True)},
        "preset": likeness(parameters).preset,
        "values": row.values,
        **{
            f"{name} [{declaration.unit}]" if declaration.unit else name: values[name]
            if parameters.matters(name)
            else ""
            for name, declaration in Parameters.declarations().items()
        },
    }


def _millimetres(error: float | None) -> str:
    return "" if error is None or math.isnan(error) else f"{1000 * error:.3f}"
