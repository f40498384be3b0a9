"""Colour from HDF5 files that have colour and depth, as BlenderProc writes them."""

from __future__ import annotations

import io

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent
from .._runtime.memory import check_memory
from ..errors import FormatError
from .hdf5 import CHILD_MEMORY, dataset, is_of_matlab, open_hdf5

_USUAL = "colors", "color", "rgb", "image"
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
    with open_hdf5(io.BytesIO(file.data.tobytes()), str(file), "Reading colour from HDF5") as opened:
        known = (dataset(opened, name, "u", 3, str(file)) for name in _USUAL)
        found = next((data for data in known if data is not None and data.dtype == np.uint8), None)
        if found is None or not {3, 4} & {found.shape[0], found.shape[2]}:
            wanted = f"no dataset {', '.join(_USUAL)} of 8 bits with 3 or 4 channels"
            raise FormatError(f"{file} has no colour: {wanted}. Give a file of colour.")
        check_memory(file, *sorted(found.shape)[1:])
        values = np.asarray(found)
    values = values.T if is_of_matlab(file) else values
    values = values if values.shape[2] in {3, 4} else np.moveaxis(values, 0, 2)
    return np.ascontiguousarray(values[..., :3])
