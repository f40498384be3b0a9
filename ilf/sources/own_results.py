"""Telling results of this program, whose depth was completed, from measured frames."""

from __future__ import annotations

import os

from .._runtime.files import is_address, read_json
from .._runtime.folders import folder_at
from ..errors import InputError
from .frame_ref import FrameRef

RECORD_FILE = "run.json"
"""File of the record of a run, beside its results."""

SHARDS_FILE = "shards.json"
"""File of a folder of shards that states what they contain."""

COMPLETED_DEPTH = (
    "the depth was completed by ILF Studio, so that filled depth counts as measured. Give the frame that was completed."
)


def is_shards(path: str | os.PathLike[str]) -> bool:
    """Whether a folder or an address contains shards, finished or not."""
    return folder_at(path).exists(SHARDS_FILE)


def is_result_folder(ref: FrameRef) -> bool:
    """Whether a frame is a folder with the result and the record of a run."""
    return ref.depth is None and ref.frame is None and is_result(ref)


def is_result(ref: FrameRef) -> bool:
    """Whether the depth of a frame was completed by this program, so that not all of it was measured. False at
    addresses."""
    if ref.frame is not None:
        return not is_address(ref.rgb) and is_shards(ref.rgb)
    record = os.path.join(ref.rgb if ref.depth is None else os.path.dirname(ref.depth), RECORD_FILE)
    if is_address(record) or not os.path.isfile(record):
        return False
    if ref.depth is None:
        return True
    try:
        data = read_json(record)
    except InputError:
        return False
    outputs = data.get("outputs") if isinstance(data, dict) else None
    return isinstance(outputs, dict) and os.path.basename(ref.depth) in outputs
