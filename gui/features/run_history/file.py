"""The run history as a file."""

from __future__ import annotations

import math
import os

from ilf.data.parameters import Parameters, nearest_preset
from ilf.io.tables import write_csv
from ilf.project.run_history import StoredRun

from ...state.document import Document
from .table import values_of


def write_runs(path: str | os.PathLike[str], document: Document) -> None:
    """Write the runs of a frame as CSV, one per line, at least one: the columns of the table, and all common
    parameters that have an effect.

    Raises
    ------
    ExportError
        If the file cannot be written; an existing file is not changed.
    """
    lines = [_line(document, stored) for stored in reversed(document.state.runs)]
    write_csv(path, [lines[0], *(line.values() for line in lines)])


def _line(document: Document, stored: StoredRun) -> dict[str, object]:
    parameters = stored.run.parameters
    values = parameters.to_dict()
    return {
        "number": stored.number,
        "name": stored.name,
        "note": stored.note,
        "when": stored.when.isoformat(timespec="seconds"),
        "how": stored.how,
        "time [s]": f"{stored.seconds:.3f}",
        "iterations": stored.iterations,
        "blocks_run": len(stored.done),
        "blocks_with_result": len(stored.results),
        "blocks": stored.block_count,
        "filled [px]": stored.recovered,
        "rmse_truth [mm]": _in_millimetres(stored.ground_truth_error),
        "rmse_hold_out [mm]": _in_millimetres(stored.hold_out_error),
        "expected_error_rms [mm]": _in_millimetres(stored.expected_error),
        "preset": nearest_preset(parameters).preset,
        "values": values_of(document, stored),
        **{
            f"{name} [{declaration.unit}]" if declaration.unit else name: values[name]
            if parameters.has_effect(name)
            else ""
            for name, declaration in Parameters.declarations().items()
        },
    }


def _in_millimetres(error: float | None) -> str:
    return "" if error is None or math.isnan(error) else f"{1000 * error:.3f}"
