"""Matching colour with depth: by time, and files by their names alone."""

from __future__ import annotations

import heapq
import math
import os
import re
from bisect import bisect_left
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping
from functools import cached_property
from typing import Generic, NamedTuple, TypeVar

from .._runtime.formatting import counted, natural
from ..errors import InputError
from .naming import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES, USUAL_DEPTH_SUFFIXES

T = TypeVar("T")

MAX_TIME_GAP_S = 0.02


def left_out(colours: int, depths: int, condition: str) -> list[str]:
    """Notes on numbers of images in no pair: they lack one of the other kind of that name, or within a time."""
    counts = (("colour", "depth", colours), ("depth", "colour", depths))
    return [
        f"{counted(count, f'{what} image')} left out: there is no {other} image {condition}."
        for what, other, count in counts
        if count
    ]


def _nearest(rows: list[float], columns: list[float]) -> list[tuple[int, int]]:
    """Greedily pair the nearest times of two sorted lists, then the nearest of the rest, and so on.

    Every row waits with its nearest free column; one whose column was taken meanwhile waits again.
    """
    free = [(time, column) for column, time in enumerate(columns)]
    waiting: list[tuple[float, int, int]] = []
    found: dict[int, int] = {}

    def wait(row: int) -> None:
        time = rows[row]
        after = bisect_left(free, (time,))
        before = bisect_left(free, free[after - 1][:1]) if after else after  # the first of equal times
        near = [
            (abs(there - time), row, column) for there, column in (*free[before : before + 1], *free[after : after + 1])
        ]
        if near:
            heapq.heappush(waiting, min(near))

    for row in range(len(rows)):
        wait(row)
    while waiting:
        _, row, column = heapq.heappop(waiting)
        if column in found:
            wait(row)
        else:
            found[column] = row
            del free[bisect_left(free, (columns[column], column))]
    return [(row, column) for column, row in found.items()]


# Pairing the images of two streams by their time stamps.

_LARGEST_GAP_S = 10.0
"""Maximum time difference [s] of a frame that is asked for by its key."""


class TimedPairs(Generic[T]):
    """Pairs of colour and the depth nearest in time, each used once.

    Parameters
    ----------
    colours, depths : mapping
        Name -> time [s] and what it stands for. The name of a colour is the key of its frame.

    Examples
    --------
    >>> TimedPairs(stamped([0, 33], 1000), stamped([4, 41], 1000)).paired(0.02)
    {'0.000': (0, 4), '0.033': (33, 41)}
    """

    def __init__(self, colours: Mapping[str, tuple[float, T]], depths: Mapping[str, tuple[float, T]]) -> None:
        self._colours, self._depths = colours, depths

    @cached_property
    def _nearest(self) -> dict[str, tuple[float, str]]:
        """Key -> time [s] from the colour to its depth, and the name of that, in the order of time. A limit of the time
        leaves some out, and changes no other."""
        colours, depths = (
            sorted((time, name) for name, (time, _) in images.items()) for images in (self._colours, self._depths)
        )
        pairs = _nearest([time for time, _ in colours], [time for time, _ in depths])
        both = ((*colours[row], *depths[column]) for row, column in sorted(pairs))
        return {colour: (abs(time - other), depth) for time, colour, other, depth in both}

    def paired(self, max_gap: float) -> dict[str, tuple[T, T]]:
        """Key -> colour and depth whose times differ by at most `max_gap` [s], in the order of time."""
        return {key: pair for key in self._nearest if (pair := self.find(key, max_gap))}

    def find(self, key: str, max_gap: float = _LARGEST_GAP_S) -> tuple[T, T] | None:
        """Colour and depth for a key; None if there are none."""
        apart, depth = self._nearest.get(key, (math.inf, ""))
        return (self._colours[key][1], self._depths[depth][1]) if apart <= max_gap else None

    def index(self, max_gap: float, where: object) -> tuple[tuple[str, ...], tuple[float, ...], tuple[str, ...]]:
        """The names of the colours in pairs, their times [s], and notes; raises InputError, about `where`, if there are
        none."""
        names = tuple(self.paired(max_gap))
        if not names:
            raise InputError(f"{where}: {self.gap_text(max_gap)}")
        left = len(self._colours) - len(names), len(self._depths) - len(names)
        return names, tuple(self._colours[name][0] for name in names), tuple(left_out(*left, f"within {max_gap:g} s"))

    def gap_text(self, max_gap: float) -> str:
        """Why no times are that near [s], as the rest of a sentence and what to do.

        Examples
        --------
        >>> TimedPairs({"a.png": (0.0, 1), "b.png": (0.1, 2)}, {"a-d.png": (0.03, 3)}).gap_text(0.02)
        'no colour lies within 0.02 s of depth: the smallest difference is 0.03 s. Allow ...'
        """
        if not (self._colours and self._depths):
            return f"there are {len(self._colours)} colour images and {len(self._depths)} depth images."
        smallest = min(apart for apart, _ in self._nearest.values())
        told = f"no colour lies within {max_gap:g} s of depth: the smallest difference is {smallest:.4g} s"
        return f"{told}. Allow more (--max-gap) if they fit, or correct the times if two clocks differ."


