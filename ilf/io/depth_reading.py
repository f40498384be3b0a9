"""A depth file read by its encoding, with what there is to say against that."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import FormatError
from .colmap_files import COLMAP_SUFFIX
from .depth_files import read_depth_values
from .doubts import Doubt, doubts_of
from .encodings import DepthEncoding, EncodingSpec, beyond_sensors, chosen_encoding, is_name
from .files import FileContent

_SCENE = Doubt(
    "Depth maps of COLMAP are in the unit of their reconstruction, which is read as metres here: give its units per "
    "metre as depth units, or m as the encoding if it was scaled to metres."
)


@dataclass(frozen=True, eq=False)
class DepthReading:
    """Depth as it was read.

    Attributes
    ----------
    values : ndarray
        (H, W), as the file has them.
    metres : ndarray of float32
        Depth [m], (H, W), NaN = missing.
    encoding : DepthEncoding
    is_assumed : bool
        Whether nothing said the encoding, so that the usual one of the values' type was taken.
    is_named : bool
        Whether it was given or stated by a name.
    left_out : str
        What was known by the file, and is missing, because no sensor can give it; "" for nothing.
    path : Path
        Of the file that it came from.
    file_doubt : Doubt or None
        What speaks against the encoding for whatever values files of this kind have.
    """

    values: NDArray[Any]
    metres: NDArray[np.float32]
    encoding: DepthEncoding
    is_assumed: bool
    is_named: bool
    left_out: str
    path: Path
    file_doubt: Doubt | None = None

    @cached_property
    def doubts(self) -> tuple[Doubt, ...]:
        """What speaks against the encoding."""
        found = doubts_of(self.values, self.metres, self.encoding, self.is_named, self.path)
        return found if self.file_doubt is None else (self.file_doubt, *found)

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know, a sentence or two each."""
        return (*([self.left_out] if self.left_out else []), *(doubt.text for doubt in self.doubts))

    @property
    def other_ways(self) -> str:
        """The doubts that name a likelier encoding, to be put behind an error; "" if there are none."""
        return "".join(f" {doubt.text}" for doubt in self.doubts if doubt.invalid is None and not doubt.is_scale)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Those of the notes that a program should hear, with the path: all but that a scale is unusual, where it was
        stated."""
        scale = {doubt.text for doubt in self.doubts if doubt.is_scale}
        return tuple(f"{self.path}: {note}" for note in self.notes if self.is_assumed or note not in scale)


def read_depth(
    file: FileContent,
    given: EncodingSpec | None = None,
    stated: EncodingSpec | None = None,
    invalid: float | None = None,
) -> DepthReading:
    """Read a depth file.

    Parameters
    ----------
    file : FileContent
    given, stated : str or float, optional
        The encoding, see `encoding_of`: what the user gives goes before what is stated beside the file.
    invalid : float, optional
        The file's value that stands for missing.

    Raises
    ------
    InputError, FormatError, ParameterError
        As `read_depth_values` and `encoding_of` do.
    """
    return reading_of(read_depth_values(file), file.path, given, stated, invalid)


def reading_of(
    values: NDArray[Any],
    path: Path,
    given: EncodingSpec | None = None,
    stated: EncodingSpec | None = None,
    invalid: float | None = None,
) -> DepthReading:
    """The same for the values (H, W) of a depth image that came from `path`."""
    encoding = chosen_encoding(values, path, given, stated, invalid)
    try:
        metres, left_out = decoded(values, encoding)
    except FormatError as error:
        raise FormatError(f"{path}: {error}") from error
    spec = stated if given is None else given
    of_scene = spec is None and path.suffix.lower() == COLMAP_SUFFIX
    doubt = _SCENE if of_scene else None
    return DepthReading(values, metres, encoding, spec is None, is_name(spec), left_out, path, doubt)


def decoded(values: NDArray[Any], encoding: DepthEncoding) -> tuple[NDArray[np.float32], str]:
    """Values as depth [m], NaN = missing, and what was left out because no sensor can give it; "" for nothing."""
    metres = encoding.metres(values)
    far = beyond_sensors(metres, encoding.farthest)
    if far is None:
        return metres, ""
    metres[far] = np.nan
    count = int(np.count_nonzero(far))
    return metres, (
        f"Depth beyond {encoding.farthest:g} m, which no sensor gives, is missing: {count} pixels ({far.mean():.1%})."
    )
