"""HDF5 files of strangers: what a data set says of itself is checked before anything of it is read.

A file of two kilobytes can declare terabytes, lead to other files, or have itself decoded by whatever plug-in is found.
"""

from __future__ import annotations

import math
import os
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.installation import optional
from ..errors import FormatError

MAX_READ = 2**30
"""Bytes that are read of a data set at once; more is refused."""

_FILTERS = {1: "deflate", 2: "shuffle", 3: "fletcher32"}
_PROBLEMS = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, ArithmeticError, MemoryError)
"""What h5py raises for damaged files."""


def open_hdf5(source: str | os.PathLike[str] | BytesIO, file: str, extra: str, purpose: str) -> Any:
    """An HDF5 file, open for reading; a context manager.

    Parameters
    ----------
    source : path-like or BytesIO
        The file, or its content.
    file : str
        Its name, for messages.
    extra, purpose : str
        As `ilf._runtime.installation.optional` takes them.

    Returns
    -------
    h5py.File

    Raises
    ------
    InputError
        If the package that reads it is missing.
    FormatError
        If it is no HDF5 file, or is truncated.
    """
    h5py = optional("h5py", extra, purpose)
    try:
        return h5py.File(source, "r")
    except _PROBLEMS as error:
        raise FormatError(f"{file} is not a whole HDF5 file. Download or copy it again.") from error


def dataset(opened: Any, name: str, kinds: str, dimensions: int, file: str) -> Any:
    """A data set of plain numbers that lies in the file itself.

    Parameters
    ----------
    opened : h5py.File
    name : str
        With the groups that it lies in, as "group/name".
    kinds : str
        Kinds of its numbers, letters of numpy's `dtype.kind`.
    dimensions : int
        How many axes it has.
    file : str
        The file's name, for messages.

    Returns
    -------
    h5py.Dataset or None
        None if there is none of this name, or it holds something else.

    Raises
    ------
    FormatError
        If it is damaged, lies in another file, or is packed in a way that is not read.
    """
    import h5py

    try:
        parts = name.split("/")
        for depth in range(1, len(parts) + 1):
            link = opened.get("/".join(parts[:depth]), getlink=True)
            if link is None:
                return None
            if not isinstance(link, h5py.HardLink):
                raise FormatError(f"{file}: {name} leads elsewhere, to another place or file. Store it in the file.")
        found = opened.get(name)
        if not isinstance(found, h5py.Dataset) or found.ndim != dimensions or found.dtype.kind not in kinds:
            return None
        if found.external or found.is_virtual:
            raise FormatError(f"{file}: the numbers of {name} are in other files. Store them in the file.")
        plan = found.id.get_create_plist()
        filters = {plan.get_filter(index)[0] for index in range(plan.get_nfilters())}
        if not filters <= _FILTERS.keys():
            raise FormatError(f"{file}: {name} is packed in a rare way. Store it plain, or with gzip.")
        _check_bytes(found.chunks or (), found.dtype, name, file)
    except _PROBLEMS as error:
        raise _damaged(file, name) from error
    return found


def rows(data: Any, index: int | slice, file: str) -> NDArray[Any]:
    """A row of a data set, or several, or all.

    Parameters
    ----------
    data : h5py.Dataset
        From `dataset`.
    index : int or slice
        On its first axis.
    file : str
        The file's name, for messages.

    Raises
    ------
    FormatError
        If these are more than `MAX_READ` bytes, or damaged.
    """
    count = 1 if isinstance(index, int) else len(range(*index.indices(data.shape[0])))
    _check_bytes((count, *data.shape[1:]), data.dtype, data.name, file)
    try:
        return np.asarray(data[index])
    except _PROBLEMS as error:
        raise _damaged(file, data.name) from error


def _check_bytes(shape: tuple[int, ...], dtype: np.dtype[Any], name: str, file: str) -> None:
    size = math.prod(shape) * dtype.itemsize
    if size > MAX_READ:
        raise FormatError(
            f"{file}: {name} says that {size / 2**30:.3g} GiB are to be read at once, more than 1 GiB. "
            "Is this the right file?"
        )


def _damaged(file: str, name: str) -> FormatError:
    return FormatError(f"{file} is damaged at {name}. Download or copy it again.")
