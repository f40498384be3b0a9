"""SHA-256 of arrays and of files, without what differs from run to run or tells where it was made."""

import hashlib
import json
from collections.abc import Set
from pathlib import Path
from typing import Any

import numpy as np

Hashes = dict[str, str]

LEFT_OUT = {"version", "versions", "processor", "device", "seconds", "meta.json"}
"""Names in JSON files whose values are not hashed; that of meta.json in run.json is a hash that depends on paths."""

NOT_HASHED = "frame.json", "manifest.csv"
"""Files of a batch with times, whose other numbers `ilf batch --json` prints."""


def of_bytes(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def of_text(text: str) -> str:
    return of_bytes(text.encode())


def of_array(values: Any) -> str:
    """Hash of an array's type, shape and values."""
    array = np.ascontiguousarray(values)
    return of_bytes(f"{array.dtype.str} {array.shape} ".encode() + array.tobytes())


def of_files(folder: Path) -> Hashes:
    """Hash of every file in a folder; JSON is hashed without `LEFT_OUT`, and with the names of absolute paths only."""
    paths = [path for path in sorted(folder.rglob("*")) if path.is_file() and path.name not in NOT_HASHED]
    return {path.relative_to(folder).as_posix(): _of_file(path) for path in paths}


def _of_file(path: Path) -> str:
    return of_text(portable_json(path)) if path.suffix == ".json" else of_bytes(path.read_bytes())


def portable_json(path: Path, left_out: Set[str] = LEFT_OUT) -> str:
    """The text of a JSON file without some names and their values, and with the names of absolute paths only."""
    return json.dumps(_portable(json.loads(path.read_text(encoding="utf-8")), left_out))


def _portable(value: Any, left_out: Set[str]) -> Any:
    if isinstance(value, dict):
        return {name: _portable(part, left_out) for name, part in value.items() if name not in left_out}
    if isinstance(value, list):
        return [_portable(part, left_out) for part in value]
    return Path(value).name if isinstance(value, str) and Path(value).is_absolute() else value
