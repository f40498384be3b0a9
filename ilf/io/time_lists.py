"""Lists of images by time, as in the TUM RGB-D benchmark: which colour belongs to which depth."""

from __future__ import annotations

import bisect
import math
from pathlib import Path

from ..errors import FormatError
from .files import read_file

MOST_APART_S = 0.02
ASSOCIATION_FILES = "associations.txt", "associated.txt", "association.txt"
"""Names of lists that have colour and depth side by side, as ICL-NUIM and many tools write them."""

UNITS = 5000.0
"""File units per metre of the depth that such lists name."""


def read_time_list(path: Path) -> list[tuple[float, str]]:
    """Times [s] and file names of a list: a time and a name per line, # before what is no entry.

    Raises
    ------
    InputError
        If it cannot be read.
    FormatError
        If a line is something else.
    """
    try:
        lines = read_file(path).data.tobytes().decode("utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise FormatError(f"{path} is not a text file ({error}). Export the list again.") from error
    found = []
    for number, line in enumerate(lines, 1):
        words = line.strip("\ufeff \t").split(maxsplit=1)
        if not words or words[0].startswith("#"):
            continue
        try:
            time, name = float(words[0]), words[1].strip()
            if not math.isfinite(time):
                raise ValueError
        except (ValueError, IndexError):
            raise FormatError(
                f"{path}, line {number}: a line must be a time in seconds and a file name, not {line!r:.80}."
            ) from None
        found.append((time, name))
    return found


def read_associations(path: Path) -> list[tuple[float, str, str]]:
    """Time of colour [s], colour and depth file of each line of a list of pairs, whichever of both comes first.

    Raises
    ------
    InputError, FormatError
        As `read_time_list`.
    """
    found = []
    for time, rest in read_time_list(path):
        words = rest.split()
        try:
            first, (other, second) = words[0], (float(words[1]), words[2])
        except (ValueError, IndexError):
            raise FormatError(
                f"{path}: a line must be a time and a file of colour and of depth, not {time:g} {rest!r:.80}."
            ) from None
        is_depth_first = "depth" in first.lower() and "depth" not in second.lower()
        found.append((other, second, first) if is_depth_first else (time, first, second))
    files = [name for _, rgb, depth in found for name in (rgb, depth)]
    if not files or len(set(files)) < len(files):
        raise FormatError(f"{path} names no files, or one of them twice. Export the list again.")
    return found


def associated(
    colours: list[tuple[float, str]], depths: list[tuple[float, str]], most_apart: float = MOST_APART_S
) -> list[tuple[str, str]]:
    """Colour and depth files that are nearest in time, each used once, in the order of time.

    Parameters
    ----------
    colours, depths : list of (float, str)
        Times [s] and names.
    most_apart : float
        Pairs lie at most this many seconds apart.

    Examples
    --------
    >>> associated([(0.00, "a.png"), (0.03, "b.png")], [(0.01, "a-d.png"), (0.06, "c-d.png")])
    [('a.png', 'a-d.png')]
    """
    colours, depths = sorted(colours), sorted(depths)
    times = [time for time, _ in depths]
    near = []
    for row, (time, _) in enumerate(colours):
        first, last = bisect.bisect_left(times, time - most_apart), bisect.bisect_right(times, time + most_apart)
        near += [(abs(times[column] - time), row, column) for column in range(first, last)]
    taken: dict[int, int] = {}
    used: set[int] = set()
    for _, row, column in sorted(near):
        if row not in taken and column not in used:
            taken[row] = column
            used.add(column)
    return [(colours[row][1], depths[column][1]) for row, column in sorted(taken.items())]
