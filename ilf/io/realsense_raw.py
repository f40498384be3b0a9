"""Depth snapshots of the RealSense Viewer: 16-bit values without a header, and a table beside them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent, read_file
from ..errors import FormatError, InputError, told_as
from .images import check_pixel_count

_FORMAT = "Z16"
_MOST_LINES = 1000


def read_viewer_raw(file: FileContent) -> NDArray[np.uint16]:
    """Read depth in the camera's units, uint16 (H, W), 0 = missing.

    The table NAME_metadata.csv that the viewer writes beside NAME.raw states its size.

    Raises
    ------
    FormatError
        If there is no such table, or it states no size, another format, or another number of values than the file has.
    """
    beside = file.path.with_name(f"{file.path.stem}_metadata.csv")
    try:
        table = read_file(beside)
    except InputError as error:
        raise FormatError(
            f"{file} has no header: its {file.data.size} bytes are not 512 x 424 float32 of a Kinect v2, and the table "
            f"of the RealSense Viewer, {beside.name}, is missing. Put it there, or save depth as PNG, NPY or TIFF."
        ) from error
    stated = table_of_names(table.data.tobytes().decode("utf-8-sig", "replace"))
    with told_as(
        FormatError, f"{table} does not state Resolution x and Resolution y. Copy it again.", (KeyError, ValueError)
    ):
        width, height = int(stated["resolution x"]), int(stated["resolution y"])
    if (kind := stated.get("format", _FORMAT).upper()) != _FORMAT:
        raise FormatError(f"{file} has the format {kind:.20}, not {_FORMAT}. Give the file of the depth stream.")
    check_pixel_count(file, width, height)
    if min(width, height) < 1 or file.data.size != 2 * width * height:
        raise FormatError(
            f"{file} has {file.data.size} bytes, but {beside.name} states {width} x {height} pixels of 2 bytes: it is "
            "truncated or of another image. Copy both again."
        )
    return np.frombuffer(file.data.tobytes(), "<u2").astype(np.uint16).reshape(height, width)


def table_of_names(text: str) -> dict[str, str]:
    """The second column of a comma-separated table by the first, in lower case; the first of equal names counts.

    Examples
    --------
    >>> table_of_names("Frame Info:\\nResolution x,848\\nFx, 421.5")
    {'resolution x': '848', 'fx': '421.5'}
    """
    rows = (line.split(",") for line in text.splitlines()[:_MOST_LINES])
    found: dict[str, str] = {}
    for name, value in (row[:2] for row in rows if len(row) > 1):
        found.setdefault(name.strip().lower(), value.strip())
    return found
