"""Arrays of NumPy's files, NPY and NPZ."""

from __future__ import annotations

import io
import math
import tokenize
import warnings
import zipfile
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from .files import MAX_FILE_BYTES, FileContent
from .images import check_pixel_count

# whatever a header that is parsed as Python text can lead to
_NPY_ERRORS = (
    ValueError, TypeError, SyntaxError, ArithmeticError, OSError, EOFError, MemoryError, RecursionError,
    tokenize.TokenError,
)  # fmt: skip


def read_npy(file: FileContent) -> NDArray[Any]:
    """The array of an NPY file; raises FormatError if it is damaged or holds Python objects."""
    stream = io.BytesIO(file.data.data)
    try:
        # np.load would otherwise go on to try archives and pickles
        version = np.lib.format.read_magic(stream)
        read_header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that Python 2 has written it is no harm
            shape, in_columns, dtype = read_header(stream)
        if dtype.hasobject:
            raise ValueError("it holds Python objects")
        # what a header asks for must be there before any memory is taken
        wanted, there = math.prod(shape) * dtype.itemsize, file.data.size - stream.tell()
        if wanted > there:
            raise ValueError(f"{wanted} bytes of values are announced, {there} are there")
        values = np.frombuffer(file.data, dtype, math.prod(shape), stream.tell())
    except _NPY_ERRORS as error:
        raise FormatError(
            f"{file}: this NPY cannot be read ({error!s:.120}): it is truncated, damaged, or holds Python "
            "objects. Save a plain float32 or uint16 array with numpy.save."
        ) from error
    if len(shape) >= 2:
        check_pixel_count(file, shape[1], shape[0])
    return values.reshape(shape, order="F" if in_columns else "C").copy(order="C")


def read_npz(file: FileContent, names: tuple[str, ...]) -> NDArray[Any]:
    """An array of an NPZ file: its only one, or the first of these names that is there.

    Raises
    ------
    FormatError
        If there is none of them among several, or it cannot be read.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(file.data.tobytes())) as archive:
            members = {entry.filename.removesuffix(".npy"): entry for entry in archive.infolist()}
            name = next((name for name in names if name in members), None)
            if name is None and len(members) == 1:
                name = next(iter(members))
            if name is None:
                raise FormatError(
                    f"{file} has {len(members)} arrays ({', '.join(sorted(members))!s:.80}) and none of them is called "
                    f"{', '.join(names)}. Save the one that counts as {names[0]}."
                )
            if members[name].file_size > MAX_FILE_BYTES:
                raise FormatError(f"{file}: {name} is larger than 1 GiB. Is this the right file?")
            data = np.frombuffer(archive.read(members[name]), np.uint8)
    except (zipfile.BadZipFile, EOFError, OSError, RuntimeError, ValueError, zlib.error) as error:
        raise FormatError(f"{file}: this NPZ cannot be read ({error!s:.120}). Save it again.") from error
    return read_npy(FileContent(file.path, data))
