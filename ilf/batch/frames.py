"""Which frames a batch has, and what the folder of each is called."""

from __future__ import annotations

import hashlib
import os
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..errors import InputError, cause
from ..sources.frame_source import FrameSource
from ..sources.source import Source

_LONGEST_NAME = 100
"""Letters of a folder's name; file systems take 255 bytes."""

_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?|.*\.|\..*", re.IGNORECASE)
"""Names that some systems do not take, or hide."""


@dataclass(frozen=True, eq=False)
class BatchFrame:
    """A frame of a batch.

    Attributes
    ----------
    key : str
        Its name in the batch: the same as long as its files are.
    source : FrameSource
        Where it is and how it is read, with absolute paths.
    time : float or None
        [s]; None where it is not known.
    folder : str
        Name of the folder that its results go into.
    neighbours : tuple of FrameSource
        The frames before and after it, where they help it to be steady.
    """

    key: str
    source: FrameSource
    time: float | None
    folder: str
    neighbours: tuple[FrameSource, ...] = ()


def frames_of_sources(
    sources: Sequence[Source], apart_from: str | os.PathLike[str] | None = None, *, reach: int = 0
) -> list[BatchFrame]:
    """All frames of some sources, one after the other.

    Of several sources, keys begin with the source's name.

    Parameters
    ----------
    sources : sequence of Source
    apart_from : path-like, optional
        A folder whose frames are left out: the batch's own results may lie among its sources.
    reach : int
        So many frames of its source before and after each are its neighbours.

    Raises
    ------
    InputError
        If two sources have the same name, or nothing is left.
    """
    names = [source.path.name for source in sources]
    if twice := [name for name, count in Counter(names).items() if count > 1]:
        raise InputError(f"Two sources are called {twice[0]}: run them one after the other, each into its own folder.")
    found, neighbours = [], []
    for name, source in zip(names, sources, strict=True):
        times = source.timestamps or [None] * len(source)
        own = [
            (f"{name}/{key}" if len(sources) > 1 else key, source.frame_source(key), time)
            for key, time in zip(source.keys, times, strict=True)
        ]
        if apart_from is not None:
            own = [one for one in own if not _is_in(one[1], Path(apart_from).absolute())]
        files = [file.absolute() for _, file, _ in own]
        found += own
        neighbours += [(*files[max(i - reach, 0) : i], *files[i + 1 : i + 1 + reach]) for i in range(len(own))]
    if not found:
        raise InputError(
            f"There are no frames but those in {apart_from}, the folder for the results. Choose another folder "
            "for these, or name another source."
        )
    return [replace(frame, neighbours=near) for frame, near in zip(named_frames(found), neighbours, strict=True)]


def frames_of_files(sources: Sequence[FrameSource]) -> list[BatchFrame]:
    """Frames from anywhere; their keys are the paths of their colour files below the folder that all files share."""
    found = [source.absolute() for source in sources]
    files = [path for source in found for path in (source.rgb, source.depth) if path is not None]
    root = os.path.commonpath([os.path.dirname(path) for path in files]) if files else ""
    keys = [_key_below(root, source, source.rgb) for source in found]
    counts = Counter(keys)
    return named_frames(
        (key if counts[key] == 1 else _key_below(root, source, source.depth or source.rgb, whole=True), source, None)
        for key, source in zip(keys, found, strict=True)
    )


def named_frames(found: Iterable[tuple[str, FrameSource, float | None]]) -> list[BatchFrame]:
    """Frames with their keys, sources and times, each with a folder of its own."""
    frames = [BatchFrame(key, source.absolute(), time, folder_name(key)) for key, source, time in found]
    counts = Counter(frame.folder.casefold() for frame in frames)
    return [
        replace(frame, folder=_told_apart(frame.folder, frame.key))
        if counts[frame.folder.casefold()] > 1  # some systems do not tell A from a
        else frame
        for frame in frames
    ]


def folder_name(key: str) -> str:
    """Name of a frame's folder: its key, as far as names of files can say it; the same key gives the same name.

    Keys that would give the same name as others have a few digits of their hash behind it.

    Examples
    --------
    >>> folder_name("rgb/0001"), folder_name("rgb: 1")
    ('rgb__0001', 'rgb_1-a5448928')
    """
    name = key.replace("/", "__")
    plain = re.sub(r"[^\w.-]+", "_", name)
    says_it = plain == name and re.search("__|_/|/_", key) is None
    if says_it and len(plain) <= _LONGEST_NAME and _RESERVED.fullmatch(plain) is None:
        return plain
    return _told_apart(plain.strip(".") or "frame", key)


def _told_apart(name: str, key: str) -> str:
    told_apart = hashlib.sha256(key.encode(errors="backslashreplace")).hexdigest()[:8]
    return f"{name[:_LONGEST_NAME]}-{told_apart}"


def with_files(frames: Sequence[BatchFrame], kind: str, folder: str | os.PathLike[str]) -> list[BatchFrame]:
    """The same frames with a file each from a folder, found by the frame's name or key.

    Parameters
    ----------
    frames : sequence of BatchFrame
    kind : str
        What the files are: "guide" or "truth".
    folder : path-like
        Its files are called as the frames are, or as their folders: 0001.png or rgb__0001.png for rgb/0001.

    Raises
    ------
    InputError
        If there is no such folder, or a frame has no file in it.
    """
    try:
        files = {path.stem: str(path.absolute()) for path in sorted(Path(folder).iterdir()) if path.is_file()}
    except OSError as error:
        raise InputError(
            f"{folder}: cannot be read ({cause(error)}). Name a folder with a file for each frame."
        ) from error
    found = []
    for frame in frames:
        names = frame.folder, frame.source.name, frame.key.rpartition("/")[2]
        path = next((files[name] for name in names if name in files), None)
        if path is None:
            raise InputError(f"{folder} has no file for {frame.key}: it would be called {names[0]} or {names[-1]}.")
        beside: dict[str, Any] = {kind: path}
        found.append(replace(frame, source=replace(frame.source, **beside)))
    return found


def selected(
    frames: Sequence[BatchFrame], *, first: int | None = None, end: int | None = None, every: int = 1
) -> list[BatchFrame]:
    """Some of the frames: every so-manyth from number `first` to before `end`, counted from 0; negative from the end.

    Raises
    ------
    InputError
        If these are none.
    """
    chosen = list(frames[first:end:every])
    if not chosen:
        raise InputError(f"There are no such frames: they are numbered from 0 to {len(frames) - 1}.")
    return chosen


def shard_of(frames: Sequence[BatchFrame], number: int, count: int) -> list[BatchFrame]:
    """One of `count` parts, counted from 1: every frame is in exactly one, and neighbours are in different ones."""
    return list(frames[number - 1 :: count])


def _key_below(root: str, source: FrameSource, path: str, whole: bool = False) -> str:
    below = Path(os.path.relpath(path, root))
    key = (below if whole or source.depth is None else below.with_suffix("")).as_posix()
    return key if source.frame is None else f"{key}/{source.frame}"


def _is_in(source: FrameSource, folder: Path) -> bool:
    return Path(os.path.abspath(source.rgb)).is_relative_to(folder)
