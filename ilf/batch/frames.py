"""The frames of a batch, the names of their folders, and the list of those that shards have."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from .._runtime.files import is_address, parse_json
from .._runtime.folders import Folder, folder_at
from .._runtime.schema import Section, json_file
from ..errors import InputError, told_as
from ..sources.frame_ref import SHARDS_FILE, FrameRef, is_result
from ..sources.neighbours import around
from ..sources.shards import LIST_FILE, SCHEMA, ShardSet
from ..sources.source import Source
from .settings import sha256_of

_MAX_NAME_LENGTH = 100
"""Maximum length of a folder's name in characters; file systems allow 255 bytes."""

_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?|.*\.|\..*", re.IGNORECASE)
"""Names that some systems do not allow, or hide."""


@dataclass(frozen=True, eq=False)
class BatchFrame:
    """A frame of a batch.

    Attributes
    ----------
    key : str
        Name of the frame in the batch; depends only on its files.
    source : FrameRef
        Its files and how to read them, with absolute paths.
    time : float or None
        Timestamp [s]; None if unknown.
    folder : str
        Name of the folder of its results.
    before, after : tuple of FrameRef
        Frames before it and after it, the nearest first, as far as they are used.
    neighbour_step : int
        Every so many of them gives its depth, as for `with_neighbours`; 0 if they are those of a static camera.
    number : int
        Its place in the frozen list of a batch that writes shards.
    """

    key: str
    source: FrameRef
    time: float | None
    folder: str
    before: tuple[FrameRef, ...] = ()
    after: tuple[FrameRef, ...] = ()
    neighbour_step: int = 0
    number: int = 0

    @property
    def neighbours(self) -> tuple[FrameRef, ...]:
        """The frames before and after it, in their order."""
        return *reversed(self.before), *self.after


def frames_of_sources(
    sources: Sequence[Source],
    excluded_folder: str | os.PathLike[str] | None = None,
    *,
    reach: int = 0,
    neighbour_step: int = 0,
) -> list[BatchFrame]:
    """List all frames of sources, one source after the other.

    With several sources, keys begin with the source's name. Frames that this program has completed are left out.

    Parameters
    ----------
    sources : sequence of Source
    excluded_folder : path-like, optional
        Folder whose frames are left out, too: the batch's own copies may be among its sources.
    reach : int
        Number of frames of the same source before and after each frame that are used.
    neighbour_step : int
        As in `BatchFrame`.

    Raises
    ------
    InputError
        If two sources have the same name, or no frame is left.
    """
    names = [source.path.name for source in sources]
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        raise InputError(f"Two sources are named {twice[0]}: run them one by one, with output folders of their own.")
    found, neighbours = [], []
    for name, source in zip(names, sources, strict=True):
        times = source.timestamps or [None] * len(source)
        own = [
            (f"{name}/{key}" if len(sources) > 1 else key, source.ref(key), time)
            for key, time in zip(source.keys, times, strict=True)
        ]
        if excluded_folder is not None:
            own = [one for one in own if not _is_in(one[1], os.fspath(excluded_folder))]
        own = [one for one in own if not is_result(one[1])]
        files = [file.absolute() for _, file, _ in own]
        found += own
        neighbours += [around(files, place, reach) for place in range(len(own))]
    if not found:
        raise InputError(
            f"{', '.join(names)}: all frames are results of ILF Studio, or in the output folder. Give measured frames, "
            "or another output folder."
        )
    return [
        replace(frame, before=before, after=after, neighbour_step=neighbour_step)
        for frame, (before, after) in zip(named_frames(found), neighbours, strict=True)
    ]


def frames_of_files(sources: Sequence[FrameRef]) -> list[BatchFrame]:
    """List frames of arbitrary files; their keys are the paths of the colour files below the common folder."""
    found = [source.absolute() for source in sources]
    files = [path for source in found for path in (source.rgb, source.depth) if path is not None]
    root = os.path.commonpath([os.path.dirname(path) for path in files]) if files else ""
    keys = [_key_below(root, source, source.rgb) for source in found]
    counts = Counter(keys)
    return named_frames(
        (key if counts[key] == 1 else _key_below(root, source, source.depth or source.rgb, whole=True), source, None)
        for key, source in zip(keys, found, strict=True)
    )


