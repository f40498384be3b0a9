"""Reading and writing blocks in files of other programs; the format is recognised by the content."""

from __future__ import annotations

import io
import json
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from PIL import Image

from .._runtime.files import is_address, read_file, read_json
from .._runtime.writing import write_bytes
from ..data.blocks import Blocks, Colour, block_colour
from ..errors import ExportError, FormatError, InputError, told_as
from .annotations import blocks_of_coco, blocks_of_labelme, blocks_of_mask_list, coco_of_blocks, labelme_of_blocks
from .images import checked_for_writing, encode_labels, read_labels
from .shapes import blocks_of_mask_folder

_MAX_JSON_BYTES = 2**28
_KINDS = "that of labelme or COCO, or a list of masks as from segment-anything"


def read_blocks(
    path: str | os.PathLike[str], shape: tuple[int, int], *, image: str | os.PathLike[str] | None = None
) -> Blocks:
    """Read blocks from a label map (PNG), labelme's or COCO's JSON, a list of masks (JSON) or a folder of masks (PNG).

    Where shapes overlap, the smallest is on top. Polygons contain the pixels whose centre is inside, by the even-odd
    rule. Labels are taken from group_ids (labelme) or annotation ids (COCO) where possible.

    Parameters
    ----------
    path : path-like
        A file, or a folder of masks; the format is recognised by the content.
    shape : (int, int)
        (H, W) of the frame, which the file must match.
    image : path-like, optional
        The frame's colour file, whose name selects the image of a COCO file with several.

    Returns
    -------
    Blocks

    Raises
    ------
    InputError
        If the file does not exist, is for another size or image, or its content is damaged or invalid.
    FormatError
        If it is of none of these formats.

    Examples
    --------
    >>> from ilf.io.block_files import write_blocks
    >>> write_blocks("chair.json", [[0, 7], [7, 7]], names={7: "chair"})
    >>> found = read_blocks("chair.json", (2, 2))
    >>> found.labels.tolist(), found.names
    ([[0, 7], [7, 7]], {7: 'chair'})
    """
    place = Path(path).absolute()
    with told_as(InputError, f"{place}: cannot be read ({{error}}). Check its permissions.", OSError):
        if place.is_dir():
            return blocks_of_mask_folder(place, shape)
    content = read_file(place)
    beginning = content.data[:64].tobytes().lstrip(b"\xef\xbb\xbf \t\r\n")
    if place.suffix.lower() != ".json" and not beginning.startswith((b"{", b"[")):
        labels = read_labels(content, shape)
        changes = np.mean(labels[:, 1:] != labels[:, :-1]) if labels.size >= _FEWEST_PIXELS else 0
        return Blocks(labels, notes=(_PICTURE.format(path=place),) if changes > _MOST_CHANGES else ())
    if content.data.size > _MAX_JSON_BYTES:
        raise InputError(f"{place} has {content.data.size >> 20} MiB, more than 256. Export only this image.")
    parsed = read_json(content)
    colour = None if image is None else Path(image).absolute()
    if isinstance(parsed, list):
        return blocks_of_mask_list(place, parsed, shape)
    if isinstance(parsed, dict) and isinstance(parsed.get("shapes"), list):
        return blocks_of_labelme(place, parsed, shape)
    if isinstance(parsed, dict) and "annotations" in parsed:
        return blocks_of_coco(place, parsed, shape, colour)
    raise FormatError(f"{place} is JSON, but not {_KINDS}. Export the blocks in one of these formats.")


_FEWEST_PIXELS, _MOST_CHANGES = 10_000, 0.3
"""Minimum size, and maximum share of neighbouring pixels with different labels."""

_PICTURE = "{path}: labels change at most pixels, as values of a picture do. Check that it is the label map."


# Writing blocks to files of other programs.

BLOCK_FORMATS = {
    "png": ("Label map, 16 bit", ".png"),
    "palette": ("Label map in the blocks' colours, 8 bit", ".png"),
    "coco": ("COCO, polygons", ".json"),
    "coco-rle": ("COCO, run lengths", ".json"),
    "labelme": ("labelme, polygons", ".json"),
}
"""Format -> description and suffix. All are exact to the pixel; those of JSON contain names."""

