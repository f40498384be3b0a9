"""Files of other programs -> blocks; which format it is, the content says."""

from __future__ import annotations

import os
from pathlib import Path

from ...errors import FormatError, InputError, cause
from ..files import read_file, read_json
from ..label_files import read_labels
from .coco import blocks_of_coco, blocks_of_mask_list
from .labelme import blocks_of_labelme
from .mask_folder import blocks_of_mask_folder
from .stacking import LoadedBlocks

_MAX_JSON_BYTES = 2**28
_KINDS = "labelme's JSON, COCO's, or a list of masks like segment-anything's"


def read_blocks(
    path: str | os.PathLike[str], shape: tuple[int, int], *, image: str | os.PathLike[str] | None = None
) -> LoadedBlocks:
    """Read blocks from a label map (PNG), labelme's or COCO's JSON, a list of masks (JSON) or a folder of masks (PNG).

    Where shapes overlap, the smallest lies on top. Polygons take the pixels whose centre is inside, by the even-odd
    rule. Numbers are those of the file where they can be had: of group_ids (labelme) or annotations (COCO).

    Parameters
    ----------
    path : path-like
        A file, or a folder of masks; the format is recognised by the content.
    shape : (int, int)
        (H, W) of the frame, which it must be for.
    image : path-like, optional
        The frame's colour file, by whose name a COCO file's image is chosen if it has several.

    Returns
    -------
    LoadedBlocks

    Raises
    ------
    InputError
        If there is no such file, it is for another size or image, or what it says is damaged or makes no sense.
    FormatError
        If it is of none of these formats.

    Examples
    --------
    >>> from ilf.io.interchange import write_blocks
    >>> write_blocks("chair.json", [[0, 7], [7, 7]], names={7: "chair"})
    >>> found = read_blocks("chair.json", (2, 2))
    >>> found.labels.tolist(), found.names
    ([[0, 7], [7, 7]], {7: 'chair'})
    """
    place = Path(path).absolute()
    try:
        if place.is_dir():
            return blocks_of_mask_folder(place, shape)
    except OSError as error:
        raise InputError(f"{place}: cannot be read ({cause(error)}). Check its permissions.") from error
    content = read_file(place)
    beginning = content.data[:64].tobytes().lstrip(b"\xef\xbb\xbf \t\r\n")
    if place.suffix.lower() != ".json" and not beginning.startswith((b"{", b"[")):
        return LoadedBlocks(read_labels(content, shape))
    if content.data.size > _MAX_JSON_BYTES:
        raise InputError(
            f"{place} has {content.data.size / 2**20:.0f} MiB; at most 256 are read. Export this image alone."
        )
    parsed = read_json(content)
    colour = None if image is None else Path(image).absolute()
    if isinstance(parsed, list):
        return blocks_of_mask_list(place, parsed, shape)
    if isinstance(parsed, dict) and isinstance(parsed.get("shapes"), list):
        return blocks_of_labelme(place, parsed, shape)
    if isinstance(parsed, dict) and "annotations" in parsed:
        return blocks_of_coco(place, parsed, shape, colour)
    raise FormatError(f"{place} is JSON, but neither {_KINDS}. Export the blocks in one of these formats.")
