"""Orientation tags (EXIF) of a pair's files: whether colour or depth is turned, so that both show the same pixels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent
from .depth_doubts import CLEAR, coincidence
from .float_images import PFM_SUFFIX
from .hdf5 import HDF5_SUFFIXES
from .heic import HEIC_SUFFIXES
from .images import AS_STORED, Tags, turned

_EXCHANGED = 1, 5

_BETTER = 0.08
"""Minimum lead of one way over the other to decide by the edges of colour and depth."""


_UNTURNED = AS_STORED, "", False


def pair_orientation(
    colour_file: FileContent,
    colour: NDArray[np.uint8],
    depth_file: FileContent,
    metres: NDArray[np.float32],
    claims: list[tuple[int, str]],
) -> tuple[Tags, str, bool]:
    """Decide whether the orientation tags of a pair's files apply: where only so sizes are the same, or else edges
    coincide. Files with the same tag stay as stored. The rows and columns of HDF5, which MATLAB exchanges, and the
    order of the rows of PFM are decided likewise, if colour has no tag.

    Parameters
    ----------
    colour_file, depth_file : FileContent
    colour, metres : ndarray
        As stored: uint8 (h, w, 3), and depth [m], NaN = missing.
    claims : list
        What `orientation_claim` gives for colour and depth, of which at least one is a sign.

    Returns
    -------
    tuple of int, str, bool
        The orientations by which colour and depth are to be turned, a note about it, "" for none, and whether it is a
        doubt.
    """
    claims = list(claims)
    for place, file in enumerate((colour_file, depth_file)):
        if file.path.suffix.lower() in HEIC_SUFFIXES and claims[1 - place][0] != 1:
            claims[place] = 1, ""  # it is upright, and so may the other one be
    is_pfm = depth_file.path.suffix.lower() == PFM_SUFFIX
    if claims[0][0] not in {1, claims[1][0]} and (is_pfm or depth_file.path.suffix.lower() in HDF5_SUFFIXES):
        claims[1] = 1, ""
    tags = claims[0][0], claims[1][0]
    if tags[0] == tags[1]:
        return _UNTURNED
    stored, upright = (colour, metres), (turned(colour, tags[0]), turned(metres, tags[1]))
    fits, fits_upright = (rgb.shape[:2] == depth.shape for rgb, depth in (stored, upright))
    named = " and ".join(text for _, text in claims if text)
    if tags == _EXCHANGED and (fits, fits_upright) in {(True, False), (False, False)}:
        return _UNTURNED  # as nearly all HDF5 files
    if not (fits or fits_upright):
        return AS_STORED, f"{named}, and is read as stored: sizes differ either way.", False
    if fits != fits_upright:
        return _decided(named, tags, fits_upright, "colour and depth have the same size only so")
    scores = coincidence(*stored), coincidence(*upright)
    if max(scores) >= CLEAR and abs(scores[0] - scores[1]) >= _BETTER:
        if (tags == _EXCHANGED or is_pfm) and scores[0] > scores[1]:
            return _UNTURNED
        return _decided(named, tags, scores[1] > scores[0], "edges of colour and depth coincide only so")
    if is_pfm:
        return _UNTURNED  # nearly all are from the bottom up
    told = f"{named}, and is read as stored, which is uncertain: edges of colour and depth coincide as well either way"
    return AS_STORED, f"{told}. If they do not fit, save that file again as an image that is upright.", True


def _decided(named: str, tags: Tags, is_applied: bool, reason: str) -> tuple[Tags, str, bool]:
    way = "so" if is_applied else "as stored"
    return tags if is_applied else AS_STORED, f"{named}, and is read {way}: {reason}.", False
