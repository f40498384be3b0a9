"""Blocks -> files of other programs."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path

from numpy.typing import ArrayLike

from ...errors import ExportError
from ..atomic import write_bytes
from ..label_files import checked_to_write, write_labels
from .coco import coco_of_blocks
from .labelme import labelme_of_blocks

BLOCK_FORMATS = {
    "png": ("Label map, 16 bit", ".png"),
    "coco": ("COCO, polygons", ".json"),
    "coco-rle": ("COCO, run lengths", ".json"),
    "labelme": ("labelme, polygons", ".json"),
}
"""Format -> what it is, and its suffix. All of them are exact to the pixel; names are in all but the first."""

_DEFAULTS = {".png": "png", ".json": "coco"}


def write_blocks(
    path: str | os.PathLike[str],
    labels: ArrayLike,
    *,
    format: str | None = None,
    names: Mapping[int, str] | None = None,
    image: str | os.PathLike[str] | None = None,
) -> None:
    """Write blocks atomically, so that `read_blocks` gives the very same label map.

    Parameters
    ----------
    path : path-like
        Must end in .png, or in .json for all other formats.
    labels : array_like
        Integers 0-65535, (H, W); 0 = no block.
    format : str, optional
        One of `BLOCK_FORMATS`; if left out, "png" or "coco", by the suffix.
    names : mapping, optional
        Label -> name. A block without one is called "block".
    image : path-like, optional
        The frame's colour file, which JSON files name.

    Raises
    ------
    ExportError
        If the labels do not fit into 16 bits, format and suffix do not go together, or the file cannot be written.

    Notes
    -----
    Polygons follow the edges of pixels. Programs that fill a polygon and draw its outline on the pixels, too, as
    labelme does when it exports masks, make blocks up to a pixel wider; those that only fill it, as COCO's own tools
    do, do not.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    chosen = format or _DEFAULTS.get(suffix)
    if chosen not in BLOCK_FORMATS:
        ways = "use .png or .json" if format is None else f"there are {', '.join(BLOCK_FORMATS)}"
        raise ExportError(f"Blocks cannot be written as {format or str(path)!r}: {ways}.")
    if suffix != BLOCK_FORMATS[chosen][1]:
        raise ExportError(f"Blocks as {chosen} cannot be written as {str(path)!r}: use {BLOCK_FORMATS[chosen][1]}.")
    if chosen == "png":
        write_labels(target, labels)
        return
    checked = checked_to_write(labels)
    colour = None if image is None else Path(image).absolute()
    if chosen == "labelme":
        content = labelme_of_blocks(checked, names or {}, colour, target)
    else:
        content = coco_of_blocks(checked, names or {}, colour, runs=chosen == "coco-rle")
    write_bytes(target, json.dumps(content).encode())
