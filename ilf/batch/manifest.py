"""manifest.csv: what came of every frame whose results are in a folder, by their records."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

from ..io.tables import write_csv
from .frame_record import FRAME_FILE, FrameOutcome, read_frame_record
from .frames import BatchFrame

MANIFEST_FILE = "manifest.csv"

_UNITS = {
    "time": "time_s",
    "expected_error_median": "expected_error_median_m",
    "expected_error_p90": "expected_error_p90_m",
    "hidden_mae": "hidden_mae_m",
    "hidden_rmse": "hidden_rmse_m",
    "truth_mae": "truth_mae_m",
    "truth_rmse": "truth_rmse_m",
}

MANIFEST_COLUMNS = tuple(_UNITS.get(field.name, field.name) for field in dataclasses.fields(FrameOutcome))


def write_manifest(folder: Path, order: Sequence[BatchFrame]) -> list[FrameOutcome]:
    """Write the manifest, and return what is in it.

    Several processes may share a folder: whoever writes looks again afterwards, and writes once more if a record has
    come meanwhile. The last one to write has then seen all that there is.

    Parameters
    ----------
    folder : Path
    order : sequence of BatchFrame
        Rows come in this order; those of other frames behind them.

    Raises
    ------
    ExportError
        If it cannot be written.
    """
    before = None
    while (state := _state(folder)) != before:
        before = state
        outcomes = read_outcomes(folder, order)
        write_csv(folder / MANIFEST_FILE, [MANIFEST_COLUMNS, *map(dataclasses.astuple, outcomes)])
    return outcomes


def read_outcomes(folder: Path, order: Sequence[BatchFrame] = ()) -> list[FrameOutcome]:
    """What came of the frames whose records are in a folder."""
    places = {frame.folder: place for place, frame in enumerate(order)}
    records = (read_frame_record(path.parent) for path in folder.glob(f"*/{FRAME_FILE}"))
    outcomes = [record.outcome for record in records if record is not None]
    return sorted(outcomes, key=lambda outcome: (places.get(outcome.folder, len(places)), outcome.frame))


def _state(folder: Path) -> dict[str, int]:
    """The records that there are, and when they were written."""
    state = {}
    for path in folder.glob(f"*/{FRAME_FILE}"):
        try:
            state[path.parent.name] = path.stat().st_mtime_ns
        except OSError:  # gone since
            continue
    return state
