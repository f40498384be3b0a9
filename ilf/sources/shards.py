"""Shards: completed frames in WebDataset tars, each with a Parquet table; written by `ilf.batch.shard_sink`."""

from __future__ import annotations

import bisect
import io
import json
import tarfile
from collections.abc import Container, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

import msgspec
import numpy as np
from numpy.typing import NDArray

from .._runtime.addresses import RemoteFiles
from .._runtime.children import run_in_child
from .._runtime.files import FileContent, is_address, parse_json, read_file
from .._runtime.folders import Folder, folder_at
from .._runtime.installation import optional
from .._runtime.memory import memory_limit
from .._runtime.schema import check_schema, converted
from ..data.camera import Cameras, camera_from_numbers, checked_transform
from ..errors import FormatError, InputError, cause, told_as
from ..io.depth import read_depth_values
from ..io.images import read_colour
from .frame_ref import SHARDS_FILE, is_shards
from .named_places import NotAllowed, named_in
from .recording import RecordedFrame, Recording, part_of, sha256_of

# The folder: shards.json, the frozen list of frames, and a tar and a table for each shard.

LIST_FILE, MERGED_FILE = "frames.jsonl", "merged.parquet"
SCHEMA = 1
"""Version of the format of shards.json, the frozen list and the tables."""

DEPTH, COLOUR, FACTS = "depth", "rgb.png", "frame.json"
"""Endings of the names of a frame's files in a tar, after the name of the frame; that of depth has .png or .npy."""

END = bytes(2 * tarfile.BLOCKSIZE)
"""The end of a tar."""

_DIGITS = 16
"""Digits of the hash in the names of shards."""


