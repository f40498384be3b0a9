"""Lists of images by time, as in the TUM RGB-D benchmark, and matching colour with depth by time."""

from __future__ import annotations

import heapq
import math
import os
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from .._runtime.files import read_file
from ..errors import FormatError, told_as

MAX_TIME_GAP_S = 0.02
ASSOCIATION_FILES = "associations.txt", "associated.txt", "association.txt"
"""Names of lists with colour and depth in one line, as written by ICL-NUIM and many tools."""

TUM_UNITS = 5000.0
"""File units per metre of the depth in such lists."""


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
    pairs = _nearest([time for time, _ in colours], [time for time, _ in depths], max_gap)
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
    place = np.searchsorted(other, one)
    gaps = [np.abs(other[np.clip(place + step, 0, len(other) - 1)] - one) for step in (-1, 0)]
    smallest = float(np.min(gaps))
    told = f"no colour lies within {max_gap:g} s of depth: the smallest difference is {smallest:.4g} s."
    step = float(np.median(np.diff(one))) if len(one) > 1 else math.inf
    if smallest <= step:
        return f"{told} Allow more (--max-gap) if they fit."
    return (
        f"{told} As colour is taken every {step:.4g} s, the two clocks seem to differ: correct the times. More allowed "
        "(--max-gap) would join images of different moments."
    )


def _nearest(rows: list[float], columns: list[float], max_gap: float) -> list[tuple[int, int]]:
    """Greedily pair the nearest times of two sorted lists, then the nearest of the rest, and so on.

    The nearest pair are neighbours among all times that are left, so only neighbours are compared.
    """
    order = sorted([(time, 0, row) for row, time in enumerate(rows)] + [(time, 1, i) for i, time in enumerate(columns)])
    before, after = list(range(-1, len(order) - 1)), [*range(1, len(order)), -1]
    waiting: list[tuple[float, int, int, int, int]] = []

    def queue_pair(left: int, right: int) -> None:
        """Queue two neighbours as a pair if they are of different lists and near enough."""
        if left < 0 or right < 0:
            return
        (time, kind, one), (later, other_kind, other) = order[left], order[right]
        if kind != other_kind and later - time <= max_gap:
            row, column = (one, other) if kind == 0 else (other, one)
            heapq.heappush(waiting, (later - time, row, column, left, right))

    def first_equal(place: int) -> int:
        """The first remaining entry with the same time in the same list."""
        while before[place] >= 0 and order[before[place]][:2] == order[place][:2]:
            place = before[place]
        return place

    def remove(place: int) -> None:
        left, right = before[place], after[place]
        if left >= 0:
            after[left] = right
        if right >= 0:
            before[right] = left
        removed.add(place)
        queue_pair(left, right)

    removed: set[int] = set()
    found = []
    for place in range(len(order) - 1):
        queue_pair(place, place + 1)
    while waiting:
        *_, left, right = heapq.heappop(waiting)
        if left in removed or right in removed:
            continue
        pair = sorted((first_equal(left), first_equal(right)), key=lambda place: order[place][1])
        found.append((order[pair[0]][2], order[pair[1]][2]))
        for place in pair:
            remove(place)
    return found
