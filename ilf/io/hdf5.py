"""Safe reading of untrusted HDF5 files, in a child: the header of a data set is checked before its values are read.

A file of two kilobytes can link to other files, or require decoding by an arbitrary plug-in.
"""

from __future__ import annotations

import os
from io import BytesIO
from typing import Any

from .._runtime.files import FileContent
from .._runtime.installation import optional
from ..errors import FormatError
from .kinds import kind_of_file, start_of, wrong_kind

HDF5_SUFFIXES = ".hdf5", ".h5", ".mat"
_MAGIC = b"\x89HDF", b"MATLAB 7.3"

CHILD_MEMORY = 2**31
"""Limit of the memory of a child that reads a file [bytes]."""

_LEAST_SIDE = 8
"""Minimum length of the sides of an image: smaller datasets are matrices and lists of points."""

_FILTERS = {1, 2, 3}
"""Numbers of deflate, shuffle and fletcher32."""


def open_hdf5(source: str | os.PathLike[str] | BytesIO, file: str, purpose: str) -> Any:
    """Open an HDF5 file for reading, as a context manager.

    Parameters
    ----------
    source : path-like or BytesIO
        The file, or its content.
    file : str
        Its name, for messages.
    purpose : str
        What needs it, as the subject of a sentence.

    Returns
    -------
    h5py.File

    Raises
    ------
    InputError
        If the package that reads it is missing.
    FormatError
        If it is not an HDF5 file, or is truncated.
    """
    h5py = optional("h5py", "ilf-studio[sensors]", purpose)
    try:
        return h5py.File(source, "r")
    except OSError as error:
        start = (source.getvalue() if isinstance(source, BytesIO) else start_of(source)) or b""
        if not start.startswith(_MAGIC) and kind_of_file("", start):  # by content alone, which may begin later
            raise wrong_kind(file, start, "an HDF5 file") from error
        raise FormatError(f"{file} is not a complete HDF5 file. Download or copy it again.") from error


def is_of_matlab(file: FileContent) -> bool:
    """Whether MATLAB has saved an HDF5 file, with the axes of its arrays reversed; its h5write leaves no sign."""
    content = file.data.tobytes()
    return content.startswith(b"MATLAB 7.3") or b"MATLAB_class" in content


def dataset(opened: Any, name: str, kinds: str, dimensions: int, file: str) -> Any:
    """Return a data set of plain numbers stored in the file itself.

    Parameters
    ----------
    opened : h5py.File
    name : str
        Name including its groups, as "group/name".
    kinds : str
        Allowed types of numbers, letters of numpy's `dtype.kind`.
    dimensions : int
        Number of axes.
    file : str
        The file's name, for messages.

    Returns
    -------
    h5py.Dataset or None
        None if it does not exist, or contains something else.

    Raises
    ------
    FormatError
        If it is stored in another file, or compressed in an unsupported way; any other error if it is damaged.
    """
    import h5py

    parts = name.split("/")
    for depth in range(1, len(parts) + 1):
        link = opened.get("/".join(parts[:depth]), getlink=True)
        if link is None:
            return None
        if not isinstance(link, h5py.HardLink):
            raise FormatError(f"{file}: {name} is a link to another place or file. Store the data in the file itself.")
    found = opened.get(name)
    if not isinstance(found, h5py.Dataset) or found.ndim != dimensions or found.dtype.kind not in kinds:
        return None
    if found.external or found.is_virtual:
        raise FormatError(f"{file}: the values of {name} are in other files. Store them in the file itself.")
    plan = found.id.get_create_plist()
    if not {plan.get_filter(index)[0] for index in range(plan.get_nfilters())} <= _FILTERS:
        raise FormatError(f"{file}: {name} is compressed in an unsupported way. Store it uncompressed, or with gzip.")
    return found


def images(opened: Any) -> dict[str, tuple[int, ...]]:
    """The shapes of the datasets of an h5py.File that can be depth, by their names with /: two axes, or three of which
    one has the length 1, and numbers of 16 bits or more. Links are not followed."""
    import h5py

    found: dict[str, tuple[int, ...]] = {}

    def look(name: str, item: Any) -> None:
        if not isinstance(item, h5py.Dataset) or item.dtype.kind not in "fiu" or name.startswith("#"):
            return  # MATLAB keeps the elements of cells under #refs#
        sides = [side for side in item.shape if side != 1]
        if item.ndim in {2, 3} and len(sides) == 2 and min(sides) >= _LEAST_SIDE and item.dtype.itemsize > 1:
            found[f"/{name}"] = item.shape

    opened.visititems(look)
    return found
