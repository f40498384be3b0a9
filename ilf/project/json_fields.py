"""What of a state needs no arrays, from its json; a reader that cannot raises FormatError, or what Python does."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ..errors import FormatError
from ..sections import Section
from .block_notes import BlockInfo
from .frame_state import Looked
from .kept_run import Colour


def result_rows(data: Section, frame_part: Section) -> list[tuple[int, str, int]]:
    """Label, pack and number in it, of every result."""
    packs = frame_part.items("packs", str)
    rows = data.items("results", list)
    if not all(len(row) == 3 and all(type(number) is int for number in row) for row in rows):
        raise FormatError("They are not told of as label, part and place.")
    return [(label, packs[pack], place) for label, pack, place in rows if 0 <= pack < len(packs)]


def block_infos(data: Section) -> dict[int, BlockInfo]:
    """Names, colours and the like, by label."""
    infos = {}
    for label in data.values:
        info = data.section(label)
        infos[int(label)] = BlockInfo(
            info.get("name", str), colour_of(info), info.get("visible", bool), info.get("locked", bool)
        )
    return infos


def reasons_of(data: Section) -> dict[int, str]:
    """Why blocks need a look, by label."""
    return {int(label): data.get(label, str) for label in data.values}


def colour_of(data: Section) -> Colour:
    """Red, green, blue."""
    red, green, blue = data.items("colour", int)
    if not all(0 <= value <= 255 for value in (red, green, blue)):
        raise FormatError("A colour is not of numbers from 0 to 255.")
    return red, green, blue


def chosen_labels(data: Section) -> Sequence[int] | frozenset[int]:
    """Which blocks a run was of, in their order if they had one."""
    labels = data.items("only", int)
    return tuple(labels) if data.get("in_order", bool) else frozenset(labels)


def number_or_none(data: Section, key: str) -> float | None:
    """None if it has not been worked out, NaN if there is none."""
    if key not in data.values:
        return None
    number: float | None = data.get(key, float, type(None))
    return math.nan if number is None else number


def looked_at(data: Section) -> Looked:
    """Where the user has looked closely."""
    line, region = data.get("line", list, type(None)), data.get("region", list, type(None))
    box = None
    if region is not None:
        (top, bottom), (left, right) = region
        box = slice(int(top), int(bottom)), slice(int(left), int(right))
    ends = None
    if line is not None:
        one, other = line
        ends = _point(one), _point(other)
    chains = tuple(tuple(map(_point, chain)) for chain in data.items("chains", list))
    return Looked(ends, box, chains, data.get("reference", int))


def _point(numbers: Any) -> tuple[float, float]:
    x, y = numbers
    return float(x), float(y)
