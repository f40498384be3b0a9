"""The part of a frame in a shard: a row of its table, and files of its tar. It waits in a file of its own until all
frames of the shard have one."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import tarfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .._runtime.files import open_file
from .._runtime.schema import plain
from .._runtime.writing import ensure_folder, write_bytes
from ..data.frame import RGBDFrame
from ..errors import ExportError, FormatError, InputError, cause
from ..run.options import ExportOptions
from ..sources.shards import FACTS
from .frame_record import FrameOutcome, FrameStatus

_LONGEST_ROW = 2**20

COLUMNS = {
    field.name: {"frame": "key", "folder": "sample"}.get(field.name, field.name)
    for field in dataclasses.fields(FrameOutcome)
}
"""Field of an outcome -> its column in the tables."""


@dataclass(frozen=True)
class Part:
    """A frame's row of the table, and its files as part of a tar; none for a failed frame."""

    row: dict[str, Any]
    data: bytes = b""

    @classmethod
    def of(cls, content: bytes) -> Part:
        """Return the part in the content of its file."""
        line, _, data = content.partition(b"\n")
        return cls(json.loads(line), data)

    def write(self, path: Path) -> None:
        """Write its file: the row as a line of JSON, then its files. Its folder is made anew if another process has
        finished the shard and removed it meanwhile."""
        content = json.dumps(plain(self.row), ensure_ascii=True).encode() + b"\n" + self.data
        try:
            write_bytes(ensure_folder(path.parent) / path.name, content)
        except ExportError:
            if path.parent.exists():
                raise
            write_bytes(ensure_folder(path.parent) / path.name, content)


def read_row(path: Path) -> dict[str, Any] | None:
    """Read the row of a part, whose files are not read; None if there is no such part. Raises FormatError if it is
    damaged."""
    try:
        with open_file(path) as file:
            row = Part.of(file.readline(_LONGEST_ROW)).row
            return {**row, "status": str(row["status"])}
    except (OSError, ValueError, LookupError, TypeError, RecursionError, InputError) as error:
        if not path.exists():
            return None
        raise FormatError(f"{path} is damaged ({cause(error)}). Delete it and run the batch again.") from error


def outcome_of(row: Mapping[str, Any]) -> FrameOutcome:
    """Return the outcome in a row of a table."""
    values = {name: row[column] for name, column in COLUMNS.items() if column in row}
    return FrameOutcome(**values | {"status": FrameStatus(values["status"])})


def failed_part(outcome: FrameOutcome) -> Part:
    """Return the part of a failed frame."""
    return Part(_figures(outcome) | {"seconds": outcome.seconds})


def completed_part(
    outcome: FrameOutcome, frame: RGBDFrame, files: Mapping[str, bytes], settings: str, options: ExportOptions
) -> Part:
    """Return the part of a completed frame; the same frame gives the same tar, wherever and whenever it is completed.

    Parameters
    ----------
    outcome : FrameOutcome
    frame : RGBDFrame
        As it was completed.
    files : mapping
        Ending of a file's name -> its content.
    settings : str
        Hash of the settings and the frozen list.
    options : ExportOptions
    """
    figures, inputs, camera, (height, width) = _figures(outcome), frame.inputs, frame.intrinsics, frame.shape
    hashes = {
        "rgb_sha256": None if inputs is None else inputs.rgb.sha256,
        "depth_sha256": None if inputs is None else inputs.depth.sha256,
    }
    facts = {
        "settings": settings,
        **figures,
        **hashes,
        "size": [width, height],
        "depth_units_per_m": options.depth_units if options.depth_formats == ("png",) else None,
        "K": None if camera is None else [camera.fx, camera.fy, camera.cx, camera.cy],
        "pose": None if frame.pose is None else frame.pose.tolist(),
    }
    members = {**files, FACTS: f"{json.dumps(plain(facts), indent=2)}\n".encode()}
    data = b"".join(_member(f"{outcome.folder}.{name}", content) for name, content in members.items())
    place = {"rgb": _colour_path(frame), "size": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    return Part({**figures, **hashes, **place, "seconds": outcome.seconds}, data)


def _figures(outcome: FrameOutcome) -> dict[str, Any]:
    """Return the values of an outcome by their columns, without its duration: equal runs give equal values."""
    values = {**dataclasses.asdict(outcome), "status": str(outcome.status)}
    del values["seconds"]
    return {COLUMNS[name]: value for name, value in values.items()}


def _colour_path(frame: RGBDFrame) -> str | None:
    """Return the file of a frame's colour; None if it is from a recording, or was registered, turned or undistorted."""
    inputs = frame.inputs
    if inputs is None:
        return None
    changes = inputs.frame, inputs.depth_intrinsics, inputs.orientations, inputs.lenses, inputs.view
    return inputs.rgb.path if all(change is None for change in changes) else None


def _member(name: str, content: bytes) -> bytes:
    """Return a file as part of a tar."""
    info = tarfile.TarInfo(name)
    info.size = len(content)
    padding = bytes(-len(content) % tarfile.BLOCKSIZE)
    return info.tobuf(tarfile.GNU_FORMAT) + content + padding
