"""Completing one frame of a batch into a shard: the task of every worker. Its part of the tar waits in a file of its
own until the shard is complete."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import tarfile
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import open_file
from .._runtime.schema import plain
from .._runtime.writing import ensure_folder, write_bytes
from ..completion.confidence.expected_error import expected_error, unsupported
from ..data.frame import RGBDFrame
from ..data.results import Completion
from ..errors import Cancelled, ExportError, FormatError, InputError, cause
from ..io.depth import encode_depth, encode_expected_error
from ..io.images import encode_image
from ..io.labels import encode_labels, with_more_invalid
from ..run.run import Run
from ..sources.reading import read_frame
from ..sources.shards import COLOUR, DEPTH, FACTS
from .frame_record import COLUMNS_WITH_UNITS, FrameOutcome, FrameStatus
from .frames import BatchFrame, folder_name, with_hash
from .settings import BatchSettings
from .task import failure_text, measured

KEPT = ("depth", "expected_error", "blocks", "unsupported", "rgb")
"""What a shard can contain of a frame, besides its frame.json."""


@dataclass(frozen=True)
class ShardTask:
    """The data of a batch that its workers need.

    Attributes
    ----------
    folder : str
        Absolute path of the parts.
    settings : BatchSettings
        Their export options have one depth format and its units.
    keep : tuple of str
        Any of `KEPT`.
    sha256 : str
        Hash of the settings and the frozen list.
    strict : bool
        Whether a frame with plausibility warnings fails.
    """

    folder: str
    settings: BatchSettings
    keep: tuple[str, ...]
    sha256: str
    strict: bool = False

    def part(self, name: str, number: int) -> Path:
        """Return the file of a frame's part, by the name of its shard and its place in the frozen list."""
        return Path(self.folder, name, f"{number:09}")


@dataclass(frozen=True, eq=False)
class ShardFrame:
    """A frame of a shard: the shard's name, the frame's place in the frozen list, and the frame."""

    shard: str
    number: int
    frame: BatchFrame


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

    def content(self) -> bytes:
        """Return the content of its file: the row as a line of JSON, then its files."""
        return json.dumps(plain(self.row), ensure_ascii=True).encode() + b"\n" + self.data


def sample_name(key: str) -> str:
    """Return the name of a frame's files in a tar, derived from its key. It has no dots: WebDataset ends it there.

    Examples
    --------
    >>> sample_name("rgb/0001"), sample_name("1305031102.175")
    ('rgb__0001', '1305031102_175-181dca9b')
    """
    name = folder_name(key)
    return name if "." not in name else with_hash(name.replace(".", "_"), key)


def complete_part(task: ShardTask, item: ShardFrame, threads: int | None = None) -> FrameOutcome:
    """Complete a frame and write its part, unless another process has. Errors of the frame itself become its outcome.

    Raises
    ------
    ExportError
        If the part cannot be written.
    FormatError
        If the part that another process has written is damaged.
    """
    path = task.part(item.shard, item.number)
    if (row := read_row(path)) is not None:
        return outcome_of(row)
    if threads is not None:
        cv2.setNumThreads(threads)
    started = time.perf_counter()
    try:
        outcome, part = _completed(task, item.frame, threads)
    except Cancelled:
        raise
    except Exception as error:
        outcome, part = failed_part(item.frame, failure_text(error))
    part.row["seconds"] = round(time.perf_counter() - started, 3)
    write_part(path, part)
    return outcome


def write_part(path: Path, part: Part) -> None:
    """Write a part; its folder is made anew if another process has finished the shard and removed it meanwhile."""
    for attempt in (1, 2):
        try:
            write_bytes(ensure_folder(path.parent) / path.name, part.content())
        except ExportError:
            if attempt == 2 or path.parent.exists():
                raise
        else:
            return


_LONGEST_ROW = 2**20


def read_row(path: Path) -> dict[str, Any] | None:
    """Return the row of a part, whose files are not read, or None if there is no such part; raises FormatError if it is
    damaged."""
    try:
        with open_file(path) as file:
            row = Part.of(file.readline(_LONGEST_ROW)).row
            return {**row, "status": str(row["status"])}
    except (OSError, ValueError, LookupError, TypeError, RecursionError, InputError) as error:
        if not path.exists():
            return None
        raise FormatError(f"{path} is damaged ({cause(error)}). Delete it and run the batch again.") from error


def failed_part(frame: BatchFrame, message: str) -> tuple[FrameOutcome, Part]:
    """Return the outcome and the part of a failed frame."""
    outcome = FrameOutcome(frame.key, frame.folder, frame.time, FrameStatus.FAILED, message)
    return outcome, Part(_figures(outcome))


