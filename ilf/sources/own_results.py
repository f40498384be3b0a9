"""Which depth was completed by this program, so that not all of it was measured."""

from __future__ import annotations

import os

from .._runtime.addresses import is_address
from .._runtime.files import read_json
from ..errors import InputError
from .shards import is_shards

RECORD_FILE = "run.json"
"""File of the record of a run, beside its results."""


def is_result(rgb: str, depth: str | None, frame: str | None) -> bool:
    """Whether the depth of a frame, located as in `FrameSource`, is that of a run. False at addresses."""
    if frame is not None:
        return not is_address(rgb) and is_shards(rgb)
    record = os.path.join(rgb if depth is None else os.path.dirname(depth), RECORD_FILE)
    if is_address(record) or not os.path.isfile(record):
        return False
    if depth is None:
        return True
    try:
        data = read_json(record)
    except InputError:  # it is no record
        return False
    outputs = data.get("outputs") if isinstance(data, dict) else None
    return isinstance(outputs, dict) and os.path.basename(depth) in outputs
