"""Frames of data sets whose files state how each is read: SUN RGB-D, and lists by time as of the TUM benchmark."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Collection, Iterable
from pathlib import Path

import numpy as np

from .._runtime.files import read_file
from ..data.camera import camera_from_numbers
from ..errors import FormatError, InputError, told_as
from ..io.encodings import TUM_UNITS
from .file_patterns import Folders
from .frame_ref import FrameRef, ReadingOptions
from .naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES
from .pairing import TimedPairs

_SUN_CAMERA_FILE = "intrinsics.txt"
_SUN_FOLDERS = "image", "depth"


def is_sun(files: Collection[str], folders: Collection[str]) -> bool:
    """Whether a folder with these files and folders is a frame of SUN RGB-D."""
    return _SUN_CAMERA_FILE in files and set(_SUN_FOLDERS) <= set(folders)


def sun_frame(root: str | Path, given: ReadingOptions) -> FrameRef:
    """The frame of a SUN RGB-D folder; raises InputError unless it has exactly one colour and one depth file."""
    colours, depths = (
        _files(Path(root) / folder, suffixes)
        for folder, suffixes in zip(_SUN_FOLDERS, (COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES), strict=True)
    )
    if len(colours) != 1 or len(depths) != 1:
        found = f"{len(colours)} colour and {len(depths)} depth files"
        raise InputError(f"{root} looks like a frame of SUN RGB-D, but has {found} instead of one each.")
    path = Path(root) / _SUN_CAMERA_FILE
    told = f"{path} must contain the nine numbers of a camera matrix ({{error}}). Correct it."
    with told_as(FormatError, told, (ValueError, InputError)):
        numbers = np.array(read_file(path).data.tobytes().decode().split(), float)
        camera = camera_from_numbers(numbers, "")
    options = given.or_else(ReadingOptions(encoding="sun", intrinsics=camera))
    return FrameRef(str(colours[0]), str(depths[0]), options=options)


def _files(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    """Files with one of these extensions, by name; none if there is no such folder."""
    files, _ = Folders(str(folder)).content("")
    return [folder / name for name in files if Path(name).suffix.lower() in suffixes]


# Lists of images by time, as in the TUM RGB-D benchmark.

_TIME_LISTS = {("rgb.txt", "depth.txt"): TUM_UNITS, ("color.txt", "aligned_depth.txt"): 1000.0}
"""Lists of colour and of depth files with their times, of the TUM benchmark and OpenLORIS -> units per metre."""

ASSOCIATION_FILES = "associations.txt", "associated.txt", "association.txt"
"""Names of lists with colour and depth in one line, as written by ICL-NUIM and many tools."""


def has_time_lists(files: Collection[str]) -> bool:
    """Whether a folder with these files lists its frames by time."""
    return _time_lists(files) is not None or any(name in files for name in ASSOCIATION_FILES)


def _time_lists(files: Collection[str]) -> tuple[str, str] | None:
    return next((lists for lists in _TIME_LISTS if set(lists) <= set(files)), None)


def timed_frames(
    root: Path, files: Collection[str], given: ReadingOptions, max_gap: float
) -> tuple[list[FrameRef], tuple[float, ...], tuple[str, ...]]:
    """The frames of a folder that lists them by time, their times [s], and notes; raises InputError if colour and
    depth do not match within `max_gap` [s], FormatError if a list is damaged."""
    notes: tuple[str, ...] = ()
    if lists := _time_lists(files):
        pairs = TimedPairs(*(read_time_list(root / name) for name in lists))
        _, times, notes = pairs.index(max_gap, f"{root}, {' and '.join(lists)}")
        rows = [(time, *pair) for time, pair in zip(times, pairs.paired(max_gap).values(), strict=True)]
    else:
        rows = read_associations(root / next(name for name in ASSOCIATION_FILES if name in files))
    usual = _TIME_LISTS[lists] if lists else TUM_UNITS
    options = given.or_else(ReadingOptions(depth_units=usual, intrinsics=_camera_by_name(root.name.lower())))
    units = options.depth_units
    told = f"the encoding {options.encoding}" if units is None else f"{units:g} units per metre"
    is_assumed = given.encoding is None and given.depth_units is None and usual == TUM_UNITS
    if is_assumed and options.intrinsics is given.intrinsics:
        told += ", as in the TUM benchmark: give --depth-encoding mm if it is in millimetres, as of many recorders"
    found = [
        FrameRef(os.path.join(root, rgb), os.path.join(root, depth), options=options, stated_in=str(root))
        for _, rgb, depth in rows
    ]
    return found, tuple(time for time, _, _ in rows), (f"Depth is read with {told}.", *notes)


def _camera_by_name(name: str) -> str | None:
    """The preset of the camera of a sequence of TUM or Bonn, by its folder's name; None for others."""
    if number := re.search(r"freiburg([123])", name):
        return f"tum-fr{number[1]}"
    return "bonn" if name.startswith("rgbd_bonn") else None


def read_time_list(path: Path) -> dict[str, tuple[float, str]]:
    """File names of a list, each with its time [s] and itself: a time and a name per line, also as Windows writes it; #
    marks comments.

    Raises
    ------
    InputError
        If it cannot be read.
    FormatError
        If a line has other content, or a file is listed twice.
    """
    return {name: (time, name) for ((time, name),) in _timed_files(path, 1)}


def read_associations(path: Path) -> list[tuple[float, str, str]]:
    """Time of colour [s], colour and depth file of each line of a list of pairs, in either order.

    Raises
    ------
    InputError, FormatError
        As `read_time_list`.
    """
    found = []
    for (time, first), (other, second) in _timed_files(path, 2):
        is_depth_first = "depth" in first.lower() and "depth" not in second.lower()
        found.append((other, second, first) if is_depth_first else (time, first, second))
    if not found:
        raise FormatError(f"{path} lists no files. Export the list again.")
    return found


def _timed_files(path: Path, count: int) -> list[list[tuple[float, str]]]:
    """The times [s] and files of each line of a list, so many in a line."""
    with told_as(FormatError, f"{path} is not a text file ({{error}}). Export the list again.", UnicodeDecodeError):
        lines = read_file(path).data.tobytes().decode("utf-8").splitlines()
    found = []
    for number, line in enumerate(lines, 1):
        text = line.strip("\ufeff \t").replace("\\", "/")
        if not text or text.startswith("#"):
            continue
        words = text.split(maxsplit=1) if count == 1 else text.split()  # the last name may have blanks
        wanted = "a time and a file" if count == 1 else "a time and a file for colour and for depth"
        told = f"{path}, line {number} must be {wanted}, not {line!r:.80}."
        with told_as(FormatError, told, (ValueError, IndexError)):
            files = [(float(words[2 * at]), words[2 * at + 1].strip()) for at in range(count)]
            if not all(math.isfinite(time) and _is_file_name(name) for time, name in files):
                raise ValueError
        found.append(files)
    _check_unique(path, (name for files in found for _, name in files))
    return found


def _is_file_name(name: str) -> bool:
    return Path(name).name not in {"", ".."}


def _check_unique(path: Path, names: Iterable[str]) -> None:
    """Raise FormatError if a list contains a file twice, under any spelling of its path."""
    seen: set[str] = set()
    for name in map(os.path.normpath, names):
        if name in seen:
            raise FormatError(f"{path} lists {name!r:.80} twice. Export the list again.")
        seen.add(name)