_PALETTE_MAX = 255
"""Largest label in the format "palette", whose values are the labels."""

_DEFAULTS = {".png": "png", ".json": "coco"}


def write_blocks(
    path: str | os.PathLike[str],
    labels: ArrayLike,
    *,
    format: str | None = None,
    names: Mapping[int, str] | None = None,
    colours: Mapping[int, Colour] | None = None,
    image: str | os.PathLike[str] | None = None,
) -> None:
    """Write blocks atomically, so that `read_blocks` returns the identical label map.

    Parameters
    ----------
    path : path-like
        Must end in .png, or in .json for all other formats.
    labels : array_like
        Integers 0-65535, (H, W); 0 = no block.
    format : str, optional
        One of `BLOCK_FORMATS`; if omitted, "png" or "coco", by the suffix.
    names : mapping, optional
        Label -> name. Blocks without a name are named "block".
    colours : mapping, optional
        Label -> colour in the format "palette". Blocks without one have that of `block_colour`.
    image : path-like, optional
        The frame's colour file, referenced in JSON files.

    Raises
    ------
    ExportError
        If the labels do not fit into 16 bits, or a palette, format and suffix do not match, or the file cannot be
        written.

    Notes
    -----
    Polygons follow the edges of pixels. Programs that fill a polygon and also draw its outline, such as labelme when it
    exports masks, make blocks up to a pixel wider; programs that only fill it, such as COCO's own tools, do not.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    chosen = format or _DEFAULTS.get(suffix)
    if chosen not in BLOCK_FORMATS:
        ways = "use .png or .json" if format is None else f"use one of {', '.join(BLOCK_FORMATS)}"
        raise ExportError(f"Blocks cannot be written as {format or str(path)!r}: {ways}.")
    if suffix != BLOCK_FORMATS[chosen][1]:
        raise ExportError(f"Blocks as {chosen} cannot be written as {str(path)!r}: use {BLOCK_FORMATS[chosen][1]}.")
    seen = "" if image is None else path_from(target.parent, image)
    write_bytes(target, encode_blocks(chosen, labels, names or {}, colours or {}, seen))


def encode_blocks(
    format: str, labels: ArrayLike, names: Mapping[int, str], colours: Mapping[int, Colour], image: str
) -> bytes:
    """Return the content of the file that `write_blocks` writes, and raise as it does; `image` is the path of the
    colour file as seen from it, "" for none."""
    if format == "png":
        return encode_labels(labels)
    checked = checked_for_writing(labels)
    if format == "palette":
        return _with_palette(checked, colours)
    if format == "labelme":
        return json.dumps(labelme_of_blocks(checked, names, image)).encode()
    return json.dumps(coco_of_blocks(checked, names, image, runs=format == "coco-rle")).encode()


def palette_problem(labels: NDArray[np.int32]) -> str:
    """A sentence that labels have no place in a palette; "" if they have."""
    largest = int(labels.max(initial=0))
    told = f"A palette has the labels 0 to {_PALETTE_MAX}, not {largest}: use a label map of 16 bits, COCO or labelme."
    return told if largest > _PALETTE_MAX else ""


def path_from(folder: Path, file: str | os.PathLike[str]) -> str:
    """Return the path of a file as seen from a folder, with / between its parts; an address as it is.

    Examples
    --------
    >>> path_from(Path("/home/me/out"), "/home/me/room/rgb.png")
    '../room/rgb.png'
    """
    if is_address(file):
        return str(file)
    try:
        return Path(os.path.relpath(file, folder)).as_posix()
    except ValueError:  # on another drive
        return str(Path(file).absolute())


def _with_palette(labels: NDArray[np.int32], colours: Mapping[int, Colour]) -> bytes:
    """Return a PNG whose values are the labels, shown in the colours of the blocks, and black where there is none."""
    if problem := palette_problem(labels):
        raise ExportError(problem)
    image, content = Image.fromarray(labels.astype(np.uint8)), io.BytesIO()
    table = [(0, 0, 0), *(colours.get(label, block_colour(label)) for label in range(1, _PALETTE_MAX + 1))]
    image.putpalette([value for colour in table for value in colour])
    image.save(content, "png")
    return content.getvalue()
