"""Depth from HDF5 files, also those of MATLAB (7.3): the dataset that is named, or the only one that can be depth."""

from __future__ import annotations

import io
import math
import os
import re
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent
from ..errors import FormatError
from .hdf5 import CHILD_MEMORY, dataset, images, is_of_matlab, open_hdf5
from .images import check_pixel_count

_USUAL = "dataset", "depth", "depths"
"""Names of depth; Hypersim calls every image dataset."""

_MOST_LISTED = 12
_WITH_NAME = re.compile(r"(.+\.(?:hdf5|h5|mat)):[/\\](.+)", re.IGNORECASE | re.DOTALL)


def split_dataset(path: str) -> tuple[str, str | None]:
    r"""A path or address without the dataset that it names behind a colon, and the name; None if it names none.

    Examples
    --------
    >>> split_dataset("C:/take.h5:/left/depth"), split_dataset("zip://depth.h5::/all.zip")
    (('C:/take.h5', '/left/depth'), ('zip://depth.h5::/all.zip', None))
    """
    found = _WITH_NAME.fullmatch(path)
    if found is None or os.path.lexists(path):
        return path, None
    return found[1], "/" + found[2].replace("\\", "/")  # as Windows' paths write it


def with_dataset(path: object, dataset: str | None) -> str:
    """A path with the name of its dataset, if it is known, as `split_dataset` takes it."""
    return f"{path}:/{dataset.lstrip('/')}" if dataset else str(path)


def read_hdf5(file: FileContent, name: str | None = None) -> NDArray[Any]:
    """Read depth (H, W) in a child. What MATLAB has saved, column by column, is transposed.

    Parameters
    ----------
    file : FileContent
    name : str, optional
        Name of the dataset, including its groups. None: dataset, depth or depths, or else the only one that can be
        depth, see `ilf.io.hdf5.images`.

    Raises
    ------
    InputError
        If h5py is not installed.
    FormatError
        If it is no HDF5, is damaged, has too many pixels, or no such dataset, or several that can be depth.
    """
    from .._runtime.children import run_in_child

    return run_in_child(_depth, file, name, file=str(file), memory=CHILD_MEMORY)


def _depth(file: FileContent, name: str | None) -> NDArray[Any]:
    with open_hdf5(io.BytesIO(file.data.tobytes()), str(file), "Reading depth from HDF5") as opened:
        found = _first(opened, [name] if name else _USUAL, str(file))
        if found is None:
            known = images(opened)
            if name or len(known) != 1:
                raise _not_found(file, name, known)
            found = _first(opened, known, str(file))
        check_pixel_count(file, math.prod(found.shape[1:]), found.shape[0])
        values = np.asarray(found)
        return np.ascontiguousarray(values.T) if is_of_matlab(file) else values


def _first(opened: Any, names: Iterable[str], file: str) -> Any:
    """The first dataset with one of these names that has two axes, or three for `without_channel`; None for none."""
    kinds = [(name.strip("/"), axes) for name in names for axes in (2, 3)]
    return next((data for name, axes in kinds if (data := dataset(opened, name, "fiu", axes, file)) is not None), None)


def _not_found(file: FileContent, name: str | None, known: dict[str, tuple[int, ...]]) -> FormatError:
    """The error for a file without depth, or without the dataset of a name, that has these images."""
    missing = f"{file} has no image {name}" if name else f"{file} has {len(known) or 'no'} datasets that can be depth"
    if not known:
        return FormatError(f"{missing}: none has two axes and numbers of 16 bits or more. Save its depth as such.")
    shapes = {one: shape[::-1] if is_of_matlab(file) else shape for one, shape in known.items()}
    listed = ", ".join(f"{one} {shape}" for one, shape in [*shapes.items()][:_MOST_LISTED])
    more = f" and {len(known) - _MOST_LISTED} more" if len(known) > _MOST_LISTED else ""
    likely = next((one for one in known if "depth" in one.lower()), next(iter(known)))
    return FormatError(
        f"{missing}{'. It has' if name else ''}: {listed}{more}. Name the one to read behind the file, "
        f"{file}:{likely}, or for all files of a folder as the dataset (--dataset) {likely}."
    )
