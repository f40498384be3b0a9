"""The files of shards: writing, checking and merging them."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, get_type_hints

from .._runtime.files import atomic_path, file_sha256, write_parts
from .._runtime.installation import optional
from ..errors import FormatError, IlfError, InputError, cause
from ..sources.shards import END, LIST_FILE, MERGED_FILE, ShardTable, read_sample, read_shard_set
from .frame_record import FrameOutcome, FrameStatus
from .shard_task import Part, column_name

_PURPOSE = "Writing shards"


def _put(folder: Path, name: str, parts: Iterable[bytes]) -> None:
    """Write a file of the results, once and whole: the only place where a shard's files come into its folder."""
    write_parts(folder / name, parts)


def schema() -> Any:
    """Return the schema of the tables: the figures of a frame, then its files and hashes."""
    pyarrow = optional("pyarrow", "shards", _PURPOSE)
    kinds = {int: pyarrow.int64(), float: pyarrow.float64()}
    hints = get_type_hints(FrameOutcome)
    columns = {
        column_name(field.name): next((kinds[kind] for kind in kinds if kind in _members(hints[field.name])), None)
        or pyarrow.string()
        for field in dataclasses.fields(FrameOutcome)
    }
    columns |= dict.fromkeys(("rgb", "rgb_sha256", "depth_sha256", "shard"), pyarrow.string())
    columns |= {"offset": pyarrow.int64(), "size": pyarrow.int64(), "sha256": pyarrow.string()}
    return pyarrow.schema(list(columns.items()))


def _members(kind: Any) -> tuple[Any, ...]:
    return getattr(kind, "__args__", (kind,))


def write_shard(folder: Path, name: str, sha256: str, parts: Sequence[Path]) -> None:
    """Write the tar of a shard from its frames' parts, then its table.

    Parameters
    ----------
    folder : Path
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
    pyarrow = optional("pyarrow", "shards", _PURPOSE)
    columns, digest = schema(), hashlib.sha256()
    rows: list[dict[str, Any]] = []

    def contents() -> Iterator[bytes]:
        offset = 0
        for path in parts:
            part = Part.of(path.read_bytes())
            place = {"shard": f"{name}.tar", "offset": offset, "size": len(part.data)} if part.data else {}
            rows.append({key: _text(value) for key, value in {**part.row, **place}.items()})
            offset += len(part.data)
            yield part.data
        yield END

    def hashed() -> Iterator[bytes]:
        for data in contents():
            digest.update(data)
            yield data

    _put(folder, f"{name}.tar", hashed())
    failed = sum(row["status"] == FrameStatus.FAILED for row in rows)
    facts = {"sha256": sha256, "tar_sha256": digest.hexdigest(), "failed": failed}
    table = pyarrow.Table.from_pylist(rows, columns.with_metadata({"ilf": json.dumps(facts)}))
    sink = pyarrow.BufferOutputStream()
    optional("pyarrow.parquet", "shards", _PURPOSE).write_table(table, sink)
    _put(folder, f"{name}.parquet", [sink.getvalue().to_pybytes()])


def sample_of(folder: Path, name: str) -> Iterator[tuple[dict[str, Any], bytes]]:
    """Yield the rows of a finished shard's table, each with its frame's part of the tar; raises FormatError if that is
    damaged."""
    table, path = ShardTable(folder / f"{name}.parquet"), folder / f"{name}.tar"
    try:
        rows = table.read().to_pylist()
    finally:
        table.close()
    try:
        with open(path, "rb") as tar:
            for row in rows:
                data = read_sample(tar, row) if row["size"] else b""
                if row["size"] and hashlib.sha256(data).hexdigest() != row["sha256"]:
                    raise FormatError(f"{path} is damaged in {row['key']}. {_REMEDY.format(name=name)}")
                yield row, data
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({cause(error)}). {_REMEDY.format(name=name)}") from error


_REMEDY = "Delete {name}.parquet and run the batch again, which writes the shard anew."


def _text(value: Any) -> Any:
    """Return a value whose text can be stored: names of files may contain bytes that are no text."""
    return value.encode(errors="backslashreplace").decode() if isinstance(value, str) else value


# Checking and merging a folder of shards.


@dataclasses.dataclass(frozen=True)
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


def check_shards(folder: Path, *, contents: bool = True) -> ShardCheck:
    """Check a folder of shards.

    Parameters
    ----------
    folder : Path
    contents : bool
        Also read all tars, and compare the tables with the frozen list.

    Raises
    ------
    InputError
        If the folder has no shards, or pyarrow is not installed.
    """
    shards = read_shard_set(folder)
    finished = set(shards.finished(folder))
    problems: list[str] = []
    completed = failed = 0
    if contents and file_sha256(folder / LIST_FILE) != shards.list_sha256:
        raise FormatError(f"{folder / LIST_FILE} is damaged: its frames are not those of the batch.")
    with open(folder / LIST_FILE, "rb") as lines:
        for index in range(shards.count):
            count, name = len(shards.numbers(index)), shards.name(index)
            keys = [_text(json.loads(next(lines))["key"]) for _ in range(count)] if contents else []
            if index not in finished:
                continue
            try:
                table = ShardTable(folder / f"{name}.parquet")
                try:
                    completed, failed = completed + table.rows - table.failed, failed + table.failed
                    if contents:
                        _check_shard(folder, name, shards.sha256, table, keys)
                finally:
                    table.close()
            except IlfError as error:
                problems.append(str(error))
    return ShardCheck(shards.count, len(finished), shards.frames, completed, failed, tuple(problems))


def _check_shard(folder: Path, name: str, sha256: str, table: ShardTable, keys: list[str]) -> None:
    """Raise FormatError or InputError unless a tar and a table belong to the settings, the list and each other."""
    remedy = _REMEDY.format(name=name)
    if table.sha256 != sha256 or table.read("key")["key"].to_pylist() != keys:
        raise FormatError(f"{folder / name}.parquet does not have the frames of the list. {remedy}")
    if file_sha256(folder / f"{name}.tar") != table.tar_sha256:
        raise FormatError(f"{folder / name}.tar is damaged: its content is not that of its table. {remedy}")


def merge_tables(folder: Path) -> Path:
    """Write one table with the rows of all finished shards; raises as `check_shards`, or ExportError."""
    shards = read_shard_set(folder)
    parquet = optional("pyarrow.parquet", "shards", _PURPOSE)
    with atomic_path(folder / MERGED_FILE) as temporary, parquet.ParquetWriter(temporary, schema()) as writer:
        for index in shards.finished(folder):
            table = ShardTable(folder / f"{shards.name(index)}.parquet")
            try:
                writer.write_table(table.read().replace_schema_metadata(None))
            finally:
                table.close()
    return folder / MERGED_FILE
