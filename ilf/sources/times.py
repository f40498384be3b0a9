"""Lists of images by time, as in the TUM RGB-D benchmark, and matching colour with depth by time."""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import read_file
from ..errors import FormatError, told_as

MAX_TIME_GAP_S = 0.02
ASSOCIATION_FILES = "associations.txt", "associated.txt", "association.txt"
"""Names of lists with colour and depth in one line, as written by ICL-NUIM and many tools."""

TUM_UNITS = 5000.0
"""File units per metre of the depth in such lists."""


_Times = NDArray[np.float64]


def read_time_list(path: Path) -> list[tuple[float, str]]:
    """Times [s] and file names of a list: a time and a name per line, also as Windows writes it; # marks comments.

    Raises
    ------
    InputError
        If it cannot be read.
    FormatError
        If a line has other content, or a file is listed twice.
    """
    with told_as(FormatError, f"{path} is not a text file ({{error}}). Export the list again.", UnicodeDecodeError):
        lines = read_file(path).data.tobytes().decode("utf-8").splitlines()
    found = []
    for number, line in enumerate(lines, 1):
        words = line.strip("\ufeff \t").split(maxsplit=1)
        if not words or words[0].startswith("#"):
            continue
        told = f"{path}, line {number} must be a time and a file, not {line!r:.80}."
        with told_as(FormatError, told, (ValueError, IndexError)):
            time, name = float(words[0]), words[1].strip().replace("\\", "/")
            if not (math.isfinite(time) and _is_file_name(name)):
                raise ValueError
        found.append((time, name))
    _check_unique(path, (name for _, name in found))
    return found


def read_associations(path: Path) -> list[tuple[float, str, str]]:
    """Time of colour [s], colour and depth file of each line of a list of pairs, in either order.

    Raises
    ------
    InputError, FormatError
        As `read_time_list`.
    """
    found = []
    for time, rest in read_time_list(path):
        words = rest.split()
        told = f"a line must be a time and a file for colour and for depth, not {time:g} {rest!r:.80}"
        with told_as(FormatError, f"{path}: {told}.", (ValueError, IndexError)):
            first, (other, second) = words[0], (float(words[1]), words[2])
            if not (math.isfinite(other) and _is_file_name(first) and _is_file_name(second)):
                raise ValueError
        is_depth_first = "depth" in first.lower() and "depth" not in second.lower()
        found.append((other, second, first) if is_depth_first else (time, first, second))
    if not found:
        raise FormatError(f"{path} lists no files. Export the list again.")
    _check_unique(path, (name for _, rgb, depth in found for name in (rgb, depth)))
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


def associated(
    colours: list[tuple[float, str]], depths: list[tuple[float, str]], max_gap: float = MAX_TIME_GAP_S
) -> list[tuple[str, str]]:
    """Match colour and depth files nearest in time, each used once, in the order of time.

    Parameters
    ----------
    colours, depths : list of (float, str)
        Times [s] and names.
    max_gap : float
        Maximum time difference of a pair [s].

    Examples
    --------
    >>> associated([(0.00, "a.png"), (0.03, "b.png")], [(0.01, "a-d.png"), (0.06, "c-d.png")])
    [('a.png', 'a-d.png')]
    """
    colours, depths = sorted(colours), sorted(depths)
    rows, columns = (np.array([time for time, _ in images]) for images in (colours, depths))
    pairs = _nearest(rows, columns, max_gap)
    return [(colours[row][1], depths[column][1]) for row, column in sorted(pairs)]


def gap_text(colours: Sequence[tuple[float, str]], depths: Sequence[tuple[float, str]], max_gap: float) -> str:
    """Why colour and depth do not match by time, as the rest of a sentence and what to do.

    Parameters
    ----------
    colours, depths : sequence of (float, str)
        Times [s] and names, as for `associated`.
    max_gap : float
        Maximum time difference of a pair [s].

    Examples
    --------
    >>> gap_text([(0.0, "a.png"), (0.1, "b.png")], [(0.03, "a-d.png")], 0.02)
    'no colour lies within 0.02 s of depth: the smallest difference is 0.03 s. Allow more (--max-gap) if they fit.'
    """
    if not (colours and depths):
        return f"there are {len(colours)} colour images and {len(depths)} depth images."
    one, other = (np.unique([time for time, _ in images]) for images in (colours, depths))
    smallest = float(np.abs(other[_closest(one, other)] - one).min())
    told = f"no colour lies within {max_gap:g} s of depth: the smallest difference is {smallest:.4g} s."
    step = float(np.median(np.diff(one))) if len(one) > 1 else math.inf
    if smallest <= step:
        return f"{told} Allow more (--max-gap) if they fit."
    return (
        f"{told} As colour is taken every {step:.4g} s, the two clocks seem to differ: correct the times. More allowed "
        "(--max-gap) would join images of different moments."
    )


def _nearest(rows: _Times, columns: _Times, max_gap: float) -> list[tuple[int, int]]:
    """Greedily pair the nearest times of two sorted arrays, then the nearest of the rest, and so on. What is nearest to
    each other is a pair, whatever comes before it."""
    found: list[tuple[int, int]] = []
    row_at, column_at = np.arange(len(rows)), np.arange(len(columns))
    while len(row_at) and len(column_at):
        left, right = rows[row_at], columns[column_at]
        there = _closest(left, right)
        is_pair = (_closest(right, left)[there] == np.arange(len(left))) & (np.abs(left - right[there]) <= max_gap)
        if not is_pair.any():
            break
        found += zip(row_at[is_pair].tolist(), column_at[there[is_pair]].tolist(), strict=True)
        row_at, column_at = row_at[~is_pair], np.delete(column_at, there[is_pair])
    return found


def _closest(times: _Times, others: _Times) -> NDArray[np.intp]:
    """The place of the nearest other time, all of them sorted; of several, the first."""
    after = np.searchsorted(others, times)
    before = np.searchsorted(others, others[np.maximum(after - 1, 0)])
    after = np.minimum(after, len(others) - 1)
    return np.where(np.abs(others[before] - times) <= np.abs(others[after] - times), before, after)
