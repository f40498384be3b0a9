"""What a cloud is to be, and making it: no widgets, for another thread."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from gui.cloud.colouring import ColourBy, Subject, colours_of
from gui.cloud.scene import Scene
from ilf.cloud import back_project
from ilf.drawing.splat import spacing_of
from ilf.frame import CameraIntrinsics


@dataclass(frozen=True, eq=False)
class Wish:
    """What the cloud is to be.

    Parameters
    ----------
    key : str
        Of the session.
    intrinsics : CameraIntrinsics
    subject : Subject
        The depth, and what it is coloured by.
    by : ColourBy
    chosen : frozenset of int or None
        The only blocks that are shown; None for everything.
    title : str
        What the colours mean.
    """

    key: str
    intrinsics: CameraIntrinsics
    subject: Subject
    by: ColourBy
    chosen: frozenset[int] | None
    title: str

    def is_same(self, other: Wish | None) -> bool:
        """Whether another wish would give the same scene."""
        if other is None or (self.by, self.title) != (other.by, other.title):
            return False
        return self.has_same_points(other) and _same(self.subject, other.subject)

    def has_same_points(self, other: Wish) -> bool:
        """Whether the scene of another wish has the same points."""
        return (
            self.key == other.key
            and self.intrinsics == other.intrinsics
            and self.subject.depth is other.subject.depth
            and self.chosen == other.chosen
            and (self.chosen is None or self.subject.labels is other.subject.labels)
        )


def compose(wish: Wish, before: Scene | None = None) -> Scene:
    """The scene that is wished for; `before` has the same points, and perhaps other colours."""
    subject = wish.subject
    if before is None:
        only = None if wish.chosen is None or subject.labels is None else np.isin(subject.labels, list(wish.chosen))
        points, pixels = back_project(subject.depth, wish.intrinsics, only)
        spacing = spacing_of(points)
        depths = (float(points[:, 2].min()), float(points[:, 2].max())) if len(points) else (0.0, 1.0)
    else:
        points, pixels, spacing, depths = before.points, before.pixels, before.spacing, before.depths
    colouring = colours_of(subject, wish.by, points, pixels)
    return Scene(points, pixels, subject.depth.shape[1], colouring, spacing, depths, wish.title)


def _same(one: Subject, other: Subject) -> bool:
    """Whether two subjects are made of the very same arrays and of equal values."""
    pairs = ((getattr(one, field.name), getattr(other, field.name)) for field in fields(Subject))
    return all(a is b or (not isinstance(a, np.ndarray) and a == b) for a, b in pairs)
