"""Frames as arrays for training: colour, depth before and after completion, expected error, camera and pose."""

from __future__ import annotations

import operator
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import is_address
from ..data.frame import RGBDFrame
from ..errors import InputError, ParameterError
from ..sources.frame_ref import RECORD_FILE, is_shards
from ..sources.reading import read_frame
from ..sources.source import Source, open_source
from .stored_results import StoredResult, StoredResults, has_results

_OF_FRAMES: Mapping[str, Callable[[RGBDFrame], NDArray[Any] | None]] = {
    "rgb": lambda frame: frame.rgb,
    "depth_in": lambda frame: frame.depth,
    "mask": lambda frame: frame.known,
    "ground_truth": lambda frame: frame.ground_truth,
}

_OF_RESULTS: Mapping[str, Callable[[StoredResult], NDArray[Any] | None]] = {
    "rgb": lambda result: result.rgb,
    "depth_in": lambda result: result.measured_depth,
    "mask": lambda result: result.measured,
    "depth": lambda result: result.depth,
    "expected_error": lambda result: result.expected_error,
    "unsupported": lambda result: result.unsupported,
}

FIELDS = tuple(dict.fromkeys((*_OF_FRAMES, *_OF_RESULTS, "K", "pose", "key")))
"""Names of all fields that an item can have."""


class FrameArrays:
    """Frames of a source, or stored results, as arrays: `len` gives their number, without reading any, and `arrays[0]`
    reads one. They can be pickled, no file stays open, and threads and processes can read items at the same time.

    Parameters
    ----------
    source : path-like or Source
        A folder with results (of `ilf complete`, `ilf batch --out` or `ilf batch --shards`), whose items are these
        results; else anything that `ilf.open_source` opens, or a Source, whose items are the measured frames.
    fields : sequence of str, optional
        Names of the fields to read. None reads all that the first item has.

    Attributes
    ----------
    keys : tuple of str
        One for each item: keys of the source or the shards, or names of the folders with results.
    fields : tuple of str
        What the items contain, see `ilf.torch.FrameDataset`.

    Raises
    ------
    InputError
        If there are no frames, or the first one cannot be read or lacks one of the fields.
    FormatError
        If a file is damaged.
    ParameterError
        If there is no such field.

    Examples
    --------
    >>> from ilf._runtime.installation import asset_path
    >>> arrays = FrameArrays(asset_path("samples"))
    >>> len(arrays), arrays.keys, arrays.fields
    (1, ('room',), ('rgb', 'depth_in', 'mask', 'ground_truth', 'K', 'pose', 'key'))
    >>> item = arrays[0]
    >>> item["rgb"].shape, item["depth_in"].shape, float(item["K"][0, 0]), item["key"]
    ((3, 480, 640), (1, 480, 640), 525.0, 'room')
    """

    def __init__(self, source: str | os.PathLike[str] | Source, fields: Sequence[str] | None = None) -> None:
        unknown = [name for name in fields or () if name not in FIELDS]
        if unknown:
            raise ParameterError(f"There is no field {unknown[0]!r:.40}. Known: {', '.join(FIELDS)}.")
        self._items: Source | StoredResults
        if isinstance(source, Source):
            self._items = _of_measured_frames(source)
        else:
            self._items = StoredResults(source) if has_results(source) else open_source(source)
        self.keys = self._items.keys
        first = self._item(0, warn=True)
        if fields is None:
            self.fields = tuple(name for name in FIELDS if self._value(0, first, name) is not None)
        else:
            self.fields = tuple(dict.fromkeys(fields))
            self._values(0, first)

    def __len__(self) -> int:
        return len(self.keys)

    def __getitem__(self, number: int) -> dict[str, Any]:
        """Read an item: name of the field -> new array, or the key.

        Raises
        ------
        IndexError
            If there is no item of that number.
        InputError, FormatError
            If it cannot be read, or lacks a field that the first item has.
        """
        at = operator.index(number)
        if not -len(self) <= at < len(self):
            raise IndexError(f"{self._items.path} has no item {at}: it has {len(self)}, from 0 to {len(self) - 1}.")
        return self._values(at, self._item(at))

    def _item(self, number: int, warn: bool = False) -> RGBDFrame | StoredResult:
        if isinstance(self._items, StoredResults):
            return self._items[number]
        return read_frame(self._items.ref(self.keys[number]), warn=warn)

    def _values(self, number: int, item: RGBDFrame | StoredResult) -> dict[str, Any]:
        values = {name: self._value(number, item, name) for name in self.fields}
        for name, value in values.items():
            if value is None:
                by_batch = ", or complete the frames with it (`ilf batch`)" if name not in _OF_FRAMES else ""
                raise InputError(
                    f"{self.keys[number]} in {self._items.path} has no {name}. Leave this field out{by_batch}."
                )
        return values

    def _value(self, number: int, item: RGBDFrame | StoredResult, name: str) -> NDArray[Any] | str | None:
        """The value of a field; None if the item does not have it."""
        if name == "key":
            return self.keys[number]
        if name == "K":
            return np.array(np.full((3, 3), np.nan) if item.intrinsics is None else item.intrinsics.matrix, np.float32)
        if name == "pose":
            return np.array(np.full((4, 4), np.nan) if item.pose is None else item.pose, np.float32)
        of_kind: Mapping[str, Callable[[Any], NDArray[Any] | None]]
        of_kind = _OF_FRAMES if isinstance(item, RGBDFrame) else _OF_RESULTS
        image = of_kind[name](item) if name in of_kind else None
        if image is None:
            return None
        return np.array(np.moveaxis(image, -1, 0) if image.ndim == 3 else image[None], order="C")


def _of_measured_frames(source: Source) -> Source:
    """The source, unless its depth was completed: it would be taken for measured depth."""
    frames = (source.ref(key) for key in source.keys)
    whole = {(one.rgb, one.frame is not None) for one in frames if one.depth is None}
    for path, is_recording in whole:
        is_completed = is_recording and is_shards(path)
        if is_completed or (not is_address(path) and os.path.isfile(Path(path) / RECORD_FILE)):
            raise InputError(f"{path} has completed depth. Give the folder with the results instead of the Source.")
    return source
