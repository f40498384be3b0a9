"""Depth and colour from HDF5 files, also those of MATLAB (7.3), read in a child.

The header of a data set is checked before its values are read: a file of two kilobytes can link to other files, or
require decoding by an arbitrary plug-in.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent
from .._runtime.installation import optional
from .._runtime.memory import check_memory
from ..errors import FormatError
from .float_images import is_other_name, named_scales
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


# Depth: the dataset that is named, or the only one that can be depth.

_DEPTHS = "dataset", "depth", "depths"
"""Names of depth; Hypersim calls every image dataset."""

_MOST_LISTED = 12


def read_hdf5(file: FileContent, name: str | None = None) -> NDArray[Any]:
    """Read depth (H, W) in a child. What MATLAB has saved, column by column, is transposed.

    Parameters
    ----------
    file : FileContent
    name : str, optional
        Name of the dataset, including its groups. None: dataset, depth or depths, or else the only one that can be
        depth, see `images`, unless its name says distance (as BlenderProc has it) or disparity.

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
    with open_hdf5(BytesIO(file.data.tobytes()), str(file), "Reading depth from HDF5") as opened:
        found = _depth_of(opened, file, name)
        check_memory(file, math.prod(found.shape[1:]), found.shape[0])
        values = np.asarray(found)
        return np.ascontiguousarray(values.T) if is_of_matlab(file) else values


def _depth_of(opened: Any, file: FileContent, name: str | None) -> Any:
    found = _first(opened, [name] if name else _DEPTHS, str(file))
    if found is None:
        known = images(opened)
        if name or len(known) != 1 or is_other_name(next(iter(known))):
            raise _not_found(file, name, known)
        found = _first(opened, known, str(file))
    return found


def hdf5_scales(file: FileContent, name: str | None = None) -> dict[str, tuple[float, ...]]:
    """What `named_scales` gives of an HDF5 file, which `read_hdf5` does not apply: of attributes of the dataset, its
    group and the file, and single values in its group. Raises as `read_hdf5` does."""
    from .._runtime.children import run_in_child

    return run_in_child(_scales, file, name, file=str(file), memory=CHILD_MEMORY)


def _scales(file: FileContent, name: str | None) -> dict[str, tuple[float, ...]]:
    with open_hdf5(BytesIO(file.data.tobytes()), str(file), "Reading depth from HDF5") as opened:
        found = _depth_of(opened, file, name)
        import h5py

        hard = (key for key in found.parent if isinstance(found.parent.get(key, getlink=True), h5py.HardLink))
        beside = ((key, found.parent[key]) for key in hard)
        numbers = [(key, item[()]) for key, item in beside if isinstance(item, h5py.Dataset) and item.size == 1]
        stated = (pair for owner in (opened, found.parent, found) for pair in owner.attrs.items())
        return named_scales([*numbers, *stated])


def _first(opened: Any, names: Iterable[str], file: str) -> Any:
    """The first dataset with one of these names that has two axes, or three for `without_channel`; None for none."""
    kinds = [(name.strip("/"), axes) for name in names for axes in (2, 3)]
    return next((data for name, axes in kinds if (data := dataset(opened, name, "fiu", axes, file)) is not None), None)


def _not_found(file: FileContent, name: str | None, known: dict[str, tuple[int, ...]]) -> FormatError:
    """The error for a file without depth, or without the dataset of a name, that has these images."""
    missing = f"{file} has no image {name}" if name else f"{file} has {len(known) or 'no'} datasets that can be depth"
    if len(known) == 1 and not name:
        missing = f"{file} has no depth, by the name of its dataset"
    if not known:
        return FormatError(f"{missing}: none has two axes and numbers of 16 bits or more. Save its depth as such.")
    shapes = {one: shape[::-1] if is_of_matlab(file) else shape for one, shape in known.items()}
    listed = ", ".join(f"{one} {shape}" for one, shape in [*shapes.items()][:_MOST_LISTED])
    listed += ", ..." if len(known) > _MOST_LISTED else ""
    likely = next((one for one in known if "depth" in one.lower()), next(iter(known)))
    remedy = f"Name the one to read behind the file, {file}:{likely}, or for all files by --dataset {likely}."
    return FormatError(f"{missing}{'. It has' if name else ''}: {listed}. {remedy}")


# Colour, as BlenderProc writes it beside depth.

_COLOURS = "colors", "color", "rgb", "image"
"""Names of colour; BlenderProc calls it colors."""


def read_hdf5_colour(file: FileContent) -> NDArray[np.uint8]:
    """Read colour, RGB (H, W, 3), in a child: a dataset of 8 bits with a usual name, and 3 channels, or 4 with opacity,
    which are its last or first axis.

    Raises
    ------
    InputError
        If h5py is not installed.
    FormatError
        If it is no HDF5, is damaged, or has no such dataset.
    """
    from .._runtime.children import run_in_child

    return run_in_child(_colour, file, file=str(file), memory=CHILD_MEMORY)


def _colour(file: FileContent) -> NDArray[np.uint8]:
    with open_hdf5(BytesIO(file.data.tobytes()), str(file), "Reading colour from HDF5") as opened:
        known = (dataset(opened, name, "u", 3, str(file)) for name in _COLOURS)
        found = next((data for data in known if data is not None and data.dtype == np.uint8), None)
        if found is None or not {3, 4} & {found.shape[0], found.shape[2]}:
            wanted = f"no dataset {', '.join(_COLOURS)} of 8 bits with 3 or 4 channels"
            raise FormatError(f"{file} has no colour: {wanted}. Give a file of colour.")
        check_memory(file, *sorted(found.shape)[1:])
        values = np.asarray(found)
    values = values.T if is_of_matlab(file) else values
    values = values if values.shape[2] in {3, 4} else np.moveaxis(values, 0, 2)
    return np.ascontiguousarray(values[..., :3])
