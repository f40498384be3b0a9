"""SHA-256 of arrays and of files, without what differs from run to run or tells where it was made."""

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np

Hashes = dict[str, str]

LEFT_OUT = {"version", "versions", "processor", "device", "seconds", "meta.json"}
"""Names in JSON files whose values are not hashed; that of meta.json in run.json is a hash that depends on paths."""

NOT_HASHED = "frame.json", "manifest.csv"
"""Files of a batch with times, whose other numbers `ilf batch --json` prints."""


def of_text(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def of_array(values: Any) -> str:
    """Hash of an array's type, shape and values."""
    array = np.ascontiguousarray(values)
    return hashlib.sha256(f"{array.dtype.str} {array.shape} ".encode() + array.tobytes()).hexdigest()


def of_files(folder: Path) -> Hashes:
    """Hash of every file in a folder; JSON is hashed without `LEFT_OUT`, and with the names of absolute paths only."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file() and path.name not in NOT_HASHED]
    return {path.relative_to(folder).as_posix(): _of_file(path) for path in paths}


def _of_file(path: Path) -> str:
    if path.suffix != ".json":
        return hashlib.sha256(path.read_bytes()).hexdigest()
    return of_text(json.dumps(_portable(json.loads(path.read_text(encoding="utf-8")))))


def _portable(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _portable(part) for name, part in value.items() if name not in LEFT_OUT}
    if isinstance(value, list):
        return [_portable(part) for part in value]
    return Path(value).name if isinstance(value, str) and Path(value).is_absolute() else value