def stamped(stamps: Iterable[int], per_second: int) -> dict[str, tuple[float, int]]:
    """Images by their time stamps, as `TimedPairs` takes them. A name is the stamp in seconds, with all of its digits.

    Parameters
    ----------
    stamps : iterable of int
    per_second : int
        Units of the time stamps per second: a power of ten.
    """
    digits = len(str(per_second)) - 1
    parts = ((stamp, *divmod(stamp, per_second)) for stamp in stamps)
    return {f"{seconds}.{rest:0{digits}d}": (stamp / per_second, stamp) for stamp, seconds, rest in parts}


# Files by their names.

_COLOUR_WORD = re.compile(r"(?<![a-z])(?:rgb|colou?rs?|images?|img)(?![a-z])|^r(?=[-_.])", re.IGNORECASE)
_DEPTH_WORD = re.compile(r"(?<![a-z])depths?(?![a-z])|^d(?=[-_.])", re.IGNORECASE)
_NUMBER = re.compile(r"\d+")
_CAMERA = re.compile(r"(?<![a-z])(?:(left|right)(?![a-z])|cam(?:era)?[-_]?(\d+)(?!\d)(?=.*\d))")
"""A side, or the number of a camera before that of the frame."""


class Pairs(NamedTuple):
    """Names of matching colour and depth files, in natural order; the numbers of files without a match; and files of
    one kind that share the name by which they would match, in groups."""

    pairs: list[tuple[str, str]]
    unmatched_colours: int
    unmatched_depths: int
    shared: tuple[tuple[str, ...], ...] = ()

    def notes(self, match_condition: str) -> list[str]:
        """Notes on files that were left out: they lack a file of the other kind of that name, or within a time."""
        notes = left_out(self.unmatched_colours, self.unmatched_depths, match_condition)
        return [*notes, f"Left out: {shared_text(self.shared)}."] if self.shared else notes


def split_by_kind(names: Iterable[str]) -> tuple[list[str], list[str]]:
    """Separate the names of one folder into colour and depth files.

    Depth files have the word depth in their name, or begin with d-; colour files have rgb, color, colour or image,
    begin with r-, or have none of these.
    """
    colours, depths = [], []
    for name in names:
        stem, suffix = _parts(name)
        if _DEPTH_WORD.search(stem):
            if suffix in DEPTH_FILE_SUFFIXES:
                depths.append(name)
        elif suffix in COLOUR_SUFFIXES:
            colours.append(name)
    return colours, depths


def depth_files(names: Iterable[str]) -> list[str]:
    """Names of possible depth files; those of rare formats only if there are none of the usual ones, as they are
    otherwise likely to contain something else."""
    known = [name for name in names if _parts(name)[1] in DEPTH_FILE_SUFFIXES]
    return [name for name in known if _parts(name)[1] in USUAL_DEPTH_SUFFIXES] or known


def paired(colours: Iterable[str], depths: Iterable[str]) -> Pairs:
    """Match names of colour files with names of depth files.

    Two names match if they are equal except for the words that mark colour and depth; of the others, if they are equal
    except for punctuation and case, and then except for leading zeros of numbers. If none match, and they are not
    times, the last number in the names is compared, where it is unique; these matches count only if they include more
    than half of the files of the smaller set, since a few may occur by chance, and names that state two cameras do not
    match. Files of other formats are left out.
    """
    images, depth_names = _colour_files(colours), depth_files(depths)
    pairs: dict[str, str] = {}

    def left() -> tuple[list[str], list[str]]:
        """The names that are in no pair."""
        taken = {*pairs.values()}
        return [name for name in images if name not in pairs], [name for name in depth_names if name not in taken]

    keys = {name: _keys(name) for name in (*images, *depth_names)}
    for step in range(3):
        more, clashes = _matched(*left(), {name: own[step] for name, own in keys.items()})
        pairs |= more
    are_times = 2 * sum(time_of(name) is not None for name in depth_names) > len(depth_names)
    if not (pairs or clashes or are_times):
        numbers = {name: _NUMBER.findall(_parts(name)[0]) for name in keys}
        last = {name: str(int(found[-1])) for name, found in numbers.items() if found}
        by_number, _ = _matched(images, depth_names, last)
        pairs = {colour: depth for colour, depth in by_number.items() if _is_one_camera(colour, depth)}
        if 2 * len(pairs) <= min(len(images), len(depth_names)):
            pairs = {}
    clashing = {name for clash in clashes for names in clash for name in names}
    colours_left, depths_left = (sum(name not in clashing for name in names) for names in left())
    shared = sorted(tuple(sorted(names)) for clash in clashes for names in clash if len(names) > 1)
    return Pairs(sorted(pairs.items(), key=lambda pair: natural(pair[0])), colours_left, depths_left, tuple(shared))