def named_frames(found: Iterable[tuple[str, FrameRef, float | None]]) -> list[BatchFrame]:
    """Build frames from keys, sources and times, each with a unique folder name."""
    frames = [BatchFrame(key, source.absolute(), time, folder_name(key)) for key, source, time in found]
    counts = Counter(frame.folder.casefold() for frame in frames)
    return [
        replace(frame, folder=with_hash(frame.folder, frame.key))
        if counts[frame.folder.casefold()] > 1  # some file systems ignore case
        else frame
        for frame in frames
    ]


def folder_name(key: str) -> str:
    """Return the name of a frame's folder, derived from its key; equal keys give equal names.

    A hash is appended to a name that does not represent the key exactly.

    Examples
    --------
    >>> folder_name("rgb/0001"), folder_name("rgb: 1")
    ('rgb__0001', 'rgb_1-a5448928')
    """
    name = key.replace("/", "__")
    plain = re.sub(r"[^\w.-]+", "_", name)
    is_exact = plain == name and re.search("__|_/|/_", key) is None
    if is_exact and len(plain) <= _MAX_NAME_LENGTH and _RESERVED.fullmatch(plain) is None:
        return plain
    return with_hash(plain.strip(".") or "frame", key)


def with_hash(name: str, key: str) -> str:
    """Return a name, shortened if it is long, with digits of the hash of the key that it stands for."""
    digest = hashlib.sha256(key.encode(errors="backslashreplace")).hexdigest()[:8]
    return f"{name[:_MAX_NAME_LENGTH]}-{digest}"


def with_companion_files(frames: Sequence[BatchFrame], kind: str, folder: str | os.PathLike[str]) -> list[BatchFrame]:
    """Return the frames with one more file each from a folder, found by the frame's name or key.

    Parameters
    ----------
    frames : sequence of BatchFrame
    kind : str
        Kind of the files: "guide" or "ground_truth".
    folder : path-like
        Its files are named as the frames or as their folders: 0001.png or rgb__0001.png for rgb/0001.

    Raises
    ------
    InputError
        If the folder cannot be read, or has no file for a frame.
    """
    with told_as(InputError, f"{folder}: cannot be read ({{error}}). Give a folder with one file per frame.", OSError):
        files = {path.stem: str(path.absolute()) for path in sorted(Path(folder).iterdir()) if path.is_file()}
    found = []
    for frame in frames:
        names = frame.folder, frame.source.name, frame.key.rpartition("/")[2]
        path = next((files[name] for name in names if name in files), None)
        if path is None:
            raise InputError(f"{folder} has no file for {frame.key}. Add {names[0]} or {names[-1]}, with any suffix.")
        found.append(replace(frame, source=frame.source.with_options(**{kind: path})))
    return found


def slice_frames(
    frames: Sequence[BatchFrame], *, first: int | None = None, end: int | None = None, every: int = 1
) -> list[BatchFrame]:
    """Return every `every`-th frame from `first` to before `end`, counted from 0; negative numbers from the end.

    Raises
    ------
    InputError
        If the selection is empty.
    """
    chosen = list(frames[first:end:every])
    if not chosen:
        raise InputError(f"No frames are left of those numbered from 0 to {len(frames) - 1}: change the selection.")
    return chosen


def shard_of(frames: Sequence[BatchFrame], number: int, count: int) -> list[BatchFrame]:
    """Return shard `number` of `count`, counted from 1: every frame is in exactly one, neighbours in different ones."""
    return list(frames[number - 1 :: count])


