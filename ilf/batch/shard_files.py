"""The files of shards: the parts of their frames, tars and tables; checking and merging them.

The part of a frame in a shard is a row of its table, and files of its tar. It waits in a file of its own until all
frames of the shard have one.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
import tarfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_type_hints

from .._runtime.files import open_file, parse_json
from .._runtime.folders import Folder
from .._runtime.installation import optional
from .._runtime.long_work import check_cancelled
from .._runtime.schema import plain
from .._runtime.writing import ensure_folder, write_bytes
from ..data.frame import RGBDFrame
from ..errors import ExportError, FormatError, IlfError, InputError, cause
from ..run.options import ExportOptions
from ..sources.shards import END, FACTS, LIST_FILE, MERGED_FILE, ShardSet, ShardTable, read_shard_set, table_ends
from .frame_record import FrameOutcome

_LONGEST_ROW = 2**20

COLUMNS = {
    field.name: {"frame": "key", "folder": "sample"}.get(field.name, field.name)
    for field in dataclasses.fields(FrameOutcome)
}
"""Field of an outcome -> its column in the tables."""


def write_part(path: Path, row: Mapping[str, Any], data: bytes = b"") -> None:
    """Write a frame's row of the table as a line of JSON, then its files as part of a tar; none for a failed frame. The
    folder is made anew if another process has finished the shard and removed it meanwhile."""
    content = json.dumps(plain(row), ensure_ascii=True).encode() + b"\n" + data
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
            row = json.loads(file.readline(_LONGEST_ROW))
            return {**row, "status": str(row["status"])}
    except (OSError, ValueError, LookupError, TypeError, RecursionError, InputError) as error:
        if not path.exists():
            return None
        raise FormatError(f"{path} is damaged ({cause(error)}). Delete it and run the batch again.") from error


def outcome_of(row: Mapping[str, Any]) -> FrameOutcome:
    """Return the outcome in a row of a table."""
    return FrameOutcome(**{name: row[column] for name, column in COLUMNS.items() if column in row})


def failed_part(outcome: FrameOutcome) -> dict[str, Any]:
    """Return the row of a failed frame."""
    return _figures(outcome) | {"seconds": outcome.seconds}


def completed_part(
    outcome: FrameOutcome, frame: RGBDFrame, files: Mapping[str, bytes], settings: str, options: ExportOptions
) -> tuple[dict[str, Any], bytes]:
    """Return the row of a completed frame and its part of a tar, which is the same wherever and whenever the same frame
    is completed.

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
        "K": None if camera is None else camera.numbers,
        "pose": None if frame.pose is None else frame.pose.tolist(),
    }
    members = {**files, FACTS: f"{json.dumps(plain(facts), indent=2)}\n".encode()}
    data = b"".join(_member(f"{outcome.folder}.{name}", content) for name, content in members.items())
    place = {"rgb": _colour_path(frame), "size": len(data), "sha256": hashlib.sha256(data).hexdigest()}
    return {**figures, **hashes, **place, "seconds": outcome.seconds}, data


def _figures(outcome: FrameOutcome) -> dict[str, Any]:
    """Return the values of an outcome by their columns, without its duration: equal runs give equal values."""
    values = dataclasses.asdict(outcome)
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


# Tars and tables.

_PURPOSE = "Writing shards"


def schema() -> Any:
    """Return the schema of the tables: the figures of a frame, then its files and hashes."""
    pyarrow = optional("pyarrow", "ilf-studio[cluster]", _PURPOSE)
    kinds = {int: pyarrow.int64(), float: pyarrow.float64()}
    hints = get_type_hints(FrameOutcome)
    columns = {
        column: next((kinds[kind] for kind in kinds if kind in _members(hints[name])), None) or pyarrow.string()
        for name, column in COLUMNS.items()
    }
    columns |= dict.fromkeys(("rgb", "rgb_sha256", "depth_sha256", "shard"), pyarrow.string())
    columns |= {"offset": pyarrow.int64(), "size": pyarrow.int64(), "sha256": pyarrow.string()}
    return pyarrow.schema(list(columns.items()))


def _members(kind: Any) -> tuple[Any, ...]:
    return getattr(kind, "__args__", (kind,))


def write_shard(folder: Folder, name: str, sha256: str, parts: Sequence[Path]) -> None:
    """Write the tar of a shard from its frames' parts, then its table.

    Parameters
    ----------
    folder : Folder
    name : str
        Without extension.
    sha256 : str
        Hash of the settings and the frozen list.
    parts : sequence of Path
        In the order of the list.

    Raises
    ------
    InputError
        If pyarrow is not installed.
    ExportError
        If a file cannot be written.
    """
    pyarrow = optional("pyarrow", "ilf-studio[cluster]", _PURPOSE)
    columns, digest = schema(), hashlib.sha256()
    rows: list[dict[str, Any]] = []

    def contents() -> Iterator[bytes]:
        offset = 0
        for path in parts:
            with open_file(path) as file:
                row, data = json.loads(file.readline(_LONGEST_ROW)), file.read()
            place = {"shard": f"{name}.tar", "offset": offset, "size": len(data)} if data else {}
            rows.append({key: _text(value) for key, value in {**row, **place}.items()})
            offset += len(data)
            digest.update(data)
            yield data
        digest.update(END)
        yield END

    folder.put(f"{name}.tar", contents())
    failed = sum(row["status"] == "failed" for row in rows)
    facts = {"sha256": sha256, "tar_sha256": digest.hexdigest(), "failed": failed}
    table = pyarrow.Table.from_pylist(rows, columns.with_metadata({"ilf": json.dumps(facts)}))
    sink = pyarrow.BufferOutputStream()
    optional("pyarrow.parquet", "ilf-studio[cluster]", _PURPOSE).write_table(table, sink)
    folder.put(f"{name}.parquet", [sink.getvalue().to_pybytes()])


