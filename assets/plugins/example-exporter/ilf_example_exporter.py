"""A table of the blocks (.blocks.csv) as an export format: a row for each."""

from __future__ import annotations

import csv
from pathlib import Path

from ilf.data.results import Completion


class BlockTable:
    """An object is made before a run: a package that is needed and missing should be reported here."""

    def write(self, path: Path, completion: Completion) -> None:
        """Write the table into the empty file at `path`, which gets its name afterwards."""
        with open(path, "w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(["block", "status", "pixels", "recovered", "iterations", "sigma_i_m"])
            for label, one in completion.outcomes.items():
                table.writerow([label, one.status.value, one.pixels, one.recovered, one.iterations, one.sigma_i])
