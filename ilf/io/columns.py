"""What is known of a cloud's points, as columns of numbers that a file has in one order or another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cloud.points import LENGTHS, PointCloud, axes_signs
from ..errors import ParameterError

UNITS_PER_METRE = {"m": 1.0, "mm": 1000.0}

_AT_ONCE = 1 << 16  # points

# enough digits for every float32 to come back as it was
_FORMATS = {"f": "%.9g", "u": "%d"}


@dataclass(frozen=True, eq=False)
class Column:
    """One number of every point.

    Parameters
    ----------
    name : str
    values : ndarray
        Shape (N,).
    factor : float
        What to multiply them with.
    kind : str
        Type in the file: "<f4" or "u1".
    """

    name: str
    values: NDArray[Any]
    factor: float = 1.0
    kind: str = "<f4"


@dataclass(frozen=True, eq=False)
class Columns:
    """All columns of a cloud in the axes and the unit that its file is to have."""

    points: tuple[Column, ...]
    normals: tuple[Column, ...]
    colours: tuple[Column, ...]
    scalars: tuple[Column, ...]


def columns_of(cloud: PointCloud, axes: str, unit: str) -> Columns:
    """Columns x, y, z; nx, ny, nz; red, green, blue; and the scalars under their own names.

    Nothing is copied: what is to be multiplied is so when it is written.

    Raises
    ------
    ParameterError
        For unknown axes or units.
    """
    if unit not in UNITS_PER_METRE:
        raise ParameterError(f"unit must be one of {', '.join(UNITS_PER_METRE)}, not {unit!r}.")
    scale, signs = UNITS_PER_METRE[unit], axes_signs(axes)
    normals = cloud.normals
    return Columns(
        points=tuple(Column("xyz"[i], cloud.points[:, i], scale * signs[i]) for i in range(3)),
        normals=() if normals is None else tuple(Column(f"n{'xyz'[i]}", normals[:, i], signs[i]) for i in range(3)),
        colours=tuple(Column(name, cloud.colours[:, i], kind="u1") for i, name in enumerate(("red", "green", "blue"))),
        scalars=tuple(
            Column(name, values, scale if name in LENGTHS else 1.0) for name, values in cloud.scalars.items()
        ),
    )


def binary_rows(columns: Sequence[Column]) -> Iterator[bytes]:
    """The numbers of one point after those of another, some points at a time."""
    for rows in _rows(columns):
        yield rows.tobytes()


def text_rows(columns: Sequence[Column], start: str = "", formats: Sequence[str] = ()) -> Iterator[bytes]:
    """A line for each point, some points at a time: with every digit, unless formats are given."""
    line = " ".join(formats or [_FORMATS[np.dtype(column.kind).kind] for column in columns])
    for rows in _rows(columns):
        values = [rows[name].tolist() for name in rows.dtype.names or ()]
        text = f"{start}{line}\n" * len(rows)
        yield (text % tuple(number for point in zip(*values, strict=True) for number in point)).encode()


def _rows(columns: Sequence[Column]) -> Iterator[NDArray[np.void]]:
    for start in range(0, len(columns[0].values), _AT_ONCE):
        some = slice(start, start + _AT_ONCE)
        rows = np.empty(len(columns[0].values[some]), [(column.name, column.kind) for column in columns])
        for column in columns:
            rows[column.name] = column.values[some]
            if column.factor != 1:
                rows[column.name] *= np.float32(column.factor)
        yield rows