def sample_of(folder: Folder, name: str) -> Iterator[tuple[dict[str, Any], bytes]]:
    """Yield the rows of a finished shard's table, each with its frame's part of the tar; raises FormatError if that is
    damaged."""
    with folder.open(f"{name}.tar") as tar:
        for row in ShardTable.of(folder, f"{name}.parquet").read().to_pylist():
            data = tar.read(row["size"] or 0)  # they lie one after the other
            if row["size"] and hashlib.sha256(data).hexdigest() != row["sha256"]:
                what = f"{row['key']} is not as in its table. {_REMEDY.format(name=name)}"
                raise FormatError(f"{folder}/{name}.tar is damaged: {what}")
            yield row, data


_REMEDY = "Delete {name}.parquet and run the batch again, which writes the shard anew."


def _text(value: Any) -> Any:
    """Return a value whose text can be stored: names of files may contain bytes that are no text."""
    return value.encode(errors="backslashreplace").decode() if isinstance(value, str) else value


# Checking and merging a folder of shards.


@dataclass(frozen=True)
class ShardCheck:
    """The state of a folder of shards.

    Attributes
    ----------
    shards, finished : int
    frames, completed, failed : int
        `completed` and `failed` count the frames of finished shards.
    problems : tuple of str
        A sentence or two for each damaged file.
    """

    shards: int
    finished: int
    frames: int
    completed: int
    failed: int
    problems: tuple[str, ...] = ()

    @property
    def is_complete(self) -> bool:
        """Whether all shards are finished and none is damaged."""
        return self.finished == self.shards and not self.problems


def check_shards(folder: Folder, *, contents: bool = True) -> ShardCheck:
    """Check a folder of shards.

    Parameters
    ----------
    folder : Folder
    contents : bool
        Also read all tars, and compare the tables with the frozen list.

    Raises
    ------
    InputError
        If the folder has no shards, or pyarrow is not installed.
    """
    shards = read_shard_set(folder)
    sizes = folder.sizes()
    finished = {shards.table(index): index for index in shards.finished(sizes)}
    problems: list[str] = []
    completed = failed = 0
    for _, table in table_ends(folder, {name: sizes[name] for name in finished}):
        if isinstance(table, FormatError):
            problems.append(str(table))
        else:
            completed, failed = completed + table.rows - table.failed, failed + table.failed
    if contents:
        problems = list(_problems(folder, shards, finished.values()))
    return ShardCheck(shards.count, len(finished), shards.frames, completed, failed, tuple(problems))


def _problems(folder: Folder, shards: ShardSet, finished: Iterable[int]) -> Iterator[str]:
    """Yield what is wrong with finished shards; raises FormatError if the frozen list is damaged."""
    if folder.sha256(LIST_FILE) != shards.list_sha256:
        raise FormatError(f"{folder}/{LIST_FILE} is damaged: its frames are not those of the batch.")
    for index in finished:
        keys = [_text(parse_json(line, LIST_FILE)["key"]) for line in shards.lines(folder, index)]
        try:
            _check_shard(folder, shards.name(index), shards.sha256, keys)
        except IlfError as error:
            yield str(error)


def _check_shard(folder: Folder, name: str, sha256: str, keys: list[str]) -> None:
    """Raise FormatError or InputError unless a tar and a table belong to the settings, the list and each other."""
    table, remedy = ShardTable.of(folder, f"{name}.parquet"), _REMEDY.format(name=name)
    if table.sha256 != sha256 or table.read("key")["key"].to_pylist() != keys:
        raise FormatError(f"{folder}/{name}.parquet does not have the frames of the list. {remedy}")
    digest, place = hashlib.sha256(), 0
    for row, data in sample_of(folder, name):
        if row["offset"] not in {None, place}:  # None: it has failed
            raise FormatError(f"{folder}/{name}.tar is damaged: {row['key']} is not as in its table. {remedy}")
        place += len(data)
        digest.update(data)
    digest.update(folder.read_range(f"{name}.tar", place, len(END) + 1))
    if digest.hexdigest() != table.tar_sha256:
        raise FormatError(f"{folder}/{name}.tar is damaged: its content is not that of its table. {remedy}")


def merge_tables(folder: Folder) -> None:
    """Write one table with the rows of all finished shards; raises as `check_shards`, or ExportError."""
    shards = read_shard_set(folder)
    parquet = optional("pyarrow.parquet", "ilf-studio[cluster]", _PURPOSE)
    with folder.writing(MERGED_FILE) as temporary, parquet.ParquetWriter(temporary, schema()) as writer:
        for index in shards.finished(folder.sizes()):
            check_cancelled()
            writer.write_table(ShardTable.of(folder, shards.table(index)).read().replace_schema_metadata(None))
