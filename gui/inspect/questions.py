"""Statistics that are asked for, and how they are found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ilf.camera import CameraIntrinsics
from ilf.errors import InputError
from ilf.inspection import PlaneFit, SurfaceStatistics, angle_between, surface_statistics

Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Question:
    """Depth, and where statistics of it are wanted; nobody changes its arrays any more.

    Attributes
    ----------
    raw, result : ndarray of float32, shape (H, W)
        [m]; the second is None if there is no result.
    intrinsics : CameraIntrinsics or None
    subject, other, reference : ndarray of bool, shape (H, W), or None
        What statistics are of; a second block, for the angle between the two; the block that heights are measured over.
    """

    raw: NDArray[np.float32]
    result: NDArray[np.float32] | None
    intrinsics: CameraIntrinsics | None
    subject: Mask | None
    other: Mask | None
    reference: Mask | None


@dataclass(frozen=True)
class Numbers:
    """What has been found.

    Attributes
    ----------
    raw, result : SurfaceStatistics or None
        Of the subject.
    angle : float or None
        Between the planes of both blocks [degrees]; None if they were not asked for or have none.
    up : (float, float, float) or None
        Normal of the reference; None if it has none.
    why : str
        Why there is no angle, or no normal.
    """

    raw: SurfaceStatistics | None = None
    result: SurfaceStatistics | None = None
    angle: float | None = None
    up: tuple[float, float, float] | None = None
    why: str = ""


def find(question: Question) -> Numbers:
    """Answer a question, off the GUI's thread."""
    present = question.raw if question.result is None else question.result

    def of(depth: NDArray[np.float32], mask: Mask) -> SurfaceStatistics:
        return surface_statistics(depth, mask, question.intrinsics)

    raw = result = angle = up = None
    why = ""
    if question.subject is not None:
        raw = of(question.raw, question.subject)
        result = None if question.result is None else of(question.result, question.subject)
    if question.other is not None:
        try:
            angle = angle_between(_plane(result or raw), _plane(of(present, question.other)))
        except InputError as error:
            why = str(error)
    if question.reference is not None:
        try:
            up = _plane(of(present, question.reference)).normal
        except InputError as error:
            why = str(error)
    return Numbers(raw, result, angle, up, why)


def _plane(found: SurfaceStatistics | None) -> PlaneFit:
    if found is None or found.plane is None:
        raise InputError("There is no plane." if found is None else found.reason)
    return found.plane