@dataclass(frozen=True)
class ShardSet:
    """The content of shards.json, which is written once, before the first frame.

    Attributes
    ----------
    settings, request : dict
        What determines the results, and the sources and selection of the frames, as JSON values.
    sha256 : str
        Hash of the settings and of all keys in the frozen list.
    frames : int
        Number of frames in the frozen list.
    per_shard : int
        Number of frames in a shard; the last one may have fewer.
    keep : tuple of str
        What the shards contain of each frame.
    list_bytes : int
    list_sha256 : str
        Size and hash of the file with the frozen list.
    list_offsets : tuple of int
        Places in it where the shards begin [bytes].
    """

    settings: dict[str, Any]
    request: dict[str, Any]
    sha256: str
    frames: int
    per_shard: int
    keep: tuple[str, ...]
    list_bytes: int
    list_sha256: str
    list_offsets: tuple[int, ...]

    @property
    def count(self) -> int:
        """Number of shards."""
        return -(-self.frames // self.per_shard)

    def name(self, index: int) -> str:
        """Return the name of a shard's files without extension."""
        return f"shard-{self.sha256[:_DIGITS]}-{index:06}"

    def numbers(self, index: int) -> range:
        """Return the places of a shard's frames in the frozen list."""
        return range(index * self.per_shard, min((index + 1) * self.per_shard, self.frames))

    def table(self, index: int) -> str:
        """Return the name of a shard's table."""
        return f"{self.name(index)}.parquet"

    def lines(self, folder: Folder, index: int) -> list[bytes]:
        """Read the lines of a shard from the frozen list; raises FormatError if it is damaged."""
        start, end = (*self.list_offsets, self.list_bytes)[index : index + 2]
        found = folder.read_range(LIST_FILE, start, end - start).splitlines()
        if len(found) != len(self.numbers(index)):
            raise FormatError(f"{folder}/{LIST_FILE} is damaged: its frames are not those of the batch.")
        return found

    def finished(self, names: Container[str]) -> list[int]:
        """Return the shards that are finished: those whose table is among the files, as it is written last."""
        return [index for index in range(self.count) if self.table(index) in names]


def read_shard_set(folder: Folder) -> ShardSet:
    """Read shards.json.

    Raises
    ------
    InputError
        If there is none, or it cannot be read.
    FormatError
        If it was not written by this program, or has another schema.
    """
    path = f"{folder}/{SHARDS_FILE}"
    if not folder.exists(SHARDS_FILE):
        raise InputError(f"{folder} contains no shards: it has no {SHARDS_FILE}. Check the name.")
    data = parse_json(folder.read(SHARDS_FILE), path, "Choose another folder.")
    if not isinstance(data, dict):
        raise FormatError(f"{path} was not written by this program. Choose another folder.")
    check_schema(data, SCHEMA, f"file {path}")
    found = converted(data, ShardSet, f"file {path}")
    if min(found.frames, found.per_shard) < 1 or len(found.list_offsets) != found.count:
        raise FormatError(f"{path} has no frames. Choose another folder.")
    return found


_TYPES = {"time_s": "double", "offset": "int64", "size": "int64"}
"""Types of the columns that are read here; the others are text."""

_REMEDY = "Delete it and run the batch again, which writes it anew."

TABLE_MEMORY = 2**31
"""Limit of the memory of a child that reads a table [bytes]."""


class ShardTable:
    """The Parquet table of a shard, opened; its rows are the frames of the shard in the order of the list.

    Parameters
    ----------
    content : bytes
        Content of its file, or the end of it, whose columns cannot be read.
    path : str
        Its path or address, for messages.

    Raises
    ------
    InputError
        If pyarrow is not installed.
    FormatError
        If the table is damaged, or of another program.
    """

    def __init__(self, content: bytes, path: str) -> None:
        self._content, self._path = content, path
        pyarrow = optional("pyarrow", "ilf-studio[cluster]", "Reading shards")
        parquet = optional("pyarrow.parquet", "ilf-studio[cluster]", "Reading shards")
        problems = pyarrow.ArrowException, OSError, KeyError, TypeError, ValueError, RecursionError
        with told_as(FormatError, f"{path} is damaged ({{error}}). {_REMEDY}", problems):
            found = parquet.read_metadata(pyarrow.BufferReader(content))
            facts = json.loads(found.metadata[b"ilf"])
            self.sha256, self.tar_sha256 = str(facts["sha256"]), str(facts["tar_sha256"])
            self.rows, self.failed = int(found.num_rows), int(facts["failed"])

    @classmethod
    def of(cls, folder: Folder, name: str) -> Self:
        """Open a table of a folder; raises as the constructor, and InputError if it cannot be read."""
        return cls(folder.read(name), f"{folder}/{name}")

    def read(self, *columns: str) -> Any:
        """Read some columns, or all, in a child, as a table of pyarrow; raises FormatError if it is damaged, or
        implausibly large."""
        with told_as(FormatError, f"{self._path} is damaged. {_REMEDY}", FormatError):
            found = run_in_child(_columns_of, self._content, columns, file=self._path, memory=TABLE_MEMORY)
        kinds = {field.name: str(field.type) for field in found.schema}
        wanted = {name: _TYPES.get(name, "string") for name in columns}
        if not (wanted.items() <= kinds.items() and {*kinds.values()} <= {"string", *_TYPES.values()}):
            raise FormatError(f"{self._path} is damaged: a column has another type. {_REMEDY}")
        return found


def _columns_of(content: bytes, columns: tuple[str, ...]) -> Any:
    import pyarrow
    from pyarrow import parquet

    return parquet.read_table(pyarrow.BufferReader(content), columns=list(columns) or None, use_threads=False)


_END = 2**16
"""Number of bytes that are read of the end of a table, which contains its facts."""


def table_ends(folder: Folder, sizes: dict[str, int]) -> Iterator[tuple[str, ShardTable | FormatError]]:
    """Yield tables of known sizes by name, without their columns, or errors of those that are damaged; raises
    InputError if one cannot be read."""
    for name, end in folder.ends(sizes, _END):
        found: ShardTable | FormatError
        try:
            found = ShardTable(end, f"{folder}/{name}")
        except FormatError:  # its facts may be longer
            try:
                found = ShardTable.of(folder, name)
            except FormatError as error:
                found = error
        yield name, found


def members_of(data: bytes, path: str) -> dict[str, bytes]:
    """Return the files of a frame in a tar, by the endings of their names; raises FormatError if they are damaged, or
    are not plain files: a sparse one of a few bytes can be a terabyte."""
    damage = told_as(FormatError, f"{path} is damaged ({{error}}). Check it by `ilf batch --verify`.", tarfile.TarError)
    with damage, tarfile.open(fileobj=io.BytesIO(data + END), mode="r:") as files:
        members = list(files)
        if wrong := [info.name for info in members if info.type != tarfile.REGTYPE or info.issparse()]:
            raise tarfile.TarError(f"{wrong[0]} is not a plain file")
        return {info.name.partition(".")[2]: files.extractfile(info).read() for info in members}  # type: ignore[union-attr]


class _Facts(msgspec.Struct):
    """What a frame's file of facts states of its completed depth."""

    size: tuple[int, int]
    K: list[float] | None = None
    pose: list[Any] | None = None
    depth_units_per_m: float | None = None


class Shards(Recording):
    """Finished shards as a recording: the completed depth, and colour from the tar or from its original file. No file
    stays open.

    Parameters
    ----------
    path : Path
    folder : Folder, optional
        The shards, if they are at the address that the path spells.

    Attributes
    ----------
    mode : str
        The mode that all frames were completed in (`Parameters.mode`); "" if it is not known.
    """

    kind = "a folder of shards"

    def __init__(self, path: Path, folder: Folder | None = None) -> None:
        super().__init__(path)
        self._folder = folder or folder_at(path)
        shards = read_shard_set(self._folder)
        pyarrow, compute = (optional(name, "shards", "Reading shards") for name in ("pyarrow", "pyarrow.compute"))
        names = [shards.name(index) for index in shards.finished(self._folder.sizes())]
        tables = []
        for name in names:
            table = ShardTable.of(self._folder, f"{name}.parquet")
            found = table.read("key", "time_s", "status", "offset", "size", "sha256", "rgb", "rgb_sha256")
            tables.append(found.filter(compute.equal(found["status"], "completed")))
            if sum(one.nbytes for one in tables) > memory_limit():
                raise FormatError(f"{path}: its tables need more memory than is allowed. Raise ILF_MEMORY (GB).")
        self._names, self._starts = names, list(np.cumsum([0, *map(len, tables)])[:-1])
        if not any(map(len, tables)):
            raise InputError(f"{path} has no completed frames yet. Run its batch first; `ilf info` lists its state.")
        self._table = pyarrow.concat_tables(tables)
        self.frames = {key: number for number, key in enumerate(self._table["key"].to_pylist())}
        parameters = shards.settings.get("parameters")
        self.mode = str(parameters.get("mode", "")) if isinstance(parameters, dict) else ""
        if left := shards.frames - sum(map(len, tables)):
            self.notes = (f"Left out, because they have failed or are not done: {left} of the batch's frames.",)
        self._last: tuple[str, dict[str, bytes]] = ("", {})
        times = self._table["time_s"].to_pylist()
        self.times = () if None in times else tuple(times)

    @classmethod
    def fits(cls, path: Path) -> bool:
        return is_shards(path)

    def frame(self, key: str) -> RecordedFrame:
        row, (name, units) = self._row(key), self.depth_file(key)
        file = self._required(key, name)
        return RecordedFrame(
            self.colour(key), read_depth_values(file), row["rgb_sha256"], file.sha256, units, time=row["time_s"]
        )

    def depth_file(self, key: str) -> tuple[str, float]:
        """The name of a frame's file of depth for `file`, and its units per metre."""
        files, units = self._files(key), self._facts(key).depth_units_per_m
        name = next((name for name in (f"{DEPTH}.png", f"{DEPTH}.npy") if name in files), f"{DEPTH}.png")
        return name, 1.0 if units is None else units

    def file(self, key: str, name: str) -> FileContent | None:
        """A file of a frame in its tar, by the ending of its name; None if it was not kept."""
        data = self._files(key).get(name)
        # the name is for messages, and for its format
        return None if data is None else part_of(f"{self.path / self._tar(key)}/{key.replace('/', '_')}.{name}", data)

    def colour(self, key: str) -> NDArray[np.uint8]:
        if (kept := self.file(key, COLOUR)) is not None:
            return read_colour(kept)
        row = self._row(key)
        remedy = "Keep colour in the shards (--keep depth,rgb) to read them without their sources."
        if row["rgb"] is None:
            raise InputError(f"{self.path} has no colour of {key}, which was not a file as it is. {remedy}")
        try:
            place = named_in(row["rgb"], str(self._folder), row["rgb_sha256"])
            file = part_of(place, RemoteFiles(place).read()) if is_address(place) else read_file(place)
        except NotAllowed:
            raise
        except InputError as error:
            raise InputError(f"{self.path} has no colour of {key}: {error} {remedy}") from error
        if file.sha256 != row["rgb_sha256"]:
            raise InputError(f"{row['rgb']}, the colour of {key}, has changed since depth was completed. {remedy}")
        return read_colour(file)

    def cameras(self, key: str) -> Cameras:
        facts = self._facts(key)
        camera = None if facts.K is None else replace(camera_from_numbers(facts.K, ""), size=facts.size)
        return Cameras.registered(camera)

    def pose(self, key: str) -> NDArray[np.float64] | None:
        pose = self._facts(key).pose
        return None if pose is None else checked_transform(pose, "pose")

    def _row(self, key: str) -> dict[str, Any]:
        row: dict[str, Any] = self._table.slice(self.at(key), 1).to_pylist()[0]
        return row

    def _tar(self, key: str) -> str:
        return f"{self._names[bisect.bisect_right(self._starts, self.frames[key]) - 1]}.tar"

    def _files(self, key: str) -> dict[str, bytes]:
        """The files of a frame, by the endings of their names; those of the last frame are kept."""
        last, files = self._last
        if last == key:
            return files
        row, path = self._row(key), f"{self._folder}/{self._tar(key)}"
        try:
            data = self._folder.read_range(self._tar(key), row["offset"], row["size"])
        except (TypeError, ValueError, OverflowError) as error:
            raise FormatError(f"{path} has no place of {key} ({cause(error):.80}). Check the folder.") from error
        if sha256_of(data) != row["sha256"]:
            raise FormatError(f"{path} is damaged in {key}. Check it by `ilf batch --shards {self.path} --verify`.")
        files = members_of(data, path)
        self._last = key, files
        return files

    def _required(self, key: str, name: str) -> FileContent:
        file = self.file(key, name)
        if file is None:
            raise FormatError(f"{self._folder}/{self._tar(key)} has no {name} of {key}.")
        return file

    def _facts(self, key: str) -> _Facts:
        file = self._required(key, FACTS)
        return converted(parse_json(file.data.tobytes(), file), _Facts, f"file {file}")
