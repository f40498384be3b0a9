"""Statistics of a block or a rectangle, of raw depth and of the result, as rows of a table."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ilf._runtime.formatting import UNKNOWN, millimetres
from ilf.data.camera import Camera
from ilf.errors import InputError
from ilf.evaluation.measuring import angle_between
from ilf.evaluation.statistics import SurfaceFit, SurfaceStatistics, surface_statistics

from ...widgets.row_table import NumberRow

COLUMNS = (("Raw", "Statistics of the raw depth"), ("Result", "Statistics of the completed depth"))
_ROWS = (
    ("Pixels", "Number of pixels"),
    ("Missing", "Share of the pixels without depth"),
    ("Mean", "Mean of the known depth"),
    ("Median", "Median of the known depth"),
    ("Std. deviation", "Standard deviation of the known depth"),
    ("Range", "Minimum and maximum of the known depth"),
    (
        "Noise",
        "Variation from pixel to pixel, independent of the surface's shape: from the median second difference of "
        "neighbours. Quantised depth shows less noise than it has",
    ),
    ("Plane RMS", "Root mean square distance from the best-fitting plane, without outliers"),
    ("Outliers", "Share of the known depth farther from that plane than 3.5 robust standard deviations"),
    ("Tilt", "Angle between that plane's normal and the camera's axis; 0° faces the camera"),
    ("Quadric RMS", "Root mean square distance from the best-fitting quadric, without outliers"),
)

Depth = NDArray[np.float32]
Mask = NDArray[np.bool_]


def statistics_of(
    raw: Depth, result: Depth | None, intrinsics: Camera | None, subject: Mask, other: Mask | None
) -> tuple[list[NumberRow], list[str]]:
    """Compute the statistics of a region; called in a worker thread.

    Parameters
    ----------
    raw, result : ndarray of float32, shape (H, W)
        [m]; the second is None if there is no result.
    intrinsics : Camera or None
    subject, other : ndarray of bool, shape (H, W)
        Region of the statistics; second block, for the angle between the planes of both, or None.

    Returns
    -------
    list of NumberRow
    list of str
        Sentences on them.
    """
    depths = [raw] if result is None else [raw, result]
    found = [surface_statistics(depth, subject, intrinsics) for depth in depths]
    notes = [one.reason for one in found if one.reason]
    if other is not None:
        try:
            second = surface_statistics(depths[-1], other, intrinsics)
            angle = angle_between(_plane(found[-1]), _plane(second))
            notes.insert(0, f"Angle between the planes of both selected blocks: {angle:.1f}°")
        except InputError as error:
            notes.append(str(error))
    columns = [_texts(one) for one in found]
    columns += [[""] * len(_ROWS)] * (len(COLUMNS) - len(found))
    rows = [
        NumberRow(name, tuple(texts), f"{name}: {hint[0].lower()}{hint[1:]}")
        for (name, hint), *texts in zip(_ROWS, *columns, strict=True)
    ]
    return rows, list(dict.fromkeys(notes))


def _plane(found: SurfaceStatistics) -> SurfaceFit:
    if found.plane is None:
        raise InputError(found.reason)
    return found.plane


def _texts(found: SurfaceStatistics) -> list[str]:
    plane, quadric = found.plane, found.quadric
    return [
        f"{found.pixels:,}",
        f"{100 * found.missing_share:.1f} %",
        metres(found.mean),
        metres(found.median),
        _millimetres(found.deviation),
        f"{found.least:.2f}–{found.largest:.2f} m" if found.known else UNKNOWN,
        _millimetres(found.noise),
        UNKNOWN if plane is None else _millimetres(plane.rms),
        UNKNOWN if plane is None else f"{100 * plane.outliers:.1f} %",
        f"{plane.tilt:.1f}°" if plane is not None and math.isfinite(plane.tilt) else UNKNOWN,
        UNKNOWN if quadric is None else _millimetres(quadric.rms),
    ]


def metres(length: float) -> str:
    """Format a length in metres; a dash for NaN."""
    return f"{length:.3f} m" if math.isfinite(length) else UNKNOWN


def _millimetres(length: float) -> str:
    """Format a small length in millimetres; a dash for NaN."""
    return f"{millimetres(length)} mm" if math.isfinite(length) else UNKNOWN
