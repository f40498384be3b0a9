"""Telling results of this program, whose depth was completed, from measured frames."""

from __future__ import annotations

import os

from .._runtime.files import is_address, read_json
from ..errors import InputError

RECORD_FILE = "run.json"
"""File of the record of a run, beside its results."""


def is_result(rgb: str, depth: str | None, frame: str | None) -> bool:
    """Whether the depth of a frame, as `FrameSource` gives it, was completed by this program, so that not all of it was
    measured. False at addresses."""
    if frame is not None:
        from .shards import is_shards

        return not is_address(rgb) and is_shards(rgb)
    record = os.path.join(rgb if depth is None else os.path.dirname(depth), RECORD_FILE)
    if is_address(record) or not os.path.isfile(record):
        return False
    return depth is None or os.path.basename(depth) in output_names(record)


def output_names(record: str) -> frozenset[str]:
    """The names of the files that a run wrote, by its record; none if the file is no record."""
    try:
        data = read_json(record)
    except InputError:
        return frozenset()
    outputs = data.get("outputs") if isinstance(data, dict) else None
    return frozenset(outputs) if isinstance(outputs, dict) else frozenset()
