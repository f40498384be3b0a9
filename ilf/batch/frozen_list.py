"""The frozen list of a batch that writes shards: a line of JSON for each frame, written once before the first."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from .._runtime.files import is_address, parse_json
from .._runtime.folders import Folder, folder_at
from .._runtime.schema import Section, json_file
from ..sources.frame_ref import FrameRef
from ..sources.own_results import SHARDS_FILE
from ..sources.shards import LIST_FILE, SCHEMA, ShardSet
from .frames import BatchFrame, folder_name, with_hash
from .settings import sha256_of

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
