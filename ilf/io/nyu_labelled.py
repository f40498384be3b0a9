"""NYU Depth V2's labelled file, nyu_depth_v2_labeled.mat: 1449 frames in one MATLAB v7.3 (HDF5) file.

MATLAB stores columns first, so HDF5 shows every array with its axes the other way round: images (N, 3, W, H),
depths and rawDepths (N, W, H).
"""

from __future__ import annotations

import os
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..camera import IMAGE_SIZES, INTRINSICS
from ..errors import FormatError, InputError
from ..frame import RGBDFrame
from ..trial import in_child
from .files import existing_file
from .hdf5_files import dataset, open_hdf5, rows
from .images import check_pixel_count

MAT_SUFFIX = ".mat"
SPLIT_FILE, TEST_FRAMES = "splits.mat", "testNdxs"

_MOST_FRAMES = 1_000_000
CAMERA = "nyu-kinect-v1"
"""Preset of its intrinsics."""

_IMAGES, _FILLED, _RAW = "images", "depths", "rawDepths"


class NyuLabelled:
    """The file, opened: frames are read one at a time. A context manager.

    Parameters
    ----------
    path : path-like

    Raises
    ------
    InputError
        If there is no such file, or the package that reads it is missing.
    FormatError
        If it is no MATLAB v7.3 file, or lacks images, depths or rawDepths in the form that they should have.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path).absolute()
        if not self.path.is_file() or self.path.stat().st_size == 0:
            existing_file(self.path)  # says what is wrong with it
        self._file = open_hdf5(self.path, str(self.path), "experiments", "Reading NYU Depth V2's labelled file")
        try:
            self._data = self._checked()
        except FormatError:
            self._file.close()
            raise

    def _checked(self) -> dict[str, Any]:
        """Images, depths and rawDepths, in the form that they should have."""
        found = {}
        for name, dimensions, kind in ((_IMAGES, 4, "u"), (_FILLED, 3, "f"), (_RAW, 3, "f")):
            found[name] = dataset(self._file, name, kind, dimensions, str(self.path))
            if found[name] is None:
                raise FormatError(
                    f"{self.path} has no {name} as NYU Depth V2's labelled file stores them. Is this "
                    "nyu_depth_v2_labeled.mat?"
                )
        shapes = {name: data.shape for name, data in found.items()}
        count, channels, *size = shapes[_IMAGES]
        if channels != 3 or shapes[_FILLED] != (count, *size) or shapes[_RAW] != (count, *size):
            raise FormatError(
                f"{self.path}: images {shapes[_IMAGES]}, depths {shapes[_FILLED]} and rawDepths {shapes[_RAW]} do not "
                "fit each other; they should be (N, 3, W, H), (N, W, H) and (N, W, H)."
            )
        check_pixel_count(self.path, *size)
        return found

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of its frames in pixels."""
        width, height = self._data[_RAW].shape[1:]
        return int(width), int(height)

    def __len__(self) -> int:
        return int(self._data[_RAW].shape[0])

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()

    def frame(self, index: int) -> RGBDFrame:
        """Colour and raw depth of a frame, by its index from 0. 0 m is missing.

        Raises
        ------
        InputError
            If there is no such frame, or it has no depth.
        FormatError
            If the file is damaged there.
        """
        camera = INTRINSICS[CAMERA] if IMAGE_SIZES[CAMERA] == self.size else None
        return RGBDFrame(self.colour(index), self.measured(index), camera, frame_name(index))

    def colour(self, index: int) -> NDArray[np.uint8]:
        """Colour of a frame, uint8 (H, W, 3)."""
        return np.ascontiguousarray(self._read(_IMAGES, index).transpose(2, 1, 0))

    def measured(self, index: int) -> NDArray[np.float32]:
        """Depth of a frame as it was measured and registered to colour [m], shape (H, W), 0 = missing."""
        return np.ascontiguousarray(self._read(_RAW, index).T, np.float32)

    def filled(self, index: int) -> NDArray[np.float32]:
        """Depth of a frame with its holes in-painted by the toolbox [m], shape (H, W), NaN = unknown.

        Where the sensor measured it is what was measured; in the holes it is the toolbox's colourisation, no
        measurement.
        """
        depth = self._read(_FILLED, index).T.astype(np.float32)
        depth[~(np.isfinite(depth) & (depth > 0))] = np.nan
        return depth

    def _read(self, name: str, index: int) -> NDArray[Any]:
        if not 0 <= index < len(self):
            raise InputError(f"{self.path} has no frame {index + 1}; it has 1 to {len(self)}.")
        return rows(self._data[name], index, str(self.path))


def frame_name(index: int) -> str:
    """What a frame is called: its number from 1, as MATLAB and the split count."""
    return f"nyu_{index + 1:04d}"


def read_split(path: str | os.PathLike[str]) -> list[int]:
    """Indices from 0 of the frames that a split names.

    Parameters
    ----------
    path : path-like
        splits.mat of the toolbox, whose test frames are taken; or a text file with one number from 1 per line.

    Raises
    ------
    InputError
        If there is no such file.
    FormatError
        If it holds no list of whole numbers from 1.
    """
    found = existing_file(path)
    is_matlab = found.suffix.lower() == MAT_SUFFIX
    numbers = in_child(_matlab_split, found, file=str(found)) if is_matlab else _listed(found)
    if not numbers or min(numbers) < 1 or max(numbers) > _MOST_FRAMES:
        raise FormatError(f"{found} names no frames. A split lists whole numbers from 1.")
    return [number - 1 for number in dict.fromkeys(numbers)]


def _matlab_split(path: Path) -> list[int]:
    """The numbers in a MATLAB v5 file, whose reader damaged files can crash."""
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        content = loadmat(path, variable_names=[TEST_FRAMES])
    except (MatReadError, ValueError, TypeError, NotImplementedError, OSError) as error:
        raise FormatError(
            f"{path} is not a MATLAB v5 file that can be read. Give the toolbox's {SPLIT_FILE}, or a text file with "
            "one number per line."
        ) from error
    numbers = np.asarray(content.get(TEST_FRAMES, []))
    whole = numbers.dtype.kind in "iuf" and bool((np.isfinite(numbers) & (numbers == np.floor(numbers))).all())
    if not whole or numbers.size > _MOST_FRAMES:
        raise FormatError(f"{path}: {TEST_FRAMES} must hold whole numbers.")
    return [int(number) for number in numbers.ravel()]


def _listed(path: Path) -> list[int]:
    try:
        return [int(word) for word in path.read_text(encoding="utf-8").split()]
    except ValueError as error:
        raise FormatError(f"{path} must hold one whole number per line: the numbers of the frames, from 1.") from error