def _completed(task: ShardTask, frame: BatchFrame, threads: int | None) -> tuple[FrameOutcome, Part]:
    settings = task.settings
    loaded = read_frame(frame.source)
    plausibility_warnings = " ".join(loaded.plausibility_warnings)
    if plausibility_warnings and task.strict:
        raise InputError(plausibility_warnings)
    if settings.invalid_mask is not None:
        loaded = with_more_invalid(loaded, settings.invalid_mask)
    run = settings.run_of(loaded)
    completion = run.complete(threads=threads)
    error = expected_error(completion)
    files, notes = _files(task, run, completion, error)
    outcome = measured(settings, frame, run, completion, error, threads)
    told = dict.fromkeys(filter(None, [*loaded.notes, *run.blocks.notes, outcome.message, *completion.notes, *notes]))
    outcome = replace(outcome, message=" ".join(told), plausibility_warnings=plausibility_warnings)
    figures, hashes = _figures(outcome), _input_hashes(loaded)
    facts = {"settings": task.sha256, **figures, **hashes, **_geometry(task, loaded)}
    files[FACTS] = f"{json.dumps(plain(facts), indent=2)}\n".encode()
    data = b"".join(_member(f"{frame.folder}.{name}", content) for name, content in files.items())
    more = {"rgb": _colour_path(loaded), "size": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    return outcome, Part({**figures, **hashes, **more}, data)


def _files(
    task: ShardTask, run: Run, completion: Completion, error: NDArray[np.float32]
) -> tuple[dict[str, bytes], list[str]]:
    """Return the kept files by the endings of their names, and notes on what they do not preserve."""
    (depth_format,), units = task.settings.options.depth_formats, task.settings.options.depth_units
    files: dict[str, bytes] = {}
    notes: list[str] = []
    name = f"{DEPTH}.{depth_format}"
    files[name], found = encode_depth(name, completion.depth, units)
    notes += found
    if "expected_error" in task.keep:
        name = f"expected_error.{depth_format}"
        files[name], found = encode_expected_error(name, error, units)
        notes += found
    if "blocks" in task.keep:
        files["blocks.png"] = encode_labels(run.blocks.labels)
    if "unsupported" in task.keep:
        files["unsupported.png"] = encode_image(".png", 255 * unsupported(completion).astype(np.uint8))
    if "rgb" in task.keep:
        files[COLOUR] = encode_image(".png", run.frame.rgb[..., ::-1])  # the encoder expects BGR
    return files, notes


def _figures(outcome: FrameOutcome) -> dict[str, Any]:
    """Return the values of an outcome by their names in tables, without its duration: equal runs give equal values."""
    values = {**dataclasses.asdict(outcome), "status": str(outcome.status)}
    del values["seconds"]
    return {column_name(name): value for name, value in values.items()}


def outcome_of(row: Mapping[str, Any]) -> FrameOutcome:
    """Return the outcome in a row of a table."""
    columns = {field.name: column_name(field.name) for field in dataclasses.fields(FrameOutcome)}
    values = {name: row[column] for name, column in columns.items() if column in row}
    return FrameOutcome(**values | {"status": FrameStatus(values["status"])})


def column_name(name: str) -> str:
    """Return the column of the tables with a field of `FrameOutcome`."""
    return {"frame": "key", "folder": "sample"}.get(name) or COLUMNS_WITH_UNITS.get(name, name)


def _input_hashes(frame: RGBDFrame) -> dict[str, str | None]:
    inputs = frame.inputs
    return {
        "rgb_sha256": None if inputs is None else inputs.rgb.sha256,
        "depth_sha256": None if inputs is None else inputs.depth.sha256,
    }


def _colour_path(frame: RGBDFrame) -> str | None:
    """Return the file of a frame's colour; None if it is from a recording, or was changed by registration or turned."""
    inputs = frame.inputs
    if (
        inputs is None
        or inputs.frame is not None
        or inputs.depth_intrinsics is not None
        or inputs.orientations
        or inputs.lenses
    ):
        return None
    return inputs.rgb.path


def _geometry(task: ShardTask, frame: RGBDFrame) -> Mapping[str, Any]:
    camera, (height, width) = frame.intrinsics, frame.shape
    options = task.settings.options
    return {
        "size": [width, height],
        "depth_units_per_m": options.depth_units if options.depth_formats == ("png",) else None,
        "K": None if camera is None else [camera.fx, camera.fy, camera.cx, camera.cy],
        "pose": None if frame.pose is None else frame.pose.tolist(),
    }


def _member(name: str, content: bytes) -> bytes:
    """Return a file as part of a tar, the same wherever and whenever it is written."""
    info = tarfile.TarInfo(name)
    info.size = len(content)
    padding = bytes(-len(content) % tarfile.BLOCKSIZE)
    return info.tobuf(tarfile.GNU_FORMAT) + content + padding