def _key_below(root: str, source: FrameRef, path: str, whole: bool = False) -> str:
    below = Path(os.path.relpath(path, root))
    key = (below if whole or source.depth is None else below.with_suffix("")).as_posix()
    return key if source.frame is None else f"{key}/{source.frame}"


def _is_in(source: FrameRef, folder: str) -> bool:
    if is_address(source.rgb) or is_address(folder):
        return source.rgb.startswith(f"{folder.rstrip('/')}/")
    return Path(os.path.abspath(source.rgb)).is_relative_to(os.path.abspath(folder))


# The frozen list of a batch that writes shards: a line of JSON for each frame, written once before the first.

ListFrames = Callable[[], Sequence[BatchFrame]]
"""A function at the top level of a module that lists all frames of a batch."""


def sample_name(key: str) -> str:
    """Return the name of a frame's files in a tar, derived from its key. It has no dots: WebDataset ends it there.

    Examples
    --------
    >>> sample_name("rgb/0001"), sample_name("1305031102.175")
    ('rgb__0001', '1305031102_175-181dca9b')
    """
    name = folder_name(key)
    return name if "." not in name else with_hash(name.replace(".", "_"), key)


def freeze(target: str, facts: dict[str, Any], request: dict[str, Any], list_frames: ListFrames) -> None:
    """Write the frozen list, and shards.json last.

    Parameters
    ----------
    target : str
        Folder or address.
    facts : dict
        What determines the results, as JSON values.
    request : dict
        What determines the frames.
    list_frames : callable
    """
    frames, folder = list_frames(), folder_at(target)
    keys, whole, size = hashlib.sha256(), hashlib.sha256(), 0
    per_shard, keep = facts["shards"]["per_shard"], tuple(facts["shards"]["keep"])
    offsets: list[int] = []

    def lines() -> Iterator[bytes]:
        nonlocal size
        for number, frame in enumerate(frames):
            if number % per_shard == 0:
                offsets.append(size)
            line = f"{json.dumps({'key': frame.key, 'time': frame.time, **frame.source.to_json()})}\n".encode()
            keys.update(f"{json.dumps(frame.key)}\n".encode())
            whole.update(line)
            size += len(line)
            yield line

    folder.put(LIST_FILE, lines())
    sha256 = sha256_of(facts | {"keys": keys.hexdigest()})
    shards = ShardSet(facts, request, sha256, len(frames), per_shard, keep, size, whole.hexdigest(), tuple(offsets))
    folder.put(SHARDS_FILE, [json_file(SCHEMA, dataclasses.asdict(shards))])


def listed_frames(folder: Folder, shards: ShardSet, index: int) -> dict[int, BatchFrame]:
    """Read the frames of a shard, by their places in the frozen list.

    Raises
    ------
    NotAllowed
        If the list names files that the user has not named, and they are not allowed.
    FormatError
        If the list is damaged.
    """
    lines = zip(shards.numbers(index), shards.lines(folder, index), strict=True)
    return {number: frame_of_line(line, number, shards.request) for number, line in lines}


def frame_of_line(line: bytes, number: int, request: Mapping[str, Any]) -> BatchFrame:
    """Return the frame in a line of the frozen list; `request` is that of the user, whose sources and other files the
    frame may use. Raises as `listed_frames`."""
    data = parse_json(line, LIST_FILE)
    stated = Section(LIST_FILE, data if isinstance(data, dict) else {})
    key, source = stated.get("key", str), FrameRef.from_json(stated, "")
    given = tuple(map(_as_folder, (*request.get("sources", ()), *map(str, request.get("reading", {}).values()))))
    paths = *source.paths, *source.options.camera_paths.values()
    if any("/../" in path or not _as_folder(path).startswith(given) for path in paths):
        source = source.allowed()
    time = stated.get("time", float, None)
    return BatchFrame(key, replace(source, stated_in=None), time, sample_name(key), number=number)


def _as_folder(path: str) -> str:
    return path.rstrip("/") + "/" if is_address(path) else os.path.join(os.path.normpath(path), "")