def _matched(
    colours: Iterable[str], depths: Iterable[str], keys: Mapping[str, str]
) -> tuple[dict[str, str], list[tuple[list[str], list[str]]]]:
    """Colour -> depth of the same key; and colours and depths of the keys that several files have."""
    by_colour, by_depth = defaultdict[str, list[str]](list), defaultdict[str, list[str]](list)
    for by_key, names in ((by_colour, colours), (by_depth, depths)):
        for name in names:
            if name in keys:
                by_key[keys[name]].append(name)
    both = [(by_colour[key], by_depth[key]) for key in by_colour.keys() & by_depth.keys()]
    pairs = {one[0]: other[0] for one, other in both if len(one) == len(other) == 1}
    return pairs, [(one, other) for one, other in both if len(one) + len(other) > 2]


def _is_one_camera(colour: str, depth: str) -> bool:
    """Whether two names state the same camera, or one of them states none."""
    one, other = (_CAMERA.findall(_parts(name)[0]) for name in (colour, depth))
    return not (one and other) or one == other


def _keys(name: str) -> tuple[str, str, str]:
    """A name without its extension and the words that mark colour and depth: as it is; but for punctuation and case;
    and but for leading zeros of numbers."""
    whole = _DEPTH_WORD.sub("", _COLOUR_WORD.sub("", os.path.splitext(name)[0]))
    plain = "-".join(re.findall(r"[^\W_]+", whole.lower()))
    return whole, plain, _NUMBER.sub(lambda digits: str(int(digits[0])), plain)


def _parts(name: str) -> tuple[str, str]:
    stem, suffix = os.path.splitext(name.lower())
    return stem, suffix


# Files whose names are times.

_TIME = re.compile(
    r"(?:[A-Za-z]+[-_])?(\d{1,10}\.\d{3,}|\d{9,10}[-_](?:\d{6}|\d{9})|\d{13}|\d{16}|\d{19})(?:[-_.][A-Za-z]+)?"
    r"|(\d{1,10}\.\d{2})|\d{7}-(\d{12})"
)
_UNITS = {12: 1e-6, 13: 1e-3, 16: 1e-6, 19: 1e-9}


def time_of(name: str) -> float | None:
    """The time [s] in a file name, also beside a word: seconds with a fraction, or, since 1970, milli-, micro- or
    nanoseconds; - and _ count as the point of seconds since 1970; and microseconds behind the number of a frame, as in
    SUN3D and Redwood's scans. None if the name is not a time.

    Examples
    --------
    >>> time_of("rgb/1305031102.175304.png"), time_of("depth_1305031102175.png"), time_of("000017.png")
    (1305031102.175304, 1305031102.175, None)
    >>> time_of("1305031102_175304.png"), time_of("12.033.png")
    (1305031102.175304, 12.033)
    >>> time_of("0000002-000000500000.jpg")
    0.5
    """
    found = _TIME.fullmatch(os.path.splitext(os.path.basename(name))[0])
    if found is None:
        return None
    time = re.sub("[-_]", ".", found[1] or found[2] or found[3])
    return float(time) if "." in time else int(time) * _UNITS[len(time)]


def paired_by_time(colours: Iterable[str], depths: Iterable[str], max_gap: float) -> Pairs:
    """Match names of colour files with the depth files nearest in time, each used once; no pairs if the names are not
    times.

    Parameters
    ----------
    colours, depths : iterable of str
    max_gap : float
        Maximum time difference of a pair [s].
    """
    images, depth_names = _colour_files(colours), depth_files(depths)
    pairs = [*TimedPairs(_timed(images), _timed(depth_names)).paired(max_gap).values()]
    return Pairs(pairs, len(images) - len(pairs), len(depth_names) - len(pairs))


def _timed(names: Iterable[str]) -> dict[str, tuple[float, str]]:
    """The files whose names are times, for `TimedPairs`."""
    return {name: (time, name) for name in names if (time := time_of(name)) is not None}


def _colour_files(names: Iterable[str]) -> list[str]:
    return [name for name in names if _parts(name)[1] in COLOUR_SUFFIXES]


def why_unpaired(colours: Collection[str], depths: Collection[str], max_gap: float) -> str:
    """Why no colour file matches a depth file, as the rest of a sentence.

    Parameters
    ----------
    colours, depths : collection of str
        Names of files, of which some may have other formats.
    max_gap : float
        As for `paired_by_time`.
    """
    images, usable = _colour_files(colours), depth_files(depths)
    for kind, found, names in (("colour", images, colours), ("depth", usable, depths)):
        if not found:
            return f"there is no {kind} file of a supported format{f', only {min(names)}' if names else ''}."
    if shared := paired(colours, depths).shared:
        return f"{shared_text(shared)}."
    if (timed := _timed(images)) and (timed_depths := _timed(usable)):
        return TimedPairs(timed, timed_depths).gap_text(max_gap)
    return f"no colour file has the name or number of a depth file: there are {min(images)} and {min(usable)}."


def shared_text(shared: Iterable[tuple[str, ...]]) -> str:
    """The rest of a sentence on files that share a name: what to do about them."""
    groups = [" and ".join(names) for names in shared]
    told = "; ".join([*groups[:2], *(["..."] if len(groups) > 2 else [])])
    same = f"some files, but for punctuation and ending, have the same name ({told})"
    return f"{same}: leave one of each out, or give their endings (--layout)"
