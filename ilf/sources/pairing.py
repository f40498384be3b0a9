"""Matching colour files with depth files by their names alone, and the timestamps of frames."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from typing import NamedTuple

from ..data.frame import FrameInputs
from .frames import COLOUR_SUFFIXES, DEPTH_FILE_SUFFIXES, USUAL_DEPTH_SUFFIXES
from .opening import opened
from .times import associated

_COLOUR_WORD = re.compile(r"(?<![a-z])(?:rgb|colou?rs?|images?|img)(?![a-z])|^r(?=[-_.])", re.IGNORECASE)
_DEPTH_WORD = re.compile(r"(?<![a-z])depths?(?![a-z])|^d(?=[-_.])", re.IGNORECASE)
_NUMBER = re.compile(r"\d+")

KeyFunction = Callable[[str], str | None]
"""A function from a name to its matching key; None for names without one."""


class Pairs(NamedTuple):
    """Names of matching colour and depth files, in natural order, the numbers of files without a match, and the names
    of files with several."""

    pairs: list[tuple[str, str]]
    unmatched_colours: int
    unmatched_depths: int
    ambiguous: tuple[str, ...] = ()


def natural(name: str) -> str:
    """Sort key for natural order.

    Examples
    --------
    >>> sorted(["frame-10", "Frame-2", "frame-1"], key=natural)
    ['frame-1', 'Frame-2', 'frame-10']
    """
    return _NUMBER.sub(lambda number: number[0].zfill(20), name.casefold())


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
    except for punctuation and case, and then except for leading zeros of numbers. If none match, the last number in the
    names is compared, where it is unique; these matches count only if they include more than half of the files of the
    smaller set, since a few may occur by chance. Files of other formats are left out.
    """
    colour_names = [name for name in colours if _parts(name)[1] in COLOUR_SUFFIXES]
    depth_names = depth_files(depths)
    pairs: list[tuple[str, str]] = []
    for key_of in (_whole_stem, _stem_without_kind, _stem_without_zeros):
        pairs += _matched(*_left(colour_names, depth_names, pairs), key_of)
    if not pairs:
        pairs = _matched(colour_names, depth_names, _last_number)
        if 2 * len(pairs) <= min(len(colour_names), len(depth_names)):
            pairs = []
    colours_left, depths_left = _left(colour_names, depth_names, pairs)
    several = {*map(_stem_without_zeros, colours_left)} & {*map(_stem_without_zeros, depths_left)}
    ambiguous = sorted({name for name in colours_left + depths_left if _stem_without_zeros(name) in several})
    without_colour, without_depth = (
        sum(name not in ambiguous for name in names) for names in (depths_left, colours_left)
    )
    in_order = sorted(pairs, key=lambda pair: natural(pair[0]))
    return Pairs(in_order, without_depth, without_colour, tuple(ambiguous))


def _left(
    colours: Iterable[str], depths: Iterable[str], pairs: Iterable[tuple[str, str]]
) -> tuple[list[str], list[str]]:
    """The names that are in no pair."""
    paired_colours, paired_depths = {colour for colour, _ in pairs}, {depth for _, depth in pairs}
    colours_left = [name for name in colours if name not in paired_colours]
    return colours_left, [name for name in depths if name not in paired_depths]


def _matched(colours: Iterable[str], depths: Iterable[str], key_of: KeyFunction) -> list[tuple[str, str]]:
    """Pairs of names with the same key, in natural order."""
    by_colour, by_depth = _unique_by_key(colours, key_of), _unique_by_key(depths, key_of)
    shared = by_colour.keys() & by_depth.keys()
    return sorted(((by_colour[key], by_depth[key]) for key in shared), key=lambda pair: natural(pair[0]))


def _unique_by_key(names: Iterable[str], key_of: KeyFunction) -> dict[str, str]:
    """Key -> name, without keys that several names share."""
    found: dict[str, list[str]] = {}
    for name in names:
        key = key_of(name)
        if key is not None:
            found.setdefault(key, []).append(name)
    return {key: same[0] for key, same in found.items() if len(same) == 1}


def _whole_stem(name: str) -> str:
    """A name without its extension and the words that mark colour and depth, with its punctuation and case."""
    return _DEPTH_WORD.sub("", _COLOUR_WORD.sub("", os.path.splitext(name)[0]))


def _stem_without_kind(name: str) -> str | None:
    """A name without its extension and the words that mark colour and depth."""
    stem = _DEPTH_WORD.sub("", _COLOUR_WORD.sub("", _parts(name)[0]))
    return "-".join(re.findall(r"[^\W_]+", stem))


def _stem_without_zeros(name: str) -> str | None:
    return _NUMBER.sub(lambda digits: str(int(digits[0])), _stem_without_kind(name) or "")


def _last_number(name: str) -> str | None:
    numbers = _NUMBER.findall(_parts(name)[0])
    return str(int(numbers[-1])) if numbers else None


def _parts(name: str) -> tuple[str, str]:
    stem, suffix = os.path.splitext(name.lower())
    return stem, suffix


# Files whose names are times.

_TIME = re.compile(r"\d{9,10}\.\d+|\d{13}|\d{16}|\d{19}")
_UNITS = {13: 1e-3, 16: 1e-6, 19: 1e-9}


def time_of(name: str) -> float | None:
    """The time [s] in a file name: seconds with a fraction, or milli-, micro- or nanoseconds since 1970; None if the
    name is not a time.

    Examples
    --------
    >>> time_of("rgb/1305031102.175304.png"), time_of("1305031102175.png"), time_of("000017.png")
    (1305031102.175304, 1305031102.175, None)
    """
    stem = os.path.splitext(os.path.basename(name))[0]
    if not _TIME.fullmatch(stem):
        return None
    return float(stem) if "." in stem else int(stem) * _UNITS[len(stem)]


def paired_by_time(colours: Iterable[str], depths: Iterable[str], max_gap: float) -> Pairs:
    """Match names of colour files with the depth files nearest in time, each used once; no pairs if the names are not
    times.

    Parameters
    ----------
    colours, depths : iterable of str
    max_gap : float
        Maximum time difference of a pair [s].
    """
    images = [name for name in colours if name.lower().endswith(COLOUR_SUFFIXES)]
    timed = [
        [(time, name) for name in names if (time := time_of(name)) is not None]
        for names in (images, depth_files(depths))
    ]
    pairs = associated(timed[0], timed[1], max_gap)
    return Pairs(pairs, len(timed[0]) - len(pairs), len(timed[1]) - len(pairs))


# Timestamps of frames.

_SECONDS = re.compile(r"(\d+)\.(\d{1,9})")


def stamp_of(inputs: FrameInputs) -> int | None:
    """Return the timestamp of a frame's colour [ns], from its key in a recording, the recording, or its file name; None
    if unknown.

    Raises
    ------
    InputError
        If the recording has to be read for it and cannot be read.
    """
    if inputs.frame is None:
        time = time_of(inputs.rgb.path)
        return None if time is None else round(time * 1e9)
    found = _SECONDS.fullmatch(inputs.frame.rpartition("/")[2])
    if found is not None:
        return int(found[1]) * 10**9 + int(found[2].ljust(9, "0"))
    with opened(inputs.rgb.path) as recording:
        taken = recording.frame(inputs.frame).time
    return None if taken is None else round(taken * 1e9)
