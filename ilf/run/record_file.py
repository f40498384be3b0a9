"""Reading of run.json: every value is checked, with a clear error message."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import Any

from .._runtime.files import read_json
from .._runtime.schema import PROGRAM, check_schema, converted
from ..data.camera import checked_transform
from ..data.parameters import BlockParameters, Parameters
from ..errors import FormatError, InputError, ParameterError, told_as
from ..io.encodings import encoding_of
from .record import SCHEMA, RunRecord


def read_record(path: str | os.PathLike[str]) -> RunRecord:
    """Read and check a run record. Unknown sections and keys are ignored.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it is not JSON, not a run record, of another schema, incomplete, or has a value of the wrong type. Also for
        unknown parameters, because without them the run would be different.
    """
    data = read_json(path)
    if not isinstance(data, dict) or data.get("program") != PROGRAM:
        raise FormatError(f"{Path(path).absolute()} is not a run record: give the run.json of an export.")
    with told_as(FormatError, f"{Path(path).absolute()}: {{error}}", (InputError, ParameterError)):
        check_schema(data, SCHEMA, "run record")
        return _parsed(data)


def modes_in(path: str | os.PathLike[str]) -> frozenset[str]:
    """The modes (`Parameters.mode`) in a run record; nothing else in it is checked, which would take a hundred times as
    long. Raises as `read_record`."""
    data = read_json(path)
    try:
        common = data["parameters"]["mode"]
        return frozenset({common, *(own.get("mode", common) for own in data["block_parameters"].values())})
    except (KeyError, TypeError, AttributeError) as error:
        raise FormatError(f"{Path(path).absolute()} is not a run record: give the run.json of an export.") from error


def _parsed(data: dict[str, Any]) -> RunRecord:
    for key, kind in (("parameters", Parameters), ("extraction", BlockParameters)):
        if isinstance(data.get(key), dict):
            data[key] = kind.from_dict(data[key])
    if isinstance(data.get("blocks_outcome"), list):
        data["blocks_outcome"] = [_without_null_deviation(outcome) for outcome in data["blocks_outcome"]]
    record = converted({"neighbours": [], **data}, RunRecord, "run record")
    record.own_parameters  # noqa: B018 - refuses unknown names and values out of range
    if record.pose is not None:
        checked_transform(record.pose, "'pose' in the run record")
    for neighbour in record.neighbours:
        checked_transform(neighbour.motion, "'motion' of a neighbour in the run record")
    inputs = record.inputs
    if inputs is None or inputs.encoding is None:
        return record
    with told_as(FormatError, f"There is no depth encoding {inputs.encoding!r:.60}.", ParameterError):
        return replace(record, inputs=replace(inputs, depth_units=encoding_of(inputs.encoding).units))


def _without_null_deviation(outcome: object) -> object:
    """Leave a deviation of null out: it is NaN, the default."""
    if isinstance(outcome, dict) and outcome.get("sigma_i", 0) is None:
        return {name: value for name, value in outcome.items() if name != "sigma_i"}
    return outcome
