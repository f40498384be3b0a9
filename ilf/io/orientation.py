"""Orientation tags (EXIF) of a pair's files: whether colour or depth is turned, so that both show the same pixels."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from .._runtime.files import FileContent
from .float_images import PFM_SUFFIX
from .hdf5 import HDF5_SUFFIXES
from .heic import HEIC_SUFFIXES
from .images import AS_STORED, Tags, turned

_EXCHANGED = 1, 5

_COMPARED = 160
"""Length of the longer side [px] at which edges are compared."""

_JUMP = 0.1
"""Minimum jump of depth between neighbours there, relative to depth."""

_SURE, _BETTER = 0.15, 0.08
"""Minimum correlation of the edges of colour and depth, and minimum lead over the other way, to decide by them."""


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
    scores = _coincidence(*stored), _coincidence(*upright)
    if max(scores) >= _SURE and abs(scores[0] - scores[1]) >= _BETTER:
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


_WAYS = {2: "mirrored", 3: "turned by 180 degrees", 4: "upside down"}
_WAYS_OF_SQUARES = {5: "with rows and columns exchanged", 6: "turned by 90 degrees", 8: "turned by 90 degrees"}
_LEAST_SIDE, _CLEARLY_BETTER = 100, 0.12
"""Minimum length of the sides [px], since smaller images have few edges, and minimum lead over images as stored."""


def turning_doubt(colour: NDArray[np.uint8], metres: NDArray[np.float32]) -> str:
    """A doubt whether one of two images of the same size is mirrored or upside down, by their edges; "" for none."""
    if min(metres.shape) < _LEAST_SIDE:
        return ""
    ways = _WAYS if metres.shape[0] != metres.shape[1] else _WAYS | _WAYS_OF_SQUARES
    best, tag = max((_coincidence(colour, turned(metres, tag)), tag) for tag in ways)
    if best < max(_SURE, _coincidence(colour, metres) + _CLEARLY_BETTER):
        return ""
    told = f"Edges of colour and depth coincide better if one of them is {ways[tag]}"
    return f"{told}. If it is, save its file the right way."


def _coincidence(colour: NDArray[np.uint8], metres: NDArray[np.float32]) -> float:
    """Correlation of the edges of colour and the jumps of depth, -1 to 1; 0 if there are none."""
    step = -(-max(metres.shape) // _COMPARED)
    depth = np.log(metres[::step, ::step])
    steps = [np.abs(np.diff(depth, axis=axis, append=np.nan)) > _JUMP for axis in (0, 1)]
    jumps = np.any(steps, axis=0).astype(np.float32)
    grey: Any = cv2.cvtColor(colour, cv2.COLOR_RGB2GRAY).astype(np.float32)
    grey = cv2.resize(grey, jumps.shape[::-1], interpolation=cv2.INTER_AREA)
    edges = cv2.magnitude(cv2.Sobel(grey, cv2.CV_32F, 1, 0), cv2.Sobel(grey, cv2.CV_32F, 0, 1))
    blurred, other = (np.asarray(cv2.GaussianBlur(values, (0, 0), 1)).ravel() for values in (edges, jumps))
    one = np.log1p(blurred)
    if np.ptp(one) == 0 or np.ptp(other) == 0:
        return 0.0
    return float(np.corrcoef(one, other)[0, 1])
