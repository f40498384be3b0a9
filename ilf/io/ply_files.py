"""Point clouds as PLY and as plain text, in float32, by numpy alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

# enough digits for every float32 to come back as it was
_FLOAT = "%.9g"
_CHANNELS = ("red", "green", "blue")


def ply_content(points: NDArray[np.float32], colours: NDArray[np.uint8] | None = None, *, ascii: bool = False) -> bytes:
    """A PLY file: one vertex with float x, y, z and, where there are colours, uchar red, green, blue per point.

    Parameters
    ----------
    points : ndarray
        float32 (N, 3).
    colours : ndarray, optional
        uint8 (N, 3), red first.
    ascii : bool
        Text, every digit of it, instead of little-endian binary (12 bytes a point, 15 with colours).
    """
    fields = [(name, "<f4") for name in "xyz"]
    if colours is not None:
        fields += [(name, "u1") for name in _CHANNELS]
    properties = [f"property {'float' if kind == '<f4' else 'uchar'} {name}\n" for name, kind in fields]
    header = "".join(
        [
            "ply\n",
            f"format {'ascii' if ascii else 'binary_little_endian'} 1.0\n",
            "comment ILF Studio\n",
            f"element vertex {len(points)}\n",
            *properties,
            "end_header\n",
        ]
    ).encode()
    if ascii:
        return header + text_content(points, colours)
    vertices = np.empty(len(points), fields)
    for column, name in enumerate("xyz"):
        vertices[name] = points[:, column]
    if colours is not None:
        for column, name in enumerate(_CHANNELS):
            vertices[name] = colours[:, column]
    return header + vertices.tobytes()


def text_content(points: NDArray[np.float32], colours: NDArray[np.uint8] | NDArray[np.floating] | None = None) -> bytes:
    """One line per point: x y z and, where there are colours, these (integers as such, others with 6 digits)."""
    columns, line = [points.astype(np.float64)], [_FLOAT] * 3
    if colours is not None:
        columns.append(colours.astype(np.float64))
        line += ["%d" if colours.dtype.kind == "u" else "%.6g"] * 3
    values = np.hstack(columns)
    return ((" ".join(line) + "\n") * len(points) % tuple(values.ravel().tolist())).encode()
