"""Run lengths as COCO has them: down the columns, column by column, first those outside, then those inside, ..."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from .stacking import Part, cropped

_WAY_OUT = "Export it again."
_LONGEST = 7
"""Characters of a run: 35 bits, more than any image has pixels."""


def run_lengths(mask: NDArray[np.bool_]) -> list[int]:
    """The run lengths of a mask (H, W).

    Examples
    --------
    >>> run_lengths(np.array([[False, True], [True, True]]))
    [1, 3]
    """
    flat = mask.ravel(order="F")
    bounds = [0, *(np.flatnonzero(flat[1:] != flat[:-1]) + 1).tolist(), flat.size]
    counts = np.diff(bounds).tolist()
    return [0, *counts] if flat[0] else counts


def compressed(counts: list[int]) -> str:
    """Run lengths as text: from the fourth on less the one before the last, 5 bits a character, the lowest first.

    Examples
    --------
    >>> compressed([6, 1, 40, 4, 5])
    '61X13mN'
    """
    text = []
    for place, count in enumerate(counts):
        left = count - counts[place - 2] if place > 2 else count
        more = True
        while more:
            bits, left = left & 31, left >> 5
            more = left != (-1 if bits & 16 else 0)
            text.append(chr(48 + bits + 32 * more))
    return "".join(text)


def part_of_runs(segmentation: dict[str, Any], where: str, shape: tuple[int, int]) -> Part | None:
    """The pixels of {"size": [H, W], "counts": run lengths or their text}; None if there are none.

    Raises
    ------
    InputError
        If the size is not `shape` (H, W), or the run lengths are damaged or do not add up to it.
    """
    size, counts = segmentation.get("size"), segmentation.get("counts")
    height, width = shape
    if size != [height, width]:
        raise InputError(
            f"{where} is for an image of [height, width] = {size!s:.40}, the frame is {width} x {height}. "
            "Use the masks of this frame."
        )
    if isinstance(counts, str):
        runs = _from_text(counts, where, height * width)
    elif isinstance(counts, list) and all(type(one) is int for one in counts):
        # what is out of bounds stays so, within what the type holds
        runs = np.array([min(max(one, -1), height * width + 1) for one in counts[: height * width + 2]], np.int64)
    else:
        raise InputError(f"{where} has run lengths that are neither whole numbers nor a text of them. {_WAY_OUT}")
    if len(runs) > height * width + 1 or (runs < 0).any() or runs.sum() != height * width:
        pixels = f"the image's {height * width} pixels"
        raise InputError(f"{where} has run lengths that do not add up to {pixels}. {_WAY_OUT}")
    ends = np.cumsum(runs)
    inside = np.flatnonzero(runs[1::2]) * 2 + 1
    if inside.size == 0:
        return None
    # only the columns from the first pixel to the last
    left, right = int(ends[inside[0] - 1]) // height, (int(ends[inside[-1]]) - 1) // height + 1
    ends = np.clip(ends, left * height, right * height)
    clipped = ends - np.concatenate(([left * height], ends[:-1]))
    mask = np.repeat(np.arange(len(runs)) % 2 == 1, clipped).reshape(right - left, height).T
    return cropped(mask, left=left)


def _from_text(text: str, where: str, pixels: int) -> NDArray[np.int64]:
    """Run lengths out of their text."""
    damaged = InputError(f"{where} has a text of run lengths that is damaged. {_WAY_OUT}")
    if not text or not text.isascii() or len(text) > _LONGEST * (pixels + 1):
        raise damaged
    codes = np.frombuffer(text.encode("ascii"), np.uint8).astype(np.int64) - 48
    last = np.flatnonzero((codes & 32) == 0)
    if codes.min() < 0 or codes.max() > 63 or last.size == 0 or last[-1] != codes.size - 1:
        raise damaged
    first = np.concatenate(([0], last[:-1] + 1))
    lengths = last - first + 1
    if lengths.max() > _LONGEST:
        raise damaged
    place = np.arange(codes.size) - np.repeat(first, lengths)
    runs = np.add.reduceat((codes & 31) << (5 * place), first)
    runs -= ((codes[last] & 16) > 0).astype(np.int64) << (5 * lengths)
    if np.abs(runs).max() > pixels:
        raise damaged
    runs[1::2], runs[2::2] = np.cumsum(runs[1::2]), np.cumsum(runs[2::2])
    return runs
